"""No leg of a mission knows north or the origin: a scene that is turned and moved has the same way, turned and moved;
one that is mirrored port for starboard has the mirrored way.

Corners as `outline` gives them before anything has moved, and the headings that the legs ask for.
"""

from __future__ import annotations

import math
from typing import Any, get_args

import numpy as np
import pytest

import pelagos as pl
from pelagos.config.mission import Leg
from pelagos.sim.guidance.outline import outline

START = [3.0, -2.0, -2.0]
LEGS: list[dict[str, Any]] = [
    {"type": "waypoints", "points": [[30.0, -12.0], [42.0, 17.0]], "depth_m": 5.0},
    {"type": "goto", "points": [[13.0, -8.0, -4.0], [4.0, 9.0, -7.0]], "heading_deg": 35.0},
    {"type": "goto", "points": [[-6.0, 5.0, -3.0]], "face": [20.0, -31.0]},
    {"type": "station_keeping", "point": [11.0, -6.0], "seconds": 9.0, "depth_m": 3.0, "heading_deg": -70.0},
    {"type": "orbit", "center": [24.0, 7.0], "radius_m": 11.0, "direction": "clockwise", "turns": 1.25, "depth_m": 6.0},
    {"type": "dock", "point": [21.0, -13.0, -6.0], "heading_deg": 65.0, "approach_m": 7.0},
    {"type": "dive", "depth_m": 9.0},
    {"type": "hold", "seconds": 5.0},
    {"type": "drift", "seconds": 5.0},
    {"type": "surface"},
    {"type": "gps_fix"},
]
TO_STARBOARD: list[dict[str, Any]] = [
    {"type": "lawnmower", "corner": [20.0, -9.0], "heading_deg": 40.0, "length_m": 50.0, "width_m": 30.0,
     "spacing_m": 10.0, "depth_m": 4.0},
    {"type": "survey", "area": [[20.0, -9.0], [71.0, -30.0], [50.0, 22.0]], "heading_deg": 40.0, "spacing_m": 9.0,
     "depth_m": 4.0},
]  # fmt: skip
"""Legs that have no mirror image: their lines grow to starboard."""
ELSEWHERE = {
    "follow": "goes after what moves or stands in a world, test_mission_legs",
    "profile": "is for gliders, test_mission_legs",
    "land": "is for what flies, test_mission_legs",
    "repeat": "has no place",
}
PLACES = ("points", "center", "point", "face", "corner", "area")


class Scene:
    """Mirrored if -1, then turned clockwise [deg], then shifted (north, west) [m]."""

    def __init__(self, turn: float = 0.0, shift: tuple[float, float] = (0.0, 0.0), mirror: float = 1.0) -> None:
        self.turn, self.shift, self.mirror = turn, np.array(shift), mirror
        c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
        self.matrix = np.array([[c, s], [-s, c]]) @ np.diag([1.0, mirror])  # of (north, west)

    def place(self, value: Any) -> Any:
        if isinstance(value[0], list):
            return [self.place(v) for v in value]
        return [*(self.matrix @ value[:2] + self.shift).tolist(), *value[2:]]

    def heading(self, degrees: float) -> float:
        return (self.mirror * degrees + self.turn + 180.0) % 360.0 - 180.0

    def leg(self, leg: dict[str, Any]) -> dict[str, Any]:
        made = {key: self.place(value) if key in PLACES else value for key, value in leg.items()}
        if "heading_deg" in leg:
            made["heading_deg"] = self.heading(leg["heading_deg"])
        if "direction" in leg and self.mirror < 0:
            made["direction"] = "counterclockwise"
        return made

    def planned(self, legs: list[dict[str, Any]]) -> tuple[np.ndarray, np.ndarray]:
        """Corners `(k, 3)` of the way, and unit vectors (north, west) of the headings asked for, as the first scene
        sees them.
        """
        start = {"position_m": self.place(START)[:2], "depth_m": -START[2], "heading_deg": self.heading(25.0)}
        mission = [self.leg(leg) for leg in legs]
        agents = {"it": {"vehicle": "bluerov2_heavy", "start": start, "mission": mission}}
        sim = pl.Simulation.load({"world": {"type": "flat", "depth_m": 40.0}, "agents": agents})
        steps = sim.model.agents["it"].tasks
        corners = outline(steps, self.place(START), sim.world.height)
        faces = [step.task.common.face_rad for step in steps if step.task.common.face_rad is not None]
        ways = np.array([[math.cos(f), -math.sin(f)] for f in faces]).reshape(-1, 2)
        back = np.linalg.inv(self.matrix).T
        return np.concatenate([(corners[:, :2] - self.shift) @ back, corners[:, 2:]], axis=1), ways @ back


def test_every_kind_of_leg_is_planned_here_or_flown_elsewhere() -> None:
    kinds = {leg.model_fields["type"].default for leg in get_args(get_args(Leg)[0])}
    assert kinds == {leg["type"] for leg in (*LEGS, *TO_STARBOARD)} | set(ELSEWHERE)


@pytest.mark.parametrize(("legs", "corners", "faces"), [(LEGS, 50, 3), (TO_STARBOARD, 18, 0)])
def test_a_way_turns_and_moves_with_its_scene(legs: list[dict[str, Any]], corners: int, faces: int) -> None:
    first = Scene().planned(legs)
    assert len(first[0]) >= corners
    assert len(first[1]) >= faces
    scenes = [Scene(77.0, (130.0, -85.0)), Scene(-141.0, (-410.0, 260.0))]
    for scene in scenes + ([Scene(mirror=-1.0)] if legs is LEGS else []):
        for found, expected in zip(scene.planned(legs), first, strict=True):
            assert found == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("heading", [65.0, -160.0])
def test_a_dock_is_come_to_along_its_heading(heading: float) -> None:
    way, _ = Scene().planned([{**LEGS[5], "heading_deg": heading}])
    ahead = np.array([math.cos(math.radians(heading)), -math.sin(math.radians(heading))])
    assert way[-1] == pytest.approx([21.0, -13.0, -6.0])
    assert way[-1, :2] - way[-2, :2] == pytest.approx(7.0 * ahead)
