"""Wind and rain over a sonar: one wind for the waves, the noise, the bubbles and the pictures of a scenario."""

from __future__ import annotations

import math
import warnings
from types import SimpleNamespace
from typing import TYPE_CHECKING, Final

import numpy as np

from pelagos.errors import ValidityWarning
from pelagos.ocean.whitecaps import wind_behind

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean

_ALIKE: Final = 0.05  # [m/s]


def wind_over(ocean: Ocean) -> float:
    """Mean wind 10 m above the sea [m/s]: the scenario's, or the one that would raise its waves; 0 without either."""
    if ocean.air.blows:
        return float(np.array(ocean.air.speed)[0])
    if ocean.waves is None:
        return 0.0
    table = np.array(ocean.waves.table).reshape(-1, 8)
    return wind_behind(SimpleNamespace(amplitude=table[:, 4], omega=2.0 * math.pi * table[:, 2]))  # type: ignore[arg-type]


def rain_over(ocean: Ocean) -> float:
    """Rain on the sea [mm/h]."""
    return float(ocean.rain)


def wind_for(own: float | None, ocean: Ocean, path: str) -> float:
    """Wind of a sonar [m/s]: its own key, where it has one, or the scenario's.

    Warns (`ValidityWarning`) where both are told and differ.
    """
    over = wind_over(ocean)
    if own is None:
        return over
    if ocean.air.blows and abs(own - over) > _ALIKE:
        message = (
            f"{path}: wind_speed_mps {own:g} overrides the scenario's wind of {over:g} m/s; leave it out to follow"
        )
        warnings.warn(message, ValidityWarning, stacklevel=4)
    return own
