"""From the legs of a scenario to the tasks of a mission, checked against vehicle, world and other agents."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from pelagos.config import mission as legs
from pelagos.config import registry
from pelagos.errors import LookupFailed, ScenarioError
from pelagos.math.geodesy import GeoOrigin
from pelagos.sim.guidance.follow import FollowAgent, FollowWall
from pelagos.sim.guidance.guidance import Step
from pelagos.sim.guidance.line import Line
from pelagos.sim.guidance.orbit import Orbit
from pelagos.sim.guidance.route import middle_line
from pelagos.sim.guidance.survey import Swath, survey_lines
from pelagos.sim.guidance.task import Common, Level, Limit, Task
from pelagos.sim.guidance.unheard import unheard_key
from pelagos.sim.guidance.vertical import Dive, Land, Profile
from pelagos.sim.guidance.wait import Drift, GpsFix, Hold, Station
from pelagos.vehicles.envelope import EnvelopeConfig
from pelagos.vehicles.family import Family

XY = tuple[float, float]

RUN_IN: Final = 8.0  # radii of turning circles: length of line before a dock on which who turned onto it settles,
RUN_IN_M: Final = 25.0  # at least, for those that cannot go sideways


@dataclass(frozen=True)
class Planner:
    """Knowledge that legs are planned with.

    Attributes:
        name: of the agent.
        vehicle: its type.
        family: how it is steered.
        envelope: what it can do.
        sensors: configurations by name.
        agents: names of all agents.
        world: the world; legs that need none may do without.
        start: (x, y) where the mission begins [m].
        where: file, line and key of a leg's number.
    """

    name: str
    vehicle: str
    family: Family
    envelope: EnvelopeConfig = field(default_factory=EnvelopeConfig)
    sensors: Mapping[str, Any] = field(default_factory=dict)
    agents: Sequence[str] = ()
    world: Any = None
    start: XY = (0.0, 0.0)
    where: Callable[[int], str] = lambda number: f"mission.{number}"

    def plan(self, mission: Sequence[Any]) -> list[Step]:
        """Tasks of all legs.

        Raises:
            InputError: with the place of the leg that cannot be.
        """
        whole: list[list[Task]] = []
        at = self.start
        for number, leg in enumerate(mission):
            self._check(leg, number)
            if leg.type == "repeat":
                if not whole:
                    raise ScenarioError("there is no leg before this one to repeat", where=self.where(number))
                again = whole[-leg.last if leg.last else 0 :]
                whole.append([task for _ in range(leg.times) for tasks in again for task in tasks])
                continue
            tasks = _MAKERS[leg.type](self, leg, number, at)
            whole.append(tasks)
            ends = [t.end for t in tasks if isinstance(t, Line)]
            at = ends[-1] if ends else at
        steps: list[Step] = []
        for tasks in whole:
            behind = len(steps) + len(tasks)
            steps += [Step(task, behind) for task in tasks]
        return steps

    # checks

    def _check(self, leg: Any, number: int) -> None:
        """Whether this vehicle can do a leg.

        Raises:
            ScenarioError: it cannot; says what it can.
        """
        where = self.where(number)
        if leg.type not in self.family.legs:
            raise ScenarioError(
                f"{self.vehicle} cannot do the leg {leg.type!r}; it can do {', '.join(self.family.legs)}", where=where
            )
        for key in ("heading_deg", "face"):
            if leg.type in ("goto", "station_keeping") and getattr(leg, key) is not None and not self.family.turns:
                raise ScenarioError(
                    f"{self.vehicle} cannot look where it does not go: leave out {key!r}", where=f"{where}.{key}"
                )
        if leg.type == "orbit" and leg.look == "center" and not self.family.turns:
            raise ScenarioError(f"{self.vehicle} cannot circle sideways: look: ahead", where=f"{where}.look")
        unheard = unheard_key(leg, self.family.name)
        if unheard is not None:
            raise ScenarioError(
                f"{self.vehicle} {unheard.why}: leave out {unheard.key!r}", where=f"{where}.{unheard.key}"
            )
        self._check_speed(leg, where)
        self._check_circle(leg, where)
        self._check_level(leg, where)

    def _check_speed(self, leg: Any, where: str) -> None:
        speed, top = getattr(leg, "speed_mps", None), self.envelope.top_mps
        if speed is not None and top is not None and speed > top:
            raise ScenarioError(f"{self.vehicle} goes at most {top:g} m/s, not {speed:g}", where=f"{where}.speed_mps")

    def _check_circle(self, leg: Any, where: str) -> None:
        radius = getattr(leg, "radius_m", None)
        if radius is None:
            return
        speed = getattr(leg, "speed_mps", None) or self.envelope.cruise_mps
        least = self.envelope.smallest_circle_m(speed)
        if radius < least:
            raise ScenarioError(
                f"the smallest circle of {self.vehicle} at {speed:g} m/s has a radius of {least:.4g} m, not {radius:g}",
                where=f"{where}.radius_m",
            )

    def _check_level(self, leg: Any, where: str) -> None:
        depth, altitude, height = (getattr(leg, k, None) for k in ("depth_m", "altitude_m", "height_m"))
        flies, floats = self.family.medium == "in the air", self.family.medium == "at the surface"
        if height is not None and not flies:
            raise ScenarioError(f"{self.vehicle} does not fly: leave out height_m", where=f"{where}.height_m")
        if depth is not None and flies:
            raise ScenarioError(f"{self.vehicle} flies: give height_m, not depth_m", where=f"{where}.depth_m")
        if floats and (depth or altitude is not None):
            raise ScenarioError(f"{self.vehicle} stays at the surface: leave out its depth or altitude", where=where)
        if altitude is not None and not any(looks_down(c) for c in self.sensors.values()):
            raise ScenarioError(
                f"{self.name} carries nothing that measures altitude: give it an altimeter or a dvl, or use depth_m",
                where=f"{where}.altitude_m",
            )
        deepest = self.envelope.depth_m
        if deepest is not None and depth is not None and depth > deepest:
            raise ScenarioError(
                f"{self.vehicle} goes at most {deepest:g} m deep, not {depth:g}", where=f"{where}.depth_m"
            )

    # parts of legs

    def common(self, leg: Any, number: int, *, level: Level | None = None) -> Common:
        """Parts that every task of a leg has."""
        speed = getattr(leg, "speed_mps", None)
        height = getattr(leg, "height_m", None)
        depth = getattr(leg, "depth_m", None) if height is None else -height
        face = getattr(leg, "face", None)
        heading = getattr(leg, "heading_deg", None) if leg.type in ("goto", "station_keeping") else None
        return Common(
            level=Level(depth, getattr(leg, "altitude_m", None)) if level is None else level,
            speed_mps=self.envelope.cruise_mps if speed is None else speed,
            face_rad=None if heading is None else math.radians(heading),
            face_point=None if face is None else self.xy(face, number),
            until=self._until(leg, number),
        )

    def _until(self, leg: Any, number: int) -> Limit | None:
        until = leg.until
        if until is None:
            return None
        if until.sensor not in self.sensors:
            where = f"{self.where(number)}.until.sensor"
            raise LookupFailed(f"sensor of {self.name}", until.sensor, self.sensors, where=where)
        key = until.sensor if until.value is None else f"{until.sensor}.{until.value}"
        return Limit(key, until.component, until.above, until.below)

    def xy(self, place: Any, number: int) -> XY:
        """World x, y [m] of a place."""
        if not isinstance(place, legs.EarthPoint):
            return float(place[0]), float(place[1])
        origin: GeoOrigin | None = None if self.world is None else self.world.origin
        if origin is None or (origin.latitude == 0.0 and origin.longitude == 0.0):
            raise ScenarioError(
                "a place on Earth needs a world that lies there; give the scenario an 'origin'",
                where=self.where(number),
            )
        x, y = origin.to_xy(place.latitude_deg, place.longitude_deg)
        return float(x), float(y)

    @property
    def tolerance_m(self) -> float:
        """Distance within which this vehicle counts a place as reached."""
        return self.envelope.tolerance_m

    def near(self, leg: Any) -> float:
        """The same, on a leg that may say so itself."""
        return self.tolerance_m if leg.acceptance_m is None else float(leg.acceptance_m)


def altitude_of(config: Any) -> str | None:
    """Part of a sensor's reading that is its altitude where it looks down, see `Sensor`; None where it has none."""
    return getattr(registry.find("sensor", config.type).load(), "ALTITUDE", None)


