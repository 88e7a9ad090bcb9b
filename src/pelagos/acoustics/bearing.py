"""Directions from the phases at the elements of a small array.

Source: H. L. Van Trees, Optimum Array Processing (2002), Sections 2.3 (phases of a plane wave) and 8.4 (bounds).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def array_rank(elements: NDArray[np.float64]) -> int:
    """1 for elements `(k, 3)` on a line, 2 in a plane, 3 in space."""
    return int(np.linalg.matrix_rank(elements - elements.mean(axis=0), tol=1e-9))


def direction_of(azimuth: float, elevation: float) -> NDArray[np.float64]:
    """Unit vector `(3,)`, x ahead, y to the left, z up, of angles [rad]."""
    level = math.cos(elevation)
    return np.array([level * math.cos(azimuth), level * math.sin(azimuth), math.sin(elevation)])


def angles_of(direction: NDArray[np.float64]) -> tuple[float, float]:
    """Azimuth, positive to the left, and elevation, positive up, of a direction `(3,)` [rad]."""
    x, y, z = direction.tolist()
    return math.atan2(y, x), math.atan2(z, math.hypot(x, y))


def turned(vector: NDArray[np.float64], turn: NDArray[np.float64]) -> NDArray[np.float64]:
    """A vector `(3,)` turned about an axis by the length of `turn` `(3,)` [rad], right-handed.

    Source: O. Rodrigues, J. Math. Pures Appl. 5, 380 (1840): v cos t + (k x v) sin t + k (k . v)(1 - cos t).
    """
    angle = float(np.linalg.norm(turn))
    if angle == 0.0:
        return vector
    axis = turn / angle
    along = float(axis @ vector) * (1.0 - math.cos(angle))
    return np.asarray(vector * math.cos(angle) + np.cross(axis, vector) * math.sin(angle) + axis * along)


def scattered(direction: NDArray[np.float64], across: tuple[float, float]) -> NDArray[np.float64]:
    """Unit vector `(3,)` that lies off a unit `direction` along a great circle.

    Args:
        direction: `(3,)`.
        across: angles to the left and upwards, across the direction [rad].
    """
    azimuth, _ = angles_of(direction)
    left = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
    up = np.cross(direction, left)
    return turned(direction, across[0] * up - across[1] * left)


def element_phases(
    elements: NDArray[np.float64],
    directions: NDArray[np.float64],
    amplitudes: NDArray[np.complex128],
    wavelength: float,
) -> NDArray[np.complex128]:
    """`(k,)` complex pressure at elements `(k, 3)` [m] from waves that come from unit `directions` `(a, 3)`."""
    turn = 2.0 * math.pi / wavelength * (elements @ directions.T)
    return np.asarray(np.exp(1j * turn) @ amplitudes)


def direction_from_phases(
    elements: NDArray[np.float64], pressure: NDArray[np.complex128], wavelength: float, near: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Unit vector towards the source by least squares.

    Whole turns of phase are taken from a direction `near` (from the coarse time differences of a wide-band signal). An
    array in a plane finds two components; the third has the side of `near`.

    Args:
        elements: `(k, 3)` in the sensor frame [m], not on a line.
        pressure: `(k,)` complex.
        wavelength: [m].
        near: unit vector, good to half a wavelength over the array.
    """
    centred = elements - elements.mean(axis=0)
    k = 2.0 * math.pi / wavelength
    expected = k * centred @ near
    mean = np.angle(np.sum(pressure * np.exp(-1j * expected)))
    phase = expected + np.angle(pressure * np.exp(-1j * (expected + mean)))
    phase -= phase.mean()
    found = np.asarray(np.linalg.lstsq(k * centred, phase, rcond=1e-9)[0])
    if array_rank(elements) < 3:
        _, _, axes = np.linalg.svd(centred)
        normal = axes[2]
        within = found - (found @ normal) * normal
        size = float(within @ within)
        if size >= 1.0:
            return np.asarray(within / math.sqrt(size))
        return np.asarray(within + math.copysign(math.sqrt(1.0 - size), float(near @ normal)) * normal)
    return np.asarray(found / np.linalg.norm(found))


def bearing_bound(elements: NDArray[np.float64], wavelength: float, snr: float) -> NDArray[np.float64]:
    """Cramer-Rao bound of the direction cosines along the array's own axes, `(rank,)` standard deviations [1].

    Phases with the variance 1/(2 snr) each: sigma_u = 1/(k sqrt(2 snr sum x_i^2)).
    """
    centred = elements - elements.mean(axis=0)
    spread = np.linalg.svd(centred, compute_uv=False)[: array_rank(elements)]
    return np.asarray(wavelength / (2.0 * math.pi) / (spread * math.sqrt(2.0 * snr)))
