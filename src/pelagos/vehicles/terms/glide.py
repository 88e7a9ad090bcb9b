"""Hull and wings of an underwater glider."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import drjit as dr

from pelagos.hydro.algebra import Vector, dot, inflow_angle
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, Number, PartConfig

_STALL: Final = 0.35  # rad; the coefficients are for less, beyond the lift falls with the cosine; assumed
_BROADSIDE: Final = 1.0  # rad: drag grows no more; assumed
_FASTEST: Final = 3.0  # m/s: moments grow no more


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
        angle = inflow_angle(w, u)
        alpha = dr.clip(angle, -_STALL, _STALL) * dr.select(dr.abs(angle) > _STALL, dr.maximum(dr.cos(angle), 0.0), 1.0)
        speed = dr.sqrt(square + 1e-12)
        beta = dr.asin(dr.clip(v / speed, -1.0, 1.0))
        lift = (c.lift_0 + c.lift * alpha) * square
        bent = dr.clip(angle, -_BROADSIDE, _BROADSIDE)
        drag = (c.drag_0 + c.drag * bent * bent) * square
        sin, cos = dr.sincos(angle)
        p, q, r = flow.nu_r[3:]
        fast = dr.minimum(square, _FASTEST**2)  # what turns it is known at its own speeds
        return [
            lift * sin - drag * cos,
            -c.side * beta * square,
            -lift * cos - drag * sin,
            -c.roll_rate * p * fast,
            (c.pitch_0 + c.pitch * alpha - c.pitch_rate * q) * fast,
            (c.yaw * beta - c.yaw_rate * r) * fast,
        ]
