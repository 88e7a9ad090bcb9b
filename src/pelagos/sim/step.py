"""The step loop. `Stepper.advance` is the table of contents of a simulation."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos.jit import Array
from pelagos.sensors.comms.link.traffic import Traffic
from pelagos.sensors.sensor import Kinematics, Measurement, Reading
from pelagos.sim.bodies import Bodies
from pelagos.sim.contacts import Contacts
from pelagos.sim.encounters import Encounters
from pelagos.sim.endings import Endings
from pelagos.sim.episodes import Episodes
from pelagos.sim.initial import StartState
from pelagos.sim.listeners import Listeners
from pelagos.sim.missions import Missions
from pelagos.sim.model import AgentModel, Model, SensorModel
from pelagos.sim.sampled import Sampled
from pelagos.sim.schedule import Schedule
from pelagos.sim.set_points import columns, exact, idle, vectors
from pelagos.sim.state import AgentRun, AgentState, mixed
from pelagos.sim.timings import Timings
from pelagos.sim.trajectory import LaneSelector, Trajectory, channels
from pelagos.vehicles.state import VehicleState

EVENTS: Final = ("modem",)  # sensors that tell what has happened since they were asked last, when they are due alone


class Stepper:
    """Moves every agent, asks every due sensor. What changes in a run is in this object and its parts.

    Attributes:
        tick: ticks since the start.
        own_current: see `Ocean.own`; None where that is not set.
        logged: the motion of every tick is written down.
        changes: counts steps, and whatever else changes the state.
        timings: where the time went.
        trajectories: by agent, the motion of the last block; after `catch_up`, since the one before.
        runs: by agent, its state, command and mode.
        missions: guidance of all agents.
        contacts: what hulls touch.
        episodes: of each copy.
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
        new = LaneSelector(n=model.n, dt_ns=model.clock.dt_ns)
        self._select: LaneSelector = new if like is None else like._select
        self.episodes = Episodes(model.n, model.first_environment)
        self._endings = Endings(model, self.episodes)
        self.missions = Missions(model)
        self.contacts = Contacts(model, bodies)
        self.traffic = Traffic(encounters.medium, self.episodes)
        self._schedule = Schedule(model, bodies, self.missions, listeners)
        self.runs: dict[str, AgentRun] = {}
        self.trajectories: dict[str, Trajectory] = {}
        self._blocks: dict[str, list[Trajectory]] = {}
        self.timings = Timings()
        self.own_current: Array | None = None
        self.logged = False
        self._close: set[str] = set()  # agents that may touch something in the present block
        self.tick: int = 0
        self.changes: int = 0

    def start(self, states: Mapping[str, StartState], *, episode: int = 0) -> None:
        """Tick 0: place the agents, and read those sensors that missions wait for."""
        self.changes += 1
        self.tick = 0
        self.timings = Timings()
        self._blocks.clear()
        self.contacts.clear()
        self.traffic.clear()
        self._bodies.forget()
        self.episodes.restart(episode)
        for name, agent in self._model.agents.items():
            self.runs[name] = self._begun(agent, states[name], agent.mode)
            self.trajectories[name] = self._standing(self.runs[name])
            self.missions.begin(agent, self._state(agent, self.runs[name]))
        self._sense(lambda agent, sensor: self.missions.guided(agent.name, sensor.name))

    def restart(self, states: Mapping[str, StartState], where: NDArray[np.bool_]) -> None:
        """Some copies begin their next episode at the present tick; the others' bytes stay."""
        self.changes += 1
        self._blocks.clear()
        self.contacts.forget(where)
        self.traffic.forget(where, self.tick)
        self.episodes.begin(where, self.tick)
        for name, agent in self._model.agents.items():
            run = self.runs[name]
            fresh = self._begun(agent, states[name], run.mode)
            run.begin_vehicle = mixed(run.begin_vehicle, fresh.begin_vehicle, where)
            run.begin_row = np.where(where[:, None], fresh.begin_row, run.begin_row)
            run.vehicle = mixed(run.vehicle, fresh.vehicle, where)
            run.row = np.where(where[:, None], fresh.row, run.row)
            self._hold(run, np.where(where[:, None], fresh.command_values, run.command_values))
            self.trajectories[name] = self._standing(run)
            self.missions.restart(agent, self._state(agent, run), where, self.tick)

    def read_all(self) -> list[Sampled]:
        """Every sensor at the present tick, due or not."""
        return self._sense(due=range(self.tick, self.tick + 1))

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
        for agent in self._model.agents.values():
            self._move(agent, ticks)
            if wait:
                self._blocks.setdefault(agent.name, []).append(self.trajectories[agent.name])
        self.tick += ticks
        self.changes += 1
        return self._sense(lambda agent, sensor: not (wait and self._schedule.waits(agent, sensor)))

    def catch_up(self) -> list[Sampled]:
        """Read the sensors that waited."""
        if not self._blocks:
            return []
        self.trajectories |= {
            name: Trajectory.join(blocks)
            for name, blocks in self._blocks.items()
            if self.logged or self._model.agents[name].sensors
        }
        self._blocks.clear()
        return self._sense(self._schedule.waits)

    def states(self) -> dict[str, AgentState]:
        """The true state of every agent."""
        return {name: self._state(self._model.agents[name], run) for name, run in self.runs.items()}

    def observed(self, sampled: list[Sampled]) -> dict[str, dict[str, Reading]]:
        """The newest reading of each sensor, by agent and name; absent where there is none."""
        observed: dict[str, dict[str, Reading]] = {name: {} for name in self._model.agents}
        for one in sampled:
            newest = one.newest(self._model.n, self._model.clock.dt_ns)
            if newest is not None:
                observed[one.agent][one.model.name] = newest
        return observed

    def contact(self, agent: str) -> NDArray[np.float64]:
        """`(n, 6)` force [N] and moment about the body's origin [N m], FLU, by contact over the last tick."""
        return self.contacts.wrench(agent)

    def mode(self, agent: str) -> str:
        """The control mode of an agent."""
        return self.runs[agent].mode

    def missions_done(self) -> bool:
        """There are missions, and all have ended."""
        return self.missions.done

    def set_command(self, agent: str, values: NDArray[np.float64]) -> None:
        """Hold another command `(n, k)`; ends the agent's mission."""
        self.missions.leave(agent)
        self._hold(self.runs[agent], values)

    def set_mode(self, agent: str, mode: str) -> None:
        """Another control mode, idling; ends the agent's mission."""
        self.missions.leave(agent)
        model, run, state = self._model.agents[agent], self.runs[agent], self.states()[agent]
        model.vehicle.check_mode(mode)
        run.mode = mode
        self._hold(run, idle(model, mode, state))

    def set_state(self, agent: str, where: NDArray[np.bool_], **parts: NDArray[np.float64]) -> None:
        """Place an agent anew in some copies; its actuators and its mission go on, its controllers begin anew."""
        self.changes += 1
        run = self.runs[agent]
        model = self._model.agents[agent]
        state = model.vehicle.place(model.driver.unpack(run.vehicle), **parts)
        run.vehicle = mixed(run.vehicle, model.driver.pack(state), where)
        run.row = np.where(where[:, None], _row(state), run.row)
        self.trajectories[agent] = self._standing(run)

    def memory(self) -> dict[str, Any]:
        """Everything that changes in a run: plain values and copies of arrays."""
        runs = {
            name: {
                "vehicle": np.array(run.vehicle),
                "command": run.command_values.copy(),
                "mode": run.mode,
                "row": run.row.copy(),
                "begin_vehicle": np.array(run.begin_vehicle),
                "begin_row": run.begin_row.copy(),
            }
            for name, run in self.runs.items()
        }
        return {
            "tick": self.tick,
            "own_current": None if self.own_current is None else np.array(self.own_current),
            "episodes": self.episodes.memory(),
            "runs": runs,
            "missions": self.missions.memory(),
            "contacts": self.contacts.memory(),
            "traffic": self.traffic.memory(),
        }

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Go on from there."""
        self.tick = memory["tick"]
        own = memory["own_current"]
        self.own_current = None if own is None else vectors(own.T)
        self.changes += 1
        self._blocks.clear()
        self.episodes.recall(memory["episodes"])
        for name, kept in memory["runs"].items():
            vehicle, begin = (exact(kept[key]) for key in ("vehicle", "begin_vehicle"))
            row, begin_row = (kept[key].copy() for key in ("row", "begin_row"))
            run = AgentRun(vehicle, [], np.empty(0), kept["mode"], row, begin, begin_row)
            self._hold(run, kept["command"].copy())
            self.runs[name] = run
            self.trajectories[name] = self._standing(run)
        self.missions.recall(memory["missions"])
        self.contacts.recall(memory["contacts"])
        self.traffic.recall(memory["traffic"])

    # the parts of `advance`

    def _guide(self) -> None:
        """Ask every mission for its set-points, at the rate of guidance."""
        if not self.missions.any:
            return
        start = time.perf_counter()
        asked = self.missions.commands(self.tick, {name: run.row for name, run in self.runs.items()})
        for name, values in asked.items():
            self._hold(self.runs[name], values)
            self.timings.add(f"{name}.guidance", start)

    def _block_length(self, last: int, wait: bool) -> int:
        """Ticks until the outside may act; one at a time where a hull may touch."""
        ticks = self._schedule.end(self.tick, last, wait=wait) - self.tick
        rows = {name: run.row for name, run in self.runs.items()}
        self._close = {name for name, row in rows.items() if self.contacts.near(name, row, ticks, self.states)}
        return 1 if self._close else ticks

    def _move(self, agent: AgentModel, ticks: int) -> None:
        """The dynamics of one agent, and what it touches."""
        start = time.perf_counter()
        run, wrench = self.runs[agent.name], None
        if agent.name in self._close and self.contacts.near(agent.name, run.row, 1, self.states, now=True):
            remember = agent.name in self._encounters.blows.asked
            wrench = self.contacts.touch(agent.name, run.vehicle, self.states, self.tick, remember=remember)
            self.timings.add(f"{agent.name}.contact", start)
            start = time.perf_counter()
        else:
            self.contacts.pass_by(agent.name)
        run.vehicle, trajectory = agent.driver.advance(
            run.vehicle, run.command, self._model.ocean, mode=run.mode, tick=self.tick, ticks=ticks, wrench=wrench,
            every=bool(agent.sensors) or self.logged or self._model.n == 1,
        )  # fmt: skip
        self.trajectories[agent.name] = self._endings.watch(agent, run, trajectory)
        self.timings.add(f"{agent.name}.dynamics", start)

    def _sense(
        self, asked: Callable[[AgentModel, SensorModel], bool] | None = None, due: range | None = None
    ) -> list[Sampled]:
        """Ask the sensors that are due in the last block, or those of them that are `asked`; all of them at `due`."""
        sampled = []
        placed = False
        for agent in self._model.agents.values():
            trajectory = self.trajectories[agent.name]
            lanes = {}
            for sensor in agent.sensors.values():
                regular = due is None or sensor.config.type in EVENTS
                ticks = trajectory.due(sensor.period) if regular or due is None else due
                if not ticks or (asked is not None and not asked(agent, sensor)):
                    continue
                start = time.perf_counter()
                if sensor.sees and not placed:
                    self._bodies.follow(self.tick)
                    self._bodies.place(self.states())
                    placed = True
                if ticks not in lanes:
                    lanes[ticks] = self._select.lanes(trajectory, ticks, self.episodes.names())
                self._answer(ticks)
                one = Sampled(agent.name, sensor, ticks, self._ask(sensor, lanes[ticks]))
                sampled.append(one.without(self.episodes.ended) if self.episodes.over.any() else one)
                if due is None:
                    self.missions.hear(sampled[-1])
                self.timings.add(f"{agent.name}.{sensor.name}", start)
        return sampled

    def read_at(self, sensors: Sequence[SensorModel], agent: str, lanes: Kinematics) -> Iterator[tuple[str, Reading]]:
        """Readings of some sensors of an agent on lanes of any motion at the present time; other agents are where they
        are in the copy of each lane."""
        count, dt_ns = dr.width(lanes.tick), self._model.clock.dt_ns
        now = range(self.tick, self.tick + 1)
        self._answer(now)
        others = lambda other: dr.gather(Kinematics, self.motion_of(now, other), lanes.copy)
        self._encounters.neighbours.motion_of = others
        for sensor in sensors:
            m = self._ask(sensor, lanes)
            valid = np.ones(count, dtype=bool) if m.valid is None else m.valid
            yield sensor.name, m.reading(slice(0, count), valid, self.tick * dt_ns, f"{agent}/{sensor.name}")

    def _ask(self, sensor: SensorModel, motion: Kinematics) -> Measurement:
        self._model.scene.reading = True
        try:
            return sensor.sensor.sense(motion)
        finally:
            self._model.scene.reading = False

    def _in_own_current(self) -> None:
        """Have the ocean's current by copy be this run's, where simulations share the ocean."""
        if self.own_current is not None:
            self._model.ocean.own = self.own_current

    def _answer(self, due: range) -> None:
        """Have the sensor that reads next ask this run, about these ticks."""
        self._in_own_current()
        self._encounters.neighbours.motion_of = partial(self.motion_of, due)
        self._encounters.blows.latest = self._latest_blow
        self._encounters.medium.motion_of = self._encounters.neighbours.motion_of
        self._encounters.medium.traffic, self._encounters.medium.ticks = self.traffic, due

    def motion_of(self, due: range, agent: str) -> Kinematics:
        """The motion of an agent at ticks of the last block, as its sensors see it."""
        return self._select.lanes(self.trajectories[agent], due, self.episodes.names())

    def _latest_blow(self, agent: str, ticks: int) -> NDArray[np.float64]:
        return self.contacts.strongest(agent, self.tick - ticks)

    # construction, and the numbers behind a state

    def _begun(self, agent: AgentModel, start: StartState, mode: str) -> AgentRun:
        """All copies of an agent at the beginning of an episode, with the command that they hold there."""
        vehicle = agent.vehicle.initial_state(start.position, start.attitude, start.velocity, start.angular_velocity)
        packed, row = agent.driver.pack(vehicle), _row(vehicle)
        run = AgentRun(packed, [], np.empty(0), mode, row, packed, row)
        held, n = agent.config.command, self._model.n
        given = held is not None and mode == agent.mode
        self._hold(run, np.tile(np.array(held), (n, 1)) if given else idle(agent, mode, self._state(agent, run)))
        return run

    def _hold(self, run: AgentRun, values: NDArray[np.float64]) -> None:
        if run.command_values.shape == values.shape and (run.command_values == values).all():
            return
        run.command_values = values
        run.command, run.source = columns(values)

    def _standing(self, run: AgentRun) -> Trajectory:
        """A block of the current tick alone."""
        packed = exact(run.row)
        return Trajectory(packed=packed, n=self._model.n, ticks=1, first_tick=self.tick)

    def _state(self, agent: AgentModel, run: AgentRun) -> AgentState:
        return AgentState.of(run.row, agent.driver.actuators(run.vehicle))


def _row(state: VehicleState) -> NDArray[np.float64]:
    return np.stack([np.array(c) for c in channels(state)], axis=-1)
