"""The step loop. `Stepper.advance` is the table of contents of a simulation."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.errors import SimulationError
from pelagos.math.frames import flip_yz_np
from pelagos.sensors.lazy import promised
from pelagos.sensors.sensor import Kinematics, Measurement, Reading
from pelagos.sim.bodies import Bodies
from pelagos.sim.clock import next_multiple
from pelagos.sim.driver import Wrench
from pelagos.sim.guidance import Guidance
from pelagos.sim.initial import StartState
from pelagos.sim.model import AgentModel, Model, SensorModel
from pelagos.sim.state import AgentRun, AgentState
from pelagos.sim.touch import Touch
from pelagos.sim.trajectory import LaneSelector, Trajectory, channels
from pelagos.vehicles.state import VehicleState

GUIDANCE_RATE_HZ = 10.0
GUIDING = ("altimeter", "gps")  # the sensors that guidance listens to
MAX_BLOCK_S = 1.0
MARGIN_MPS = 2.0  # a hull is taken to gain at most this much speed within a block, when its way is bounded


@dataclass(frozen=True)
class Sampled:
    """What one sensor read in a block: a measurement whose lanes are `ticks` times the copies."""

    agent: str
    model: SensorModel
    ticks: range
    measurement: Measurement

    def count(self, n: int) -> int:
        """Ticks at which at least one copy has a reading."""
        valid = self.measurement.valid
        return len(self.ticks) if valid is None else int(valid.reshape(-1, n).any(axis=1).sum())

    @staticmethod
    def join(parts: Sequence[Sampled]) -> Sampled:
        """What one sensor read in blocks that follow one another, as one."""
        one = parts[0]
        if len(parts) == 1:
            return one
        measured = [p.measurement for p in parts]
        valid = [m.valid for m in measured if m.valid is not None]
        joined = Measurement(
            data=np.concatenate([m.data for m in measured]),
            truth=promised(lambda: np.concatenate([m.truth for m in measured])),
            valid=np.concatenate(valid) if valid else None,
            extras={name: np.concatenate([m.extras[name] for m in measured]) for name in one.measurement.extras},
            tables=one.measurement.tables,
        )
        ticks = range(one.ticks.start, parts[-1].ticks[-1] + 1, one.model.period)
        return Sampled(one.agent, one.model, ticks, joined)

    def newest(self, n: int, dt_ns: int) -> Reading | None:
        """The reading of the last tick at which a copy has one; None where there is no such tick."""
        m, everywhere = self.measurement, np.ones(n, dtype=bool)
        for k in reversed(range(len(self.ticks))):
            row = slice(k * n, (k + 1) * n)
            valid = everywhere if m.valid is None else m.valid[row]
            if valid.any():
                return m.reading(row, valid, self.ticks[k] * dt_ns, f"{self.agent}/{self.model.name}")
        return None


@dataclass
class Feedback:
    """What guidance knows from sensors: the last altitude `(n,)` [m], and whether a fix came since it last asked."""

    altitude: NDArray[np.float64]
    gps: NDArray[np.bool_]


@dataclass
class Timings:
    """Wall-clock seconds and number of calls, by part of the loop."""

    seconds: dict[str, float] = field(default_factory=dict)
    calls: dict[str, int] = field(default_factory=dict)

    def add(self, part: str, start: float) -> None:
        """Count the time since `start`."""
        self.seconds[part] = self.seconds.get(part, 0.0) + time.perf_counter() - start
        self.calls[part] = self.calls.get(part, 0) + 1


class Stepper:
    """Moves every agent, asks every due sensor. What changes in a run is here, and nowhere else.

    Attributes:
        tick: ticks since the start.
        timings: where the time went.
        trajectories: by agent, the motion of the last block; after `catch_up`, since the one before.
    """

    def __init__(self, model: Model, bodies: Bodies) -> None:
        self._model = model
        self._bodies = bodies
        self._select = LaneSelector(n=model.n, dt_ns=model.clock.dt_ns, first_environment=model.first_environment)
        self._touch = {name: Touch(agent, model, bodies) for name, agent in model.agents.items()}
        self._guidance_period = model.clock.period(GUIDANCE_RATE_HZ)
        self._runs: dict[str, AgentRun] = {}
        self._guidance: dict[str, Guidance] = {}
        self._feedback: dict[str, Feedback] = {}
        self.trajectories: dict[str, Trajectory] = {}
        self._blocks: dict[str, list[Trajectory]] = {}
        self._contact: dict[str, Wrench] = {}
        self._blows: dict[str, list[tuple[int, NDArray[np.float64]]]] = {}
        model.blows.latest = self._latest_blow
        self.timings = Timings()
        self.tick = 0

    def start(self, states: Mapping[str, StartState]) -> dict[str, dict[str, Reading]]:
        """Tick 0: place the agents, and read every sensor."""
        self.tick = 0
        self.timings = Timings()
        self._guidance.clear()
        self._blocks.clear()
        self._blows.clear()
        self._model.scene.forget()
        for name, agent in self._model.agents.items():
            self._place(agent, states[name])
        return self._observe(self._sense())

    def read_now(self) -> list[Sampled]:
        """Every sensor that is due at the current tick, read again: the same bytes."""
        return self._sense()

    def step(self) -> dict[str, dict[str, Reading]]:
        """One tick."""
        return self._observe(self.advance(self.tick + 1))

    def advance(self, last: int, *, wait: bool = False) -> list[Sampled]:
        """Go on by one block, which ends at tick `last` or where the outside may act before.

        With `wait`, sensors for which nothing waits are left to `catch_up`: a call for the readings of ten blocks costs
        little more than one for those of a single block (a DVL 0.2 ms, an IMU 0.03 ms).
        """
        self._guide()
        self._bodies.follow(self.tick)
        ticks = self._block_length(last, wait)
        for agent in self._model.agents.values():
            self._move(agent, ticks)
            if wait:
                self._blocks.setdefault(agent.name, []).append(self.trajectories[agent.name])
        self.tick += ticks
        return self._sense(lambda agent, sensor: not (wait and self._waits(agent, sensor)))

    def catch_up(self) -> list[Sampled]:
        """Read the sensors that waited."""
        if not self._blocks:
            return []
        self.trajectories = {name: Trajectory.join(blocks) for name, blocks in self._blocks.items()}
        self._blocks.clear()
        return self._sense(self._waits)

    def states(self) -> dict[str, AgentState]:
        """The true state of every agent."""
        return {name: self._state(self._model.agents[name], run) for name, run in self._runs.items()}

    def contact(self, agent: str) -> NDArray[np.float64]:
        """`(n, 6)` force [N] and moment about the body's origin [N m], FLU, by contact over the last tick."""
        wrench = self._contact.get(agent)
        if wrench is None:
            return np.zeros((self._model.n, 6))
        force, moment = (np.broadcast_to(np.array(w), (3, self._model.n)).T for w in wrench)
        return np.concatenate([flip_yz_np(force), flip_yz_np(moment)], axis=1)

    def _keep_blow(self, agent: str) -> None:
        """Remember the contact of the tick that begins, for a second."""
        kept = self._blows.setdefault(agent, [])
        kept.append((self.tick + 1, self.contact(agent)))
        oldest = self.tick - round(1e9 / self._model.clock.dt_ns)
        while kept[0][0] < oldest:
            kept.pop(0)

    def _latest_blow(self, agent: str, ticks: int) -> NDArray[np.float64]:
        """See `Blows.latest`."""
        found = [wrench for tick, wrench in self._blows.get(agent, ()) if tick > self.tick - ticks]
        if not found:
            return np.zeros((self._model.n, 6))
        wrenches = np.stack(found)
        strongest = np.linalg.norm(wrenches[..., :3], axis=-1).argmax(axis=0)
        return np.asarray(wrenches[strongest, np.arange(self._model.n)])

    def mode(self, agent: str) -> str:
        """The control mode of an agent."""
        return self._runs[agent].mode

    def missions_done(self) -> bool:
        """There are missions, and all have ended."""
        return bool(self._guidance) and all(g.done for g in self._guidance.values())

    def set_command(self, agent: str, values: NDArray[np.float64]) -> None:
        """Hold another command `(n, k)`; ends the agent's mission."""
        self._guidance.pop(agent, None)
        self._hold(self._runs[agent], values)

    def set_mode(self, agent: str, mode: str) -> None:
        """Another control mode, idling; ends the agent's mission."""
        self._guidance.pop(agent, None)
        model, run, state = self._model.agents[agent], self._runs[agent], self.states()[agent]
        model.vehicle.check_mode(mode)
        run.mode = mode
        self._hold(run, _idle(model, mode, state))

    def set_state(self, agent: str, **parts: NDArray[np.float64]) -> None:
        """Place an agent anew; its actuators and its mission go on."""
        run = self._runs[agent]
        model = self._model.agents[agent]
        state = model.vehicle.place(model.driver.unpack(run.vehicle), **parts)
        run.vehicle, run.row = model.driver.pack(state), _row(state)
        self.trajectories[agent] = self._standing(run)

    # the parts of `advance`

    def _guide(self) -> None:
        """Ask every mission for its set-points, at the rate of guidance."""
        if self.tick % self._guidance_period:
            return
        for name, guidance in self._guidance.items():
            start = time.perf_counter()
            run, feedback = self._runs[name], self._feedback[name]
            state = AgentState.of(run.row, np.empty((len(run.row), 0)))  # guidance does not ask for actuators
            t_s = self.tick * self._model.clock.dt_ns * 1e-9
            self._hold(run, guidance.command(state, feedback.altitude, feedback.gps, t_s))
            feedback.gps[:] = False
            self.timings.add(f"{name}.guidance", start)

    def _waits(self, agent: AgentModel, sensor: SensorModel) -> bool:
        """Whether a sensor's readings may be read some blocks later."""
        guides = agent.name in self._guidance and sensor.config.type in GUIDING
        changes = self._bodies.any or self._model.scene.streamed
        return sensor.waits and not guides and not (sensor.sees and changes)

    def _block_length(self, last: int, wait: bool) -> int:
        """Ticks until a sensor that sees, a mission or the caller may act; one at a time where a hull may touch."""
        periods = [
            sensor.period
            for agent in self._model.agents.values()
            for sensor in agent.sensors.values()
            if sensor.sees and not (wait and self._waits(agent, sensor))
        ]
        if self._guidance:
            periods.append(self._guidance_period)
        limit = min(last, self.tick + max(1, self._model.clock.ticks(MAX_BLOCK_S)))
        ticks = next_multiple(self.tick, periods, limit) - self.tick
        return 1 if any(self._near(name, ticks) for name in self._runs) else ticks

    def _near(self, name: str, ticks: int, *, now: bool = False) -> bool:
        row = self._runs[name].row
        speed = float(np.abs(row[:, 7:10]).sum(axis=1).max()) + MARGIN_MPS
        way = speed * ticks * self._model.clock.dt_ns * 1e-9
        return self._touch[name].possible(row[:, 0:3], way, self._agent_states, now=now)

    def _agent_states(self) -> dict[str, AgentState]:
        return self.states()

    def _move(self, agent: AgentModel, ticks: int) -> None:
        """The dynamics of one agent, and what it touches."""
        start = time.perf_counter()
        run, wrench = self._runs[agent.name], None
        self._contact.pop(agent.name, None)
        if ticks == 1 and self._near(agent.name, 1, now=True):
            self._bodies.place(self.states())
            wrench = self._contact[agent.name] = self._touch[agent.name].wrench(run.vehicle)
            if agent.name in self._model.blows.asked:
                self._keep_blow(agent.name)
            self.timings.add(f"{agent.name}.contact", start)
            start = time.perf_counter()
        run.vehicle, trajectory = agent.driver.advance(
            run.vehicle, run.command, self._model.ocean, mode=run.mode, tick=self.tick, ticks=ticks, wrench=wrench
        )
        motion = trajectory.numpy()
        if not np.isfinite(motion).all():
            self._stop_not_finite(agent, motion)
        run.row = motion[-1]
        self.trajectories[agent.name] = trajectory
        self.timings.add(f"{agent.name}.dynamics", start)

    def _sense(self, asked: Callable[[AgentModel, SensorModel], bool] | None = None) -> list[Sampled]:
        """Ask the sensors that are due in the last block, or those of them that are `asked`."""
        sampled = []
        placed = False
        for agent in self._model.agents.values():
            trajectory = self.trajectories[agent.name]
            lanes = {}
            for sensor in agent.sensors.values():
                due = trajectory.due(sensor.period)
                if not due or (asked is not None and not asked(agent, sensor)):
                    continue
                start = time.perf_counter()
                if sensor.sees and not placed:
                    self._bodies.follow(self.tick)
                    self._bodies.place(self.states())
                    placed = True
                if due not in lanes:
                    lanes[due] = self._select.lanes(trajectory, due)
                self._model.neighbours.motion_of = partial(self._motion_of, due)
                sampled.append(Sampled(agent.name, sensor, due, sensor.sensor.sense(lanes[due])))
                self._feed_back(sampled[-1])
                self.timings.add(f"{agent.name}.{sensor.name}", start)
        return sampled

    def _motion_of(self, due: range, agent: str) -> Kinematics:
        return self._select.lanes(self.trajectories[agent], due)

    def _feed_back(self, sampled: Sampled) -> None:
        """Keep what guidance needs."""
        n, kind, m = self._model.n, sampled.model.config.type, sampled.measurement
        feedback = self._feedback[sampled.agent]
        if kind == "altimeter":
            altitude = np.asarray(m.data, dtype=np.float64).reshape(len(sampled.ticks), n, -1)[-1, :, 0]
            valid = np.isfinite(altitude) if m.valid is None else m.valid[-n:] & np.isfinite(altitude)
            feedback.altitude = np.where(valid, altitude, np.inf)
        elif kind == "gps" and m.valid is not None:
            feedback.gps |= m.valid.reshape(-1, n).any(axis=0)

    # construction, and the numbers behind a state

    def _place(self, agent: AgentModel, start: StartState) -> None:
        vehicle = agent.vehicle.initial_state(start.position, start.attitude, start.velocity)
        mode = agent.mode
        run = AgentRun(agent.driver.pack(vehicle), [], np.empty(0), mode, _row(vehicle))
        self._runs[agent.name] = run
        self.trajectories[agent.name] = self._standing(run)
        state = self._state(agent, run)
        held = agent.config.command
        self._hold(run, _idle(agent, mode, state) if held is None else np.tile(np.array(held), (self._model.n, 1)))
        n = self._model.n
        self._feedback[agent.name] = Feedback(np.full(n, np.inf), np.zeros(n, dtype=bool))
        if agent.tasks:
            dt_s = self._guidance_period * self._model.clock.dt_ns * 1e-9
            self._guidance[agent.name] = Guidance.start(agent.tasks, state, dt_s=dt_s, length_m=_length(agent))

    def _hold(self, run: AgentRun, values: NDArray[np.float64]) -> None:
        if run.command_values.shape == values.shape and (run.command_values == values).all():
            return
        run.command_values = values
        run.command = _columns(values)

    def _standing(self, run: AgentRun) -> Trajectory:
        """A block of the current tick alone."""
        packed = jit.own(jit.Float64, run.row)
        return Trajectory(packed=packed, n=self._model.n, ticks=1, first_tick=self.tick)

    def _state(self, agent: AgentModel, run: AgentRun) -> AgentState:
        return AgentState.of(run.row, agent.driver.actuators(run.vehicle))

    def _observe(self, sampled: list[Sampled]) -> dict[str, dict[str, Reading]]:
        observed: dict[str, dict[str, Reading]] = {name: {} for name in self._model.agents}
        for one in sampled:
            newest = one.newest(self._model.n, self._model.clock.dt_ns)
            if newest is not None:
                observed[one.agent][one.model.name] = newest
        return observed

    def _stop_not_finite(self, agent: AgentModel, motion: NDArray[np.float64]) -> None:
        k, copy, _ = (int(i) for i in np.argwhere(~np.isfinite(motion))[0])
        t_s = (self.tick + 1 + k) * self._model.clock.dt_ns * 1e-9
        run = self._runs[agent.name]
        last = motion[k - 1, copy] if k else run.row[copy]
        lacking = self._model.ocean.uncovered(jit.Array3f64(*(float(v) for v in last[:3])), jit.Float64(t_s))
        raise NotFinite(agent, copy, t_s, last, run.command_values[copy], lacking)


