"""A run: the step loop until its end, with recording, progress and a policy."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from pelagos.config.loader import to_yaml
from pelagos.errors import CommandError, PelagosError
from pelagos.math.so3 import rotate_np
from pelagos.sim.record import Recorder
from pelagos.sim.step import NotFinite, Sampled
from pelagos.world.legend import legend

if TYPE_CHECKING:
    from pelagos.sim.simulation import Observations, Policy, Simulation

WAIT_S = 0.5  # sensors for which nothing waits are read together for at most this long; a killed run loses as much
SETTLE_S = 1.0  # a run goes on for this long after its last mission has ended


@dataclass(frozen=True)
class RunResult:
    """What a run was.

    Attributes:
        simulated_s, wall_s: how long [s].
        ended: why: the time was over, every mission had ended, or the user stopped it.
        counts: readings by "agent.sensor".
        ms_per_call: wall-clock time of one call [ms] by "agent.part".
        seconds_by_part: wall-clock time in all [s] by "agent.part".
        recording: the file, if one was written.
        observations: the newest reading of every sensor.
    """

    simulated_s: float
    wall_s: float
    ended: Literal["time", "missions", "interrupt"]
    counts: Mapping[str, int]
    ms_per_call: Mapping[str, float]
    seconds_by_part: Mapping[str, float]
    recording: Path | None
    observations: Observations

    @property
    def real_time_factor(self) -> float:
        """Simulated over wall-clock time."""
        return self.simulated_s / self.wall_s if self.wall_s > 0 else math.inf


def run(
    sim: Simulation,
    seconds: float | None,
    *,
    policy: Policy | None,
    record: str | Path | Recorder | None,
    progress: Callable[[float, float], None] | None,
    realtime: bool,
) -> RunResult:
    """See `Simulation.run`."""
    asked = sim.scenario.duration_s if seconds is None else float(seconds)
    if not (math.isfinite(asked) and asked > 0):
        raise CommandError(f"a run lasts a positive number of seconds, not {seconds!r}")
    recorder = record if isinstance(record, Recorder) or record is None else open_recorder(Path(record), sim)
    loop = _Loop(sim, asked, policy, recorder, progress, realtime, until_missions_end=seconds is None)
    try:
        return loop.go()
    except NotFinite as error:
        raise _with_dump(error, recorder) from None
    finally:
        if recorder is not None and recorder is not record:
            recorder.close()


def open_recorder(path: Path, sim: Simulation) -> Recorder:
    """A recorder for every sensor of `sim`.

    Raises:
        RecordingError: the file cannot be written.
    """
    scenario = sim.scenario
    sensors = {name: {s: m.config for s, m in agent.sensors.items()} for name, agent in sim.model.agents.items()}
    origin = (sim.world.origin.latitude, sim.world.origin.longitude)
    moving = sim.moving
    names = legend(sim.world, moving)
    made = Recorder(path, to_yaml(scenario), sim.seed, sensors, None, origin, sim.dt_ns, copies=sim.n, legend=names)
    for mover in sim.world.movers:
        number, instance = next((g.label, g.instance) for g in moving if g.name == mover.name)
        made.add_mover(
            mover.name,
            {"mover": mover.name, "body": mover.body, "label": names["labels"][str(number)]["name"],
             "label_number": str(number), "instance": str(instance)},
        )  # fmt: skip
    return made


class _Loop:
    def __init__(
        self,
        sim: Simulation,
        asked: float,
        policy: Policy | None,
        recorder: Recorder | None,
        progress: Callable[[float, float], None] | None,
        realtime: bool,
        *,
        until_missions_end: bool,
    ) -> None:
        self._sim, self._asked, self._policy = sim, asked, policy
        self._recorder, self._progress, self._realtime = recorder, progress, realtime
        self._until_missions_end = until_missions_end
        self._stepper = sim.stepper
        self._first = self._stepper.tick
        self._last = self._first + sim.model.clock.ticks(asked)
        self._counts = {f"{a.name}.{s}": 0 for a in sim.model.agents.values() for s in a.sensors}
        self._caught_up = self._first
        self._moved = self._first if self._first == 0 else self._first + 1  # movers are written down from this tick on
        self._held: dict[tuple[str, str], list[Sampled]] = {}
        self._latest: Observations = {name: {} for name in sim.model.agents}

    def go(self) -> RunResult:
        started = time.perf_counter()
        ended: Literal["time", "missions", "interrupt"] = "time"
        if self._first == 0:
            self._take(self._stepper.read_now())
            self._record_truth()
        try:
            while self._stepper.tick < self._last:
                self._advance()
                self._report(started)
                if self._until_missions_end and self._stepper.missions_done():
                    ended = "missions"
                    settle = self._stepper.tick + self._sim.model.clock.ticks(SETTLE_S)
                    self._last = min(self._last, settle)
                    self._until_missions_end = False
        except KeyboardInterrupt:
            ended = "interrupt"
        except NotFinite:
            self._catch_up()
            raise
        self._catch_up()
        return self._result(time.perf_counter() - started, ended)

    def _advance(self) -> None:
        if self._policy is not None:
            self._sim.command(self._policy(self._latest) or {})
            self._latest = {name: {} for name in self._sim.model.agents}
            self._take(self._stepper.advance(self._stepper.tick + 1))
            self._record_truth()
        elif self._realtime:
            self._take(self._stepper.advance(self._last))
            self._record_truth()
        else:
            last = min(self._last, self._caught_up + self._sim.model.clock.ticks(WAIT_S))
            sampled = self._stepper.advance(last, wait=True)
            self._take([one for one in sampled if not one.model.waits])
            for one in sampled:
                if one.model.waits:  # guidance could not wait, the recording can: a call for five takes the time of one
                    self._held.setdefault((one.agent, one.model.name), []).append(one)
            if self._stepper.tick >= last:
                self._catch_up()

    def _catch_up(self) -> None:
        """Read the sensors that waited, and write down the motion since."""
        if self._stepper.tick > self._caught_up and self._policy is None and not self._realtime:
            self._caught_up = self._stepper.tick
            self._take([*map(Sampled.join, self._held.values()), *self._stepper.catch_up()])
            self._held.clear()
            self._record_truth()

    def _take(self, sampled: list[Sampled]) -> None:
        """Count, record and keep what was read."""
        n, dt_ns = self._sim.n, self._sim.dt_ns
        for one in sampled:
            self._counts[f"{one.agent}.{one.model.name}"] += one.count(n)
            if self._recorder is not None:
                start = time.perf_counter()
                t_ns = np.array(one.ticks, dtype=np.int64) * dt_ns
                self._recorder.write_block(one.agent, one.model.name, t_ns, one.measurement, n=n)
                self._stepper.timings.add("record", start)
            newest = one.newest(n, dt_ns)
            if newest is not None:
                self._latest[one.agent][one.model.name] = newest

    def _record_truth(self) -> None:
        """Write down the motion of the ticks that were taken."""
        if self._recorder is None:
            return
        start = time.perf_counter()
        clock = self._sim.model.clock
        period = clock.period(self._sim.scenario.record.state_rate_hz)
        self._record_movers(period)
        for name, trajectory in self._stepper.trajectories.items():
            due = np.array(trajectory.due(period), dtype=np.int64)
            if len(due):
                motion = trajectory.numpy()[due - trajectory.first_tick]
                parts = (motion[..., 0:3], motion[..., 3:7], motion[..., 7:10], motion[..., 10:13])
                self._recorder.write_truth_block(name, due * clock.dt_ns, *parts)
        self._stepper.timings.add("record", start)

    def _record_movers(self, period: int) -> None:
        """Write down where movers were at the same ticks: where they are depends on the tick alone."""
        assert self._recorder is not None
        first, self._moved = -(-self._moved // period) * period, self._stepper.tick + 1
        ticks = np.arange(first, self._moved, period, dtype=np.int64)
        for mover in self._sim.world.movers:
            if mover.name in self._recorder.movers and len(ticks):
                poses = [mover.pose(tick * self._sim.dt_ns * 1e-9) for tick in ticks.tolist()]
                q = np.stack([p.attitude for p in poses])
                back = q * [1.0, -1.0, -1.0, -1.0]  # into the body's own frame
                self._recorder.write_mover_block(
                    mover.name,
                    ticks * self._sim.dt_ns,
                    np.stack([p.position for p in poses]),
                    q,
                    rotate_np(back, np.stack([p.velocity for p in poses])),
                    rotate_np(back, np.stack([p.angular_velocity for p in poses])),
                )

    def _report(self, started: float) -> None:
        simulated = (self._stepper.tick - self._first) * self._sim.dt_ns * 1e-9
        if self._realtime:
            ahead = simulated - (time.perf_counter() - started)
            if ahead > 0:
                time.sleep(ahead)
        if self._progress is not None:
            self._progress(simulated, self._asked)

    def _result(self, wall_s: float, ended: Any) -> RunResult:
        timings = self._stepper.timings
        return RunResult(
            simulated_s=(self._stepper.tick - self._first) * self._sim.dt_ns * 1e-9,
            wall_s=wall_s,
            ended=ended,
            counts=self._counts,
            ms_per_call={p: 1e3 * s / timings.calls[p] for p, s in timings.seconds.items()},
            seconds_by_part=dict(timings.seconds),
            recording=None if self._recorder is None else self._recorder.path,
            observations=self._latest,
        )


def _with_dump(error: NotFinite, recorder: Recorder | None) -> PelagosError:
    """The same error, with the file that holds the last finite state."""
    folder = Path.cwd() if recorder is None else recorder.path.parent
    path = folder / f"{error.agent}_last_state.npz"
    try:
        np.savez(path, state=error.state, command=error.command, t_s=error.t_s, copy=error.copy)
    except OSError:
        return error
    error.args = (f"{error.args[0]}. The state is in {path}",)
    return error
