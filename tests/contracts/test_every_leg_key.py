"""No key of a leg is accepted and then ignored, and no leg tells port from starboard but by its keys.

A point that does at once what its guidance asks for goes through a mission of one leg, before and after one of the
leg's keys has another value: what was asked for on the way must differ, or when it ended. In the mirror it must be the
image.
"""

from __future__ import annotations

import math
from typing import Any, get_args

import numpy as np
import pytest
from other_values import others
from pydantic import TypeAdapter, ValidationError

from known import check
from pelagos.config import registry
from pelagos.config.mission import Leg
from pelagos.errors import PelagosError, ScenarioError
from pelagos.math.geodesy import GeoOrigin
from pelagos.sim.guidance.aboard import Aboard, Fix
from pelagos.sim.guidance.guidance import Guidance
from pelagos.sim.guidance.plan import Planner
from pelagos.sim.guidance.steering.choice import steering_of
from pelagos.vehicles.envelope import EnvelopeConfig
from pelagos.vehicles.family import FAMILIES

FAMILY = {family.name: family for family in FAMILIES}
STEP_S, STEPS = 1.0, 220
START, HEADING = (3.0, -2.0, -2.0), 0.4
AHEAD: list[dict[str, Any]] = [
    {"type": "waypoints", "points": [[30.0, -12.0], [42.0, 17.0]], "depth_m": 5.0, "speed_mps": 1.3,
     "acceptance_m": 4.0},
    {"type": "goto", "points": [[13.0, -8.0, -4.0], [4.0, 9.0, -7.0]], "heading_deg": 35.0, "speed_mps": 0.4},
    {"type": "goto", "points": [[13.0, -8.0], [4.0, 9.0]], "face": [20.0, -31.0], "depth_m": 3.0, "acceptance_m": 3.0},
    {"type": "station_keeping", "point": [11.0, -6.0], "seconds": 19.0, "depth_m": 3.0, "heading_deg": -70.0,
     "speed_mps": 0.3},
    {"type": "station_keeping", "point": [11.0, -6.0], "seconds": 60.0, "face": [20.0, -31.0], "altitude_m": 9.0},
    {"type": "orbit", "center": [24.0, 7.0], "radius_m": 11.0, "turns": 1.25, "depth_m": 6.0, "look": "center",
     "speed_mps": 0.7, "direction": "counterclockwise"},
    {"type": "orbit", "center": [24.0, 7.0], "radius_m": 11.0, "direction": "counterclockwise", "turns": 1.25,
     "altitude_m": 6.0, "speed_mps": 0.7},
    {"type": "dock", "point": [21.0, -13.0, -6.0], "heading_deg": 65.0, "approach_m": 7.0, "tolerance_m": 0.4,
     "speed_mps": 0.3},
    {"type": "dock", "point": [21.0, -13.0], "heading_deg": 65.0, "altitude_m": 5.0},
    {"type": "dive", "depth_m": 9.0, "speed_mps": 0.6},
    {"type": "hold", "seconds": 5.0},
    {"type": "drift", "seconds": 25.0, "depth_m": 4.0},
    {"type": "surface", "speed_mps": 0.6},
    {"type": "gps_fix", "timeout_s": 14.0},
    {"type": "follow", "agent": "other", "offset_m": [-4.0, 2.0, 1.0], "seconds": 30.0, "speed_mps": 0.9},
    {"type": "follow", "agent": "other", "seconds": 30.0, "altitude_m": 8.0},
    {"type": "lawnmower", "corner": [20.0, -9.0], "heading_deg": 40.0, "length_m": 50.0, "width_m": 30.0,
     "spacing_m": 10.0, "depth_m": 4.0, "speed_mps": 1.3, "acceptance_m": 4.0},
    {"type": "survey", "area": [[20.0, -9.0], [71.0, -30.0], [50.0, 22.0]], "heading_deg": 40.0, "spacing_m": 9.0,
     "depth_m": 4.0, "speed_mps": 1.3, "acceptance_m": 4.0},
    {"type": "survey", "area": [[20.0, -9.0], [71.0, -30.0], [50.0, 22.0]], "swath_deg": 70.0, "overlap": 0.3,
     "altitude_m": 8.0},
]  # fmt: skip
MISSIONS: list[tuple[str, list[dict[str, Any]]]] = [
    *(("hover", [leg]) for leg in AHEAD),
    *(("torpedo", [leg]) for leg in AHEAD),
    ("torpedo", [{"type": "station_keeping", "point": [11.0, -6.0], "seconds": 90.0, "radius_m": 30.0}]),
    ("rotor", [{"type": "land", "point": [8.0, -5.0], "sink_mps": 0.4}]),
    ("rotor", [{"type": "waypoints", "points": [[8.0, -5.0]], "height_m": 11.0}]),
    ("glider", [{"type": "profile", "upper_depth_m": 2.0, "lower_depth_m": 11.0, "cycles": 2, "heading_deg": 25.0,
                 "glide_deg": 21.0}]),
    ("glider", [{"type": "profile", "lower_depth_m": 11.0, "point": [40.0, -30.0], "acceptance_m": 12.0}]),
    *((family, [{"type": "profile", "upper_depth_m": 2.0, "lower_depth_m": 11.0, "cycles": 2, **more}])
      for family, more in (("hover", {}), ("hover", {"point": [40.0, -30.0], "speed_mps": 0.4}),
                           ("torpedo", {"heading_deg": 25.0, "speed_mps": 0.4}))),
    ("hover", [{"type": "dive", "depth_m": 9.0}]),
    ("hover", [{"type": "surface"}]),
    ("hover", [{"type": "goto", "points": [[9.0, 4.0]]}, {"type": "goto", "points": [[3.0, -2.0]]},
               {"type": "repeat", "times": 2, "last": 1}]),
]  # fmt: skip
ELSEWHERE = {"follow.wall": "needs walls", "follow.pipeline": "needs a pipeline", "follow.distance_m": "needs a wall"}
"""Keys without a sample here: flown in test_mission_legs."""


