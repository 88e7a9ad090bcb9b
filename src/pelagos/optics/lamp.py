"""Lamps of a vehicle: what they light up, and what the water in their cones sends back. Lanes are camera rays."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.phase import henyey_greenstein
from pelagos.optics.sight_line import SightLines, waters_at
from pelagos.optics.water import MEAN_COSINE, WaterArrays

_SAMPLES: Final = 6  # along a ray through the cone
_IN_LAYERS: Final = 20  # the same where the water differs along it
_NEAREST: Final = 0.05  # [m], a lamp is not a point closer than this
SHADE_PARTS: Final = 4  # of a ray, in which shadows are told apart


@dataclass
class Beam:
    """One lamp at the moments of the lanes, a Dr.Jit struct.

    Attributes:
        position: `Array3f`, relative to the camera, world axes [m].
        axis: `Array3f`, unit, world axes.
        intensity: `Array3f`, on the axis [cd].
        inner, outer: `Float`, cosine of the angle within which it is full, and beyond which it is none.
        shade: `Array4f`, share of its light that comes past what stands around to the water on the camera's ray, in
            `SHADE_PARTS` parts of equal angle seen from the lamp, nearest first; None where nothing stands around.
    """

    position: Array
    axis: Array
    intensity: Array
    inner: Array
    outer: Array
    shade: Array | None = None


def axis_intensity(flux: float, beam_angle: float) -> float:
    """Candela on the axis of a lamp of `flux` [lm] whose light falls smoothly to none at half of `beam_angle` [rad]."""
    return flux / (2 * math.pi * (1 - math.cos(0.5 * beam_angle)) * 0.62)


def lamp_beam_at(lamp: Beam, loss: Array, point: Array) -> tuple[Array, Array, Array]:
    """Irradiance across the beam at a point with `loss` [1/m] on the way [lx], direction to the lamp, distance [m]."""
    to_lamp = lamp.position - point
    r = dr.maximum(dr.norm(to_lamp), _NEAREST)
    direction = to_lamp / r
    return lamp.intensity * _cone(lamp, direction) * dr.exp(-loss * r) / (r * r), direction, r


def lamp_backscatter(
    lamp: Beam, water: WaterArrays, direction: Array, reach: Array, lines: SightLines | None = None
) -> Array:
    """Radiance that the water along a camera ray sends back from one lamp, `Array3f` [cd/m^2], single scattering.

    The integral over the ray of I(angle) exp(-k (r + s)) beta(angle) / r^2 ds, with steps of equal angle seen from
    the lamp (C. Kulla and M. Fajardo 2012, doi 10.1111/j.1467-8659.2012.03148.x), which makes 1 / r^2 harmless.

    Args:
        lamp: see `Beam`.
        water: its optics.
        direction: `Array3f`, unit, from the camera.
        reach: `Float`, length of the ray in water [m].
        lines: of sight, where the water differs along them; the way from the lamp goes through the same.
    """
    nearest, off_axis, first, last = _angles(lamp, direction, reach)
    samples = _SAMPLES if lines is None else _IN_LAYERS
    step = (last - first) / samples
    mean, here = water, water
    total = jit.Array3f(0)
    for k in range(samples):
        tangent = dr.tan(first + step * (k + 0.5))
        s = nearest + off_axis * tangent
        r = off_axis * dr.sqrt(1 + tangent * tangent)
        to_lamp = (lamp.position - s * direction) / r
        turn = dr.dot(direction, to_lamp)  # the light goes on along -to_lamp and is turned towards -direction
        if lines is not None:
            mean, here = waters_at(lines, water, s)
        keep = mean.absorption + mean.backscatter
        beta = here.water_scattering / (4 * math.pi) + here.particle_scattering * henyey_greenstein(turn, MEAN_COSINE)
        # ds = off_axis (1 + tan^2) d(angle) = r^2 / off_axis d(angle): the r^2 of spreading cancels
        lit = _cone(lamp, to_lamp) * _unshaded(lamp, (k + 0.5) / samples)
        total += lit * dr.exp(-keep * (r + dr.maximum(s, 0))) * beta * (step / off_axis)
    return total * lamp.intensity


def seen_from(lamp: Beam, direction: Array, reach: Array, share: Array) -> tuple[Array, Array, Array]:
    """The place on a camera's ray at a share of the angle that the ray spans seen from a lamp.

    Returns:
        distance from the camera [m]; place relative to it, `Array3f` [m]; its distance from the lamp [m].
    """
    nearest, off_axis, first, last = _angles(lamp, direction, reach)
    s = nearest + off_axis * dr.tan(dr.lerp(first, last, share))
    place = s * direction
    return s, place, dr.norm(lamp.position - place)


def _angles(lamp: Beam, direction: Array, reach: Array) -> tuple[Array, Array, Array, Array]:
    """Closest place of a camera's ray to a lamp [m], its distance [m], and the angles between which it runs [rad]."""
    nearest = dr.dot(lamp.position, direction)
    off_axis = dr.maximum(dr.norm(lamp.position - nearest * direction), _NEAREST)
    return nearest, off_axis, dr.atan2(-nearest, off_axis), dr.atan2(reach - nearest, off_axis)


def _unshaded(lamp: Beam, share: float) -> Array:
    """Share of the light that comes to a place, between the middles of the parts."""
    if lamp.shade is None:
        return 1.0
    x = min(max(share * SHADE_PARTS - 0.5, 0.0), SHADE_PARTS - 1.0)
    k = min(int(x), SHADE_PARTS - 2)
    return dr.lerp(lamp.shade[k], lamp.shade[k + 1], x - k)


def _cone(lamp: Beam, to_lamp: Array) -> Array:
    t = dr.clip((-dr.dot(lamp.axis, to_lamp) - lamp.outer) / (lamp.inner - lamp.outer), 0, 1)
    return t * t * (3 - 2 * t)
