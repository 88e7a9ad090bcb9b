"""The 3-D scene: what stands, swims and is seen, as nodes of the stage. Called by the view's thread alone."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.drawing.colours import DEPTHS, display, painted
from pelagos.drawing.sample import CAMERAS, FANS
from pelagos.math.so3 import matrix_np
from pelagos.messages.fan import copper
from pelagos.sensors.sensor import SensorConfig
from pelagos.vehicles.vehicle import Vehicle
from pelagos.viewer.cloud import Cloud
from pelagos.viewer.frame import Placed, ShownFrame, ShownPose, old_after_s
from pelagos.viewer.ground import NestedGrids, Patch
from pelagos.viewer.hub import Hub
from pelagos.viewer.hull import Model3d, model_3d
from pelagos.viewer.section import Curtain
from pelagos.viewer.stage import Stage
from pelagos.viewer.structures import ground_of, parts, parts_of
from pelagos.viewer.track import Track
from pelagos.world.world import World

GROUND_COLOURS: Final = ("depth", "material")
_FINEST_M: Final = 0.5
_FAN_BEAMS: Final = 64
_FAN_BINS: Final = 96
_LABELS: Final = 160  # of a world alone; the page leaves out those that would lie on others
_ASIDE_M: Final = 25.0  # things of one name that are nearer share a label
_TRUE: Final = (255, 209, 102)
_KNOWN: Final = (214, 122, 255)
_PLAN: Final = (120, 200, 255)
_FLOW: Final = (150, 235, 190)
_BEAM: Final = (255, 120, 90)
_SIGHT: Final = (225, 235, 240)
_COPPER: Final = copper()


@dataclass
class _Vehicle:
    """Nodes of one agent."""

    node: Any
    model: Model3d
    parts: list[Any]
    turned: NDArray[np.float64]
    track: Track
    known: Any = None
    known_track: Track | None = None


class Scene:
    """Draws a world and frames of what happens in it.

    Attributes:
        world: what stands.
        notes: what users should know about the drawing.

    Args:
        hub: where nodes go.
        world: what stands.
        vehicles: by agent.
        sensors: configurations by "agent.sensor".
    """

    def __init__(
        self, hub: Hub, world: World, vehicles: Mapping[str, Vehicle], sensors: Mapping[str, SensorConfig]
    ) -> None:  # fmt: skip
        self._stage = Stage(hub)
        self.world, self._sensors = world, sensors
        self.notes: list[str] = []
        self._colour = "depth"
        self._known: dict[int, tuple[object, ...]] = {}
        self._patches: dict[int, Any] = {}
        self._movers: dict[str, Any] = {}
        self._things: dict[str, Any] = {}
        self._sights: dict[str, Any] = {}
        self._last_ns = 0
        self._hidden: set[str] = set()
        self._beamed: dict[str, int] = {}  # times of the DVLs' beams that are drawn [ns]
        self._grids = self._ground()
        self._structures()
        self._clouds = {n: Cloud(self._stage, n) for n, c in sensors.items() if c.type in Cloud.KINDS}
        self._vehicles = {name: self._add_vehicle(name, vehicle) for name, vehicle in vehicles.items()}

    # what stands

    def _ground(self) -> NestedGrids | None:
        if self.world.terrain is None:
            return None
        low, high = self.world.bounds[:, :2]
        field = self.world.terrain
        spacing = float(max(field.x[1] - field.x[0], field.y[1] - field.y[0]))
        grids = NestedGrids(self.world.height, np.stack([low, high]), max(spacing, _FINEST_M))
        heights = field.z[np.isfinite(field.z)]
        self._span = tuple(float(v) for v in np.percentile(heights, [0.5, 99.5])) if heights.size else (-1.0, 0.0)
        self._material = self._albedos()
        return grids

    def _albedos(self) -> NDArray[np.float64]:
        """`(nx - 1, ny - 1, 3)` reflectances of the ground's cells."""
        assert self.world.terrain is not None
        field = self.world.terrain
        rows = np.zeros((len(field.x) - 1, len(field.y) - 1), dtype=np.int64)
        ground = ground_of(self.world)
        if ground is not None:
            middle = np.asarray(ground.vertices)[ground.faces].mean(axis=1)
            rows[_cells(field, middle)] = ground.face_materials
        return np.asarray(np.array([m.albedo for m in self.world.palette])[rows])

    def look_at_ground(self, x: float, y: float) -> None:
        """Have the ground's finest grids about a place."""
        if self._grids is None:
            return
        for patch in self._grids.patches(x, y, self._known):
            self._draw(patch)

    def colour_ground(self, by: str) -> None:
        """By "depth" or "material"."""
        if by in GROUND_COLOURS and by != self._colour:
            self._colour = by
            self._known.clear()

    def _draw(self, patch: Patch) -> None:
        old = self._patches.pop(patch.level, None)
        if len(patch.faces):
            self._patches[patch.level] = self._stage.add(
                "mesh", f"/ground/{patch.level}", vertices=patch.vertices, faces=patch.faces,
                colours=self._ground_colours(patch.vertices), about={"smooth": True, "ground": True},
            )  # fmt: skip
        elif old is not None:
            old.remove()

    def _ground_colours(self, vertices: NDArray[np.float32]) -> NDArray[np.uint8]:
        """sRGB."""
        if self._colour == "depth":
            return painted(vertices[:, 2], self._span[0], self._span[1], DEPTHS)
        field = self.world.terrain
        assert field is not None
        return np.round(255 * display(np.minimum(1.6 * self._material[_cells(field, vertices)], 1.0))).astype(np.uint8)

    def _structures(self) -> None:
        made, left = parts_of(self.world)
        if left:
            self.notes.append(f"{left} of the smallest things are not drawn")
        for part in made:
            self._stage.add(
                "mesh", f"/world/{_plain(part.name)}", colour=part.colour, vertices=part.vertices, faces=part.faces
            )

    def label_world(self) -> None:
        """Write names at the things that stand, one for each name and place; first those of which there are few."""
        seen: set[tuple[str, int, int]] = set()
        ground = ground_of(self.world)
        things = [g for g in self.world.still if g is not ground and len(g.faces) and g.name]
        count = Counter(g.name for g in things)
        for g in sorted(things, key=lambda g: count[g.name]):
            middle = g.extent.mean(axis=0)
            key = (g.name, round(middle[0] / _ASIDE_M), round(middle[1] / _ASIDE_M))
            if key not in seen and len(seen) < _LABELS:
                seen.add(key)
                place = (float(middle[0]), float(middle[1]), float(g.extent[1, 2]) + 0.5)
                self._stage.add("label", f"/labels/{len(seen)}", position=place, about={"text": g.name, "small": True})

    # what moves

    def _add_vehicle(self, name: str, vehicle: Vehicle) -> _Vehicle:
        model, at = model_3d(vehicle), f"/agents/{_plain(name)}"
        node = self._stage.add("frame", at)
        for i, part in enumerate(model.still):
            self._stage.add(
                "mesh", f"{at}/hull{i}", colour=part.colour, vertices=part.vertices, faces=part.faces,
                about={"smooth": True},
            )  # fmt: skip
        turning = [
            self._stage.add(
                "mesh", f"{at}/turning{i}", colour=moved.colour, position=moved.foot, vertices=moved.vertices,
                faces=moved.faces,
            )
            for i, moved in enumerate(model.turning)
        ]  # fmt: skip
        above = (0.0, 0.0, 0.3 + 0.2 * model.length)
        self._stage.add("label", f"{at}/name", position=above, about={"text": name})
        self._add_sights(name, at)
        track = Track(self._stage, f"/tracks/{_plain(name)}", _TRUE)
        return _Vehicle(node, model, turning, np.zeros(len(model.turning)), track)

    def _add_sights(self, agent: str, at: str) -> None:
        """Add the sights of sensors: fans, beams and frustums that go with the vehicle."""
        for name, config in self._sensors.items():
            if name.partition(".")[0] != agent:
                continue
            place = f"{at}/{_plain(name.partition('.')[2])}"
            pose: dict[str, Any] = {"position": config.position_m, "attitude": config.q_body_sensor}
            if config.type in FANS:
                vertices, faces = fan_mesh(config)
                dark = np.zeros((len(vertices), 3), dtype=np.uint8)
                self._sights[name] = self._stage.add("fan", place, vertices=vertices, faces=faces, colours=dark, **pose)
            elif config.type == "dvl":
                nothing = np.zeros((4, 2, 3), dtype=np.float32)
                self._sights[name] = self._stage.add("lines", place, colour=_BEAM, points=nothing, **pose)
            elif config.type in CAMERAS:
                lines = frustum(config, 0.9)
                self._sights[name] = self._stage.add("lines", place, colour=_SIGHT, points=lines, **pose)

    def draw(self, frame: ShownFrame, *, looked_on: bool = True) -> None:
        """Show a frame; without anybody who looks on, only what late comers need."""
        if frame.jump:
            self._start_anew()
        dt_s = max((frame.t_ns - self._last_ns) * 1e-9, 0.0)
        self._last_ns = frame.t_ns
        for name, pose in frame.agents.items():
            if name in self._vehicles:
                self._move(self._vehicles[name], pose, frame.navigation.get(name), name, dt_s)
        for name, pose in frame.movers.items():
            if name in self._movers:
                self._movers[name].place(pose.position, pose.attitude)
        for placed in frame.samples:
            self._show(placed)
        self._forget_beams(frame)
        self._stage.send_poses(frame.t_ns * 1e-9)
        for cloud in self._clouds.values():
            cloud.flush(looked_on=looked_on)

    def _forget_beams(self, frame: ShownFrame) -> None:
        """Take the beams away of a DVL that has lost the ground, or that has not spoken since a jump."""
        for name, t_ns in list(self._beamed.items()):
            age_s = (frame.t_ns - t_ns) * 1e-9
            if not 0 <= age_s <= old_after_s(self._sensors[name].rate_hz):
                self._sights[name].update(points=np.zeros((4, 2, 3), dtype=np.float32))
                del self._beamed[name]

    def _start_anew(self) -> None:
        for vehicle in self._vehicles.values():
            vehicle.track.clear()
            if vehicle.known_track is not None:
                vehicle.known_track.clear()
        for cloud in self._clouds.values():
            cloud.clear()

    def _move(self, vehicle: _Vehicle, pose: ShownPose, known: ShownPose | None, name: str, dt_s: float) -> None:
        vehicle.node.place(pose.position, pose.attitude)
        vehicle.turned = vehicle.model.turned(pose.actuators, vehicle.turned, dt_s)
        for part, node, angle in zip(vehicle.model.turning, vehicle.parts, vehicle.turned, strict=True):
            node.place(part.foot, part.attitude(float(angle)))
        vehicle.track.add(pose.position)
        if known is not None:
            self._show_known(vehicle, known, name)

    def _show_known(self, vehicle: _Vehicle, known: ShownPose, name: str) -> None:
        """Show the vehicle's estimate of its place: a see-through hull with a track of its own."""
        if vehicle.known is None:
            at = f"/known/{_plain(name)}"
            vehicle.known = self._stage.add("frame", at)
            for i, part in enumerate(vehicle.model.still):
                self._stage.add(
                    "mesh", f"{at}/hull{i}", colour=_KNOWN, vertices=part.vertices, faces=part.faces,
                    about={"smooth": True, "opacity": 0.45},
                )  # fmt: skip
            vehicle.known_track = Track(self._stage, f"/tracks/{_plain(name)}_known", _KNOWN)
        vehicle.known.place(known.position, known.attitude)
        assert vehicle.known_track is not None
        vehicle.known_track.add(known.position)

    def _show(self, placed: Placed) -> None:
        sample, sight = placed.sample, self._sights.get(placed.sample.name)
        config = self._sensors.get(sample.name)
        if sample.points is not None and sample.name in self._clouds and config is not None:
            body = sample.points @ matrix_np(np.asarray(config.q_body_sensor)).T + np.asarray(config.position_m)
            self._clouds[sample.name].add(placed.pose.to_world(body), sample.colours)
        if sight is None or sample.name in self._hidden:
            return
        if sample.polar is not None:
            sight.update(colours=fan_colours(sample.polar))
        elif sample.kind == "dvl" and sample.beams is not None:
            ends = np.nan_to_num(sample.beams).astype(np.float32)
            sight.update(points=np.stack([np.zeros_like(ends), ends], axis=1))
            self._beamed[sample.name] = sample.t_ns

    # what the user changes

    def show(self, what: str, *, visible: bool) -> None:
        """Show or hide "points", "currents", or a sensor's sight by its name."""
        if what == "points":
            for cloud in self._clouds.values():
                cloud.visible = visible
        elif what == "currents":
            (self._hidden.discard if visible else self._hidden.add)(what)
            if "/currents" in self._things:
                self._things["/currents"].show(visible=visible)
        elif what in self._sights:
            self._sights[what].show(visible=visible)
            (self._hidden.discard if visible else self._hidden.add)(what)

    def plan(self, agent: str, points: NDArray[np.float64]) -> None:
        """Show the planned path of an agent, `(m, 3)` [m]; fewer than two points: none."""
        at = f"/plans/{_plain(agent)}"
        old = self._things.pop(at, None)
        if old is not None:
            old.remove()
        if len(points) >= 2:
            lines = np.stack([points[:-1], points[1:]], axis=1).astype(np.float32)
            self._things[at] = self._stage.add("lines", at, colour=_PLAN, points=lines)

    def show_currents(self, segments: NDArray[np.float32]) -> None:
        """Arrows `(m, 2, 3)` [m]; none takes them away."""
        old = self._things.pop("/currents", None)
        if old is not None:
            old.remove()
        if len(segments):
            self._things["/currents"] = self._stage.add("lines", "/currents", colour=_FLOW, points=segments)
            self._things["/currents"].show(visible="currents" not in self._hidden)

    def show_section(self, found: Curtain | None) -> None:
        """A curtain through the water; None takes it away."""
        old = self._things.pop("/section", None)
        if found is not None and len(found.faces):
            self._things["/section"] = self._stage.add(
                "mesh", "/section", vertices=found.vertices, faces=found.faces, colours=found.colours,
                about={"smooth": True, "opacity": 0.72, "plain": True},
            )  # fmt: skip
        elif old is not None:
            old.remove()

    def add_body(self, name: str, geometry: Any) -> None:
        """A mover or a prop, which `draw` moves."""
        at = f"/bodies/{_plain(name)}"
        self._movers[name] = self._stage.add("frame", at)
        for i, part in enumerate(parts([geometry], self.world.palette)):
            self._stage.add("mesh", f"{at}/{i}", colour=part.colour, vertices=part.vertices, faces=part.faces)
        above = (0.0, 0.0, float(geometry.extent[1, 2]) + 0.4)
        self._stage.add("label", f"{at}/name", position=above, about={"text": name, "small": True})

    def remove_body(self, name: str) -> None:
        """Take it out."""
        node = self._movers.pop(name, None)
        if node is not None:
            node.remove()

    @property
    def bodies(self) -> set[str]:
        """Names of movers and props that are drawn."""
        return set(self._movers)


