"""Lasers that a camera sees: a dot or a line on what they meet, and the beam or sheet in the water before it.

A beam of power P with a Gaussian profile has at the distance x the 1/e^2 radius w, w^2 = w_0^2 + (x theta)^2, and the
irradiance 2 P / (pi w^2) exp(-2 rho^2 / w^2) (A. E. Siegman, Lasers, 1986, Section 17.1). A line laser spreads P over a
fan; across its sheet the profile is the same. Where a beam is thinner than a pixel it is shown as wide as one, with
the same light in all.
"""

from __future__ import annotations

import math
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.phase import henyey_greenstein
from pelagos.optics.sight_line import SightLines, waters_at
from pelagos.optics.transport import WITHIN_FIVE_DEGREES
from pelagos.optics.water import MEAN_COSINE, WaterArrays

_PIXEL: Final = 0.6  # of a pixel's width: least 1/e^2 radius that is shown
_EDGE: Final = 0.02  # [rad] over which a fan's light begins
_LINE: Final = math.sqrt(2 / math.pi)  # of a Gaussian profile across a line


@jit.struct
class LaserBeam:
    """One laser at the moments of the lanes, a Dr.Jit struct.

    Attributes:
        position: `Array3f`, relative to the camera, world axes [m].
        axis: `Array3f`, unit, world axes.
        across: `Array3f`, unit, square to the sheet of a line laser; world axes.
        flux: `Array3f` [lm].
        waist: `Float`, 1/e^2 radius at the laser [m].
        spread: `Float`, half of the divergence [rad].
        fan: `Float`, full angle of the sheet [rad]; None for a dot.
    """

    position: Array
    axis: Array
    across: Array
    flux: Array
    waist: Array
    spread: Array
    fan: Array | None


def laser_loss(water: WaterArrays) -> Array:
    """Rate at which the beam's light is lost for its dot: a + b / 2, what is scattered by less than five degrees still
    belongs to it [1/m]."""
    return water.absorption + (1 - WITHIN_FIVE_DEGREES) * water.scattering


def laser_at(laser: LaserBeam, loss: Array, point: Array, footprint: Array) -> tuple[Array, Array, Array]:
    """Irradiance across the beam [lx] at a point, with `loss` [1/m] on the way; direction to the laser; distance [m].

    Args:
        laser: see `LaserBeam`.
        loss: `Array3f`.
        point: `Array3f`, relative to the camera, world axes [m].
        footprint: width of a pixel there [m].
    """
    offset = point - laser.position
    distance = dr.maximum(dr.norm(offset), 1e-3)
    ahead = dr.dot(offset, laser.axis)
    if laser.fan is None:
        aside = offset - ahead * laser.axis
        w2 = _width2(laser, ahead, footprint)
        density = 2 / (math.pi * w2) * dr.exp(-2 * dr.dot(aside, aside) / w2)
    else:
        out = dr.dot(offset, laser.across)
        along = dr.sqrt(dr.maximum(distance * distance - out * out, 1e-6))
        w2 = _width2(laser, along, footprint)
        density = _in_fan(laser, laser.fan, offset) / along * (_LINE * dr.rsqrt(w2)) * dr.exp(-2 * out * out / w2)
    density = dr.select(ahead > 0, density, 0)
    return laser.flux * density * dr.exp(-loss * distance), -offset / distance, distance


def laser_glow(
    laser: LaserBeam, water: WaterArrays, direction: Array, reach: Array, pixel_angle: float,
    lines: SightLines | None = None,
) -> tuple[Array, Array]:  # fmt: skip
    """Radiance that the beam or sheet in the water sends along a camera ray, single scattering, and where from.

    Args:
        laser, water: see `laser_at`.
        direction: `Array3f`, unit, from the camera.
        reach: length of the ray in water [m].
        pixel_angle: angle between neighbouring pixels [rad].
        lines: see `lamp_backscatter`.

    Returns:
        `Array3f` [cd/m^2], and the place of the beam next to the ray, `Array3f` relative to the camera [m].
    """
    if laser.fan is None:
        b = dr.dot(direction, laser.axis)
        sine2 = dr.maximum(1 - b * b, 1e-4)
        ahead = (b * dr.dot(direction, laser.position) - dr.dot(laser.axis, laser.position)) / sine2
        place = laser.position + laser.axis * ahead
        s = dr.dot(direction, place)
        missed = place - direction * s
        w2 = _width2(laser, ahead, pixel_angle * dr.maximum(s, 0))
        column = _LINE * dr.rsqrt(w2 * sine2) * dr.exp(-2 * dr.dot(missed, missed) / w2)
        there = ahead > 0
    else:
        slope = dr.dot(direction, laser.across)
        slope = dr.select(dr.abs(slope) < 1e-4, 1e-4, slope)
        s = dr.dot(laser.position, laser.across) / slope
        place = direction * s
        offset = place - laser.position
        column = _in_fan(laser, laser.fan, offset) / (dr.maximum(dr.norm(offset), 0.02) * dr.abs(slope))
        there = dr.dot(offset, laser.axis) > 0
    offset = place - laser.position
    way = dr.norm(offset)
    turn = -dr.dot(direction, offset) / dr.maximum(way, 1e-3)
    mean, here = (water, water) if lines is None else waters_at(lines, water, s)
    beta = here.water_scattering / (4 * math.pi) + here.particle_scattering * henyey_greenstein(turn, MEAN_COSINE)
    kept = dr.exp(-laser_loss(mean) * (way + dr.maximum(s, 0)))
    seen = there & (s > 0) & (s < reach)
    return dr.select(seen, laser.flux * (column * beta) * kept, 0), place


def _width2(laser: LaserBeam, ahead: Array, footprint: Array) -> Array:
    """Square of the 1/e^2 radius as it is shown [m^2]."""
    return dr.square(laser.waist) + dr.square(laser.spread * ahead) + dr.square(_PIXEL * footprint)


def _in_fan(laser: LaserBeam, fan: Array, offset: Array) -> Array:
    """Share of the flux per radian of the fan in the direction of a point [1/rad]."""
    side = dr.dot(offset, dr.cross(laser.across, laser.axis))
    angle = dr.abs(dr.atan2(side, dr.dot(offset, laser.axis)))
    return dr.clip((0.5 * fan - angle) / _EDGE + 0.5, 0, 1) / fan
