"""The thread that steps a simulation for the view: pace, pause, single ticks, way-points, and orders at boundaries."""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Final

import numpy as np

from pelagos.errors import InputError, SimulationError
from pelagos.sim.order import Order, apply
from pelagos.sim.simulation import Simulation
from pelagos.viewer.live import Live

STEP_S: Final = 0.05
"""Wall-clock time that a call of `step` is meant to take, in a run that keeps to the clock."""
FASTEST: Final = 0.0
"""A speed of 0: as fast as it goes."""
_NEAR_M: Final = 3.0
_IDLE_S: Final = 0.05
_BEHIND_S: Final = 0.3  # a run that is later than this does not try to catch up
_MEMORY_S: Final = 1.0  # wall-clock time over which the speed that is shown is taken


class Pilot:
    """Steps a simulation until it is closed.

    Attributes:
        sim: what is stepped.
        live: where its frames go.
        paused: it stands still.
        speed: times the clock; 0: as fast as it goes.
        goals: way-points that are still ahead, by agent, world NWU [m].
        say: tells the user.

    Args:
        sim: a simulation of one copy; copy 0 of several is shown.
        live: see above.
        record: file to record into from the start.
    """

    def __init__(self, sim: Simulation, live: Live, *, speed: float = 1.0, paused: bool = False) -> None:
        self.sim, self.live = sim, live
        self.paused, self.speed = paused, speed
        self.goals: dict[str, list[np.ndarray[Any, Any]]] = {}
        self.say: Callable[[str, str], None] = lambda text, kind: None
        self._orders: queue.SimpleQueue[Callable[[], object]] = queue.SimpleQueue()
        self._wake = threading.Event()
        self._closed = False
        self._single = 0
        self._rate, self._spent = 0.0, (0.0, 0.0)
        self._recording: tuple[AbstractContextManager[Any], Path] | None = None
        self._ended = False
        self._from: dict[str, np.ndarray[Any, Any]] = {}  # where the way to the present way-point begins

    def post(self, order: Callable[[], object]) -> None:
        """Have something done between two steps; any thread may call this."""
        self._orders.put(order)
        self._wake.set()

    def close(self) -> None:
        """End `run`."""
        self._closed = True
        self._wake.set()

    def stop_soon(self) -> None:
        """End `run` after the step that it is in; takes no lock, so a handler of signals may call it."""
        self._closed = True

    def run(self) -> None:
        """Step, until `close`."""
        with self.sim.watch(self.live.heard):
            self.sim.reset()
            self.live.show()
            due = time.perf_counter()
            while not self._closed:
                self._obey()
                if (self.paused and not self._single) or self._ended:
                    self._rest()
                    due = time.perf_counter()
                    continue
                due = self._advance(due)
        self.end_recording()

    def single(self) -> None:
        """One tick, and stand still again."""
        self.paused, self._single = True, self._single + 1

    def reset(self, seed: int | None = None) -> None:
        """Back to the start.

        Raises:
            InputError: something records.
        """
        if self._recording is not None:
            raise InputError("end the recording before going back to the start")
        self.sim.reset(seed)
        self.goals.clear()
        self._ended = False
        self.live.show()

    def go_to(self, agent: str, place: np.ndarray[Any, Any]) -> None:
        """Append a way-point [m]; the vehicle leaves its mission for it."""
        goals = self.goals.setdefault(agent, [])
        goals.append(place)
        if len(goals) == 1:
            try:
                self._head(agent)
            except InputError:
                goals.clear()
                raise

    def begin_recording(self, path: Path) -> None:
        """Record from now on.

        Raises:
            RecordingError: the file cannot be written.
        """
        if self._recording is None:
            context = self.sim.recording(path)
            context.__enter__()
            self._recording = context, path

    def end_recording(self) -> Path | None:
        """Finish the file; its path, None where nothing recorded."""
        if self._recording is None:
            return None
        context, path = self._recording
        self._recording = None
        context.__exit__(None, None, None)
        return path

    def status(self) -> Mapping[str, Any]:
        """State of the run, as JSON types."""
        missions = self.sim.stepper.missions.guidance
        agents = {}
        for name in self.sim.model.agents:
            entry: dict[str, Any] = {"mode": self.sim.stepper.mode(name), "leg": ""}
            guidance = missions.get(name)
            if guidance is not None:
                number, count = int(guidance.progress.task[0]), len(guidance.steps)
                task = "done" if number >= count else type(guidance.steps[number].task).__name__.lower()
                entry["leg"] = f"{min(number + 1, count)}/{count} {task}"
            held = self.sim.held_command(name)[0]
            entry["command"] = [None if not math.isfinite(v) else round(float(v), 4) for v in held]
            entry["goals"] = [[round(float(v), 2) for v in g] for g in self.goals.get(name, ())]
            agents[name] = entry
            if len(agents) >= 20:
                break
        return {
            "paused": self.paused or self._ended, "speed": self.speed, "rate": round(self._rate, 3), "agents": agents,
            "recording": "" if self._recording is None else str(self._recording[1]), "seed": self.sim.seed,
            "props": [b.name for b in self.sim.bodies.bodies if b.fastest_mps is None],
        }  # fmt: skip

    def _obey(self) -> None:
        while True:
            try:
                order = self._orders.get_nowait()
            except queue.Empty:
                return
            try:
                with self.live.at_work():  # another sea, or a reset, may have kernels of its own
                    order()
            except (InputError, TypeError, ValueError, KeyError) as error:
                self.say(str(error), "error")

    def _rest(self) -> None:
        self._rate, self._spent = 0.0, (0.0, 0.0)
        self.live.show()
        self._wake.wait(_IDLE_S * 4)
        self._wake.clear()

    def _advance(self, due: float) -> float:
        """One step, and the wait behind it; gives the wall-clock time at which the next is due."""
        dt_s = self.sim.dt_ns * 1e-9
        if self._single:
            self._single -= 1
            ticks = 1
        else:
            simulated = STEP_S * (self.speed if self.speed > 0 else max(self._rate, 1.0))
            ticks = max(1, min(round(simulated / dt_s), round(1.0 / dt_s)))
        start = time.perf_counter()
        try:
            with self.live.at_work():
                self.sim.step(ticks=ticks)
        except SimulationError as error:
            self.say(str(error), "error")
            self._ended = True
            return start
        self._follow_goals()
        if self.speed > 0:
            due = max(due + ticks * dt_s / self.speed, time.perf_counter() - _BEHIND_S)
            ahead = due - time.perf_counter()
            if ahead > 0:
                self._wake.wait(ahead)
                self._wake.clear()
        took = max(time.perf_counter() - start, 1e-6)
        past = math.exp(-took / _MEMORY_S)  # sums of both times, not a mean of ratios: blocks that catch up are short
        self._spent = (past * self._spent[0] + ticks * dt_s, past * self._spent[1] + took)
        self._rate = self._spent[0] / self._spent[1]
        return due

    def _follow_goals(self) -> None:
        for agent, goals in self.goals.items():
            if goals:
                left = goals[0][:2] - self.sim.state[agent].position[0, :2]
                past = float(left @ (goals[0][:2] - self._from[agent])) < 0
                if past or float(np.linalg.norm(left)) < _NEAR_M:
                    goals.pop(0)
                    if goals:
                        self._head(agent)

    def _head(self, agent: str) -> None:
        goal = [float(v) for v in self.goals[agent][0]]
        self._from[agent] = np.array(self.sim.state[agent].position[0, :2])
        apply(Order("waypoint", agent, {"values": goal}, "view"), self.sim)
