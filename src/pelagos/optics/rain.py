"""Streaks of rain drops that fall past the eye while the shutter is open.

Space before the eye is cut into shells, a shell into cells that hold a drop half of the time, of the size that carries
most water. What a drop covers for a part of the exposure, it covers with that share of its brightness (K. Garg and
S. K. Nayar, Int. J. Comput. Vis. 75:3, 2007, doi 10.1007/s11263-006-0028-6). Drops farther off than a few metres are
finer than pixels: they belong to the rain's extinction.
"""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.texture import hashed

_NEAREST: Final = 0.5  # [m]
_FACTOR: Final = 1.5
_SHELLS: Final = 6  # out to 6 m
_FILLED: Final = 0.5  # share of the cells that hold a drop
_ROOM: Final = 0.3  # [m] that a cell is higher than a streak
_NUMBER: Final = 8000.0  # N0 of Marshall and Palmer [1/(m^3 mm)]


def median_diameter(rate: Array) -> Array:
    """Drop diameter [m] that halves the rain's water, 3.67/Lambda; Lambda = 4.1 R^-0.21 per mm.

    Source: J. S. Marshall and W. McK. Palmer, J. Meteorol. 5:165 (1948); `rate` R [mm/h].
    """
    return 1e-3 * 3.67 / 4.1 * dr.maximum(rate, 1e-3) ** 0.21


def fall_speed(diameter: Array) -> Array:
    """Of a drop [m/s]: 9.65 - 10.3 exp(-0.6 D/mm) (D. Atlas et al., Rev. Geophys. 11:1, 1973), at least 1."""
    return dr.maximum(9.65 - 10.3 * dr.exp(-600.0 * diameter), 1.0)


def drops_per_m3(rate: Array, least: float = 1.0) -> Array:
    """Number of drops larger than `least` [mm] in a cubic metre, N0/Lambda exp(-Lambda D) (Marshall and Palmer)."""
    slope = 4.1 * dr.maximum(rate, 1e-3) ** -0.21
    return _NUMBER / slope * dr.exp(-slope * least)


def streaks(direction: Array, reach: Array, rate: Array, moment: Array, exposure: Array, pixel_angle: float) -> Array:
    """Share of each pixel's exposure that drops cover, `Float`.

    Args:
        direction: of the rays, unit `Array3f`.
        reach: length of the ray in air [m].
        rate: of rainfall [mm/h].
        moment: `UInt32`, another one another fall of drops.
        exposure: [s].
        pixel_angle: angle between neighbouring pixels [rad].
    """
    diameter = median_diameter(rate)
    length = fall_speed(diameter) * exposure
    tall = length + _ROOM
    level = dr.maximum(dr.sqrt(direction.x * direction.x + direction.y * direction.y), 0.05)
    azimuth, rise = dr.atan2(direction.y, direction.x), direction.z / level
    cover = jit.Float(0)
    for shell in range(_SHELLS):
        distance = _NEAREST * _FACTOR**shell
        pixel = distance / level * pixel_angle
        across = _FILLED / (drops_per_m3(rate) * tall * distance * (_FACTOR - 1))
        u, v = azimuth * distance / across, rise * distance / tall + 64.0
        i, j = dr.floor(u), dr.floor(v)
        cell = jit.UInt32(jit.Int32(i)) * 0x8DA6B343 ^ jit.UInt32(jit.Int32(j)) * 0xD8163841
        seed = cell ^ moment ^ jit.UInt32(0x9E3779B9 * (shell + 1) & 0xFFFFFFFF)
        draws = [0.5 + 0.5 * hashed(seed + (k * 0x85EBCA6B & 0xFFFFFFFF)) for k in range(3)]
        side = dr.abs(u - i - draws[0]) * across
        height = (v - j) * tall - draws[1] * _ROOM
        wide = dr.clip((0.5 * dr.maximum(diameter, pixel) - side) / pixel + 0.5, 0, 1) * dr.minimum(diameter / pixel, 1)
        along = dr.clip(dr.minimum(height, length - height) / pixel + 0.5, 0, 1)
        single = dr.clip(across / pixel - 1, 0, 1)  # finer ones are haze
        seen = wide * along * single * dr.minimum(diameter / length, 1)
        cover += dr.select((distance < reach * level) & (draws[2] < _FILLED), seen, 0)
    return dr.minimum(cover, 1)
