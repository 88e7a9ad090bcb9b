"""The wing and body of a small aeroplane."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal

import drjit as dr

from pelagos.hydro.algebra import Vector, dot, inflow_angle
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, Number, PartConfig, Positive
from pelagos.vehicles.wetness import Keeps


class WingConfig(PartConfig):
    """Aerodynamic coefficients of an aeroplane, control surfaces apart.

    Source: R. W. Beard, T. W. McLain, "Small Unmanned Aircraft", Princeton 2012, Chapter 4; beyond stall a flat
    plate.
    """

    type: Literal["wing"]
    area_m2: Positive
    """S [m^2]."""
    span_m: Positive
    """b [m]."""
    chord_m: Positive
    """c [m]."""
    oswald: Positive
    """e [-]."""
    stall_deg: Positive
    """Angle of attack at which the flow separates [deg]."""
    blend: Positive = 50.0
    """How sharply [1/rad]."""
    C_L0: Number
    """[-]"""
    C_La: Number
    """[1/rad]"""
    C_Lq: Number
    """[-]"""
    C_Dp: NonNegative
    """Parasitic drag [-]."""
    C_m0: Number
    """[-]"""
    C_ma: Number
    """[1/rad]"""
    C_mq: Number
    """[-]"""
    C_Yb: Number
    """[1/rad]"""
    C_lb: Number
    """[1/rad]"""
    C_lp: Number
    """[-]"""
    C_lr: Number
    """[-]"""
    C_nb: Number
    """[1/rad]"""
    C_np: Number
    """[-]"""
    C_nr: Number
    """[-]"""

    def build(self, body: Body) -> Wing:
        """The term."""
        return Wing(self, body.density)


@dataclass(frozen=True)
class Wing:
    """config: coefficients; density: of the air [kg/m^3]."""

    keeps: ClassVar[Keeps] = "dry"
    config: WingConfig
    density: float

    def wrench(self, flow: Flow) -> Vector:
        """Force and moment (6)."""
        c = self.config
        u, v, w, p, q, r = flow.nu_r
        square = dot(flow.nu_r[:3], flow.nu_r[:3])
        speed = dr.sqrt(square + 1e-9)
        alpha = inflow_angle(w, u)
        beta = dr.asin(dr.clip(v / speed, -1.0, 1.0))
        sin, cos = dr.sincos(alpha)
        stalled = _separation(alpha, math.radians(c.stall_deg), c.blend)
        attached = c.C_L0 + c.C_La * alpha
        lift = (1 - stalled) * attached + stalled * 2 * dr.mulsign(sin * sin * cos, alpha)
        induced = attached * attached / (math.pi * c.oswald * c.span_m**2 / c.area_m2)
        drag = c.C_Dp + (1 - stalled) * induced + stalled * 2 * sin * sin
        pressure = 0.5 * self.density * c.area_m2 * square
        rate = 0.25 * self.density * c.area_m2 * speed
        lift_force = pressure * lift + rate * c.C_Lq * c.chord_m * q
        return [
            lift_force * sin - pressure * drag * cos,
            pressure * c.C_Yb * beta,
            -lift_force * cos - pressure * drag * sin,
            c.span_m * (pressure * c.C_lb * beta + rate * c.span_m * (c.C_lp * p + c.C_lr * r)),
            c.chord_m * (pressure * (c.C_m0 + c.C_ma * alpha) + rate * c.chord_m * c.C_mq * q),
            c.span_m * (pressure * c.C_nb * beta + rate * c.span_m * (c.C_np * p + c.C_nr * r)),
        ]


def _separation(alpha: Array, stall: float, blend: float) -> Array:
    """0 while the flow is attached, 1 when it has separated."""
    up = dr.exp(dr.clip(-blend * (alpha - stall), -50.0, 50.0))
    down = dr.exp(dr.clip(blend * (alpha + stall), -50.0, 50.0))
    return (1 + up + down) / ((1 + up) * (1 + down))
