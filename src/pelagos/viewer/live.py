"""A simulation that somebody looks at: what its blocks gave, as frames, handed on without waiting for who draws them.

The step thread copies poses and readings; everything else happens in the view's own thread. A frame that nobody took
yet when the next is due grows: nothing waits, and nothing that a waterfall needs is lost.

Readings may hold arrays of the device. The view's thread must never be the last to let go of one: the thread that steps
may be in a recorded call, which has the device's lock and waits for the interpreter's, and both would wait for ever. So
what is handed on owns its memory, and while somebody may look, the thread that steps alone collects cyclic garbage.
"""

from __future__ import annotations

import gc
import threading
import time
from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, Final

import numpy as np

from pelagos.drawing.sample import CLOUDS, DRAWN, WATERFALLS, sample_of
from pelagos.sensors.sensor import Reading, SensorConfig
from pelagos.sim.garbage import StepperCollects
from pelagos.sim.simulation import Simulation
from pelagos.sim.watch import BlockReadings
from pelagos.viewer.frame import Placed, ShownFrame, ShownPose, between
from pelagos.viewer.turns import ShortTurns

EVERY_S: Final = 0.1
"""Wall-clock time between two frames, at least."""
_EVERY_ONE: Final = (*WATERFALLS, *CLOUDS, "mechanical_scanning_sonar")
_MOST: Final = 60  # readings of one sensor that wait
_POSES: Final = 400
_FEW: Final = 8  # numbers of a reading
_MANY: Final = 20  # agents: of more, poses are kept only when a frame is due


