"""From light to a picture: how long and how sensitive, and how numbers become 8 bits.

A pixel is full at the luminance L_sat = 78 N^2 / (t S) (ISO 12232:2019, saturation-based speed), with aperture N,
exposure time t [s] and speed S (ISO).
"""

from __future__ import annotations

import drjit as dr

from pelagos import jit
from pelagos.jit import Array

SATURATION = 78.0  # [cd s / m^2]
GREY = 0.18  # reflectance that a meter takes the world for


def saturation_luminance(aperture: Array, shutter: Array, iso: Array) -> Array:
    """Luminance that fills a pixel [cd/m^2] for aperture N, exposure time [s] and ISO speed."""
    return SATURATION * aperture * aperture / (shutter * iso)


def metered(
    mean: Array, *, aperture: float, longest: float, shortest: float, iso: tuple[float, float], compensation: float
) -> tuple[Array, Array]:
    """Exposure time [s] and ISO speed that make the mean luminance of a frame middle grey.

    Time first, at the lowest speed; what the longest time does not give, the speed does. The frame meters itself, so
    the choice has no memory.

    Args:
        mean: of the frame, `Float` [cd/m^2].
        aperture: f-number.
        longest, shortest: exposure time [s].
        iso: least and greatest speed.
        compensation: [stops], positive is brighter.
    """
    wanted = SATURATION * aperture**2 * GREY * 2.0**compensation / dr.maximum(mean, 1e-9)  # t S
    shutter = dr.clip(wanted / iso[0], shortest, longest)
    return shutter, dr.clip(wanted / shutter, iso[0], iso[1])


def luminance(colour: Array) -> Array:
    """Weighted mean of linear red, green, blue (Rec. 709)."""
    return 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2]


def shoulder(x: Array, knee: float) -> Array:
    """Linear up to `knee`, then bending smoothly towards 1: highlights roll off instead of clipping. knee = 1 clips."""
    if knee >= 1:
        return dr.clip(x, 0, 1)
    over = dr.maximum(x - knee, 0) / (1 - knee)
    return dr.clip(dr.select(x < knee, x, knee + (1 - knee) * (over / (1 + over))), 0, 1)


def encode_srgb(x: Array) -> Array:
    """Linear 0 .. 1 to sRGB (IEC 61966-2-1)."""
    return dr.select(x <= 0.0031308, 12.92 * x, 1.055 * dr.power(dr.maximum(x, 1e-6), 1 / 2.4) - 0.055)


def to_bits(x: Array, bits: int) -> Array:
    """0 .. 1 to whole numbers, `UInt32`, rounded."""
    return jit.UInt32(dr.clip(x, 0, 1) * (2**bits - 1) + 0.5)
