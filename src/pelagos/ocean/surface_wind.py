"""The wind that roughens an ocean's surface, and how much of the roughness its own waves hold. NumPy; run once."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from pelagos.ocean.wave_system import Components
from pelagos.ocean.whitecaps import wind_behind

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean
    from pelagos.ocean.waves import Waves


def surface_wind(ocean: Ocean) -> tuple[float, float | None]:
    """Speed 10 m up [m/s] and direction that it blows towards, from north to west [rad].

    Of the ocean's wind; without one, that which would raise its waves, and no direction.
    """
    if ocean.air.blows:
        speed, north, west = (float(np.array(v)[0]) for v in (ocean.air.speed, ocean.air.north, ocean.air.west))
        return speed, math.atan2(west, north)
    return (0.0 if ocean.waves is None else wind_behind(_components(ocean.waves))), None


def wave_slope(ocean: Ocean, shortest: float) -> float:
    """Mean square slope, both directions together, of the ocean's waves longer than `shortest` [m]."""
    if ocean.waves is None:
        return 0.0
    waves = _components(ocean.waves)
    long = waves.wavenumber < 2 * math.pi / shortest
    return 0.5 * float(np.sum((waves.amplitude * waves.wavenumber)[long] ** 2))


def _components(waves: Waves) -> Components:
    rows = np.array(waves.table).reshape(-1, 8)
    x, y, omega, phase = 2 * math.pi * rows[:, :4].T
    return Components(rows[:, 4], omega, rows[:, 5], np.arctan2(y, x), phase)