class Plane:
    """A seabed that slopes both ways, off the coast of South Africa."""

    origin = GeoOrigin(-33.0, 18.0)
    geometries = ()

    def __init__(self, side: float = 1.0) -> None:
        self.side = side

    def height(self, x: Any, y: Any) -> Any:
        return -20.0 + 0.05 * np.asarray(x) - 0.02 * self.side * np.asarray(y)


def flown(family: str, mission: list[dict[str, Any]], side: float = 1.0) -> np.ndarray:
    """Commands of a flight `(steps, k)`, and when its tasks ended, 0 where they did not; `side`: -1 in the mirror."""
    sensors = {"probe": registry.entries("sensor")["altimeter"].config()}
    steps = Planner("it", "it", FAMILY[family], sensors=sensors, agents=("it", "other"), world=Plane(side)).plan(
        [TypeAdapter(Leg).validate_python(leg) for leg in mission]
    )
    names, envelope = FAMILY[family].needs, EnvelopeConfig(cruise_mps=0.8, tolerance_m=1.5)
    point = Point(family, side)
    guidance = Guidance(steps, steering_of(FAMILY[family], envelope, 1.5, 1), names, point.aboard(0.0))
    asked = []
    for k in range(STEPS):
        row = guidance.command(point.aboard(k * STEP_S))[0]
        asked.append(row)
        if guidance.done:
            break
        point.go(dict(zip(names, row, strict=True)))
    ended = np.nan_to_num(guidance.ended[0])
    whole = np.zeros((STEPS + len(ended), len(names)))
    whole[: len(asked)] = asked
    whole[STEPS:] = ended[:, None]
    return whole


class Point:
    """A vehicle that does at once what it is told."""

    def __init__(self, family: str, side: float) -> None:
        self.place, self.heading, self.side = np.array(START) * [1.0, side, 1.0], side * HEADING, side
        if family == "rotor":
            self.place[2] = 14.0
        self.velocity, self.down, self.shallow_s = np.zeros(3), True, 0.0

    def aboard(self, t: float) -> Aboard:
        place, way = np.array([6.0 + 0.3 * t, 4.0 - 0.2 * t, -5.0]), np.array([0.3, -0.2, 0.0])
        across = np.array([1.0, self.side, 1.0])
        others = {"other": Fix((across * place)[None], np.array([self.side * 0.6]), (across * way)[None])}
        altitude = self.place[2] - Plane(self.side).height(*self.place[:2])
        fix = Fix(self.place[None].copy(), np.array([self.heading]), self.velocity[None].copy())
        reading = np.array([[1e3, self.place[1]]])
        return Aboard(
            fix, t, STEP_S, np.array([altitude]), np.array([7.5 < self.shallow_s < 8.5]), {"probe": reading}, others
        )

    def go(self, asked: dict[str, float]) -> None:
        before = self.place.copy()
        if "x" in asked:
            self.place, self.heading = np.array([asked[k] for k in "xyz"]), -asked["yaw"]
        else:
            self.heading = asked["heading"]
            speed = asked.get("speed", 0.4)
            self.place[:2] += STEP_S * speed * np.array([math.cos(self.heading), -math.sin(self.heading)])
            deep = -self.place[2]
            if "upper_depth" in asked:
                self.down = deep < asked["depth"] if self.down else deep <= asked["upper_depth"]
                self.place[2] += STEP_S * (-0.2 if self.down else 0.2)
            else:
                self.place[2] -= np.clip(asked["depth"] - deep, -0.2, 0.2)
        self.velocity = (self.place - before) / STEP_S
        self.shallow_s = self.shallow_s + STEP_S if self.place[2] > -0.3 else 0.0


