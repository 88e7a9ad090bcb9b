"""A recording as a source of frames: played, held, and sought in, with the marks of what happened."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import yaml

from pelagos.config.loader import load_scenario
from pelagos.config.scenario import Scenario
from pelagos.config.swarm import topic_name
from pelagos.drawing.sample import CLOUDS, WATERFALLS
from pelagos.errors import NoRecording, PelagosError
from pelagos.sensors.sensor import SensorConfig
from pelagos.sim.replay import Recording
from pelagos.viewer.course import course
from pelagos.viewer.currents import arrows
from pelagos.viewer.frame import Placed, ShownFrame
from pelagos.viewer.marks import legs, marks, planned
from pelagos.viewer.panels import LINES
from pelagos.viewer.recorded import WANTED, sample_from, truth_at
from pelagos.viewer.server import Server
from pelagos.viewer.still import standing
from pelagos.viewer.view import Subject, View
from pelagos.world.build import build_world
from pelagos.world.world import World

EVERY_S: Final = 0.1
_BACK: Final = 12  # readings of a picture sensor that a jump looks back for


class Replay:
    """Plays a recording; it is the view's source and its control.

    Args:
        recording: what is played; of a fleet the first copy.
        sensors: configurations by "agent.sensor".
        world: in which what sensors should have said is found; None: only what they said is known.
        speed: times the clock.

    Raises:
        NoRecording: it has no poses.
    """

    def __init__(
        self, recording: Recording, sensors: Mapping[str, SensorConfig], *, world: World | None = None,
        speed: float = 1.0,
    ) -> None:  # fmt: skip
        self._recording, self._sensors, self._world = recording, sensors, world
        topics = [t for t in recording.topics("/truth") if recording.of_first(t)]
        if not topics:
            raise NoRecording(f"{recording.path}: this recording has no poses (no topic ends in /truth)")
        self.courses = {t.split("/")[-2]: course(recording, t) for t in topics}
        known = [t for t in recording.topics("/navigation") if recording.of_first(t)]
        self._known = {t.split("/")[-2]: course(recording, t) for t in known}
        bodies = [t for t in recording.topics("/odometry") if t.startswith(("/movers/", "/props/", "/env0/props/"))]
        self._movers = {t.split("/")[-2]: course(recording, t) for t in bodies}
        self.first_ns = min(int(c.t_ns[0]) for c in self.courses.values())
        self.last_ns = max(int(c.t_ns[-1]) for c in self.courses.values())
        self._topics = self._chosen()
        self._times = {topic: recording.times(topic) for topic in self._topics.values()}
        self._now, self._shown, self._jump = float(self.first_ns), self.first_ns - 1, True
        self.paused, self.speed = False, speed
        self._clock = time.monotonic()
        self._lock = threading.Lock()
        self._wake = threading.Event()
        span = self.first_ns, self.last_ns
        self.marks = marks(recording, self._topics, self._sensors, span, legs(planned(recording), self.courses))

    @property
    def known(self) -> tuple[str, ...]:
        """See `View`."""
        return ("pause", "speed", "seek")

    def obey(self, message: Mapping[str, Any]) -> bool:
        """See `View`."""
        value = message.get("t", message.get("speed", 0))
        number = float(value) if isinstance(value, int | float) and np.isfinite(value) else None
        with self._lock:
            match message.get("do"):
                case "pause":
                    self.paused = bool(message.get("paused", not self.paused))
                    if not self.paused and self._now >= self.last_ns:
                        self._now, self._jump = float(self.first_ns), True
                case "speed" if number is not None and 0 <= number <= 100:
                    self.speed = number or 20.0  # as fast as eyes can follow
                case "seek" if number is not None:
                    to = float(np.clip(number * 1e9, self.first_ns, self.last_ns))
                    self._jump |= to < self._now or to - self._now > 2e9
                    self._now = to
                case _:
                    return False
            self._clock = time.monotonic()
        self._wake.set()
        return True

    def take(self, wait_s: float = 0.5) -> ShownFrame | None:
        """The frame of now."""
        self._wake.wait(min(wait_s, EVERY_S))
        self._wake.clear()
        with self._lock:
            clock, self._clock = self._clock, time.monotonic()
            if not self.paused:
                self._now = min(self._now + (self._clock - clock) * 1e9 * self.speed, float(self.last_ns))
                self.paused = self._now >= self.last_ns
            t_ns, jump, self._jump = int(self._now), self._jump, False
            status = {"paused": self.paused, "speed": self.speed, "rate": 0.0 if self.paused else self.speed}
        if t_ns == self._shown and not jump:
            return None
        return self.frame(t_ns, since_ns=None if jump else self._shown, status=status)

    def frame(self, t_ns: int, *, since_ns: int | None, status: Mapping[str, Any] | None = None) -> ShownFrame:
        """The frame of a time, with the readings since another; None: with those that a jump needs."""
        self._shown = t_ns
        samples = []
        for name, topic in self._topics.items():
            for index in self._due(name, topic, t_ns, since_ns):
                recorded = self._recording.message(topic, index)
                sample = sample_from(self._sensors[name], name, recorded)
                if sample is not None:
                    pose = self.courses[name.partition(".")[0]].at(recorded.t_ns)
                    if self._world is not None:
                        sample = replace(sample, truth=truth_at(self._sensors[name], pose, self._world))
                    samples.append(Placed(sample, pose))
        event = next((m["text"] for m in reversed(self.marks) if 0 <= t_ns * 1e-9 - m["t"] < 3.0), "")
        poses = {name: c.at(t_ns) for name, c in self.courses.items()}
        return ShownFrame(
            t_ns, poses, {n: c.at(t_ns) for n, c in self._known.items()},
            {n: c.at(t_ns) for n, c in self._movers.items()}, samples,
            {**(status or {}), "event": event, "agents": {}}, since_ns is None,
        )  # fmt: skip

    def _due(self, name: str, topic: str, t_ns: int, since_ns: int | None) -> range:
        times, kind = self._times[topic], self._sensors[name].type
        last = int(np.searchsorted(times, t_ns, side="right"))
        every = kind in WATERFALLS or kind in CLOUDS
        if since_ns is None:
            return range(max(0, last - (LINES if every else 1)), last)
        first = int(np.searchsorted(times, since_ns, side="right"))
        return range(max(first, last - (LINES if every else 1)), last)

    def _chosen(self) -> dict[str, str]:
        """The topic that is looked at, by sensor."""
        found: dict[str, str] = {}
        for topic, channel in self._recording.channels.items():
            name = f"{topic_name(channel.about.get('agent', ''))}.{channel.about.get('sensor', '')}"
            if name not in self._sensors or not self._recording.of_first(topic):
                continue
            ends = WANTED.get(self._sensors[name].type)
            if self._recording.count(topic) and (name not in found if ends is None else topic.endswith(ends)):
                found.setdefault(name, topic)
        return {name: topic for name, topic in found.items() if name.partition(".")[0] in self.courses}


def scenario_of(recording: Recording) -> Scenario:
    """The scenario that a recording carries.

    Raises:
        NoRecording: it carries none, or one that this version cannot read.
    """
    text = recording.attachments.get("scenario.yaml")
    if not text:
        raise NoRecording(f"{recording.path}: this recording carries no scenario, so there is no world to show")
    try:
        return load_scenario(yaml.safe_load(text))
    except PelagosError as error:
        raise NoRecording(f"{recording.path}: its scenario cannot be read: {error}") from None


def subject_of(recording: Recording) -> tuple[Subject, dict[str, SensorConfig]]:
    """Subject of a recording: the world is built anew from its scenario."""
    from pelagos.ocean.config import build_ocean
    from pelagos.vehicles.vehicle import Vehicle
    from pelagos.viewer.water import Water

    scenario = scenario_of(recording)
    world = build_world(scenario.located_world)
    vehicles: dict[str, Vehicle] = {}
    sensors: dict[str, SensorConfig] = {}
    for member, agent in scenario.members.items():
        name = topic_name(member)
        vehicles[name] = Vehicle.from_config(agent.vehicle)
        sensors |= {f"{name}.{s}": config for s, config in agent.sensors.items()}
    seed = int(recording.metadata.get("seed", scenario.seed))
    ocean = build_ocean(scenario.ocean, world, seed=seed)
    bodies = standing(scenario, world)
    first = next((course(recording, t) for t in recording.topics("/truth")), None)
    t_s, place = (0.0, np.array([0.0, 0.0, -2.0])) if first is None else (first.t_ns[0] * 1e-9, first.position[0])
    water, plans = Water.of(ocean, place, t_s), planned(recording)
    subject = Subject(
        scenario.name, world, vehicles, sensors, plans, scenario.description, "replay", water, bodies=bodies,
        currents=arrows(ocean, world, t_s, -float(place[2])),
    )  # fmt: skip
    return subject, sensors


def replay_view(path: Path, *, server: Server | None = None, paused: bool = False, speed: float = 1.0) -> View:
    """The view of a recording, served to this machine alone where no `server` is given.

    Raises:
        NoRecording: no poses, no scenario, or no recording at all.
    """
    recording = Recording(path)
    if not recording.topics("/truth"):
        raise NoRecording(f"{path}: this recording has no poses (no topic ends in /truth)")
    subject, sensors = subject_of(recording)
    source = Replay(recording, sensors, world=subject.world, speed=speed or 1.0)
    source.paused = paused
    more = {"first_s": source.first_ns * 1e-9, "last_s": source.last_ns * 1e-9, "events": source.marks}
    return View(replace(subject, more=more), source, source, server=server)
