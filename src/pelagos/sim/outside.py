"""The face of a simulation towards viewers, bridges and loggers: callbacks, recordings, other threads."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, cast

from pelagos.errors import CommandError, LookupFailed
from pelagos.sim.gate import Gate
from pelagos.sim.listeners import Listeners, OnReading, OnTick, Subscription
from pelagos.sim.model import Model
from pelagos.sim.record import Recorder
from pelagos.sim.run_log import RunLog, open_recorder
from pelagos.sim.sampled import Sampled
from pelagos.sim.step import Stepper
from pelagos.sim.watch import BlockReadings, Watcher

if TYPE_CHECKING:
    from pelagos.sim.simulation import Simulation


class Outside:
    """Face of a simulation to those who watch it and act on it.

    Attributes:
        model: the constant part.
        listeners: callbacks.
        gate: by which actions enter, and runs are held.
        logs: of the recordings that are open.
        watchers: callbacks of `watch`.
    """

    model: Model
    listeners: Listeners
    gate: Gate
    logs: list[RunLog]
    watchers: list[Watcher]
    _stepper: Stepper

    def post(self, action: Callable[[], object]) -> None:
        """Have an action done at the next boundary of steps, by the thread that steps; any thread may call this.

        Boundaries come with every call of `step`, and in a run at least once a simulated second; a paused run acts at
        once. Actions are done in the order in which they were posted.
        """
        self.gate.post(action)

    def on_tick(self, callback: OnTick, *, rate_hz: float | None = None) -> Subscription:
        """Call `callback(sim)` at every tick, tick 0 included, or at `rate_hz` at most.

        Blocks of ticks end where it is called, so a low rate costs little, and none costs nothing; readings and states
        are the same bytes. It may set commands, spawn, post actions or end the run, but not step. `Listeners` has the
        order of calls. What it raises ends the step or the run, and says which callback it was.

        Args:
            callback: called after the readings of that tick were told.
            rate_hz: calls in a simulated second; the time between them is rounded up to whole ticks.

        Returns:
            A handle to `cancel`, also as a context manager.
        """
        if rate_hz is not None and not (math.isfinite(rate_hz) and rate_hz > 0):
            raise CommandError(f"rate_hz is a positive number, not {rate_hz!r}")
        period = 1 if rate_hz is None else max(1, math.ceil(1e9 / (rate_hz * self.model.clock.dt_ns) - 1e-9))
        return self.listeners.add("tick", callback, period=period)

    def subscribe(self, sensor: str, callback: OnReading, *, invalid: bool = False) -> Subscription:
        """Call `callback(reading)` for every reading of a sensor, at its own tick, tick 0 included.

        Args:
            sensor: "auv0.imaging".
            callback: as for `on_tick`.
            invalid: call also for readings that are valid in no copy, such as those of a DVL without bottom lock.

        Raises:
            LookupFailed: there is no such sensor.
        """
        known = [f"{a.name}.{s}" for a in self.model.agents.values() for s in a.sensors]
        if sensor not in known:
            raise LookupFailed("sensor", sensor, known)
        return self.listeners.add(sensor, callback, invalid=invalid)

    @contextmanager
    def watch(self, callback: Callable[[BlockReadings], object]) -> Iterator[None]:
        """Call `callback(heard)` after every block of ticks within a `with` block, with what was read in it.

        The readings of tick 0 come within `reset`, or with the first step or run from there, and once.
        Unlike `on_tick` and `subscribe` it asks for no boundaries: blocks are as long as without it, so it costs what
        the callback does. Sensors that a run reads together afterwards are heard then. The callback may look at
        `sim.state` and post actions, but not step.

        Args:
            callback: takes a `BlockReadings`, readings by "agent.sensor".
        """
        watcher = Watcher(callback)
        self.watchers.append(watcher)
        try:
            yield
        finally:
            self.watchers.remove(watcher)

    def tell_watchers(self, sampled: Sequence[Sampled]) -> None:
        """Tell everybody who watches what was read in a block."""
        self._tell(tuple(self.watchers), sampled)

    def tell_start(self, sampled: Sequence[Sampled] | None = None, *, again: bool = False) -> None:
        """Tell those who watch, and have not heard it, what is read where a run begins; `again`: all of them."""
        new = tuple(w for w in self.watchers if again or not w.begun)
        for watcher in new:
            watcher.begun = True
        if new:
            self._tell(new, self._stepper.read_now() if sampled is None else sampled)

    def _tell(self, watchers: Sequence[Watcher], sampled: Sequence[Sampled]) -> None:
        if watchers:
            heard = BlockReadings(sampled, n=self.model.n, dt_ns=self.model.clock.dt_ns)
            for watcher in watchers:
                watcher.callback(heard)

    def _tell_reset(self) -> None:
        """Time has gone back to a start: who watches hears its readings at once, and may not step meanwhile."""
        self.gate.enter("reset")
        try:
            self.tell_start(again=True)
        finally:
            self.gate.leave()

    @contextmanager
    def recording(self, path: str | Path) -> Iterator[Recorder]:
        """Record all steps and runs of a `with` block, as `run(record=...)` records its own.

        Raises:
            RecordingError: the file cannot be written.
        """
        recorder = open_recorder(Path(path), cast("Simulation", self))
        log = RunLog(cast("Simulation", self), recorder)
        self.logs.append(log)
        self._stepper.logged = True
        try:
            log.begin()
            yield recorder
        finally:
            self.logs.remove(log)
            self._stepper.logged = bool(self.logs)
            recorder.close()

    def pause(self) -> None:
        """Hold a run at its next boundary of steps until `resume`; posted actions are done meanwhile."""
        self.gate.set(paused=True)

    def resume(self) -> None:
        """Let a run go on."""
        self.gate.set(paused=False)

    def stop(self) -> None:
        """End the present run at its next boundary of steps, in order."""
        self.gate.set(stopped=True)

    @property
    def paused(self) -> bool:
        """Runs are held."""
        return self.gate.paused

    def _refuse_within(self, what: str, *, in_recording: bool = False) -> None:
        """Refuse what would turn time back under a step loop or, unless that is allowed, a recording."""
        self.gate.refuse(what)
        if self.logs and not in_recording:
            raise CommandError(f"sim.{what} turns time back; leave the recording {self.logs[-1].recorder.path} before")
