"""Every leg with every option, planned and gone by three copies that obey with a lag, in a current, from all quarters.

Host only: a copy is a point, with a heading, that does what it is told a little later. What vehicles make of it is held
by `test_known_vehicles`.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from known import DOUBLE, check
from pelagos.config.loader import load_scenario
from pelagos.config.mission import Leg
from pelagos.sensors.sonar.altimeter import AltimeterConfig
from pelagos.sim.cost import cost_of
from pelagos.sim.guidance.aboard import Aboard, Fix, wrapped
from pelagos.sim.guidance.guidance import Guidance
from pelagos.sim.guidance.outcome import Flown, Track, outcomes
from pelagos.sim.guidance.outline import outline
from pelagos.sim.guidance.plan import Planner
from pelagos.sim.guidance.squad import Squad
from pelagos.sim.guidance.steering.choice import steering_of
from pelagos.sim.guidance.survey import Swath, survey_lines
from pelagos.vehicles.envelope import EnvelopeConfig
from pelagos.vehicles.family import FAMILIES
from pelagos.world.build import build_world, world_config

FAMILY = {family.name: family for family in FAMILIES}
DT, SINK = 0.5, 0.4
START = np.array([[14.0, -9.0, -4.0], [-21.0, -13.0, -6.0], [-8.0, 26.0, -3.0]])
HEADING = np.array([0.4, 2.9, -1.7])
CURRENT = np.array([[0.11, -0.07, 0.0], [-0.05, 0.13, 0.0], [0.0, 0.09, 0.0]])
AREA = [[10.0, -9.0], [51.0, -30.0], [38.0, 5.0], [60.0, 22.0], [12.0, 30.0]]
HERE = {"latitude_deg": 45.00023, "longitude_deg": 12.99971}
ENVELOPES = {"torpedo": {"turn_radius_m": 7.0, "slow_mps": 0.6}, "ship": {"turn_radius_m": 12.0},
    "hover": {"cruise_mps":
             0.6, "tolerance_m": 0.8}, "airplane": {"cruise_mps": 9.0, "turn_radius_m": 20.0,
                 "turn_speed_mps": 10.0}}  # fmt: skip
MISSIONS: dict[str, tuple[str, list[dict[str, Any]]]] = {
    "lines": ("torpedo", [
        {"type": "waypoints", "points": [[31.0, -22.0], HERE], "depth_m": 7.0, "speed_mps": 1.1, "acceptance_m": 4.0},
        {"type": "lawnmower", "corner": [12.0, -7.0], "heading_deg": -125.0, "length_m": 33.0, "width_m": 25.0,
         "spacing_m": 12.0, "altitude_m": 9.0},
        {"type": "repeat", "times": 1, "last": 1}]),
    "surveys": ("torpedo", [
        {"type": "survey", "area": AREA, "spacing_m": 17.0, "depth_m": 3.0},
        {"type": "survey", "area": AREA, "heading_deg": 215.0, "swath_deg": 110.0, "overlap": 0.3, "depth_m": 5.0},
        {"type": "survey", "area": AREA[::-1], "heading_deg": -20.0, "swath_deg": 90.0, "altitude_m": 7.0}]),
    "turns": ("torpedo", [
        {"type": "orbit", "center": [5.0, 4.0], "radius_m": 17.0, "turns": 0.8, "direction": "clockwise",
        "depth_m": 6.0},
        {"type": "orbit", "center": [-9.0, 14.0], "radius_m": 13.0, "turns": 1.3, "direction": "counterclockwise",
         "speed_mps": 1.0}]),
    "in and out": ("torpedo", [
        {"type": "dive", "depth_m": 11.0, "speed_mps": 0.9}, {"type": "hold", "seconds": 9.0},
        {"type": "dock", "point": [19.0, -15.0, -9.0], "heading_deg": 155.0, "approach_m": 12.0, "tolerance_m": 1.5,
         "speed_mps": 0.8},
        {"type": "surface"}, {"type": "gps_fix", "timeout_s": 20.0}, {"type": "drift", "seconds": 7.0}]),
    "wall to port": ("torpedo", [{"type": "follow", "wall": "port", "distance_m": 6.0, "seconds": 60.0,
    "depth_m": 4.0}]),
    "wall to starboard": ("torpedo", [{"type": "follow", "wall": "starboard", "distance_m": 6.0, "seconds": 60.0,
                                       "altitude_m": 12.0}]),
    "up and down": ("torpedo", [
        {"type": "profile", "upper_depth_m": 4.0, "lower_depth_m": 9.0, "cycles": 2, "heading_deg": -70.0},
        {"type": "profile", "lower_depth_m": 8.0, "point": [-20.0, 31.0], "acceptance_m": 6.0}]),
    "hovering": ("hover", [
        {"type": "goto", "points": [[16.0, -4.0, -7.0], [11.0, 5.0]], "heading_deg": 250.0, "speed_mps": 0.4},
        {"type": "goto", "points": [[3.0, -8.0]], "face": [40.0, 17.0], "altitude_m": 8.0, "acceptance_m": 0.6},
        {"type": "orbit", "center": [4.0, 1.0], "radius_m": 5.0, "turns": 0.4, "direction": "counterclockwise",
         "look": "center", "depth_m": 4.0},
        {"type": "dock", "point": [8.0, -5.0, -6.0], "heading_deg": 65.0, "approach_m": 4.0}]),
    "hovering at last": ("hover", [
        {"type": "station_keeping", "point": [6.0, -4.0], "seconds": 25.0, "face": [-9.0, 3.0], "depth_m": 5.0},
        {"type": "station_keeping", "seconds": 8.0, "heading_deg": -100.0},
        {"type": "follow", "agent": "other", "offset_m": [-3.0, 2.0, 1.0], "seconds": 40.0},
        {"type": "land", "point": [2.0, 3.0], "sink_mps": 0.3}]),
    "afloat": ("surface", [
        {"type": "survey", "area": AREA[:3], "heading_deg": 70.0, "spacing_m": 11.0},
        {"type": "station_keeping", "point": [6.0, -4.0], "seconds": 40.0},
        {"type": "orbit", "center": [4.0, 7.0], "radius_m": 9.0, "turns": 0.6, "direction": "counterclockwise"},
        {"type": "follow", "agent": "other", "offset_m": [-6.0, 1.0, 0.0], "seconds": 30.0},
        {"type": "goto", "points": [[-7.0, 21.0]], "speed_mps": 0.9}, {"type": "drift", "seconds": 8.0}]),
    "a ship": ("ship", [
        {"type": "waypoints", "points": [[91.0, -52.0], [-40.0, 33.0]], "acceptance_m": 8.0},
        {"type": "station_keeping", "point": [6.0, -4.0], "seconds": 50.0, "radius_m": 25.0}]),
    "a glider": ("glider", [
        {"type": "dive", "depth_m": 9.0}, {"type": "waypoints", "points": [[41.0, -22.0]], "depth_m": 12.0},
        {"type": "profile", "upper_depth_m": 3.5, "lower_depth_m": 10.0, "cycles": 1, "heading_deg": 130.0,
        "glide_deg": 18.0}, {"type":
         "surface"}]),
    "in the air": ("airplane", [
        {"type": "waypoints", "points": [[141.0, -122.0]], "height_m": 50.0},
        {"type": "orbit", "center": [40.0, -30.0], "radius_m": 60.0, "turns": 0.7, "direction": "counterclockwise",
         "height_m": 40.0}]),
    "a drone": ("rotor", [
        {"type": "goto", "points": [[16.0, -4.0, 12.0]], "heading_deg": -50.0}, {"type": "land", "sink_mps": 0.5}]),
    "a pipeline": ("torpedo", [{"type": "follow", "pipeline": "pipeline", "altitude_m": 5.0, "speed_mps": 1.3}]),
    "until": ("torpedo", [
        {"type": "waypoints", "points": [[200.0, 90.0]], "depth_m": 6.0,
         "until": {"sensor": "heat", "component": 1, "above": 3.1}},
        {"type": "hold", "seconds": 99.0, "until": {"sensor": "heat", "below": -9.0}}]),
}  # fmt: skip
TURNS = {"port": (90.0, 0.0, 0.0), "starboard": (-90.0, 0.0, 0.0), "down": (0.0, 0.0, 0.0), "heat": (0.0, 0.0, 0.0)}


@pytest.fixture(scope="module")
def world() -> Any:
    slope = {"kind": "ridges", "relief_m": 4.3, "wavelength_m": 71.0, "heading_deg": -35.0, "roughness_m": 0.0}
    keys = {"type": "generated", "size_m": [200, 160], "grid_m": 2.0, "depth_m": 26.0, "seed": 4, "terrain": slope}
    pipe = {"kind": "pipeline"}
    return build_world(world_config({**keys, "latitude_deg": 45.0, "longitude_deg": 13.0, "objects": [pipe]}))


def planner_of(family: str, world: Any) -> Planner:
    sensors = {name: AltimeterConfig(type="altimeter", rate_hz=5, orientation_deg=turn) for name, turn in TURNS.items()}
    envelope = EnvelopeConfig(**ENVELOPES.get(family, {}))
    return Planner("it", family, FAMILY[family], envelope, sensors, ["it", "other"], world, start=(3.0, -2.0))


class Copies:
    """Three points that obey set-points with a lag."""

    def __init__(self, family: str, world: Any) -> None:
        self.family, self.world, self.t_s = family, world, 0.0
        self.place, self.heading = START.copy(), HEADING.copy()
        if family in ("surface", "ship"):
            self.place[:, 2] = 0.0
        if family in ("airplane", "rotor"):
            self.place[:, 2] = [30.0, 22.0, 41.0]
        self.way, self.speed = np.zeros((3, 3)), np.array([0.7, 0.2, 1.1])

    def ground(self) -> Any:
        """Beneath each; outside of the world far below."""
        return np.nan_to_num(self.world.height(self.place[:, 0], self.place[:, 1]), nan=-90.0)

    def aboard(self) -> Aboard:
        """A wall west of the first copies runs askew; the other vehicle goes on a bend and stops."""
        t = min(self.t_s, 70.0)
        other = np.array([[12.0 + 0.3 * t, 5.0 - 0.2 * t, -5.0 - 0.01 * t]] * 3) + START[::-1] * 0.4
        moves = np.array([[0.3, -0.2, -0.01]] * 3) * (self.t_s < 70.0)
        away = [np.abs(self.place @ [0.28, 0.96, 0.0] - side * 40.0)[:, None] for side in (1, -1)]
        heat = np.stack([-self.place[:, 0] / 9, self.place[:, 1] / 9 + self.t_s / 20], axis=1)
        return Aboard(
            Fix(self.place.copy(), self.heading.copy(), self.way.copy()), self.t_s, DT, self.place[:,
                2] - self.ground(),
            np.array([self.t_s % 3 < 1, self.t_s % 5 < 1, False]), readings={"port": away[0], "starboard": away[1],
            "heat": heat}, others={"other": Fix(other, 0.3 + 0.02 * t + HEADING, moves)},
        )  # fmt: skip

    def obey(self, told: dict[str, Any]) -> None:
        before, share = self.place.copy(), 1 - math.exp(-DT / 1.5)
        if "x" in told:
            goal = np.stack([told[axis] for axis in "xyz"], axis=1)
            self.place += share * (goal - self.place) + 0.2 * DT * CURRENT
            self.heading = wrapped(self.heading + share * wrapped(-told["yaw"] - self.heading))
        else:
            self.heading = wrapped(self.heading + share * wrapped(told["heading"] - self.heading))
            self.speed += share * (told.get("speed", told.get("airspeed", np.full(3, 1.2))) - self.speed)
            self.place[:, 0] += DT * self.speed * np.cos(self.heading)
            self.place[:, 1] -= DT * self.speed * np.sin(self.heading)
            self.place += DT * CURRENT
            depth = told.get("depth", -told["height"] if "height" in told else np.zeros(3))
            self.place[:, 2] += np.clip(-depth - self.place[:, 2], -SINK, SINK)
            if self.family == "glider":
                self.place[:, 2] = np.minimum(self.place[:, 2], -0.1 * (depth > 0))
        self.place[:, 2] = np.maximum(self.place[:, 2], self.ground() + 0.1)
        self.way, self.t_s = (self.place - before) / DT, self.t_s + DT


def numbers(value: Any) -> list[float]:
    """Every number of a plan, in order; -1 where nothing is given."""
    if dataclasses.is_dataclass(value):
        return [v for f in dataclasses.fields(value) for v in numbers(getattr(value, f.name))]
    if isinstance(value, str):
        return [float(len(value))]
    if value is None:
        return [-1.0]
    return [float(v) for v in np.ravel(np.asarray(value, dtype=float))]


@pytest.mark.parametrize("name", MISSIONS)
def test_missions(name: str, world: Any) -> None:
    family, given = MISSIONS[name]
    legs = [TypeAdapter(Leg).validate_python(leg) for leg in given]
    planner = planner_of(family, world)
    steps = planner.plan(legs)
    copies = Copies(family, world)
    names = (*FAMILY[family].needs, *FAMILY[family].may)
    steering = steering_of(FAMILY[family], planner.envelope, 1.7, 3)
    guidance = Guidance(steps, steering, names, copies.aboard())
    told, way, kept = [], [], None
    for k in range(420):
        aboard = copies.aboard()
        error = np.array([[0.3, -0.2, 0.1]] * 3) * (k > 200)
        truth = Aboard(Fix(copies.place + error, copies.heading + 0.05 * (k > 200), copies.way), aboard.t_s, DT,
                       aboard.altitude, aboard.fixed)  # fmt: skip
        told.append(guidance.command(aboard, truth if k > 200 else None))
        if k == 40:
            kept = guidance.memory()
        way.append(copies.place.copy())
        copies.obey(dict(zip(names, told[-1].T, strict=True)))
    assert kept is not None
    tracks = [Track(DT * np.arange(420), np.array(way)[:, i]) for i in range(3)]
    flown = [Flown(steps, [leg.type for leg in legs], 0.0, guidance.ended[i],
                   int(guidance.progress.task[i]), FAMILY[family].stops) for i in range(3)]  # fmt: skip
    ended = [outcomes(f, t) for f, t in zip(flown, tracks, strict=True)]
    found = {
        "plan": [v for step in steps for v in numbers(step)], "task": guidance.progress.task, "ended": guidance.ended,
        "told": told, "early": told[:40], "way": way, "memory": numbers([]) + list(np.ravel(kept["progress"]
        ["memory"])), "outcomes": [v for of in ended for leg in of for v in numbers(leg)[1:]],
        "outline": outline(steps, START[1], world.height),
    }  # fmt: skip
    check("guidance", name, found, DOUBLE)


def test_a_squad_goes_as_its_members() -> None:
    """Two agents whose missions differ in places alone, asked together, side by side."""
    flat: Any = build_world(world_config({"type": "flat", "depth_m": 40.0, "size_m": [400, 300]}))
    given = [
        [{"type": "waypoints", "points": [[31.0 + k, -22.0]], "depth_m": 7.0},
         {"type": "station_keeping", "point": [4.0 - 9 * k, 9.0], "seconds": 20.0},
         {"type": "orbit", "center": [5.0, 4.0 + 3 * k], "radius_m": 9.0, "turns": 0.5}] for k in (0, 2)
    ]  # fmt: skip
    planner, names = planner_of("torpedo", flat), FAMILY["torpedo"].needs
    one, other = Copies("torpedo", flat), Copies("torpedo", flat)
    other.place += [9.0, -4.0, 1.0]
    each = {
        name: Guidance(
            planner.plan([TypeAdapter(Leg).validate_python(leg) for leg in legs]),
            steering_of(planner.family, planner.envelope, 1.7, 3), names, copies.aboard(),
        )
        for name, legs, copies in zip(("a", "b"), given, (one, other), strict=True)
    }  # fmt: skip

    def both() -> Aboard:
        a, b = one.aboard(), other.aboard()
        parts = {key: np.concatenate([getattr(a.own, key), getattr(b.own, key)]) for key in vars(a.own)}
        return Aboard(Fix(**parts), a.t_s, DT, np.concatenate([a.altitude, b.altitude]), np.zeros(6, dtype=bool))

    squad = Squad(each, steering_of(planner.family, planner.envelope, 1.7, 6), names, both())
    told = []
    for _ in range(160):
        told.append(np.concatenate(list(dict(squad.command(both())).values())))
        one.obey(dict(zip(names, told[-1][:3].T, strict=True)))
        other.obey(dict(zip(names, told[-1][3:].T, strict=True)))
    check("guidance", "a squad", {"told": told, "a": one.place, "b": other.place}, DOUBLE)


SENSORS: dict[str, dict[str, Any]] = {
    "imu": {"type": "imu", "rate_hz": 100}, "camera": {"type": "camera", "rate_hz": 5, "width_px": 320,
    "height_px": 200},
    "sonar": {"type": "imaging_sonar", "rate_hz": 4, "beams": 120, "bins": 300},
    "multibeam": {"type": "multibeam", "rate_hz": 5, "beams": 90, "water_column_bins": 70},
    "lidar": {"type": "lidar", "rate_hz": 10}, "ear": {"type": "hydrophone", "rate_hz": 10, "elements_m": [[0, 0, 0], [
    0.1, 0.2, 0.3]]},
    "adcp": {"type": "adcp", "rate_hz": 2}, "side": {"type": "sidescan", "rate_hz": 5, "bins": 400},
}  # fmt: skip


def test_groups_draws_and_what_a_run_costs() -> None:
    auv = {
        "vehicle": "remus100", "sensors": SENSORS, "count": 11, "mission_from": "start",
        "start": {"position_m": [3.0, -4.0], "depth_m": 5.0, "spacing_m": [30.0, 25.0]},
        "mission": [{"type": "survey", "area": AREA, "spacing_m": 9.0, "depth_m": 4.0},
                    {"type": "goto", "points": [[1.0, 2.0, -3.0]]}],
        "distributions": {"start.heading_deg": {"uniform": [-90.0, 40.0]}, "start.depth_m": {"normal": [9.0, 1.5]},
                          "mission.1.speed_mps": {"choice": [0.7, 1.1, 1.6]}},
        "overrides": {3: {"sensors": {"imu": {"rate_hz": 50}}}, 5: {"start": {"heading_deg": 170.0}}},
    }  # fmt: skip
    in_rows = {**auv, "count": 7, "start": {**auv["start"], "grid": [3, 4]}, "distributions": {}, "overrides": {}}
    ground = {"type": "generated", "size_m": [210, 160], "grid_m": 1.5, "depth_m": 26.0}
    vary = {"ocean.current_mps.1": {"normal": [0.2, 0.1]}, "agents.one.start.position_m.0": {"uniform": [-3.0, 8.0]},
            "agents.one.factors.mass": {"choice": [0.9, 1.0, 1.2]}}  # fmt: skip
    one = {"vehicle": "bluerov2_heavy", "start": {"position_m": [40.0, 30.0], "depth_m": 6.0}}
    scenario = load_scenario({"seed": 11, "tick_rate_hz": 200, "duration_s": 37.0, "world": ground, "vary": vary,
                              "agents": {"auv": auv, "rows": in_rows, "one": one}})  # fmt: skip
    starts = [[*a.start.position_m, a.start.heading_deg, a.start.depth_m or 0.0] for a in scenario.members.values()]
    legs = [v for a in scenario.members.values() for leg in a.mission for key in ("area", "points", "speed_mps")
            for v in np.ravel(np.array(getattr(leg, key, None) or [-1.0], dtype=float))]  # fmt: skip
    found: dict[str, Any] = {"starts": starts, "legs": legs}
    for n, block in ((1, 0.0), (3, 1.0)):
        cost = cost_of(scenario, n, block_s=block)
        parts = sorted(cost.parts, key=lambda part: part.path)
        found[f"cost of {n}"] = [
            cost.memory,
            cost.rays_per_s,
            cost.ticks,
            *(v for p in parts for v in (p.memory, p.rays_per_s)),
        ]
    found["drawn"] = [
        draw.draw(seed, name) for draw in scenario.vary.values() for seed in (1, 2) for name in ("a", "b/1")
    ]
    found["steps"] = [v for draw in scenario.vary.values() for v in draw.steps(5)]
    check("guidance", "groups and costs", found, DOUBLE)


@pytest.mark.parametrize("heading_deg", [None, 25.0, -140.0])
def test_lines_over_an_area_with_bays(heading_deg: float | None) -> None:
    """Two pieces to a line, of which now the one and now the other lies over shallower ground."""
    area = np.array([[0, 0], [70, -6], [75, 40], [48, 38], [41, 9], [33, 12], [30, 47], [-4, 44]], dtype=float)
    heading = None if heading_deg is None else math.radians(heading_deg)

    def height(x: Any, y: Any) -> Any:
        return -19.0 + 0.11 * x - 0.07 * y + 2.0 * np.sin(x / 9.0)

    found = [
        survey_lines(turned, Swath(None, math.radians(110.0), 0.25), height=height, depth_m=3.0, altitude_m=None,
                     heading_rad=heading)
        for turned in (area, area * [1.0, -1.0], area[::-1, ::-1])
    ]  # fmt: skip
    check("guidance", f"bays {heading_deg}", {str(k): lines for k, lines in enumerate(found)}, DOUBLE)
