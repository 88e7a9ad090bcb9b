"""A run: the step loop until its end, with recording, progress and a policy."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from pelagos.errors import CommandError, PelagosError, RecordingError
from pelagos.sim.not_finite import NotFinite
from pelagos.sim.record import Recorder
from pelagos.sim.run_log import RunLog, open_recorder
from pelagos.sim.sampled import Sampled, newest

if TYPE_CHECKING:
    from pelagos.sim.lives import Observations
    from pelagos.sim.simulation import Policy, Simulation
    from pelagos.sim.step import Stepper

WAIT_S = 0.5  # sensors for which nothing waits are read together for at most this long; a killed run loses as much
Ending = Literal["time", "missions", "interrupt", "stopped"]
SETTLE_S = 1.0  # a run goes on for this long after its last mission has ended


@dataclass(frozen=True)
class RunResult:
    """Result of a run.

    Attributes:
        simulated_s, wall_s: how long [s].
        ended: why: the time was over, every mission had ended, the user stopped it (Ctrl-C), or `sim.stop` did.
        counts: readings by "agent.sensor".
        ms_per_call: wall-clock time of one call [ms] by "agent.part".
        seconds_by_part: wall-clock time in all [s] by "agent.part".
        recording: the file, if one was written.
        observations: the newest reading of every sensor.
    """

    simulated_s: float
    wall_s: float
    ended: Ending
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
    realtime: bool | float,
) -> RunResult:
    """See `Simulation.run`."""
    asked = sim.scenario.duration_s if seconds is None else float(seconds)
    if not (math.isfinite(asked) and asked > 0):
        raise CommandError(f"a run lasts a positive number of seconds, not {seconds!r}")
    if not (math.isfinite(realtime) and realtime >= 0):
        raise CommandError(f"realtime is true, false, or how many times as fast as the clock; not {realtime!r}")
    sim.gate.enter("run")
    recorder = None
    try:
        recorder = record if isinstance(record, Recorder) or record is None else open_recorder(Path(record), sim)
        logs = [*sim.logs, *([] if recorder is None else [RunLog(sim, recorder)])]
        sim.gate.set(stopped=False)
        sim.stepper.logged = bool(logs)
        loop = _Loop(sim, asked, policy, logs, progress, float(realtime), until_missions_end=seconds is None)
        return loop.go()
    except NotFinite as error:
        raise _with_dump(error, recorder) from None
    finally:
        sim.gate.leave()
        sim.stepper.logged = bool(sim.logs)
        if recorder is not None and recorder is not record:
            recorder.close()


class _Loop:
    def __init__(
        self,
        sim: Simulation,
        asked: float,
        policy: Policy | None,
        logs: list[RunLog],
        progress: Callable[[float, float], None] | None,
        realtime: float,
        *,
        until_missions_end: bool,
    ) -> None:
        self._sim, self._asked, self._policy = sim, asked, policy
        self._logs, self._progress, self._realtime = logs, progress, realtime
        self._until_missions_end = until_missions_end
        self._gate, self._listeners = sim.gate, sim.listeners
        self._first = self._stepper.tick
        self._last = self._first + sim.model.clock.ticks(asked)
        self._counts = {f"{a.name}.{s}": 0 for a in sim.model.agents.values() for s in a.sensors}
        self._caught_up = self._first
        self._held: dict[tuple[str, str], list[Sampled]] = {}
        self._newest: dict[tuple[str, str], list[Sampled]] = {}
        self._waits = policy is None and not realtime
        self._ahead_of = (self._first, time.perf_counter())  # tick and wall-clock time that realtime counts from

    @property
    def _stepper(self) -> Stepper:
        """The present one: another ocean brings another stepper."""
        return self._sim.stepper

    def go(self) -> RunResult:
        started = time.perf_counter()
        ended: Ending = "time"
        self._gate.settle = self._catch_up
        if self._first == 0:
            sampled = self._stepper.read_now()
            self._keep(sampled)
            for log in self._logs:
                log.begin(sampled)
            self._sim.tell_start(sampled)
            if self._listeners.any:
                self._listeners.tell(self._sim, 0, sampled)
        try:
            while self._stepper.tick < self._last:
                if self._gate.hold():
                    self._ahead_of = (self._stepper.tick, time.perf_counter())
                if self._gate.stopped:
                    ended = "stopped"
                    break
                self._advance()
                self._report()
                if self._until_missions_end and self._stepper.missions_done():
                    ended = "missions"
                    settle = self._stepper.tick + self._sim.model.clock.ticks(SETTLE_S)
                    self._last = min(self._last, settle)
                    self._until_missions_end = False
        except KeyboardInterrupt:
            ended = "interrupt"
        except RecordingError:
            raise
        except Exception:  # of a callback, a policy, or a state that is not finite: what was before it is recorded
            self._catch_up()
            raise
        self._catch_up()
        return self._result(time.perf_counter() - started, ended)

    def _advance(self) -> None:
        """One block: written down, then told."""
        tick = self._stepper.tick
        if self._policy is not None:
            self._sim.command(self._policy(self._latest) or {})
            self._newest.clear()
        for log in self._logs:
            log.look()
        last = tick + 1 if self._policy is not None else self._last
        if self._waits:
            last = min(last, self._caught_up + self._sim.model.clock.ticks(WAIT_S))
        sampled = self._stepper.advance(last, wait=self._waits)
        if not self._waits:
            self._take(sampled)
            self._record_motion()
        else:
            self._take([one for one in sampled if not one.model.waits])
            for one in sampled:
                if one.model.waits:  # others could not wait, the recording can: a call for five takes the time of one
                    self._held.setdefault((one.members[0], one.model.name), []).append(one)
            if self._stepper.tick >= last:
                self._catch_up()
        if self._listeners.any:
            self._listeners.tell(self._sim, self._stepper.tick, sampled)

    def _catch_up(self) -> None:
        """Read the sensors that waited, and write down the motion since."""
        if self._waits and self._stepper.tick > self._caught_up:
            self._caught_up = self._stepper.tick
            self._take([*map(Sampled.join, self._held.values()), *self._stepper.catch_up()])
            self._held.clear()
            self._record_motion()

    def _take(self, sampled: list[Sampled]) -> None:
        """Count, record and keep what was read."""
        self._keep(sampled)
        for log in self._logs:
            log.readings(sampled)
        self._sim.tell_watchers(sampled)

    def _keep(self, sampled: list[Sampled]) -> None:
        for one in sampled:
            for agent, count in zip(one.members, one.counts(self._sim.n), strict=True):
                self._counts[f"{agent}.{one.model.name}"] += count
            key = one.members[0], one.model.name
            self._newest[key] = newest([*self._newest.get(key, ()), one], self._sim.n)

    @property
    def _latest(self) -> Observations:
        """The newest reading of every sensor."""
        return self._stepper.observed([one for parts in self._newest.values() for one in parts])

    def _record_motion(self) -> None:
        for log in self._logs:
            log.motion()

    def _report(self) -> None:
        if self._realtime:
            tick, wall = self._ahead_of
            due = (self._stepper.tick - tick) * self._sim.dt_ns * 1e-9 / self._realtime
            ahead = due - (time.perf_counter() - wall)
            if ahead > 0:
                time.sleep(ahead)
        if self._progress is not None:
            self._progress((self._stepper.tick - self._first) * self._sim.dt_ns * 1e-9, self._asked)

    def _result(self, wall_s: float, ended: Ending) -> RunResult:
        timings = self._stepper.timings
        return RunResult(
            simulated_s=(self._stepper.tick - self._first) * self._sim.dt_ns * 1e-9,
            wall_s=wall_s,
            ended=ended,
            counts=self._counts,
            ms_per_call={p: 1e3 * s / timings.calls[p] for p, s in timings.seconds.items()},
            seconds_by_part=dict(timings.seconds),
            recording=self._logs[-1].recorder.path if self._logs else None,
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
