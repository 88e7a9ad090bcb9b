"""The step loop. `Stepper.advance` is the table of contents of a simulation."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.sensors.comms.link.traffic import Traffic
from pelagos.sensors.sensor import Kinematics, Measurement, Reading
from pelagos.sim.batch import Batch, SensorModel
from pelagos.sim.batch_run import BatchRun
from pelagos.sim.bodies import Bodies
from pelagos.sim.contacts import Contacts
from pelagos.sim.driver import Wrench
from pelagos.sim.encounters import Encounters
from pelagos.sim.endings import Endings
from pelagos.sim.episodes import Episodes
from pelagos.sim.finite_readings import require_finite
from pelagos.sim.initial import StartState
from pelagos.sim.listeners import Listeners
from pelagos.sim.missions import Missions
from pelagos.sim.model import AgentModel, Model
from pelagos.sim.observed import Observed
from pelagos.sim.sampled import Sampled
from pelagos.sim.schedule import Schedule
from pelagos.sim.set_points import exact, idle, vectors
from pelagos.sim.state import AgentState, States, mixed
from pelagos.sim.timings import Timings
from pelagos.sim.trajectory import LaneSelector, RowNames, Trajectory, at_lanes, channels, of_rows
from pelagos.sim.variety import Variety
from pelagos.vehicles.state import VehicleState

EVENTS: Final = ("modem",)  # sensors that tell what has happened since they were asked last, when they are due alone


class Stepper:
    """Moves every agent, asks every due sensor. What changes in a run is in this object and its parts.

    Attributes:
        tick: ticks since the start.
        own_current: see `Ocean.own`; None where that is not set.
        agent_currents: by agent `(n, 3)` NWU [m/s], of those that have another.
        logged: the motion of every tick is written down.
        changes: counts steps, and whatever else changes the state.
        timings: where the time went.
        trajectories: by batch, the motion of the last block; after `catch_up`, since the one before.
        runs: by batch, its state, commands and modes.
        missions: guidance of all agents.
        contacts: what hulls touch.
        episodes: of each copy.
        variety: what differs among them.
        traffic: packets between modems.

    Args:
        model, bodies, encounters, listeners: what it steps, and for whom.
        like: a stepper of the same model, whose recorded calls are shared.
    """

    def __init__(
        self,
        model: Model,
        bodies: Bodies,
        encounters: Encounters,
        listeners: Listeners,
        *,
        like: Stepper | None = None,
    ) -> None:
        self._model, self._bodies, self._encounters = model, bodies, encounters
        new = {name: LaneSelector(n=batch.rows, dt_ns=model.clock.dt_ns) for name, batch in model.batches.items()}
        shared = {} if like is None else {k: v for k, v in like._select.items() if k in new and v.rows == new[k].rows}
        self._select: dict[str, LaneSelector] = new | shared
        self._names = {name: RowNames(batch) for name, batch in model.batches.items()}
        self.episodes = Episodes(model.n, model.first_environment)
        self._endings = Endings(model, self.episodes)
        self.variety = Variety(model)
        self.missions = Missions(model)
        self.contacts = Contacts(model, bodies)
        self.traffic = Traffic(encounters.medium, self.episodes)
        self._schedule = Schedule(model, bodies, self.missions, listeners)
        self.runs: dict[str, BatchRun] = {}
        self.trajectories: dict[str, Trajectory] = {}
        self._blocks: dict[str, list[Trajectory]] = {}
        self.timings = Timings()
        self.own_current: Array | None = None
        self.agent_currents: dict[str, NDArray[np.float64]] = {}
        self.logged = False
        self._close = False  # something may touch in the present block
        self._placed = False  # the moving scene, in this round of readings
        self._lanes: dict[tuple[str, range], tuple[Trajectory, Any, Kinematics]] = {}
        self.tick: int = 0
        self.changes: int = 0

    def start(self, states: Mapping[str, StartState], *, episode: int = 0, tick: int = 0) -> None:
        """The first tick: place the agents, and read those sensors that missions wait for."""
        self.changes += 1
        self.tick = tick
        self.timings = Timings()
        self._blocks.clear()
        self.contacts.clear()
        self.traffic.clear()
        self._bodies.forget()
        self.episodes.restart(episode)
        for name, batch in self._model.batches.items():
            self.runs[name] = self._begun(batch, states)
            self.trajectories[name] = self._standing(batch, self.runs[name])
        now = self.states()
        for name, agent in self._model.agents.items():
            self.missions.begin(agent, now[name])
        self._sense(lambda batch, sensor: any(self.missions.guided(name, sensor.name) for name in batch.members))

    def restart(self, states: Mapping[str, StartState], where: NDArray[np.bool_]) -> None:
        """Some copies begin their next episode at the present tick; the others' bytes stay."""
        self.changes += 1
        self._blocks.clear()
        self.contacts.forget(where)
        self.traffic.forget(where, self.tick)
        self.episodes.begin(where, self.tick)
        for name, batch in self._model.batches.items():
            run, fresh = self.runs[name], self._begun(batch, states)
            begun = AgentState.of(fresh.row, batch.driver.actuators(fresh.vehicle))
            rows = np.tile(where, len(batch.members))
            run.restart(fresh, rows, partial(self._first_command, batch, begun))
            self.trajectories[name] = self._standing(batch, run)
        now = self.states()
        for name, agent in self._model.agents.items():
            self.missions.restart(agent, now[name], where, self.tick)

    @property
    def agents(self) -> Collection[str]:
        """Names of all."""
        return self._model.agents.keys()

    def read_all(self) -> list[Sampled]:
        """Every sensor at the present tick, due or not."""
        return self._sense(due=range(self.tick, self.tick + 1))

    def read_some(self, agent: str, names: Collection[str]) -> list[Sampled]:
        """Some sensors of an agent, and of those that move with it, at the present tick, due or not."""
        batch = self._model.agents[agent].batch
        now = range(self.tick, self.tick + 1)
        return self._sense(lambda b, sensor: b is batch and sensor.name in names, due=now)

    def read_now(self) -> list[Sampled]:
        """Every sensor that is due at the current tick, read again: the same bytes."""
        return self._sense()

    def advance(self, last: int, *, wait: bool = False) -> list[Sampled]:
        """Go on by one block, which ends at tick `last` or where the outside may act before.

        With `wait`, sensors for which nothing waits are left to `catch_up`: a call for the readings of ten blocks costs
        little more than one for those of a single block (a DVL 0.2 ms, an IMU 0.03 ms).
        """
        self._guide()
        self._in_own_current()
        self._bodies.follow(self.tick)
        ticks = self._block_length(last, wait)
        self._move(ticks)
        if wait:
            for name, trajectory in self.trajectories.items():
                self._blocks.setdefault(name, []).append(trajectory)
        self.tick += ticks
        self.changes += 1
        return self._sense(lambda batch, sensor: not (wait and self._schedule.waits(batch, sensor)))

    def catch_up(self) -> list[Sampled]:
        """Read the sensors that waited."""
        if not self._blocks:
            return []
        self.trajectories |= {
            name: Trajectory.join(blocks)
            for name, blocks in self._blocks.items()
            if self.logged or self._model.batches[name].sensors
        }
        self._blocks.clear()
        return self._sense(self._schedule.waits)

    def states(self) -> States:
        """The true state of every agent."""
        return States(self._model, self.runs)

    def observed(self, sampled: list[Sampled]) -> Observed:
        """The newest reading of each sensor, by agent and name; absent where there is none."""
        return Observed(self._model, sampled)

    def contact(self, agent: str) -> NDArray[np.float64]:
        """`(n, 6)` force [N] and moment about the body's origin [N m], FLU, by contact over the last tick."""
        model = self._model.agents[agent]
        return self.contacts.wrench(model.batch.name)[model.rows]

    def mode(self, agent: str) -> str:
        """The control mode of an agent."""
        model = self._model.agents[agent]
        return self.runs[model.batch.name].mode_of(model.rows)

    def missions_done(self) -> bool:
        """There are missions, and all have ended."""
        return self.missions.done

    def set_command(self, agent: str, values: NDArray[np.float64]) -> None:
        """Hold another command `(n, k)`; ends the agent's mission."""
        self.missions.leave(agent)
        model = self._model.agents[agent]
        self.runs[model.batch.name].hold(model.rows, values)

    def set_mode(self, agent: str, mode: str) -> None:
        """Another control mode, idling; ends the agent's mission."""
        self.missions.leave(agent)
        model, state = self._model.agents[agent], self.states()[agent]
        model.vehicle.check_mode(mode)
        self.runs[model.batch.name].change_mode(model.rows, mode, idle(model.vehicle, mode, state))

    def set_state(self, agent: str, where: NDArray[np.bool_], **parts: NDArray[np.float64]) -> None:
        """Place an agent anew in some copies; its actuators and its mission go on, its controllers begin anew."""
        self.changes += 1
        model = self._model.agents[agent]
        batch, run = model.batch, self.runs[model.batch.name]
        rows = np.zeros(batch.rows, dtype=bool)
        rows[model.rows] = where
        now, whole = AgentState.of(run.row, np.empty((batch.rows, 0))), {}
        for name, values in parts.items():
            whole[name] = getattr(now, name).copy()
            whole[name][model.rows] = values
        state = batch.vehicle.place(batch.driver.unpack(run.vehicle), **whole)
        run.vehicle = mixed(run.vehicle, batch.driver.pack(state), rows)
        run.row = np.where(rows[:, None], _row(state), run.row)
        self.trajectories[batch.name] = self._standing(batch, run)

    def memory(self) -> dict[str, Any]:
        """Everything that changes in a run: plain values and copies of arrays."""
        return {
            "tick": self.tick,
            "own_current": None if self.own_current is None else np.array(self.own_current),
            "agent_currents": {name: v.copy() for name, v in self.agent_currents.items()},
            "episodes": self.episodes.memory(),
            "runs": {name: self._run_of(agent).part(agent.rows) for name, agent in self._model.agents.items()},
            "missions": self.missions.memory(),
            "contacts": self.contacts.memory(),
            "traffic": self.traffic.memory(),
        }

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Go on from there."""
        self.tick = memory["tick"]
        own = memory["own_current"]
        self.own_current = None if own is None else vectors(own.T)
        self.agent_currents = {name: v.copy() for name, v in memory["agent_currents"].items()}
        self.changes += 1
        self._blocks.clear()
        self.episodes.recall(memory["episodes"])
        for name, batch in self._model.batches.items():
            run = self.runs[name] = BatchRun.joined([memory["runs"][member] for member in batch.members])
            self.trajectories[name] = self._standing(batch, run)
        self.missions.recall(memory["missions"])
        self.contacts.recall(memory["contacts"])
        self.traffic.recall(memory["traffic"])

    def _run_of(self, agent: AgentModel) -> BatchRun:
        return self.runs[agent.batch.name]

    def row(self, agent: str) -> NDArray[np.float64]:
        """`(n, CHANNELS)` motion of an agent now."""
        model = self._model.agents[agent]
        return self.runs[model.batch.name].row[model.rows]

    def command_values(self, agent: str) -> NDArray[np.float64]:
        """`(n, k)` the command that an agent holds."""
        model = self._model.agents[agent]
        return self.runs[model.batch.name].values_of(model.rows)

    # the parts of `advance`

    def _guide(self) -> None:
        """Ask every mission for its set-points, at the rate of guidance."""
        if not self.missions.any:
            return
        start = time.perf_counter()
        asked = self.missions.commands(self.tick, AgentRows(self))
        for name, values in asked.items():
            model = self._model.agents[name]
            self.runs[model.batch.name].hold(model.rows, values)
        if asked:
            self.timings.add(f"{next(iter(asked))}.guidance" if len(asked) == 1 else "guidance", start)

    def _block_length(self, last: int, wait: bool) -> int:
        """Ticks until the outside may act; one at a time where a hull may touch."""
        ticks = self._schedule.end(self.tick, last, wait=wait) - self.tick
        self._close = self.contacts.possible(self._motions(), ticks)
        return 1 if self._close else ticks

    def _motions(self) -> dict[str, NDArray[np.float64]]:
        return {name: run.row for name, run in self.runs.items()}

    def _move(self, ticks: int) -> None:
        """The dynamics of all batches, and what they touch."""
        near = self.contacts.near(self._motions()) if self._close else frozenset()
        moved = {name: self._advance(name, ticks) for name in self.runs if name not in near}
        self.contacts.pass_by()
        if near:
            moved |= self._touch(near)
        for name, (state, trajectory) in moved.items():
            run = self.runs[name]
            run.vehicle = state
            self.trajectories[name] = self._endings.watch(self._model.batches[name], run, trajectory)

    def _advance(self, name: str, ticks: int, wrench: Wrench | None = None) -> tuple[Array, Trajectory]:
        start, batch = time.perf_counter(), self._model.batches[name]
        every = bool(batch.sensors) or self.logged or batch.rows == 1
        self._in_own_current(batch)
        factors = self.variety.factors(batch, self.episodes)
        made = self.runs[name].advance(
            batch.driver, self._model.ocean, self.tick, ticks, wrench, every=every, factors=factors
        )
        self.timings.add(f"{name}.dynamics", start)
        return made

    def _touch(self, near: frozenset[str]) -> dict[str, tuple[Array, Trajectory]]:
        """One tick of the batches that may touch something: first without contact, then with that which it brings."""
        free = {name: self._advance(name, 1) for name in self.runs if name in near}
        start = time.perf_counter()
        states = {name: (self.runs[name].vehicle, state) for name, (state, _) in free.items()}
        touched = self.contacts.act(self._motions(), states)
        for name in self._encounters.blows.asked & self.runs.keys():
            self.contacts.remember(name, self.tick)
        self.timings.add("contact", start)
        return free | {name: self._advance(name, 1, wrench) for name, wrench in touched.items()}

    def _sense(
        self, asked: Callable[[Batch, SensorModel], bool] | None = None, due: range | None = None
    ) -> list[Sampled]:
        """Ask the sensors that are due in the last block, or those of them that are `asked`; all of them at `due`."""
        sampled = []
        self._placed = False
        self._lanes.clear()
        for batch in self._model.batches.values():
            trajectory = self.trajectories[batch.name]
            for sensor in batch.sensors.values():
                regular = due is None or sensor.config.type in EVENTS
                ticks = trajectory.due(sensor.period) if regular or due is None else due
                if not ticks or (asked is not None and not asked(batch, sensor)):
                    continue
                start = time.perf_counter()
                if sensor.casts:
                    self._place()
                self._answer(ticks)
                self._in_own_current(batch)
                one = Sampled(batch.members, sensor, ticks, self._ask(sensor, self._lanes_of(batch, ticks)))
                sampled.append(one.without(self.episodes.ended) if self.episodes.any_over else one)
                require_finite(sampled[-1], self._model.n, self._model.clock.dt_ns, self._uncovered)
                if due is None:
                    self.missions.hear(sampled[-1])
                self.timings.add(f"{batch.name}.{sensor.name}", start)
        return sampled

    def _place(self) -> None:
        """Bring the moving scene up to date, once a round of readings."""
        if not self._placed:
            self._bodies.follow(self.tick)
            self._bodies.place(self.states())
            self._placed = True

    def _lanes_of(self, batch: Batch, due: range) -> Kinematics:
        """The motion of all rows of a batch at ticks of the last block, selected once a round of readings."""
        trajectory = self.trajectories[batch.name]
        names = self._names[batch.name].of(self.episodes.names())
        known = self._lanes.get((batch.name, due))
        if known is None or known[0] is not trajectory or known[1] is not names:
            lanes = self._select[batch.name].lanes(trajectory, due, names)
            known = self._lanes[batch.name, due] = (trajectory, names, lanes)
        return known[2]

    def read_at(self, sensors: Sequence[SensorModel], agent: str, lanes: Kinematics) -> Iterator[tuple[str, Reading]]:
        """Readings of some sensors of an agent on lanes of any motion at the present time; other agents are where they
        are in the copy of each lane."""
        count, dt_ns = dr.width(lanes.tick), self._model.clock.dt_ns
        now = range(self.tick, self.tick + 1)
        self._answer(now)
        copy, here = lanes.copy % self._model.n, self._model.agents[agent]
        others = lambda other: at_lanes(self.motion_of(now, other), copy)
        self._encounters.neighbours.motion_of = others
        self._names[here.batch.name].at_poses(lanes, here.member)
        for sensor in sensors:
            m = self._ask(sensor, lanes)
            valid = np.ones(count, dtype=bool) if m.valid is None else m.valid
            yield sensor.name, m.reading(slice(0, count), valid, self.tick * dt_ns, f"{agent}/{sensor.name}")

    def _uncovered(self, agent: str, copy: int, t_s: float) -> Sequence[str]:
        """Fields of the ocean that end before the place of an agent's copy."""
        place = self.row(agent)[copy, :3]
        return self._model.ocean.uncovered(jit.Array3f64(*(float(v) for v in place)), jit.Float64(t_s))

    def _ask(self, sensor: SensorModel, motion: Kinematics) -> Measurement:
        self._model.scene.reading = True
        try:
            return sensor.sensor.sense(motion)
        finally:
            self._model.scene.reading = False

    def _in_own_current(self, batch: Batch | None = None) -> None:
        """Have the ocean's current by copy be this run's, where simulations share the ocean; or by row of a batch."""
        own = self.variety.current(self.episodes) if self.own_current is None else self.own_current
        if own is None:
            return
        self._model.ocean.own = own
        if batch is not None and not self.agent_currents.keys().isdisjoint(batch.members):
            common = np.array(own).T
            self._model.ocean.own = vectors(
                np.concatenate([self.agent_currents.get(name, common) for name in batch.members])
            )

    def _answer(self, due: range) -> None:
        """Have the sensor that reads next ask this run, about these ticks."""
        self._in_own_current()
        self._encounters.neighbours.motion_of = partial(self.motion_of, due)
        self._encounters.blows.latest = self._latest_blow
        self._encounters.medium.motions_of, self._encounters.medium.place = partial(self.motions_of, due), self._place
        self._encounters.medium.traffic, self._encounters.medium.ticks = self.traffic, due

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
        return self.contacts.strongest(agent, self.tick - ticks)

    # construction, and the numbers behind a state

    def _begun(self, batch: Batch, states: Mapping[str, StartState]) -> BatchRun:
        """All rows of a batch at the beginning of an episode, with the command that they hold there."""
        starts = [states[name] for name in batch.members]
        place, attitude, velocity = (
            np.concatenate([getattr(s, part) for s in starts]) for part in ("position", "attitude", "velocity")
        )
        spins = [np.zeros_like(s.position) if s.angular_velocity is None else s.angular_velocity for s in starts]
        vehicle = batch.vehicle.initial_state(place, attitude, velocity, np.concatenate(spins))
        run = BatchRun(batch.driver.pack(vehicle), batch.mode, _row(vehicle))
        state = AgentState.of(run.row, batch.driver.actuators(run.vehicle))
        run.hold(slice(None), self._first_command(batch, state, batch.mode))
        return run

    def _first_command(self, batch: Batch, state: AgentState, mode: str) -> NDArray[np.float64]:
        """`(rows, k)` the command that is held at the beginning of an episode."""
        held = idle(batch.vehicle, mode, state)
        for member, name in enumerate(batch.members):
            given = self._model.agents[name].config.command
            if given is not None and mode == batch.mode:
                held[batch.rows_of(member)] = np.array(given)
        return held

    def _standing(self, batch: Batch, run: BatchRun) -> Trajectory:
        """A block of the current tick alone."""
        return Trajectory(packed=exact(run.row), n=batch.rows, ticks=1, first_tick=self.tick)


class AgentRows(Mapping[str, NDArray[np.float64]]):
    """`(n, CHANNELS)` motion of each agent now."""

    def __init__(self, stepper: Stepper) -> None:
        self._stepper = stepper

    def __getitem__(self, agent: str) -> NDArray[np.float64]:
        return self._stepper.row(agent)

    def __iter__(self) -> Iterator[str]:
        return iter(self._stepper.agents)

    def __len__(self) -> int:
        return len(self._stepper.agents)


def _row(state: VehicleState) -> NDArray[np.float64]:
    return np.stack([np.array(c) for c in channels(state)], axis=-1)