def looks_down(config: Any) -> bool:
    """Whether a sensor measures the altitude: an altimeter or DVL, say, that looks downwards."""
    if altitude_of(config) is None:
        return False
    _, x, y, _ = config.q_body_sensor
    return bool(1 - 2 * (x * x + y * y) > 0.5)


def _waypoints(planner: Planner, leg: legs.Waypoints, number: int, at: XY) -> list[Task]:
    points = [planner.xy(p, number) for p in leg.points]
    return _transits(points, planner.common(leg, number), planner.near(leg))


def _transits(points: Sequence[XY], common: Common, acceptance_m: float) -> list[Task]:
    starts: list[XY | None] = [None, *points[:-1]]
    return [Line(end, start, acceptance_m, common=common) for start, end in zip(starts, points, strict=True)]


def _along(lines: Sequence[tuple[XY, XY]], common: Common, acceptance_m: float) -> list[Task]:
    """A transit to the first line's start, then along every line; turns happen while the next line is picked up."""
    first = Line(lines[0][0], None, acceptance_m, common=common)
    return [first, *(Line(end, start, acceptance_m, common=common) for start, end in lines)]


def lawnmower(leg: Any, corner: XY) -> list[tuple[XY, XY]]:
    """The survey lines (start, end) of a lawn-mower leg, in order; the pattern grows to starboard of the first line."""
    heading = math.radians(leg.heading_deg)
    ahead = np.array([math.cos(heading), -math.sin(heading)])  # NWU: compass heading turns from x towards -y
    right = np.array([-math.sin(heading), -math.cos(heading)])
    lines = []
    for k in range(math.floor(leg.width_m / leg.spacing_m + 1e-9) + 1):
        a = np.asarray(corner, dtype=float) + k * leg.spacing_m * right
        b = a + leg.length_m * ahead
        start, end = (a, b) if k % 2 == 0 else (b, a)
        lines.append(((float(start[0]), float(start[1])), (float(end[0]), float(end[1]))))
    return lines


