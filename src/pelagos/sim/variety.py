"""Differences between copies and episodes: the draws of a scenario's `vary`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.config.vary import ANGLES, CURRENTS, ERROR, LAMPS, MOUNT, PROPS, TURBIDITY, WAVES, Varied, parse
from pelagos.errors import ScenarioError
from pelagos.jit import Array
from pelagos.math.frames import flip_quaternion_np
from pelagos.math.so3 import from_euler
from pelagos.sim.episodes import Episodes
from pelagos.sim.initial import StartState, on_its_sea
from pelagos.sim.props import attitude_of
from pelagos.sim.remount import moved, remount
from pelagos.sim.set_points import vectors
from pelagos.sim.varied_sea import VariedSea

if TYPE_CHECKING:
    from pelagos.ocean.waves import Waves
    from pelagos.sensors.sensor import Kinematics, Measurement
    from pelagos.sim.batch import Batch, SensorModel
    from pelagos.sim.model import Model


class Variety:
    """The draws of a model's fleet, each named by (seed, environment, episode, key): no copy changes another's.

    They follow from these names alone, so that neither a checkpoint nor a fork has to hold them.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self._keys: dict[str, Varied] = {key: parse(key) for key in model.scenario.vary}
        sensed = [v for v in self._keys.values() if v.group == "sensors"]
        self._moved = {(v.agent, v.name) for v in sensed if v.number in MOUNT}
        self._lit = {(v.agent, v.name) for v in sensed if v.number == LAMPS}
        self._erring = {(v.agent, v.name) for v in sensed if v.number == ERROR}
        self._sea = VariedSea(model, self._keys)
        self._known: tuple[bytes, dict[str, NDArray[np.float64]]] = (b"", {})
        self._device: dict[Any, Any] = {}

    @cached_property
    def has_current(self) -> bool:
        """The current is drawn."""
        return any(key in self._keys for key in CURRENTS)

    def drawn(self, episodes: Episodes) -> dict[str, NDArray[np.float64]]:
        """By key `(n,)` the values of the present episodes, in the scenario's units."""
        if not self._keys:
            return {}
        now = episodes.environment.tobytes() + episodes.number.tobytes()
        if self._known[0] != now:
            where = np.ones(self._model.n, dtype=bool)
            self._known, self._device = (now, self._values(episodes.number, where)), {}
        return self._known[1]

    def factors(self, batch: Batch, episodes: Episodes) -> list[Array]:
        """On the parameters that `batch.driver.vary` names, of all rows."""
        if not batch.driver.vary:
            return []
        values = self.drawn(episodes)
        if batch.name not in self._device:
            made = [
                jit.from_numpy(jit.Float64, values[f"agents.{batch.name}.factors.{name}"]) for name in batch.driver.vary
            ]
            self._device[batch.name] = made
        found: list[Array] = self._device[batch.name]
        return found

    def remounted(self, sensor: SensorModel, batch: Batch, motion: Kinematics, episodes: Episodes) -> Kinematics:
        """Motion that a sensor is shown whose place is drawn; see `sim.remount`."""
        if (batch.name, sensor.name) not in self._moved:
            return motion
        before = f"agents.{batch.name}.sensors.{sensor.name}."
        values, config = self.drawn(episodes), sensor.config
        if before not in self._device:
            written = (*config.position_m, *config.orientation_deg)
            parts = [
                values.get(before + name, np.full(self._model.n, own)) for name, own in zip(MOUNT, written, strict=True)
            ]
            self._device[before] = remount(config, np.stack(parts[:3], axis=1), np.stack(parts[3:], axis=1))
        return moved(motion, *self._device[before])

    def lit(self, sensor: SensorModel, batch: Batch, motion: Kinematics, episodes: Episodes) -> Kinematics:
        """Motion for a camera whose lamps shine as many times as brightly as was drawn."""
        if (batch.name, sensor.name) not in self._lit:
            return motion
        key = f"agents.{batch.name}.sensors.{sensor.name}.{LAMPS}"
        factor = np.maximum(self.drawn(episodes)[key], 0)[motion.copy.numpy()]
        return replace(motion, lamps=jit.from_numpy(jit.Float, factor.astype(np.float32)))

    def murky(self, motion: Kinematics, episodes: Episodes) -> Kinematics:
        """Motion for a sensor that looks through the water that was drawn for its copy."""
        if TURBIDITY not in self._keys:
            return motion
        values = self.drawn(episodes)[TURBIDITY][motion.copy.numpy() % self._model.n]
        row = np.searchsorted(self._model.ocean.turbidities, values)
        return replace(motion, turbidity=jit.from_numpy(jit.UInt32, row.astype(np.uint32)))

    def _rounded(self, turbidity: NDArray[np.float64]) -> NDArray[np.float64]:
        known = np.array(self._model.ocean.turbidities)
        return np.asarray(known[np.abs(turbidity[:, None] - known).argmin(axis=1)])

    def erring(self, sensor: SensorModel, batch: Batch, m: Measurement, copy: Array, episodes: Episodes) -> Measurement:
        """A measurement whose error is as many times its own as was drawn; `copy` of each lane."""
        if (batch.name, sensor.name) not in self._erring:
            return m
        key = f"agents.{batch.name}.sensors.{sensor.name}.{ERROR}"
        factor = np.maximum(self.drawn(episodes)[key], 0)[copy.numpy()].reshape(-1, *[1] * (m.data.ndim - 1))
        with np.errstate(invalid="ignore"):  # without an echo
            data = m.truth + factor * (m.data - m.truth)
        return replace(m, data=data.astype(m.data.dtype), truth=m.truth)

    def current(self, episodes: Episodes) -> Array | None:
        """Of the water in each copy, NWU [m/s]; None where it is not drawn."""
        if not self.has_current:
            return None
        values, still = self.drawn(episodes), np.zeros(self._model.n)
        if CURRENTS not in self._device:
            self._device[CURRENTS] = vectors(np.stack([values.get(key, still) for key in CURRENTS], axis=1))
        return self._device[CURRENTS]

    def waves(self, episodes: Episodes) -> Waves | None:
        """The sea of each copy; None where all have the scenario's."""
        if not self._sea:
            return None
        values = self.drawn(episodes)
        if WAVES not in self._device:
            self._device[WAVES] = self._sea.waves(values)
        made: Waves = self._device[WAVES]
        return made

    def starts(
        self, begin: Mapping[str, StartState], where: NDArray[np.bool_], number: NDArray[np.int64]
    ) -> dict[str, StartState]:
        """The scenario's starts, drawn for the episodes `number` `(n,)` of the copies `where` `(n,)`.

        Raises:
            ScenarioError: a place that was drawn is not free.
        """
        found = dict(begin)
        agents = {v.agent for v in self._keys.values() if v.group == "start"}
        if not agents and not self._sea:
            return found
        values = self._values(number, where)
        for name in agents:
            mine = {v.number: values[key] for key, v in self._keys.items() if (v.agent, v.group) == (name, "start")}
            found[name] = self._start(name, begin[name], mine, where)
        if self._sea:
            ocean = self._model.ocean.with_(own_waves=self._sea.waves(values, where))
            found = {name: on_its_sea(self._model.agents[name], ocean, begin[name], s) for name, s in found.items()}
        return found

    def props(
        self, where: NDArray[np.bool_], number: NDArray[np.int64]
    ) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """`(n, 3)` place NWU [m] and `(n, 4)` attitude of the scenario's props, by name, in the episodes `number`
        `(n,)` of the copies `where` `(n,)`."""
        n, configs = self._model.n, self._model.scenario.props
        keys = {name: [f"{PROPS}.{name}.{number}" for number in MOUNT] for name in configs}
        drawn = any(v.group == PROPS for v in self._keys.values())
        values, found = self._values(number, where) if drawn else {}, {}
        for name, config in configs.items():
            written = (*config.position_m, *config.orientation_deg)
            parts = [values.get(key, np.full(n, own)) for key, own in zip(keys[name], written, strict=True)]
            if any(key in values for key in keys[name][3:]):
                turns = np.stack(parts[3:], axis=1).tolist()
                turned = [attitude_of(turn) for turn in turns]
            else:
                turned = [attitude_of(config.orientation_deg)] * n
            found[name] = np.stack(parts[:3], axis=1), np.array(turned)
        return found

    def _values(self, number: NDArray[np.int64], where: NDArray[np.bool_]) -> dict[str, NDArray[np.float64]]:
        model, found = self._model, {}
        for key, draw in model.scenario.vary.items():
            values = np.zeros(model.n)
            for i in np.flatnonzero(where).tolist():
                name = f"{model.first_environment + i}/{int(number[i])}/{key}"
                values[i] = draw.draw(model.seed, name)
            if key == TURBIDITY:
                values = self._rounded(values)
            found[key] = values
        return found

    def _start(
        self, name: str, begin: StartState, mine: Mapping[str, NDArray[np.float64]], where: NDArray[np.bool_]
    ) -> StartState:
        config = self._model.agents[name].config.start
        position, velocity = begin.position.copy(), begin.velocity.copy()
        for key, values in mine.items():
            first, _, axis = key.partition(".")
            if first == "position_m":
                position[where, int(axis)] = values[where]
        if "speed_mps" in mine:
            velocity[where, 0] += mine["speed_mps"][where] - config.speed_mps
        attitude = begin.attitude.copy()
        if any(angle in mine for angle in ANGLES):
            for i in np.flatnonzero(where):
                angles = (mine[a][i] if a in mine else getattr(config, a) for a in ANGLES)
                q = from_euler(*(math.radians(a) for a in angles))
                attitude[i] = flip_quaternion_np(np.array([float(c) for c in q]))
        self._require_free(name, position, where)
        return replace(begin, position=position, velocity=velocity, attitude=attitude)

    def _require_free(self, name: str, position: NDArray[np.float64], where: NDArray[np.bool_]) -> None:
        model = self._model
        if model.agents[name].config.start.anywhere:
            return
        close = where & model.world.near(position, model.agents[name].vehicle.bounding_radius_m)
        for i in np.flatnonzero(close):
            why = model.world.inside(position[i][None])
            if why is not None:
                raise ScenarioError(
                    f"what was drawn for {name} in environment {model.first_environment + int(i)}: it cannot start "
                    f"there: {why}",
                    where=model.scenario.where("vary"),
                )
