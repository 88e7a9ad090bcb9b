"""Hull and wings of an underwater glider."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import drjit as dr

from pelagos.hydro.algebra import Vector, dot
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, Number, PartConfig


class GlideConfig(PartConfig):
    """Lift, drag, side force and moments by angle of attack, sideslip and speed squared.

    Source: J. G. Graver, "Underwater gliders: dynamics, control and design", PhD thesis, Princeton 2005, Chapter 3.
    """

    type: Literal["glide"]
    lift_0: Number = 0.0
    """K_L0 [kg/m]."""
    lift: NonNegative
    """K_L, by angle of attack [kg/m]."""
    drag_0: NonNegative
    """K_D0 [kg/m]."""
    drag: NonNegative
    """K_D, by angle of attack squared [kg/m]."""
    pitch_0: Number = 0.0
    """K_M0 [kg]."""
    pitch: Number
    """K_M, by angle of attack; negative steadies [kg]."""
    pitch_rate: NonNegative
    """Damping moment by pitch rate and speed squared [kg s]."""
    side: NonNegative
    """Side force by sideslip [kg/m]."""
    yaw: NonNegative
    """Moment that turns the nose into the flow, by sideslip [kg]."""
    yaw_rate: NonNegative
    """Damping moment by yaw rate and speed squared [kg s]."""
    roll_rate: NonNegative
    """Damping moment by roll rate and speed squared [kg s]."""

    def build(self, body: Body) -> Glide:
        """The term."""
        return Glide(self)


@dataclass(frozen=True)
class Glide:
    """config: coefficients."""

    config: GlideConfig

    def wrench(self, flow: Flow) -> Vector:
        """Force and moment (6)."""
        c = self.config
        u, v, w = flow.nu_r[:3]
        square = dot(flow.nu_r[:3], flow.nu_r[:3])
        alpha = dr.atan2(w, u)
        speed = dr.sqrt(square + 1e-12)
        beta = dr.asin(dr.clip(v / speed, -1.0, 1.0))
        lift = (c.lift_0 + c.lift * alpha) * square
        drag = (c.drag_0 + c.drag * alpha * alpha) * square
        sin, cos = dr.sincos(alpha)
        p, q, r = flow.nu_r[3:]
        return [
            lift * sin - drag * cos,
            -c.side * beta * square,
            -lift * cos - drag * sin,
            -c.roll_rate * p * square,
            (c.pitch_0 + c.pitch * alpha - c.pitch_rate * q) * square,
            (c.yaw * beta - c.yaw_rate * r) * square,
        ]
