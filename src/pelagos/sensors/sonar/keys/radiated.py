"""Vehicles that make noise, from a scenario's keys."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.acoustics.radiated_noise import propeller_level, ship_level
from pelagos.config.radiated_noise import RadiatedNoise, ShipNoise, ThrusterNoise
from pelagos.sensors.sonar.ping.vehicle_noise import NoiseSource

_HULL: Final = 2.0  # [m], how far a small vehicle's hull reaches from its origin; assumed


def noise_sources(agents: Mapping[str, Any]) -> dict[str, NoiseSource]:
    """Those of some agents that have `radiated_noise`, by name."""
    return {name: noise_source(a.radiated_noise) for name, a in agents.items() if a.radiated_noise is not None}


def noise_source(config: RadiatedNoise) -> NoiseSource:
    """A vehicle that makes this noise."""
    if isinstance(config, ShipNoise):
        level = partial(_ship, config)
        return NoiseSource(level, max(_HULL, 0.5 * config.length_m))
    return NoiseSource(partial(_thrusters, config), _HULL)


def _ship(config: ShipNoise, frequency: float, speed: NDArray[np.float64]) -> NDArray[np.float64]:
    return ship_level(frequency, speed, length=config.length_m, ship_class=config.ship_class)


def _thrusters(config: ThrusterNoise, frequency: float, speed: NDArray[np.float64]) -> NDArray[np.float64]:
    at = {"at_frequency": config.frequency_hz, "at_speed": config.speed_mps}
    moving = propeller_level(frequency, speed, level=config.level_db, **at)
    if config.idle_db is None:
        return moving
    idle = propeller_level(frequency, config.speed_mps, level=config.idle_db, **at)
    return np.asarray(10.0 * np.log10(10.0 ** (moving / 10.0) + 10.0 ** (idle / 10.0)))