def heard(family: str, mission: list[dict[str, Any]], known: set[str], numbers: dict[str, Any]) -> dict[str, bool]:
    """Each key of the last leg that is not `known`, and whether another value changes the flight, put in `numbers`."""
    before, leg = mission[:-1], mission[-1]
    cls = next(c for c in get_args(get_args(Leg)[0]) if c.model_fields["type"].default == leg["type"])
    schema, found = cls.model_json_schema(), {}
    try:
        plain = flown(family, mission)
    except PelagosError:  # a leg that is not for this family
        return {}
    numbers[f"{len(numbers)} {leg['type']}"] = plain
    for key, value in leg.items():
        if key == "type":
            continue
        for path, moved in others(schema["properties"][key], schema.get("$defs", {}), value):
            at = f"{leg['type']}.{key}{path}"
            if at in known or found.get(at):
                continue
            try:
                other = flown(family, [*before, {**leg, key: moved}])
                numbers[f"{len(numbers)} {at}"] = other
                found[at] = not np.array_equal(other, plain)
            except (PelagosError, ValidationError):
                found.setdefault(at, False)
    return found


@pytest.mark.parametrize("family", ["hover", "rotor", "glider", pytest.param("torpedo", marks=pytest.mark.slow)])
def test_every_key_of_a_leg_changes_the_way_or_its_end_as_known(family: str) -> None:
    felt: dict[str, bool] = {}
    numbers: dict[str, Any] = {}
    for mission in (mission for of, mission in MISSIONS if of == family):
        for at, is_felt in heard(family, mission, {k for k, v in felt.items() if v}, numbers).items():
            felt[at] = felt.get(at, False) or is_felt
    assert len(felt) > 1
    check("keys_of_legs", family, numbers)
    assert not sorted(at for at, is_felt in felt.items() if not is_felt)


def test_every_key_of_every_leg_is_tried() -> None:
    keys = {
        f"{cls.model_fields['type'].default}.{key}"
        for cls in get_args(get_args(Leg)[0]) for key in cls.model_fields if key not in ("type", "until")
    }  # fmt: skip
    tried = {f"{leg['type']}.{key}" for _, mission in MISSIONS for leg in mission for key in leg}
    shared = {k for k in keys if k.endswith(("altitude_m", "height_m", "depth_m", "speed_mps", "acceptance_m"))}
    assert keys - tried - set(ELSEWHERE) <= shared, "give a mission with it in MISSIONS"


CIRCLES = ("station_keeping",)
"""Legs on which those who cannot stop circle, clockwise on either side."""
TO_STARBOARD = ("lawnmower", "survey")
"""Legs whose lines grow to starboard: they have no mirror image."""


def image(leg: dict[str, Any]) -> dict[str, Any]:
    """The leg in the mirror."""
    made = dict(leg)
    for key in ("center", "point", "face", "offset_m"):
        if key in leg:
            made[key] = [leg[key][0], -leg[key][1], *leg[key][2:]]
    if "points" in leg:
        made["points"] = [[x, -y, *z] for x, y, *z in leg["points"]]
    if "heading_deg" in leg:
        made["heading_deg"] = -leg["heading_deg"]
    if "direction" in leg:
        made["direction"] = {"clockwise": "counterclockwise", "counterclockwise": "clockwise"}[leg["direction"]]
    return made


@pytest.mark.parametrize("family", ["hover", "rotor", "glider", "torpedo"])
def test_a_leg_in_the_mirror_asks_for_the_image(family: str) -> None:
    flips = [-1.0 if name in ("y", "yaw", "y_speed", "heading") else 1.0 for name in FAMILY[family].needs]
    for mission in (mission for of, mission in MISSIONS if of == family and mission[-1]["type"] not in TO_STARBOARD):
        try:
            there = flown(family, mission)
        except PelagosError:  # a leg that is not for this family
            continue
        if family == "torpedo" and mission[-1]["type"] in CIRCLES:
            continue
        other = flown(family, [image(leg) for leg in mission], -1.0)
        assert other[:STEPS] == pytest.approx(there[:STEPS] * flips, abs=1e-6), mission
        assert other[STEPS:] == pytest.approx(there[STEPS:]), mission


ONCE = {"type": "profile", "lower_depth_m": 9.0, "cycles": 1}
DIVE = {"type": "dive", "depth_m": 9.0}
FLIGHT = {"type": "dive", "height_m": 9.0}
GOTO = {"type": "goto", "points": [[7.0, -4.0]]}


@pytest.mark.parametrize(
    ("family", "leg", "key"),
    [
        ("hover", DIVE, "speed_mps"), ("rotor", FLIGHT, "speed_mps"), ("hover", {"type": "surface"}, "speed_mps"),
        ("hover", ONCE, "speed_mps"), ("hover", ONCE, "heading_deg"), ("hover", ONCE, "glide_deg"),
        ("torpedo", ONCE, "glide_deg"), ("glider", ONCE, "speed_mps"), ("glider", DIVE, "speed_mps"),
        ("ship", GOTO, "speed_mps"),
    ],
)  # fmt: skip
def test_a_key_that_a_vehicle_would_not_follow_is_refused(family: str, leg: dict[str, Any], key: str) -> None:
    flown(family, [leg])
    with pytest.raises(ScenarioError, match=rf"^mission\.0\.{key}: it .*: leave out '{key}'"):
        flown(family, [{**leg, key: 11.0}])
