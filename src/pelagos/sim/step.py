"""The step loop. `Stepper.advance` is the table of contents of a simulation."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.sensors.comms.link.traffic import Traffic
from pelagos.sim.batch import Batch
from pelagos.sim.batch_run import BatchRun
from pelagos.sim.bodies import Bodies
from pelagos.sim.boundaries import Boundaries
from pelagos.sim.contacts import Contacts
from pelagos.sim.driver import Wrench
from pelagos.sim.encounters import Encounters
from pelagos.sim.endings import Endings
from pelagos.sim.episodes import Episodes
from pelagos.sim.initial import StartState
from pelagos.sim.listeners import Listeners
from pelagos.sim.missions import Missions
from pelagos.sim.model import AgentModel, Model
from pelagos.sim.observed import Observed
from pelagos.sim.sampled import Sampled
from pelagos.sim.schedule import Schedule
from pelagos.sim.sensing import Sensing
from pelagos.sim.set_points import idle, vectors
from pelagos.sim.state import AgentState, States, mixed
from pelagos.sim.timings import Timings
from pelagos.sim.trajectory import Trajectory, channels
from pelagos.sim.variety import Variety
from pelagos.vehicles.state import VehicleState


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
        sensing: asks the sensors.

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
        self.sensing: Sensing = Sensing(self, model, bodies, encounters, like=None if like is None else like.sensing)
        self.episodes = Episodes(model.n, model.first_environment)
        self._endings = Endings(model, self.episodes)
        self.variety = Variety(model)
        self.missions = Missions(model)
        self.contacts, self._boundaries = Contacts(model, bodies), Boundaries(model)
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
        self.tick: int = 0
        self.changes: int = 0

    def start(self, states: Mapping[str, StartState], *, episode: int = 0, tick: int = 0) -> None:
        """The first tick: place the agents, and read those sensors that missions wait for."""
        self.changes += 1
        self.tick = tick
        self.timings = Timings()
        self._blocks.clear()
        self.contacts.begin()
        self.traffic.clear()
        self._bodies.forget()
        self.episodes.restart(episode)
        for name, batch in self._model.batches.items():
            self.runs[name] = self._begun(batch, states)
            self.trajectories[name] = self._standing(batch, self.runs[name])
        now = self.states()
        for name, agent in self._model.agents.items():
            self.missions.begin(agent, now[name])
        self.sensing.sense(lambda batch, sensor: any(self.missions.guided(name, sensor.name) for name in batch.members))

    def restart(self, states: Mapping[str, StartState], where: NDArray[np.bool_]) -> None:
        """Some copies begin their next episode at the present tick; the others' bytes stay."""
        self.missions.refuse_restart(self.tick)
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
        self.missions.restart(now, where, self.tick)

    @property
    def agents(self) -> Collection[str]:
        """Names of all."""
        return self._model.agents.keys()

    def read_all(self) -> list[Sampled]:
        """Every sensor at the present tick, due or not."""
        return self.sensing.sense(due=range(self.tick, self.tick + 1))

    def read_some(self, agent: str, names: Collection[str]) -> list[Sampled]:
        """Some sensors of an agent, and of those that move with it, at the present tick, due or not."""
        batch = self._model.agents[agent].batch
        now = range(self.tick, self.tick + 1)
        return self.sensing.sense(lambda b, sensor: b is batch and sensor.name in names, due=now)

    def read_now(self) -> list[Sampled]:
        """Every sensor that is due at the current tick, read again: the same bytes."""
        return self.sensing.sense()

    def advance(self, last: int, *, wait: bool = False) -> list[Sampled]:
        """Go on by one block, which ends at tick `last` or where the outside may act before.

        With `wait`, sensors for which nothing waits are left to `catch_up`: a call for the readings of ten blocks costs
        little more than one for those of a single block (a DVL 0.2 ms, an IMU 0.03 ms).
        """
        self._guide()
        self.in_own_water()
        self._bodies.follow(self.tick)
        ticks = self._block_length(last, wait)
        self._move(ticks)
        if wait:
            for name, trajectory in self.trajectories.items():
                self._blocks.setdefault(name, []).append(trajectory)
        self.tick += ticks
        self.changes += 1
        return self.sensing.sense(lambda batch, sensor: not (wait and self._schedule.waits(batch, sensor)))

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
        return self.sensing.sense(self._schedule.waits)

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

    def set_command(self, agent: str, values: NDArray[np.float64], *, leave: bool = True) -> None:
        """Hold another command `(n, k)`; with `leave` the agent's mission ends."""
        if leave:
            self.missions.leave(agent)
        model = self._model.agents[agent]
        self.runs[model.batch.name].hold(model.rows, values)

    def set_mode(self, agent: str, mode: str) -> None:
        """Another control mode, idling; ends the agent's mission."""
        self.missions.leave(agent)
        model, state = self._model.agents[agent], self.states()[agent]
        model.vehicle.check_mode(mode)
        self.runs[model.batch.name].change_mode(model.rows, mode, idle(model.vehicle, mode, state))

    def set_states(self, placed: Mapping[str, Mapping[str, NDArray[np.float64]]], where: NDArray[np.bool_]) -> None:
        """Place agents anew in some copies; actuators and missions go on, controllers begin anew.

        Args:
            placed: by agent, all parts of a pose and its motion `(n, k)`.
            where: `(n,)` the copies.
        """
        self.changes += 1
        for name, batch in self._model.batches.items():
            run, mine = self.runs[name], [member for member in batch.members if member in placed]
            if not mine:
                continue
            now, rows = AgentState.of(run.row, np.empty((batch.rows, 0))), np.zeros(batch.rows, dtype=bool)
            whole = {part: getattr(now, part).copy() for part in placed[mine[0]]}
            for member in mine:
                own = self._model.agents[member].rows
                rows[own] = where
                for part, values in placed[member].items():
                    whole[part][own] = values
            state = batch.vehicle.place(batch.driver.unpack(run.vehicle), **whole)
            run.vehicle = mixed(run.vehicle, batch.driver.pack(state), rows)
            run.row = np.where(rows[:, None], _row(state), run.row)
            self.trajectories[name] = self._standing(batch, run)

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
        for name, batch in self._model.batches.items():
            theirs = {m: asked[m] for m in batch.members if m in asked}
            if len(theirs) == len(batch.members) > 1:
                self.runs[name].hold(slice(0, batch.rows), np.concatenate(list(theirs.values())))
                continue
            for member, values in theirs.items():
                self.runs[name].hold(self._model.agents[member].rows, values)
        if asked:
            self.timings.add(f"{next(iter(asked))}.guidance" if len(asked) == 1 else "guidance", start)

    def _block_length(self, last: int, wait: bool) -> int:
        """Ticks until the outside may act; one at a time where a hull may touch."""
        ticks = self._schedule.end(self.tick, last, wait=wait) - self.tick
        self._close = self.contacts.possible(self._motions(), ticks)
        return 1 if self._close or self._boundaries.any else ticks

    def _motions(self) -> dict[str, NDArray[np.float64]]:
        return {name: run.row for name, run in self.runs.items()}

    def _move(self, ticks: int) -> None:
        """The dynamics of all batches, and what they touch."""
        near = self.contacts.near(self._motions()) if self._close else frozenset()
        moved = {name: self._advance(name, ticks) for name in self.runs if name not in near}
        self.contacts.pass_by()
        if near:
            moved |= self._touch(near)
        for name, (state, _) in moved.items():
            self.runs[name].vehicle = state
        self.trajectories |= self._endings.watch(self.runs, {name: made for name, (_, made) in moved.items()})

    def _advance(self, name: str, ticks: int, wrench: Wrench | None = None) -> tuple[Array, Trajectory]:
        start, batch = time.perf_counter(), self._model.batches[name]
        every = bool(batch.sensors) or self.logged or batch.rows == 1
        self.in_own_water(batch)
        factors = self.variety.factors(batch, self.episodes)
        run, ocean, walls = self.runs[name], self._model.ocean, self._boundaries.walls(batch, self.runs[name].row)
        made = run.advance(batch.driver, ocean, self.tick, ticks, wrench, every=every, factors=factors, walls=walls)
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

    def in_own_water(self, batch: Batch | None = None) -> None:
        """Have a shared ocean's sea and current by copy, or a batch's current by row, be this run's."""
        waves = self.variety.waves(self.episodes)
        if waves is not None:
            self._model.ocean.own_waves = waves
        own = self.variety.current(self.episodes) if self.own_current is None else self.own_current
        if own is None:
            return
        self._model.ocean.own = own
        if batch is not None and not self.agent_currents.keys().isdisjoint(batch.members):
            common = np.array(own).T
            self._model.ocean.own = vectors(
                np.concatenate([self.agent_currents.get(name, common) for name in batch.members])
            )

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
        return Trajectory(packed=jit.from_numpy(jit.Float64, run.row), n=batch.rows, ticks=1, first_tick=self.tick)


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