def _lawnmower(planner: Planner, leg: legs.Lawnmower, number: int, at: XY) -> list[Task]:
    return _along(lawnmower(leg, planner.xy(leg.corner, number)), planner.common(leg, number), planner.near(leg))


def _survey(planner: Planner, leg: legs.Survey, number: int, at: XY) -> list[Task]:
    lines = survey_lines(
        np.array([planner.xy(p, number) for p in leg.area]),
        Swath(leg.spacing_m, math.radians(leg.swath_deg or 0.0), leg.overlap),
        height=planner.world.height,
        depth_m=leg.depth_m,
        altitude_m=leg.altitude_m,
        heading_rad=None if leg.heading_deg is None else math.radians(leg.heading_deg),
        where=planner.where(number),
    )
    return _along(lines, planner.common(leg, number), planner.near(leg))


def _goto(planner: Planner, leg: legs.Goto, number: int, at: XY) -> list[Task]:
    common = planner.common(leg, number)
    acceptance = planner.near(leg)
    tasks: list[Task] = []
    before: XY | None = None
    for k, point in enumerate(leg.points):
        end, level = planner.xy(point, number), common.level
        if isinstance(point, tuple) and len(point) == 3:
            if planner.family.medium != "in the air" and point[2] > 0:
                where = f"{planner.where(number)}.points.{k}"
                raise ScenarioError(
                    f"{planner.vehicle} does not fly: z is {point[2]:g} m above the surface", where=where
                )
            level = Level(None if planner.family.medium == "at the surface" else -point[2])
        exact = planner.family.stops and (k == len(leg.points) - 1 or planner.family.turns)
        tasks.append(Line(end, before, acceptance, exact, common=replace(common, level=level)))
        before = end
    return tasks


def _station(planner: Planner, leg: legs.StationKeeping, number: int, at: XY) -> list[Task]:
    point = None if leg.point is None else planner.xy(leg.point, number)
    common, tasks = planner.common(leg, number), []
    if point is not None and planner.family.stops:
        tasks.append(Line(point, None, planner.tolerance_m, exact=True, common=common))
    return [*tasks, Station(leg.seconds, point, leg.radius_m, common)]


def _orbit(planner: Planner, leg: legs.Orbit, number: int, at: XY) -> list[Task]:
    turn = 1.0 if leg.direction == "clockwise" else -1.0
    center = planner.xy(leg.center, number)
    return [Orbit(center, leg.radius_m, leg.turns, turn, leg.look == "center", planner.common(leg, number))]


def _dock(planner: Planner, leg: legs.Dock, number: int, at: XY) -> list[Task]:
    end = planner.xy(leg.point, number)
    heading, slow = math.radians(leg.heading_deg), planner.envelope.slow_mps
    radius, exact = planner.envelope.turn_radius_m or 0.0, planner.family.turns
    run_in = 0.0 if exact else max(RUN_IN * radius, RUN_IN_M)

    def before(distance: float) -> XY:
        return end[0] - distance * math.cos(heading), end[1] + distance * math.sin(heading)

    ready = before(leg.approach_m)
    level = None
    if isinstance(leg.point, tuple) and len(leg.point) == 3 and planner.family.medium != "at the surface":
        level = Level(-leg.point[2])
    common = planner.common(leg, number, level=level)
    common = replace(common, face_rad=heading)
    speed = leg.speed_mps if leg.speed_mps is not None else slow or 0.4 * planner.envelope.cruise_mps
    near, slowly = max(0.2 * leg.approach_m, leg.tolerance_m), replace(common, speed_mps=speed)
    way = [Line(ready, None, near, planner.family.stops, common=common)]
    if run_in > leg.approach_m:  # slowly there too: a current asks for another crab angle at another speed
        far = before(run_in)
        way = [Line(far, None, max(radius, near), common=common), Line(ready, far, near, common=slowly)]
    inside = Line(end, ready, leg.tolerance_m, exact, again=0 if exact else len(way), common=slowly)
    return [*way, inside]


