"""The sensors of a run: which are asked when, and the answers to those that ask about other agents while they read."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.sensors.sensor import Kinematics, Measurement, Reading
from pelagos.sim.batch import Batch, SensorModel
from pelagos.sim.bodies import Bodies
from pelagos.sim.encounters import Encounters
from pelagos.sim.finite_readings import require_finite
from pelagos.sim.model import Model
from pelagos.sim.sampled import Sampled
from pelagos.sim.trajectory import LaneSelector, RowNames, Trajectory, at_lanes, of_rows

if TYPE_CHECKING:
    from pelagos.sim.step import Stepper


class Sensing:
    """Asks the sensors of every agent, and answers them, for one run.

    Args:
        run: whose motion they see.
        model, bodies, encounters: see `Stepper`.
        like: of a run of the same model, whose recorded calls are shared.
    """

    def __init__(
        self, run: Stepper, model: Model, bodies: Bodies, encounters: Encounters, *, like: Sensing | None = None
    ) -> None:
        self._run, self._model, self._bodies, self._encounters = run, model, bodies, encounters
        new = {name: LaneSelector(n=batch.rows, dt_ns=model.clock.dt_ns) for name, batch in model.batches.items()}
        shared = {} if like is None else {k: v for k, v in like._select.items() if k in new and v.rows == new[k].rows}
        self._select: dict[str, LaneSelector] = new | shared
        self._names = {name: RowNames(batch) for name, batch in model.batches.items()}
        self._placed = False  # the moving scene, in this round of readings
        self._lanes: dict[tuple[str, range], tuple[Trajectory, Any, Kinematics]] = {}

    def sense(
        self, asked: Callable[[Batch, SensorModel], bool] | None = None, due: range | None = None
    ) -> list[Sampled]:
        """Ask the sensors that are due in the last block, or those of them that are `asked`; all of them at `due`."""
        sampled = []
        self._placed = False
        self._lanes.clear()
        for batch in self._model.batches.values():
            trajectory = self._run.trajectories[batch.name]
            for sensor in batch.sensors.values():
                regular = due is None or sensor.events
                ticks = trajectory.due(sensor.period) if regular or due is None else due
                if not ticks or (asked is not None and not asked(batch, sensor)):
                    continue
                start = time.perf_counter()
                if sensor.casts:
                    self._place()
                self._answer(ticks)
                self._run.in_own_water(batch)
                one = Sampled(batch.members, sensor, ticks, self._ask(sensor, batch, self._lanes_of(batch, ticks)))
                sampled.append(one.without(self._run.episodes.ended) if self._run.episodes.any_over else one)
                require_finite(sampled[-1], self._model.n, self._model.clock.dt_ns, self._uncovered)
                if due is None:
                    self._run.missions.hear(sampled[-1])
                self._run.timings.add(f"{batch.name}.{sensor.name}", start)
        return sampled

    def _place(self) -> None:
        """Bring the moving scene up to date, once a round of readings."""
        if not self._placed:
            self._bodies.follow(self._run.tick)
            self._bodies.place(self._run.states())
            self._placed = True

    def _lanes_of(self, batch: Batch, due: range) -> Kinematics:
        """The motion of all rows of a batch at ticks of the last block, selected once a round of readings."""
        trajectory = self._run.trajectories[batch.name]
        names = self._names[batch.name].of(self._run.episodes.names())
        known = self._lanes.get((batch.name, due))
        if known is None or known[0] is not trajectory or known[1] is not names:
            lanes = self._select[batch.name].lanes(trajectory, due, names)
            known = self._lanes[batch.name, due] = (trajectory, names, lanes)
        return known[2]

    def read_at(self, sensors: Sequence[SensorModel], agent: str, lanes: Kinematics) -> Iterator[tuple[str, Reading]]:
        """Readings of some sensors of an agent on lanes of any motion at the present time; other agents are where they
        are in the copy of each lane."""
        count, dt_ns = dr.width(lanes.tick), self._model.clock.dt_ns
        now = range(self._run.tick, self._run.tick + 1)
        self._answer(now)
        copy, here = lanes.copy % self._model.n, self._model.agents[agent]
        others = lambda other: at_lanes(self.motion_of(now, other), copy)
        self._encounters.neighbours.motion_of, self._encounters.neighbours.motions_of = others, None
        names = self._names[here.batch.name]
        names.at_poses(lanes, here.member)
        try:
            for sensor in sensors:
                m = self._ask(sensor, here.batch, lanes)
                valid, frame = np.ones(count, dtype=bool) if m.valid is None else m.valid, f"{agent}/{sensor.name}"
                whole = slice(0, count)
                yield sensor.name, m.reading(whole, valid, self._run.tick * dt_ns, frame, sensor.config.type)
        finally:
            names.posed = False

    def _uncovered(self, agent: str, copy: int, t_s: float) -> Sequence[str]:
        """Fields of the ocean that end before the place of an agent's copy."""
        place = self._run.row(agent)[copy, :3]
        return self._model.ocean.uncovered(jit.Array3f64(*(float(v) for v in place)), jit.Float64(t_s))

    def _ask(self, sensor: SensorModel, batch: Batch, motion: Kinematics) -> Measurement:
        variety, episodes = self._run.variety, self._run.episodes
        shown = variety.lit(sensor, batch, variety.remounted(sensor, batch, motion, episodes), episodes)
        shown = variety.murky(shown, episodes)
        self._model.scene.reading = True
        try:
            return variety.erring(sensor, batch, sensor.sensor.sense(shown), motion.copy, episodes)
        finally:
            self._model.scene.reading = False

    def _answer(self, due: range) -> None:
        """Have the sensor that reads next ask this run, about these ticks."""
        self._run.in_own_water()
        neighbours = self._encounters.neighbours
        neighbours.motion_of, neighbours.motions_of = partial(self.motion_of, due), partial(self.motions_of, due)
        self._encounters.blows.latest = self._latest_blow
        self._encounters.medium.motions_of, self._encounters.medium.place = partial(self.motions_of, due), self._place
        self._encounters.medium.traffic, self._encounters.medium.ticks = self._run.traffic, due

    def motion_of(self, due: range, agent: str) -> Kinematics:
        """The motion of an agent at ticks of the last block, as its sensors see it."""
        whole, rows = self.motions_of(due, agent)
        size = self._model.agents[agent].batch.rows
        return whole if rows == slice(0, size) else of_rows(whole, rows, size)

    def motions_of(self, due: range, agent: str) -> tuple[Kinematics, slice]:
        """The motion of all agents that are moved together with one, and which rows of each tick are its own."""
        model = self._model.agents[agent]
        return self._lanes_of(model.batch, due), model.rows

    def _latest_blow(self, agent: str, ticks: int) -> NDArray[np.float64]:
        return self._run.contacts.strongest(agent, self._run.tick - ticks)
