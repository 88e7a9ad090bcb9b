"""Windows of underwater housings: how a flat or a domed port bends the rays of the lens behind it. NumPy, float64.

Exact refraction at both faces (Snell's law); the air side has index 1. Frame: sensor, x forward along the lens's
axis, the entrance pupil at the origin. Source: A. Jordt, Underwater 3D Reconstruction Based on Physical Models for
Refraction, thesis, Kiel 2014, Chapters 3 and 4.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.optics.water import REFRACTIVE_INDEX

GLASS_INDEX: Final = 1.49  # acrylic

Rays = tuple[NDArray[np.float64], NDArray[np.float64]]


def through_flat_port(
    directions: NDArray[np.float64], *, distance: float, thickness: float, outside: float = REFRACTIVE_INDEX
) -> Rays:
    """Starts on the wet face [m] and directions in the water, each `(..., 3)`, of rays that leave the pupil in air.

    Args:
        directions: `(..., 3)` unit, in air; those that do not meet the port become NaN.
        distance: from the pupil to the dry face [m].
        thickness: of the glass [m].
        outside: index behind the port; 1 where it is out of the water.
    """
    normal = np.array([-1.0, 0.0, 0.0])
    d = np.where(directions[..., :1] > 1e-6, directions, np.nan)
    start = d * (distance / d[..., :1])
    inside = refract_np(d, normal, 1 / GLASS_INDEX)
    start = start + inside * (thickness / inside[..., :1])
    return start, refract_np(inside, normal, GLASS_INDEX / outside)


def through_dome_port(
    directions: NDArray[np.float64],
    *,
    radius: float,
    thickness: float,
    offset: tuple[float, float, float],
    outside: float = REFRACTIVE_INDEX,
) -> Rays:
    """The same for a spherical dome: concentric with the pupil it bends nothing.

    Args:
        directions: see `through_flat_port`.
        radius: of the dry face [m].
        thickness: of the glass [m].
        offset: of the dome's centre from the pupil [m].
        outside: see `through_flat_port`.
    """
    centre = np.asarray(offset)
    dry = _sphere(np.zeros_like(directions), directions, centre, radius)
    inside = refract_np(directions, (centre - dry) / radius, 1 / GLASS_INDEX)
    wet = _sphere(dry, inside, centre, radius + thickness)
    return wet, refract_np(inside, (centre - wet) / (radius + thickness), GLASS_INDEX / outside)


def refract_np(direction: NDArray[np.float64], normal: NDArray[np.float64], eta: float) -> NDArray[np.float64]:
    """Snell's law with a unit `normal` against `direction`; eta is near index over far; NaN past the critical angle."""
    cosine = -np.sum(direction * normal, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore"):
        far = np.sqrt(1 - eta * eta * (1 - cosine * cosine))
    return np.asarray(eta * direction + (eta * cosine - far) * normal)


def _sphere(
    start: NDArray[np.float64], direction: NDArray[np.float64], centre: NDArray[np.float64], radius: float
) -> NDArray[np.float64]:
    """Points at which rays from inside leave a sphere; NaN from outside."""
    to_centre = centre - start
    along = np.sum(to_centre * direction, axis=-1, keepdims=True)
    off2 = np.sum(to_centre * to_centre, axis=-1, keepdims=True) - along**2
    with np.errstate(invalid="ignore"):
        half = np.sqrt(radius**2 - off2)
    return np.asarray(start + direction * (along + half))
