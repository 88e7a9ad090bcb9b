"""The view: one thread that takes frames and sends them to the browsers, at most ten a second."""

from __future__ import annotations

import html
import math
import threading
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from pelagos.sensors.sensor import SensorConfig
from pelagos.vehicles.vehicle import Vehicle
from pelagos.viewer.chart import Chart
from pelagos.viewer.frame import ShownFrame, ShownPose
from pelagos.viewer.panels import Panels
from pelagos.viewer.scene import Scene
from pelagos.viewer.section import Curtain
from pelagos.viewer.server import LOADING, Server
from pelagos.viewer.water import Water
from pelagos.world.world import World

_LONG_S: Final = 2  # a step of this length is told to those who wait for it
_LOOK_M: Final = 8.0  # the ground's finest grid follows when the vehicle has moved so far


class Source(Protocol):
    """Source of frames."""

    def take(self, wait_s: float = 0.5) -> ShownFrame | None:
        """The newest frame; None where there was none in time."""
        ...


class Control(Protocol):
    """Executor of the browsers' orders."""

    @property
    def known(self) -> tuple[str, ...]:
        """Orders that can be given."""
        ...

    def obey(self, message: Mapping[str, Any]) -> bool:
        """Do it, or have it done; False where it is something else."""
        ...


@dataclass(frozen=True)
class Subject:
    """Subject of a view.

    Attributes:
        name, description: of the scenario.
        world: what stands.
        vehicles: by agent.
        sensors: configurations by "agent.sensor".
        plans: planned paths by agent, `(m, 3)` [m].
        kind: "live", "replay" or "world".
        water: waves and light.
        more: for the page, JSON types: the time line of a replay.
        bodies: geometries of movers and props, by name, where no simulation has them.
        currents: arrows `(m, 2, 3)` [m].
        sections: titles of the fields that a section can show, by name.
    """

    name: str
    world: World
    vehicles: Mapping[str, Vehicle] = field(default_factory=dict)
    sensors: Mapping[str, SensorConfig] = field(default_factory=dict)
    plans: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    description: str = ""
    kind: str = "live"
    water: Water = field(default_factory=Water)
    more: Mapping[str, Any] = field(default_factory=dict)
    bodies: Mapping[str, Any] = field(default_factory=dict)
    currents: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 2, 3), dtype=np.float32))
    sections: Mapping[str, str] = field(default_factory=dict)


