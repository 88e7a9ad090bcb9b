"""Speeds from shifted echoes: errors of the estimate, and the way from beams to a vector.

Sources: B. H. Brumley, R. G. Cabrera, K. L. Deines, E. A. Terray, IEEE J. Ocean. Eng. 16, 402 (1991),
doi 10.1109/48.90905 (broadband pulse pairs); Teledyne RD Instruments, Acoustic Doppler Current Profiler: Principles of
Operation (2011), Sections 2-4 (Janus beams).
"""

from __future__ import annotations

import math

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array


def janus_beams(tilt: float, azimuths: tuple[float, ...]) -> NDArray[np.float64]:
    """Unit vectors `(beams, 3)`, forward-left-up, of beams that look down, `tilt` [rad] off the vertical."""
    a = np.asarray(azimuths)
    down = np.full(len(a), -math.cos(tilt))
    return np.stack([math.sin(tilt) * np.cos(a), math.sin(tilt) * np.sin(a), down], axis=-1)


def heard_water(free: list[Array], reach: Array, cosine: float) -> list[Array]:
    """Slanted beams that hear the water as far as `reach`: `Bool` each.

    A beam ends where it meets something; and on all of them side lobes bring the echo that comes straight from what
    lies nearest, level, as far along the beams as it is deep: at `cosine` times the range along the beam (Teledyne RD
    Instruments 2011: near the bottom).

    Args:
        free: range along each beam to what it meets, infinite without [m].
        reach: far end of the water, along the beams [m].
        cosine: of the beams' tilt.
    """
    nearest = dr.minimum(dr.minimum(free[0], free[1]), dr.minimum(free[2], free[3]))
    return [(distance > reach) & (nearest * cosine > reach) for distance in free]


def velocity_from_beams(speeds: list[Array], valid: list[Array], beams: NDArray[np.float64]) -> tuple[Array, Array]:
    """The velocity whose components along the valid beams fit best, and whether three beams or more determine it.

    Args:
        speeds: component of the velocity along each beam [m/s].
        valid: `Bool` each.
        beams: `(beams, 3)` unit vectors.

    Returns:
        `Array3f64` [m/s], zero where undetermined, and `Bool`. Least squares by the normal equations.
    """
    xx = yy = zz = xy = xz = yz = jit.Float64(0)
    bx = by = bz = jit.Float64(0)
    count = jit.UInt32(0)
    for speed, ok, (x, y, z) in zip(speeds, valid, beams, strict=True):
        w = dr.select(ok, jit.Float64(1), 0.0)
        xx, yy, zz = xx + w * x * x, yy + w * y * y, zz + w * z * z
        xy, xz, yz = xy + w * x * y, xz + w * x * z, yz + w * y * z
        s = dr.select(ok, speed, 0.0)
        bx, by, bz = bx + s * x, by + s * y, bz + s * z
        count += dr.select(ok, jit.UInt32(1), 0)
    cx, cy, cz = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    determinant = xx * cx + xy * cy + xz * cz
    solved = (count >= 3) & (dr.abs(determinant) > 1e-9)
    scale = dr.select(solved, 1.0 / dr.select(solved, determinant, 1.0), 0.0)
    velocity = jit.Array3f64(
        (cx * bx + cy * by + cz * bz) * scale,
        (cy * bx + (xx * zz - xz * xz) * by + (xy * xz - xx * yz) * bz) * scale,
        (cz * bx + (xy * xz - xx * yz) * by + (xx * yy - xy * xy) * bz) * scale,
    )
    return velocity, solved


def echo_margin_db(distance: Array, reach: Array, absorption: Array) -> Array:
    """Level of a bottom echo over that at the distance `reach` [dB]: 30 log10(reach/r) + 2 a (reach - r).

    The echo of a bottom that fills a beam falls with 30 log r (Urick 1983, Section 8.12).
    """
    ratio = dr.maximum(reach, 1e-3) / dr.maximum(distance, 1e-3)
    return 30.0 * 0.30102999566398120 * dr.log2(ratio) + 2.0 * absorption * (reach - distance)
