"""Transponders and pingers at fixed places or on other vehicles, and the first of their paths that a receiver takes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.acoustics.channel import spectral_level
from pelagos.config.strict import Strict
from pelagos.errors import LookupFailed, ScenarioError
from pelagos.ocean.ocean import Ocean
from pelagos.ocean.surface_wind import surface_wind
from pelagos.sensors.comms.link.place import check_in_water
from pelagos.sensors.comms.link.water_paths import Paths, WaterPaths
from pelagos.sensors.sensor import SensorContext

_FIRST_DB: Final = 10.0  # below the loudest path, down to which a receiver takes a path for the first
_SHIPPING: Final = 0.5  # ships far away: between none and heavy
_NONE: Final = -1  # row of the path where nothing arrives


class TransponderConfig(Strict):
    """A transponder at a fixed place, or on another vehicle."""

    position_m: tuple[float, float, float]
    """World x (north), y (west), z (up) [m]; with `agent` in that vehicle's body frame, forward, left, up [m]."""
    agent: str | None = None
    """The vehicle that carries it; at a fixed place where not given."""

    @property
    def q_body_sensor(self) -> tuple[float, float, float, float]:
        """It hears in all directions: turned as its vehicle."""
        return 1.0, 0.0, 0.0, 0.0


@dataclass(frozen=True)
class FirstPaths:
    """By lane and transponder, `(m, k)`: the first loud path; NaN where there is none.

    Attributes:
        time: one way [s].
        loss_db: transmission loss [dB re 1 m].
        direction: `(m, k, 3)` unit vector NWU in which its ray leaves the instrument, and so the one it arrives from.
        speed: of sound at the instrument [m/s].
        places: `(m, k, 3)` where the transponders truly are, NWU [m].
    """

    time: NDArray[np.float64]
    loss_db: NDArray[np.float64]
    direction: NDArray[np.float64]
    speed: NDArray[np.float64]
    places: NDArray[np.float64]


class Transponders:
    """Those that one instrument listens to, in the order of the scenario.

    Args:
        configs: by name.
        context: of the instrument.
        key: of the configuration that names them.

    Raises:
        LookupFailed: a carrier is no vehicle of the scenario.
        ScenarioError: a place is not in the water, or the carrier is the instrument's own.

    Attributes:
        fixed: `(k, 3)` NWU [m], NaN for those that vehicles carry.
    """

    def __init__(self, configs: Mapping[str, TransponderConfig], context: SensorContext, *, key: str) -> None:
        self._configs, self._context = tuple(configs.values()), context
        for name, config in configs.items():
            if config.agent is None:
                check_in_water(context, name, config.position_m)
            else:
                _check_carrier(context, f"{key}.{name}.agent", name, config.agent)
        self.fixed = np.array([[np.nan] * 3 if t.agent else t.position_m for t in self._configs])

    def __len__(self) -> int:
        return len(self._configs)

    def places(self, copy: NDArray[np.int64]) -> NDArray[np.float64]:
        """As lanes of these copies find them, `(m, k, 3)` NWU [m]."""
        found = np.tile(self.fixed, (len(copy), 1, 1))
        for k, transponder in enumerate(self._configs):
            if transponder.agent is not None:
                assert self._context.medium is not None
                found[:, k] = self._context.medium.pose_of(transponder.agent, transponder).position[copy]
        return found

    def listen(
        self, paths: WaterPaths, position: NDArray[np.float64], t: NDArray[np.float64], copy: NDArray[np.int64]
    ) -> FirstPaths:
        """First paths between an instrument at `position` `(m, 3)` NWU [m] at times `t` `(m,)` [s] and all of them."""
        m, k = len(position), len(self)
        time, loss, speed = (np.full((m, k), np.nan) for _ in range(3))
        places, direction = np.empty((m, k, 3)), np.full((m, k, 3), np.nan)
        for moment in np.unique(t):
            rows = np.flatnonzero(t == moment)
            places[rows], copies = self.places(copy[rows]), np.repeat(copy[rows], k)
            ends = np.repeat(position[rows], k, axis=0), places[rows].reshape(-1, 3)
            found = paths.trace(*ends, float(moment), copies, self._context.own_body[copies])
            first = _first_loud(found, len(copies)).reshape(-1, k)
            time[rows], loss[rows] = (
                np.append(v, np.nan)[first] for v in (found.arrivals.delay, found.arrivals.loss_db)
            )
            direction[rows] = np.append(found.departure, np.full((1, 3), np.nan), axis=0)[first]
            speed[rows] = found.speed[:, 0].reshape(-1, k)
        return FirstPaths(time, loss, direction, speed, places)


def pulse_noise_db(ocean: Ocean, frequency_hz: float, own_noise_db: float, pulse_s: float) -> float:
    """Noise behind a matched filter [dB re 1 uPa]: the density of the sea's and the own noise [dB re 1 uPa^2/Hz] over
    the length of the pulse."""
    sea = float(spectral_level(frequency_hz, wind_speed=surface_wind(ocean)[0], shipping=_SHIPPING)[0])
    density = 10.0 * math.log10(10.0 ** (sea / 10.0) + 10.0 ** (own_noise_db / 10.0))
    return density - 10.0 * math.log10(pulse_s)


def _first_loud(found: Paths, pairs: int) -> NDArray[np.int64]:
    """`(pairs,)` row of the first path that is not far below the loudest one; `_NONE` where nothing arrives."""
    a, chosen = found.arrivals, np.full(pairs, _NONE, np.int64)
    for pair in np.unique(a.path[~found.blocked]):
        rows = np.flatnonzero((a.path == pair) & ~found.blocked)
        loud = rows[a.loss_db[rows] <= a.loss_db[rows].min() + _FIRST_DB]
        chosen[pair] = loud[np.argmin(a.delay[loud])]
    return chosen


def _check_carrier(context: SensorContext, key: str, name: str, agent: str) -> None:
    if context.medium is None:
        raise ScenarioError(f"{name!r} is carried by {agent!r}: it needs a simulation, with that vehicle in it")
    own, _, sensor = str(context.path).partition(".")
    if agent not in context.medium.agents:
        raise LookupFailed("agent", agent, context.medium.agents, where=f"agents.{own}.sensors.{sensor}.{key}")
    if agent == own:
        raise ScenarioError(f"{name!r} is carried by {agent!r} itself; a vehicle ranges to others")
