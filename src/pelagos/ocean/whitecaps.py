"""Whitecaps: water that falls too fast is foam, as much of it as the wind makes.

Crests break where the surface's downward acceleration comes near half of gravity's (M. S. Longuet-Higgins, J. Fluid
Mech. 151:457, 1985). In a sea of components, whose short end is cut off, the limit is set so that the share of the
surface beyond it is the whitecaps' of the wind: W = 3.84e-6 U^3.41 (E. C. Monahan and I. O'Muircheartaigh, J. Phys.
Oceanogr. 10:2094, 1980).
"""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import TYPE_CHECKING, Final

import numpy as np

from pelagos.math.constants import GRAVITY

if TYPE_CHECKING:
    from pelagos.ocean.wave_system import Components

NEVER: Final = 1e9  # a limit that nothing reaches
_DEVELOPED: Final = 0.051  # steepness 2 pi Hs / (g Tz^2) of a fully developed sea (Pierson and Moskowitz)
_SWELL: Final = (0.2, 0.5)  # of that: flatter seas are swell without whitecaps, steeper ones wind sea; assumed
_LEAST: Final = 1e-5  # share of the surface that is not worth drawing


def whitecap_share(wind: float) -> float:
    """Share of the surface that is white at a wind speed 10 m up [m/s]; measured between 2 and 17 m/s."""
    return min(3.84e-6 * math.pow(wind, 3.41), 0.5)


def wind_behind(components: Components) -> float:
    """Wind speed 10 m up [m/s] that would raise a sea like this one; 0 for swell."""
    m0, m2 = (0.5 * float(np.sum(components.amplitude**2 * components.omega**p)) for p in (0, 2))
    if m2 <= 0:
        return 0.0
    height = 4 * math.sqrt(m0)
    steepness = height * m2 / (2 * math.pi * GRAVITY * m0)  # Tz = 2 pi sqrt(m0 / m2)
    share = (steepness / _DEVELOPED - _SWELL[0]) / (_SWELL[1] - _SWELL[0])
    return min(max(share, 0.0), 1.0) * 0.93 * math.sqrt(height * GRAVITY / 0.21)  # Hs = 0.21 U19.5^2 / g


def breaking_limit(components: Components, wind: float | None) -> float:
    """Downward acceleration over gravity at which the surface turns white, for a wind 10 m up or the sea's own."""
    share = whitecap_share(wind_behind(components) if wind is None else wind)
    deviation = math.sqrt(0.5 * float(np.sum((components.amplitude * components.omega**2) ** 2))) / GRAVITY
    if share < _LEAST or deviation <= 0:
        return NEVER
    return -NormalDist().inv_cdf(share) * deviation