def _follow(planner: Planner, leg: legs.Follow, number: int, at: XY) -> list[Task]:
    common, where = planner.common(leg, number), planner.where(number)
    if leg.agent is not None:
        others = [name for name in planner.agents if name != planner.name]
        if leg.agent not in others:
            raise LookupFailed("agent to follow", leg.agent, others, where=f"{where}.agent")
        top = leg.speed_mps or planner.envelope.top_mps or 1.5 * planner.envelope.cruise_mps
        return [FollowAgent(leg.agent, leg.offset_m, leg.seconds, top, common)]
    if leg.wall is not None:
        return [FollowWall(leg.wall, _side(planner, leg.wall, where), leg.distance_m, leg.seconds, common)]
    assert leg.pipeline is not None
    line = middle_line(list(planner.world.geometries), leg.pipeline, where=f"{where}.pipeline")
    if np.hypot(*(line[-1] - np.array(at))) < np.hypot(*(line[0] - np.array(at))):
        line = line[::-1]
    return _transits([(float(x), float(y)) for x, y in line], common, max(planner.tolerance_m, 1.0))


def _side(planner: Planner, sensor: str, where: str) -> float:
    """1 for a ranging sensor that looks to port, -1 to starboard."""
    if sensor not in planner.sensors:
        raise LookupFailed(f"sensor of {planner.name}", sensor, planner.sensors, where=f"{where}.wall")
    config = planner.sensors[sensor]
    if altitude_of(config) != "":
        text = f"{sensor!r} is a {config.type}; a wall is followed with an altimeter"
        raise ScenarioError(text, where=f"{where}.wall")
    w, x, y, z = config.q_body_sensor
    left = -2 * (y * z - w * x)  # of the axis -z of the sensor, along which these look
    if abs(left) < 0.5:
        raise ScenarioError(
            f"{sensor!r} does not look sideways: orientation_deg [90, 0, 0] is to port, [-90, 0, 0] to starboard",
            where=f"{where}.wall",
        )
    return math.copysign(1.0, left)


def _dive(planner: Planner, leg: legs.Dive, number: int, at: XY) -> list[Task]:
    return [Dive(common=planner.common(leg, number))]


def _surface(planner: Planner, leg: legs.Surface, number: int, at: XY) -> list[Task]:
    return [Dive(True, planner.common(leg, number, level=Level(0.0)))]


def _profile(planner: Planner, leg: legs.Profile, number: int, at: XY) -> list[Task]:
    heading = None if leg.heading_deg is None else math.radians(leg.heading_deg)
    point = None if leg.point is None else planner.xy(leg.point, number)
    glide, common = math.radians(leg.glide_deg), planner.common(leg, number)
    depths = leg.upper_depth_m, leg.lower_depth_m
    return [Profile(*depths, leg.cycles, heading, point, planner.near(leg), glide, common)]


def _land(planner: Planner, leg: legs.Land, number: int, at: XY) -> list[Task]:
    common = planner.common(leg, number)
    point = None if leg.point is None else planner.xy(leg.point, number)
    over = [] if point is None else [Line(point, None, planner.tolerance_m, exact=True, common=common)]
    return [*over, Land(point, leg.sink_mps, common)]


def _drift(planner: Planner, leg: legs.Drift, number: int, at: XY) -> list[Task]:
    return [Drift(leg.seconds, planner.common(leg, number))]


def _gps_fix(planner: Planner, leg: legs.GpsFix, number: int, at: XY) -> list[Task]:
    level = None if planner.family.medium == "in the air" else Level(0.0)
    rises = planner.family.medium == "under water"
    return [GpsFix(leg.timeout_s, rises, planner.common(leg, number, level=level))]


def _hold(planner: Planner, leg: legs.Hold, number: int, at: XY) -> list[Task]:
    return [Hold(leg.seconds, planner.common(leg, number))]


_MAKERS: Final[dict[str, Callable[[Planner, Any, int, XY], list[Task]]]] = {
    "waypoints": _waypoints, "lawnmower": _lawnmower, "survey": _survey, "goto": _goto, "station_keeping": _station,
    "orbit": _orbit, "dock": _dock, "follow": _follow, "dive": _dive, "surface": _surface, "profile": _profile,
    "land": _land, "drift": _drift, "gps_fix": _gps_fix, "hold": _hold,
}  # fmt: skip