def _cells(field: Any, places: NDArray[np.floating]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of the cells of a height field that places `(k, 2)` or `(k, 3)` [m] are in."""
    return (
        np.clip(np.searchsorted(field.x, places[:, 0]) - 1, 0, len(field.x) - 2),
        np.clip(np.searchsorted(field.y, places[:, 1]) - 1, 0, len(field.y) - 2),
    )


def fan_mesh(config: Any) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """The sector of a sonar in its own plane, x ahead and y left [m]: vertices beam by beam, and faces."""
    azimuth = np.linspace(float(config.azimuths[0]), float(config.azimuths[-1]), _FAN_BEAMS)
    a, r = np.meshgrid(azimuth, np.linspace(config.range_min_m, config.range_max_m, _FAN_BINS), indexing="ij")
    vertices = np.stack([r * np.cos(a), r * np.sin(a), 0 * r], axis=-1).reshape(-1, 3).astype(np.float32)
    n = np.arange(_FAN_BEAMS * _FAN_BINS, dtype=np.uint32).reshape(_FAN_BEAMS, _FAN_BINS)
    p, q, u, v = (c.ravel() for c in (n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]))
    return vertices, np.concatenate([np.stack([p, q, u], -1), np.stack([p, u, v], -1)])


def frustum(config: Any, far_m: float) -> NDArray[np.float32]:
    """`(8, 2, 3)` edges of what a camera sees, in its frame FLU [m]."""
    half = 0.5 * math.radians(float(getattr(config, "fov_deg", 0.0) or 60.0))
    wide = far_m * math.tan(half)
    high = wide * config.height_px / config.width_px
    corners = np.array([[far_m, wide, high], [far_m, -wide, high], [far_m, -wide, -high], [far_m, wide, -high]])
    rays = np.stack([np.zeros((4, 3)), corners], axis=1)
    return np.concatenate([rays, np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)]).astype(np.float32)


def fan_colours(polar: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Colours of `fan_points` of levels `(beams, bins)`."""
    return np.asarray(_COPPER.take(polar.take(_thinned(polar.shape)), axis=0))


@cache
def _thinned(shape: tuple[int, int]) -> NDArray[np.intp]:
    """Places in a picture `(beams, bins)`, beam after beam, of the levels that a fan in the scene shows."""
    i, j = (
        np.linspace(0, n - 1, m).round().astype(np.intp) for n, m in zip(shape, (_FAN_BEAMS, _FAN_BINS), strict=True)
    )
    return (i[:, None] * shape[1] + j).ravel()


def _plain(name: str) -> str:
    """A name as a part of a node's path: letters, digits, a few signs."""
    return "".join(c if c.isalnum() or c in "_-" else "_" for c in name) or "_"