class View:
    """Shows a subject in the browsers; close it, or use it as a context manager.

    Attributes:
        url: where to open it, with its token.
        pictures: how many frames were drawn.
        waited_s: tells how long the step under way has taken [s]; browsers are told of more than 2 s.

    Args:
        subject: what.
        source: of frames.
        control: obeys; None: nothing can be changed.
        server: what listens, from now on the view's own; one of this machine alone where not given.
    """

    def __init__(
        self, subject: Subject, source: Source, control: Control | None = None, *, server: Server | None = None
    ) -> None:
        self.subject, self.pictures = subject, 0
        self._source, self.control = source, control
        self.server = Server() if server is None else server
        self.hub = self.server.hub
        self.scene = Scene(self.hub, subject.world, subject.vehicles, subject.sensors)
        self.panels = Panels(subject.sensors)
        self.chart = Chart(subject.world)
        self._wanted: set[str] = set()
        self._asked: list[Mapping[str, Any]] = []
        self._followed = next(iter(subject.vehicles), "")
        self._looked_at = np.full(2, np.inf)
        self._geometries: dict[str, Any] = dict(subject.bodies)
        self._bodies_of: Any = None
        self._other: deque[Callable[[], None]] = deque()  # to draw with the next frame
        self.show_currents(subject.currents)
        self.waited_s: Callable[[], float] = lambda: 0.0
        self._told_s = 0
        self._closed = threading.Event()
        self.hub.heard = self._heard  # before "hello", which browsers answer
        self._begin()
        self._thread = threading.Thread(target=self._publish, name="pelagos view", daemon=True)

    @property
    def url(self) -> str:
        """Address of the page."""
        return self.server.url

    def start(self) -> View:
        """Begin to draw."""
        self._thread.start()
        return self

    def show_bodies_of(self, bodies: Any) -> None:
        """Draw what is spawned in a simulation: `Simulation.bodies`."""
        self._bodies_of = bodies

    def show_currents(self, segments: NDArray[np.float32]) -> None:
        """Draw other arrows with the next frame; any thread may call this."""
        self._other.append(lambda: self.scene.show_currents(segments))

    def show_section(self, found: Curtain | None) -> None:
        """Draw another section with the next frame, or none; any thread may call this."""
        self._other.append(lambda: self._section(found))

    def show_water(self, water: Water) -> None:
        """Waves and light are others from now on; any thread may call this."""
        self._other.append(lambda: self.hub.publish("water", water.message()))

    def survey(self) -> None:
        """Look at the part of the ground that a browser's map came near to; by a thread that may use the device."""
        ground = self.chart.survey()
        if ground is not None:
            self._other.append(lambda: self.chart.publish(self.hub, ground))

    def close(self) -> None:
        """Stop drawing and serving."""
        if not self._closed.is_set():
            self._closed.set()
            if self._thread.is_alive():
                self._thread.join(timeout=5.0)
            self.server.close()

    def __enter__(self) -> View:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _repr_html_(self) -> str:
        """The page in a cell, under the name that the notebook itself has: else no cookie would come with it."""
        address = html.escape(self.url, quote=True)
        near, name = address.replace("//127.0.0.1:", "//localhost:"), f"pelagos-view-{self.server.port}"
        return (
            f'<iframe id="{name}" src="{near}" width="100%" height="620" style="border:0;border-radius:8px"></iframe>'
            f'<script>if (location.hostname === "127.0.0.1") '
            f'document.getElementById("{name}").src = "{address}"</script>'
            f'<p><a href="{address}" target="_blank">open in a window of its own</a></p>'
        )

    # the thread

    def _publish(self) -> None:
        while not self._closed.is_set():
            frame = self._source.take(0.25)
            self._tell_of_waiting()
            asked = bool(self._asked)
            self._do_asked()
            if frame is None and not asked:
                continue
            try:
                with self.hub.together():
                    if frame is None:  # paused, or at a recording's end: whoever asks sees what there is
                        self.panels.publish(self.hub, self._wanted or None)
                        continue
                    self._draw(frame)
            except Exception as error:  # a drawing that fails must not end the view, nor the mission
                self.hub.say(f"the picture failed: {type(error).__name__}: {error}", kind="error")
            self.pictures += 1

    def _tell_of_waiting(self) -> None:
        """Have a page that stands still say so each second: kernels that are new to a machine take long to compile."""
        waited = int(self.waited_s())
        told = waited if waited >= _LONG_S else 0
        if told != self._told_s:
            self._told_s = told
            self.hub.publish("waiting", {"type": "waiting", "s": told})

    def _draw(self, frame: ShownFrame) -> None:
        looked_on = self.hub.count > 0
        if frame.jump:
            self.panels.clear()
            self.hub.forget("panel/")
            self.hub.publish("jump", {"type": "jump", "t": frame.t_ns * 1e-9}, keep=False)
        while self._other:
            self._other.popleft()()
        for placed in frame.samples:
            self.panels.take(placed.sample)
        self._bodies(frame)
        followed = frame.agents.get(self._followed) or next(iter(frame.agents.values()), None)
        if followed is not None:
            self._ground_follows(followed)
        self.scene.draw(frame, looked_on=looked_on)
        self.hub.publish("state", self._state(frame))
        self.panels.publish(self.hub, self._wanted or None)

    def _section(self, found: Curtain | None) -> None:
        self.scene.show_section(found)
        legend: dict[str, Any] = {"type": "section", "title": ""}
        if found is not None:
            low, high = (round(v, 4) if math.isfinite(v) else None for v in (found.low, found.high))
            legend |= {"title": found.title, "unit": found.unit, "low": low, "high": high, "shades": found.shades}
        self.hub.publish("section", legend)

    def _ground_follows(self, pose: ShownPose) -> None:
        at = pose.position[:2]
        if float(np.abs(at - self._looked_at).max()) > _LOOK_M:
            self._looked_at = np.array(at)
            self.scene.look_at_ground(float(at[0]), float(at[1]))

    def _bodies(self, frame: ShownFrame) -> None:
        """Draw movers and props that are new, and take out those that are gone."""
        if self._bodies_of is not None:
            self._geometries = {b.name: b.geometry for b in list(self._bodies_of.bodies)}
        for name in frame.movers:
            if name not in self.scene.bodies and name in self._geometries:
                self.scene.add_body(name, self._geometries[name])
        for name in self.scene.bodies - set(frame.movers):
            self.scene.remove_body(name)

    def _state(self, frame: ShownFrame) -> dict[str, Any]:
        agents: dict[str, dict[str, Any]] = {}
        for name, pose in list(frame.agents.items())[:60]:
            roll, pitch, heading = pose.euler
            x, y, z = (float(v) for v in pose.position)
            ground = float(self.subject.world.height(x, y))
            agents[name] = {
                "x": round(x, 3), "y": round(y, 3), "depth": round(-z, 3), "roll": round(roll, 2),
                "pitch": round(pitch, 2), "heading": round(heading, 4),
                "speed": round(float(np.linalg.norm(pose.velocity)), 3),
                "altitude": round(z - ground, 3) if math.isfinite(ground) else None,
            }  # fmt: skip
            known = frame.navigation.get(name)
            if known is not None:
                agents[name]["known"] = [round(float(v), 3) for v in known.position]
        props = {n: [round(float(v), 2) for v in p.position] for n, p in frame.movers.items()}
        return {"type": "state", "t": frame.t_ns * 1e-9, "agents": agents, "props": props, "run": dict(frame.status)}

    # what the browsers ask for

    def _heard(self, message: Mapping[str, Any]) -> None:
        """In the server's thread."""
        if self.control is not None and self.control.obey(message):
            return
        self._asked.append(message)

    def _do_asked(self) -> None:
        while self._asked:
            message = self._asked.pop(0)
            match message.get("do"):
                case "follow" if message.get("agent") in self.subject.vehicles:
                    self._followed = str(message["agent"])
                case "look_at":
                    self._look_at(message)
                case "chart":
                    self._near_chart(message)
                case "panels":
                    names = message.get("names")
                    self._wanted = {str(n) for n in names} if isinstance(names, list) else set()
                    for name in self._wanted & set(self.panels.panels):
                        self.panels.panels[name].fresh = True
                case "show":
                    self.scene.show(str(message.get("what")), visible=bool(message.get("visible")))
                case "ground":
                    self.scene.colour_ground(str(message.get("by")))
                    if np.isfinite(self._looked_at).all():
                        self.scene.look_at_ground(*(float(v) for v in self._looked_at))
                case other:
                    self.hub.say(f"this view cannot do {str(other)[:40]!r}", kind="error")

    def _begin(self) -> None:
        """Constant part of the scene: the map, the sensors, the vehicles."""
        world = self.subject.world
        low, high = self.chart.bounds
        self.server.offer("map.png", "image/png", self.chart.whole)
        self.hub.forget(LOADING)
        self.hub.publish("hello", {
            "type": "hello", "name": self.subject.name, "description": self.subject.description,
            "kind": self.subject.kind, "chart": self.chart.legend, "bounds": [float(v) for v in (*low, *high)],
            "agents": {n: _about(v) for n, v in self.subject.vehicles.items()}, "sensors": self.panels.listing(),
            "floor": float(world.bounds[0, 2]),
            "can": [] if self.control is None else list(self.control.known),
            "notes": self.scene.notes,
            "sections": dict(self.subject.sections),
            "plans": {n: np.round(p[:, :2], 2).tolist() for n, p in self.subject.plans.items()}, **self.subject.more,
        })  # fmt: skip
        self.hub.publish("water", self.subject.water.message())
        for name, points in self.subject.plans.items():
            self.scene.plan(name, points)
        self._looked_at = 0.5 * (low + high)
        self.scene.look_at_ground(*(float(v) for v in self._looked_at))

    def _near_chart(self, message: Mapping[str, Any]) -> None:
        """A part of the map from nearer; of a simulation, the thread that steps looks at the ground."""
        self.chart.ask(message)
        if self.subject.kind != "live":
            ground = self.chart.survey()
            if ground is not None:
                self.chart.publish(self.hub, ground)

    def _look_at(self, message: Mapping[str, Any]) -> None:
        """The ground in full detail where a browser's free camera looks."""
        x, y = message.get("x"), message.get("y")
        if isinstance(x, int | float) and isinstance(y, int | float) and math.isfinite(x) and math.isfinite(y):
            self._looked_at = np.array([x, y], dtype=np.float64)
            self.scene.look_at_ground(float(x), float(y))


def _about(vehicle: Vehicle) -> dict[str, Any]:
    return {
        "type": vehicle.name, "modes": {m: list(vehicle.command_names(m)) for m in vehicle.modes},
        "length": round(float(np.ptp(vehicle.hull.vertices[:, 0])), 2),
    }  # fmt: skip
