"""The coordinates of a rigid body that a record may hold, by name."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

COORDINATES: Final = ("north", "east", "depth", "roll", "pitch", "heading", "u", "v", "w", "p", "q", "r")
"""Position NED [m], Euler angles zyx [rad], velocity over ground in body axes FRD [m/s], [rad/s]."""
UNITS: Final = ("m", "m", "m", "rad", "rad", "rad", "m/s", "m/s", "m/s", "rad/s", "rad/s", "rad/s")
ANGLES: Final = ("roll", "pitch", "heading")
RATES: Final = dict(zip(COORDINATES[:6], COORDINATES[6:], strict=True))
"""The velocity that belongs to a coordinate of the pose."""
PLAUSIBLE: Final = dict(
    zip(COORDINATES, (1e7, 1e7, 12000.0, 6.5, 6.5, 700.0, 60.0, 60.0, 60.0, 20.0, 20.0, 20.0), strict=True)
)
"""Largest size of a value in SI units that a marine vehicle may have; more is another unit or a fault. A heading may
count on through many turns."""

STILL: Final = 1e-9
"""Standard deviation below which a coordinate does not change [SI]: digits of its numbers."""

START_SPREAD: Final = dict(zip(COORDINATES, (1.0, 1.0, 1.0, 0.1, 0.1, 1.0, 0.3, 0.3, 0.3, 0.1, 0.1, 0.1), strict=True))
"""Standard deviation, at the beginning of a shot, of coordinates that were not measured: wide for a vehicle that floats
or hovers upright. A plan may say others."""


_NORMAL: Final = 1.4826  # standard deviations of normal noise in its median size


def normal_size(differences: NDArray[np.float64]) -> float:
    """Standard deviation of normal noise with the median size of `differences` `(n,)`, about 0."""
    return _NORMAL * float(np.median(np.abs(differences)))


def number(name: str) -> int:
    """Place of a coordinate among the twelve."""
    return COORDINATES.index(name)
