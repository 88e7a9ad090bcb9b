"""`Exchange`: a run and its doors. Messages go out and orders come in at boundaries of steps, and nowhere else."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Final

from pelagos.bridges.door import Door, Driver
from pelagos.bridges.inbox import ANSWER_S, Inbox
from pelagos.bridges.journal import TOPIC
from pelagos.bridges.machinery import Machinery
from pelagos.bridges.pace import Pace
from pelagos.bridges.tap import STRING, Message, Tap, text_message
from pelagos.sim.garbage import StepperCollects
from pelagos.sim.listeners import Subscription
from pelagos.sim.mcap_writer import McapWriter
from pelagos.sim.record import Recorder, installed
from pelagos.sim.run import RunResult
from pelagos.sim.run_log import open_recorder
from pelagos.sim.simulation import Simulation

FREE_HZ: Final = 2.0
"""Boundaries in a simulated second of a run as fast as it goes: readings are made in blocks of half a second."""
REALTIME_HZ: Final = 100.0


class Exchange:
    """Runs a simulation with doors open; `run` may be called again after a reset from outside.

    Attributes:
        inbox: where doors put orders.
        pace: how the run keeps to the clock on the wall.
        reset_asked: the outside asked to begin anew; the run has ended for that.
        doors: in the order in which messages go out.

    Args:
        sim: the simulation.
        rate_hz: boundaries in a simulated second; by `realtime` where not given.
        realtime: how many times as fast as the clock on the wall; 0 as fast as it goes.
        say: what tells the user about refused orders.
    """

    def __init__(
        self,
        sim: Simulation,
        *,
        rate_hz: float | None = None,
        realtime: float = 0.0,
        say: Callable[[str], None] | None = None,
    ) -> None:
        self.sim = sim
        self.doors: list[Door] = []
        self._drivers: list[Driver] = []
        self.pace = Pace(realtime)
        self.reset_asked = False
        self.inbox = Inbox(sim, self.note, say)
        self._rate_hz = rate_hz or (REALTIME_HZ if realtime else FREE_HZ)
        self._tap: Tap | None = None
        self._orders = 0
        self._machinery: Machinery | None = None
        self._steps: tuple[Subscription, threading.Event] | None = None
        self._garbage = StepperCollects()

    def add(self, door: Door) -> None:
        """Open another door at the next run."""
        self.doors.append(door)

    def at_least(self, rate_hz: float) -> None:
        """Have boundaries at this rate or faster, for a door that speaks of the present."""
        self._rate_hz = max(self._rate_hz, rate_hz)

    def drive(self, driver: Driver) -> None:
        """Let an autopilot set the pace: the simulation waits for it at its boundaries."""
        self._drivers.append(driver)

    def run(
        self,
        seconds: float | None = None,
        *,
        record: str | Path | None = None,
        progress: Callable[[float, float], None] | None = None,
    ) -> RunResult:
        """Run for a time, or until the missions or the outside end it; see `Simulation.run`."""
        self.reset_asked = False
        file = None if record is None else McapWriter(Path(record), library=f"pelagos {installed('pelagos')}")
        tap = Tap(file)
        path = Path() if record is None else Path(record)
        recorder = open_recorder(path, self.sim, writer=tap, by_member=bool(self.doors))  # doors speak of members
        self._tap, self._orders = tap, tap.declare(TOPIC, STRING)
        self._machinery = Machinery(self.sim, tap) if self.doors else None
        for door in self.doors:
            door.open(self.sim, tap)
        subscriptions = [self.sim.on_tick(self._boundary, rate_hz=self._rate_hz)]
        for rate_hz in {driver.rate_hz for driver in self._drivers}:
            group = [driver for driver in self._drivers if driver.rate_hz == rate_hz]
            subscriptions.append(self.sim.on_tick(partial(_meet, group), rate_hz=rate_hz))
        self.pace.restart(self.sim.time_ns)
        self._garbage.open()
        try:
            return self._go(seconds, recorder, progress)
        finally:
            for subscription in subscriptions:
                subscription.cancel()
            self.inbox.write_down()
            self._send()
            recorder.close()
            self._tap = None
            self._garbage.close()

    def reset(self) -> None:
        """Ask for a new beginning: the run ends in order, and whoever called `run` resets and runs again."""
        self.reset_asked = True
        self.sim.stop()

    def resume(self) -> None:
        """Let a paused run go on; the time of the pause is not made up for."""
        self.sim.post(self._resume)

    def do(self, action: Callable[[], object], wait_s: float = ANSWER_S) -> bool:
        """Have something done by the thread that steps, at a boundary, and wait for it; False where it came to none."""
        done = threading.Event()

        def act() -> None:
            try:
                action()
            finally:
                done.set()

        self.sim.post(act)
        return done.wait(wait_s)

    def step(self, ticks: int) -> threading.Event:
        """Let a paused run go on by so many ticks; the event is set when it is held again."""
        done = threading.Event()
        self.sim.post(lambda: self._begin_steps(ticks, done))
        return done

    def close(self) -> Counter[str]:
        """Close every door; what was dropped, refused and failed, by reason."""
        found: Counter[str] = Counter()
        ends: list[Door | Driver] = [*self.doors, *self._drivers]
        for door in ends:
            found.update({f"{door.name}: {reason}": count for reason, count in door.report().items() if count})
            door.close()
        found.update({f"refused: {reason}": count for reason, count in self.inbox.refused.items()})
        self.doors.clear()
        self._drivers.clear()
        return found

    def _go(
        self, seconds: float | None, recorder: Recorder, progress: Callable[[float, float], None] | None
    ) -> RunResult:
        # a factor so high that the run itself never waits, but hands every block on at once
        realtime = 1e6 if self.pace.factor else False
        return self.sim.run(seconds, record=recorder, progress=progress, realtime=realtime)

    def _boundary(self, sim: Simulation) -> None:
        self._garbage.collect()
        self.pace.keep(sim.time_ns)
        self.inbox.write_down()
        if self._machinery is not None:
            self._machinery.say(sim)
        self._send()
        self.inbox.drain()

    def _send(self) -> None:
        if self._tap is None:
            return
        messages: Sequence[Message] = self._tap.take()
        for door in self.doors:
            door.send(self.sim, messages)

    def note(self, text: str, t_ns: int) -> None:
        """Write an order's text down in the recording, if one is made."""
        if self._tap is not None:
            self._tap.add_message(self._orders, t_ns, text_message(text))

    def _resume(self) -> None:
        self._end_steps()
        self.pace.restart(self.sim.time_ns)
        self.sim.resume()

    def _begin_steps(self, ticks: int, done: threading.Event) -> None:
        self._end_steps()
        left, last = ticks, self.sim.time_ns // self.sim.dt_ns

        def count(sim: Simulation) -> None:
            nonlocal left
            left -= sim.time_ns // sim.dt_ns > last
            if left <= 0:
                self._end_steps()
                self.sim.pause()
                self._send()

        self._steps = self.sim.on_tick(count), done
        self.pace.restart(self.sim.time_ns)
        self.sim.resume()

    def _end_steps(self) -> None:
        if self._steps is not None:
            counter, done = self._steps
            self._steps = None
            counter.cancel()
            done.set()


def _meet(drivers: Sequence[Driver], sim: Simulation) -> None:
    """All are answered before any is waited for, so that they think at the same time."""
    for driver in drivers:
        driver.answer(sim)
    for driver in drivers:
        driver.wait(sim)