class NotFinite(SimulationError):
    """A state is not finite any more; carries the last one that was.

    Attributes:
        agent, copy, t_s: which vehicle, and when [s].
        state: `(CHANNELS,)` the last finite motion.
        command: the command that was held.
    """

    def __init__(
        self,
        agent: AgentModel,
        copy: int,
        t_s: float,
        state: NDArray[np.float64],
        command: NDArray[np.float64],
        lacking: Sequence[str] = (),
    ) -> None:
        self.agent, self.copy, self.t_s, self.state, self.command = agent.name, copy, t_s, state, command
        if lacking:
            term = f"{' and '.join(lacking)} ends before that place or moment (outside: error)"
        else:
            term = agent.vehicle.blame(state[0:3], state[3:7], state[7:10], state[10:13])
        position, velocity = np.array2string(state[0:3], precision=3), np.array2string(state[7:10], precision=3)
        super().__init__(
            f"{agent.name} (copy {copy}) has no finite state at t = {t_s:.3f} s; {term}; just before it was "
            f"at {position} m with {velocity} m/s, commanded {np.array2string(command, precision=4)}"
        )


def _length(agent: AgentModel) -> float:
    vertices = agent.vehicle.hull.vertices
    return float(np.ptp(vertices[:, 0]))


def _row(state: VehicleState) -> NDArray[np.float64]:
    return np.stack([np.array(c) for c in channels(state)], axis=-1)


def _columns(values: NDArray[np.float64]) -> list[jit.Array]:
    """Each column of `(n, k)` set-points on the device."""
    if len(values) == 1:
        return [dr.opaque(jit.Float64, float(v)) for v in values[0]]  # faster than the way over NumPy
    columns = [jit.Float64(np.ascontiguousarray(column)) for column in values.T]
    jit.settle(columns)
    return columns


def _idle(agent: AgentModel, mode: str, state: AgentState) -> NDArray[np.float64]:
    """A command that changes nothing much: stay at this place, depth and heading, actuators at rest."""
    idle = {"depth": state.depth, "heading": -state.euler[:, 2], "yaw": state.euler[:, 2]}
    idle |= {axis: state.position[:, i] for i, axis in enumerate("xyz")}
    n = len(state.position)
    columns = [idle.get(name, np.zeros(n)) for name in agent.vehicle.command_names(mode)]
    return np.stack(columns, axis=-1) if columns else np.empty((n, 0))