class Live:
    """Frames of a simulation; use `heard` as the callback of `Simulation.watch`.

    Attributes:
        sensors: configurations by "agent.sensor".
        status: gives the run's status, called by the step thread with every frame.
        garbage: collected with frames, while it is open.
        step_began: `time.monotonic` at which the block or order under way began; None between them.
    """

    def __init__(self, sim: Simulation, *, copy: int = 0) -> None:
        self._sim, self._copy = sim, copy
        agents = sim.model.agents
        self.sensors: Mapping[str, SensorConfig] = {
            f"{a}.{s}": m.config for a, agent in agents.items() for s, m in agent.sensors.items()
        }
        self.status: Callable[[], Mapping[str, Any]] = dict
        self.garbage = StepperCollects()
        self.step_began: float | None = None
        self._poses: dict[str, deque[tuple[int, ShownPose]]] = {name: deque(maxlen=_POSES) for name in agents}
        self._readings: dict[str, deque[Reading]] = {}
        self._waiting: ShownFrame | None = None
        self._raw: dict[str, list[Reading]] = {}
        self._some = threading.Condition()
        self._at = 0.0
        self._last_ns, self._heard_ns = -1, -1
        self._jump = False

    def heard(self, heard: BlockReadings) -> None:
        """Keep what a block gave, and make a frame if one is due, or if time went back."""
        if self.step_began is not None:
            self.step_began = time.monotonic()
        t_ns = self._sim.time_ns
        back = t_ns < self._heard_ns or t_ns == self._heard_ns == 0
        self._heard_ns = t_ns
        if back:
            self._restart()
        for name in heard:
            config = self.sensors.get(name)
            if config is None:
                continue
            kept = self._readings.setdefault(name, deque(maxlen=_MOST if config.type in _EVERY_ONE else 1))
            if config.type in _EVERY_ONE:
                kept.extend(heard[name])
            else:
                newest = heard.newest(name)
                if newest is not None:
                    kept.append(newest)
        due = back or time.monotonic() - self._at >= EVERY_S
        if due or len(self._poses) <= _MANY:
            self._keep_poses()
        if due:
            self.show()

    def show(self) -> None:
        """Make a frame of now: at the end of a block, or where the simulation stands still."""
        self._at = time.monotonic()
        if not gc.isenabled():
            self.garbage.collect()
        sim = self._sim
        t_ns = sim.time_ns
        if not any(poses and poses[-1][0] == t_ns for poses in self._poses.values()):
            self._keep_poses()
        jump, self._jump = self._jump or t_ns < self._last_ns, False
        self._last_ns = t_ns
        known = {}
        for name, solutions in sim.stepper.missions.solutions.items():
            if solutions:
                last = solutions[-1]
                known[name] = ShownPose(last.position[self._copy].copy(), last.attitude[self._copy].copy())
        movers = {
            b.name: ShownPose(b.position[self._copy].copy(), b.attitude[self._copy].copy()) for b in sim.bodies.bodies
        }
        agents = {name: poses[-1][1] for name, poses in self._poses.items() if poses}
        frame = ShownFrame(t_ns, agents, known, movers, (), self.status(), jump)
        with self._some:
            if jump:
                self._raw.clear()
            if self._waiting is not None:
                frame = ShownFrame(t_ns, agents, known, movers, (), frame.status, jump or self._waiting.jump)
            for name, readings in self._readings.items():
                found = [*self._raw.get(name, ()), *(own(r, self._copy) for r in readings)]
                self._raw[name] = found[-_MOST:] if self.sensors[name].type in _EVERY_ONE else found[-1:]
                readings.clear()
            self._waiting = frame
            self._some.notify_all()

    @contextmanager
    def looked_at(self) -> Iterator[None]:
        """Let the view's thread take part: garbage is left to the thread that steps, and turns are short."""
        turns = ShortTurns()
        self.garbage.open()
        turns.open()
        try:
            yield
        finally:
            turns.close()
            self.garbage.close()

    @contextmanager
    def at_work(self) -> Iterator[None]:
        """Time what the thread that steps does here, for `waited_s`."""
        self.step_began = time.monotonic()
        try:
            yield
        finally:
            self.step_began = None

    def waited_s(self) -> float:
        """Wall-clock time that the step or order under way has taken so far [s]; any thread may ask."""
        began = self.step_began
        return 0.0 if began is None else time.monotonic() - began

    def _restart(self) -> None:
        """Forget what was kept, which is of another run."""
        self._jump = True
        self._readings.clear()
        for poses in self._poses.values():
            poses.clear()

    def take(self, wait_s: float = 0.5) -> ShownFrame | None:
        """The newest frame, its samples made by the thread that asks; None where there was none in time."""
        with self._some:
            if self._waiting is None:
                self._some.wait(wait_s)
            frame, self._waiting = self._waiting, None
            raw, self._raw = self._raw, {}
        if frame is None:
            return None
        agents = {name.partition(".")[0] for name in raw}
        poses = {agent: list(self._poses[agent]) for agent in agents}
        samples = [
            Placed(sample_of(self.sensors[name], reading, truth=True), _pose(poses[agent], reading.t_ns, frame, agent))
            for name, readings in raw.items()
            for agent in (name.partition(".")[0],)
            for reading in readings
            if reading.valid[0]
        ]
        return ShownFrame(frame.t_ns, frame.agents, frame.navigation, frame.movers, samples, frame.status, frame.jump)

    def _keep_poses(self) -> None:
        t_ns, states, row = self._sim.time_ns, self._sim.state, self._copy
        for name, poses in self._poses.items():
            if poses and poses[-1][0] > t_ns:
                poses.clear()
                self._jump = True
            if not poses or poses[-1][0] < t_ns:
                s = states[name]
                poses.append(
                    (t_ns, ShownPose(*(np.array(v[row]) for v in (s.position, s.attitude, s.velocity, s.actuators))))
                )


def _pose(poses: Sequence[tuple[int, ShownPose]], t_ns: int, frame: ShownFrame, agent: str) -> ShownPose:
    """Pose of a sensor's vehicle at a time, between two poses that were kept, in order of time."""
    place = bisect_right(poses, t_ns, key=lambda kept: kept[0])
    if place in (0, len(poses)):
        return poses[place - 1 if place else 0][1] if poses else frame.agents[agent]
    return between(poses[place - 1], poses[place], t_ns)


def own(reading: Reading, row: int) -> Reading:
    """One copy's part of a reading, `(1, ...)`, in memory of its own; with its truth where that is a few numbers."""
    data, valid = (np.array(v[row : row + 1]) for v in (reading.data, reading.valid))
    truth = np.array(reading.truth[row : row + 1]) if data.size <= _FEW else data
    extras = {name: np.array(reading.extras[name][row : row + 1]) for name in DRAWN if name in reading.extras}
    return Reading(data, truth, reading.t_ns, reading.frame, valid, extras, reading.kind)
