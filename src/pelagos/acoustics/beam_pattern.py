"""Beam patterns of apertures: lines, pistons, weighted arrays.

All patterns are amplitudes, 1 on axis, for one way; `sine` is the sine of the angle off axis.
Source: H. L. Van Trees, Optimum Array Processing (2002), Chapters 2 and 3, doi 10.1002/0471221104.
"""

from __future__ import annotations

from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos.jit import Array

HALF_POWER_LINE: Final = 0.8858929413789  # width at -3 dB of a uniform line [wavelength / length]
FIRST_NULL_LINE: Final = 1.0  # sine of the first null of a uniform line [wavelength / length]
_COSINE_SHARE: Final = {"uniform": 1.0, "light": 0.75, "hamming": 0.54, "hann": 0.5}


def line(sine: Array, length: Array) -> Array:
    """Uniform line aperture: sin(u)/u, u = pi L sine; `length` L [wavelengths]. First side lobe -13.26 dB."""
    u = dr.pi * length * sine
    small = dr.abs(u) < 1e-4
    return dr.select(small, 1.0 - u * u / 6.0, dr.sin(u) / dr.select(small, 1.0, u))


def elements(sine: Array, count: int) -> Array:
    """Array of `count` point elements half a wavelength apart: sin(N u)/(N sin u), u = pi sine / 2."""
    u = 0.5 * dr.pi * sine
    small = dr.abs(dr.sin(u)) < 1e-6
    return dr.select(small, 1.0, dr.sin(count * u) / (count * dr.select(small, 1.0, dr.sin(u))))


def line_length(width_rad: float) -> float:
    """Length [wavelengths] of the uniform line whose half-power width is `width_rad` (full width, one way)."""
    return HALF_POWER_LINE / (2.0 * float(np.sin(0.5 * width_rad)))


def line_np(sine: NDArray[np.float64], length: float) -> NDArray[np.float64]:
    """`line` for NumPy arrays, of any shape, used where tables are made on the host."""
    return np.sinc(length * sine)


def weighted_line_np(sine: NDArray[np.float64], length: float, shading: str) -> NDArray[np.float64]:
    """Pattern of a line with a shading, same shape as `sine`, amplitude 1 on axis.

    Args:
        sine: sine of the angle off axis.
        length: aperture [wavelengths].
        shading: "uniform" (side lobes -13.3 dB), "light" (-21.2 dB), "hamming" (-42.7 dB) or "hann" (-31.5 dB, falling
            fast): raised-cosine weights a + (1 - a) cos(2 pi x / L), F. J. Harris, Proc. IEEE 66, 51 (1978),
            doi 10.1109/PROC.1978.10837.
    """
    alpha = _COSINE_SHARE[shading]
    u: Any = length * sine
    side = 0.5 * (1.0 - alpha) * (np.sinc(u - 1.0) + np.sinc(u + 1.0))
    return np.asarray((alpha * np.sinc(u) + side) / alpha)


def line_weights(place: NDArray[np.float64], shading: str) -> NDArray[np.float64]:
    """Weights of a line with a shading at places in parts of its length, -1/2 to 1/2, same shape: those whose pattern
    `weighted_line_np` is."""
    alpha = _COSINE_SHARE[shading]
    return np.asarray(alpha + (1.0 - alpha) * np.cos(2.0 * np.pi * place))


def shaded_line(sine: Array, length: Array, shading: str) -> Array:
    """`weighted_line_np` for Dr.Jit arrays."""
    share = _COSINE_SHARE[shading]
    if share == 1.0:
        return line(sine, length)
    u = length * sine
    side = 0.5 * (1.0 - share) * (line(u - 1.0, 1.0) + line(u + 1.0, 1.0))
    return (share * line(u, 1.0) + side) / share


SHADING_WIDTH: Final = {
    "uniform": 1.0,
    "light": 1.1294,
    "hamming": 1.4708,
    "hann": 1.6261,
}  # half-power width relative to uniform


def shaded_length(width_rad: float, shading: str) -> float:
    """Length [wavelengths] of the line with a shading whose half-power width at broadside is `width_rad`, one way."""
    return HALF_POWER_LINE * SHADING_WIDTH[shading] / (2.0 * float(np.sin(0.5 * width_rad)))


def equivalent_width(azimuths: NDArray[np.float64], width_rad: float, shading: str) -> NDArray[np.float64]:
    """Integral of each steered beam's power pattern, 1 on axis, over the angle `(beams,)` [rad].

    Over the sine of the angle it is the integral of the squared weights a + (1 - a) cos(2 pi x/L) over the square of
    their own (Parseval): (1 + ((1 - a)/a)^2/2)/L; steered by t it is wider by 1/cos t.

    Args:
        azimuths: beam directions `(beams,)` [rad].
        width_rad: half-power width at broadside, one way [rad].
        shading: see `weighted_line_np`.
    """
    share = _COSINE_SHARE[shading]
    noise = 1.0 + 0.5 * ((1.0 - share) / share) ** 2
    return np.asarray(noise / shaded_length(width_rad, shading) / np.maximum(np.cos(azimuths), 0.05))


def steering_matrix(azimuths: NDArray[np.float64], width_rad: float, shading: str, reach: int) -> NDArray[np.float32]:
    """Receive response of each beam to its neighbours, `(beams, 2 reach + 1)`, unit power in each row.

    Beam j of a line array steered to azimuth a_j answers a source in the direction of beam i with the pattern at
    sin a_i - sin a_j. Rows are normalised to unit power, so that a field of independent scatterers keeps its level.

    Args:
        azimuths: beam directions [rad], evenly spaced or not, `(beams,)`.
        width_rad: half-power width at broadside [rad], one way, of the shaded array.
        shading: see `weighted_line_np`.
        reach: neighbours on each side that are answered.
    """
    length = shaded_length(width_rad, shading)
    beams = len(azimuths)
    neighbour = np.arange(beams)[:, None] + np.arange(-reach, reach + 1)[None, :]
    inside = (neighbour >= 0) & (neighbour < beams)
    sine = np.sin(azimuths)
    offset = sine[np.clip(neighbour, 0, beams - 1)] - sine[:, None]
    response = np.where(inside, weighted_line_np(offset, length, shading), 0.0)
    return np.asarray(response / np.sqrt((response**2).sum(axis=1, keepdims=True)), dtype=np.float32)


def energy_reach(steering: NDArray[np.float32], *, lost: float = 0.03) -> int:
    """Neighbours on each side that hold all but the fraction `lost` of the power of every row of a steering matrix."""
    power = steering.astype(np.float64) ** 2
    reach: int = steering.shape[1] // 2
    for k in range(reach):
        if power[:, reach - k : reach + k + 1].sum(axis=1).min() >= 1.0 - lost:
            return k
    return reach


def spread_over_beam(
    length: float, places: NDArray[np.floating], *, ways: int = 2
) -> tuple[NDArray[np.float64], float]:
    """Angles within a line's main lobe where rays of equal weight stand, and the weight of all of them together.

    Args:
        length: aperture [wavelengths].
        places: even places in (0, 1): the share of the power pattern that lies to one side of each ray.
        ways: 2 for the pattern there and back, 1 for that of one way.

    Returns:
        angles off axis [rad], of the same shape, and the pattern's integral over the angle [rad].
    """
    limit = float(np.arcsin(min(1.0 / length, 1.0)))
    grid = np.linspace(-limit, limit, 4001)
    power = line_np(np.sin(grid), length) ** (2 * ways)
    share = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]))]) * (grid[1] - grid[0])
    return np.interp(places * share[-1], share, grid), float(share[-1])
