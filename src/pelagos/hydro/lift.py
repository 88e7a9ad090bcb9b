"""Lift and drag of bodies, and forces of control surfaces, FRD."""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr

from pelagos.hydro.algebra import Vector, cross, dot, inflow_angle, mul, neg, total
from pelagos.jit import Array


@dataclass(frozen=True)
class Polar:
    """Lift and drag of a body in pitch: CL = slope alpha, CD = parasitic + induced CL^2.

    Attributes:
        area: reference area S [m^2].
        slope: [1/rad].
        parasitic: CD_0 [-].
        induced: [-].
    """

    area: Array
    slope: Array
    parasitic: Array
    induced: Array


def helmbold_slope(aspect_ratio: float) -> float:
    """Lift slope [1/rad] of a wing of low aspect ratio.

    Source: R. W. Beard and T. W. McLain, "Small Unmanned Aircraft", Princeton 2012, Chapter 4.
    """
    return math.pi * aspect_ratio / (1 + math.sqrt(1 + (aspect_ratio / 2) ** 2))


def induced_factor(aspect_ratio: float, oswald: float) -> float:
    """1/(pi e AR) [-]."""
    return 1.0 / (oswald * math.pi * aspect_ratio)


def lift_and_drag(polar: Polar, density: Array, nu_r: Vector, *, mirrored: bool) -> list[Array]:
    """Wrench (6) of lift and drag in the vertical plane: F21 Section 6.4.

    `mirrored`: flow from astern sees the same body from behind. Otherwise the angle of attack runs to pi, with the very
    large lift and drag that Fossen's programs have there (for agreement with them, not for truth).
    """
    u, w = nu_r[0], nu_r[2]
    alpha = inflow_angle(w, dr.abs(u) if mirrored else u)
    lift = polar.slope * alpha
    drag = polar.parasitic + polar.induced * lift * lift
    pressure = 0.5 * density * polar.area * dot(nu_r[:3], nu_r[:3])
    square = u * u + w * w
    moving = square > 0
    inverse = dr.rcp(dr.sqrt(dr.select(moving, square, 1.0)))  # sine and cosine without calling them
    sin, cos = w * inverse, dr.select(moving, u * inverse, 1.0)
    lift_ahead = dr.mulsign(lift, u) if mirrored else lift
    return [
        pressure * (lift_ahead * sin - drag * cos),
        0.0,
        -pressure * (drag * sin + lift * dr.abs(cos) if mirrored else drag * sin + lift * cos),
        0.0,
        0.0,
        0.0,
    ]


def fin(
    gain: Array,
    drag_gain: Array,
    direction: tuple[float, float],
    place: Vector,
    deflection: Array,
    nu_r: Vector,
    *,
    incidence: bool = False,
    mirrored: bool = True,
) -> list[Array]:
    """Wrench (6) of an all-moving fin, linear in its deflection: F21 Chapter 9.

    Args:
        gain: rho/2 A CL [kg/m].
        drag_gain: rho/2 A CD by deflection squared [kg/m].
        direction: (cos g, sin g), g the fin's angle about x from the starboard side downwards.
        place: centre of pressure (3) [m].
        deflection: [rad], right-handed about the fin's outward axis.
        nu_r: relative velocity (6); the speed in the plane normal to the fin's axis counts.
        incidence: the flow's own angle at the fin lifts too (small angles: its sine over its cosine is the angle).
        mirrored: flow from astern meets the fin from behind, so that the same deflection pushes it the other way.
    """
    cos, sin = direction
    v, w = nu_r[1], nu_r[2]
    past = total(mul(sin, v), neg(mul(cos, w)))
    square = total(nu_r[0] * nu_r[0], past * past)
    square = dr.mulsign(square, nu_r[0]) if mirrored else square
    f = gain * square * deflection
    if incidence:
        spin = cross(nu_r[3:], place)
        across = total(mul(sin, total(v, spin[1])), neg(mul(cos, total(w, spin[2]))))
        f = f - gain * dr.abs(nu_r[0]) * across  # from astern too it opposes the flow across it
    x = 0.0 if isinstance(drag_gain, float) and drag_gain == 0 else -drag_gain * square * deflection * deflection
    force = [x, mul(sin, f), neg(mul(cos, f))]
    return [*force, *cross(place, [0.0, *force[1:]])]
