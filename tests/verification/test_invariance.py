"""A scene that is moved and turned as a whole reads the same; its mirror image reads the mirror image.

Everything that has a place or a direction is moved: start, targets, legs, things, a mover, a neighbour, current,
waves. Nothing in the equations knows where north is or where the origin lies, so what a vehicle feels and sees in its
own frame must not change. The tolerances are those of single precision in rays (1e-4 of a range; 3 % of a picture's
pixels lie on edges) and of double precision that a closed loop has multiplied.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.math.constants import GRAVITY

SHIFTS = [((130.0, -85.0), 77.0), ((-410.0, 260.0), -141.0)]
PERIOD_S = 5.0


class Moved:
    """A turn by `heading` [deg, clockwise] about the origin, then a shift (north, west) [m]."""

    def __init__(self, shift: tuple[float, float] = (0.0, 0.0), heading: float = 0.0) -> None:
        self.shift, self.heading = np.array(shift), heading
        c, s = math.cos(math.radians(heading)), math.sin(math.radians(heading))
        self.turn = np.array([[c, s], [-s, c]])  # of (north, west): (1, 0) goes to (cos, -sin), which is that heading

    def place(self, point: list[float]) -> list[float]:
        return [*(self.turn @ point[:2] + self.shift).tolist(), *point[2:]]

    def angle(self, degrees: float) -> float:
        return (degrees + self.heading + 180.0) % 360.0 - 180.0

    def phase(self, towards: float, degrees: float) -> float:
        """Phase at the new origin of a deep-water wave that had `degrees` at the old one."""
        k = (2.0 * math.pi / PERIOD_S) ** 2 / GRAVITY
        way = math.radians(self.angle(towards))
        return degrees - math.degrees(k * float(np.array([math.cos(way), -math.sin(way)]) @ self.shift))

    def back(self, positions: np.ndarray) -> np.ndarray:
        """World positions `(..., 3)` of the moved scene in the frame of the first."""
        flat = (positions[..., :2] - self.shift) @ self.turn
        return np.concatenate([flat, positions[..., 2:]], axis=-1)


def scene(m: Moved, agents: dict[str, Any], **ocean: Any) -> dict[str, Any]:
    path = [m.place([9.0, -4.0, -4.0]), m.place([9.0, 6.0, -5.5])]
    return {
        "seed": 5,
        "tick_rate_hz": 50,
        "world": {
            "type": "flat",
            "depth_m": 12.0,
            "size_m": [1500.0, 1500.0],
            "things": [
                {
                    "shape": "box",
                    "at_m": m.place([7.0, 2.5, -8.0]),
                    "size_m": [3.0, 1.0, 8.0],
                    "orientation_deg": [0.0, 0.0, -m.angle(25.0)],
                },
                {"shape": "cylinder", "at_m": m.place([5.0, -4.0, -8.0]), "size_m": [1.2, 1.2, 8.0]},
            ],
            "movers": [
                {
                    "name": "drum",
                    "body": "cylinder",
                    "size_m": 1.0,
                    "path": {"kind": "waypoints", "points_m": path, "speed_mps": 0.5},
                }
            ],
        },
        "ocean": {
            "currents": [{"type": "uniform", "speed_mps": 0.17, "towards_deg": m.angle(-65.0)}],
            **ocean,
        },
        "agents": agents,
    }


def seen(m: Moved) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Last readings of a held ROV with things, a mover and a neighbour in view; positions seen from the first."""
    small = {"width_px": 40, "height_px": 30}
    sensors = {
        name: {"type": name, "rate_hz": 5, "position_m": [0.2, 0.05, 0.1], **more}
        for name, more in {
            "imu": {}, "depth": {}, "dvl": {}, "altimeter": {}, "depth_camera": small, "semantic_camera": small,
            "normal_camera": small, "lidar": {"rate_hz": 10}, "current_meter": {},
        }.items()
    }  # fmt: skip
    start = {"position_m": m.place([0.0, 0.0, -5.0]), "heading_deg": m.angle(12.0)}
    agents = {
        "rov": {
            "vehicle": "bluerov2_heavy", "start": start, "control": "velocity", "command": [0.2, -0.1, 0.05, 0.15],
            "sensors": sensors,
        },
        "other": {
            "vehicle": "remus100", "start": {"position_m": m.place([6.0, 0.5, -5.5]), "heading_deg": m.angle(100.0)},
            "control": "depth_heading", "command": [5.5, math.radians(m.angle(100.0)), 500.0],
        },
    }  # fmt: skip
    sim = pl.Simulation.load(scene(m, agents))
    sim.reset()
    kept: dict[str, np.ndarray] = {}
    for _ in range(30):
        obs = sim.step()
        kept |= {name: reading.data[0] for name, reading in obs["rov"].items()}
    return kept, {name: m.back(sim.state[name].position[0]) for name in agents}


@pytest.fixture(scope="module")
def first():
    return seen(Moved())


@pytest.mark.parametrize(("shift", "heading"), SHIFTS)
def test_sensors_read_the_same_wherever_the_scene_lies(first, shift, heading):
    readings, places = seen(Moved(shift, heading))
    for name, place in places.items():
        assert place == pytest.approx(first[1][name], abs=1e-9 * np.hypot(*shift) + 1e-9), name
    for name, values in readings.items():
        before = first[0][name].astype(np.float64)
        now = values.astype(np.float64)
        if name in (
            "semantic_camera",
            "normal_camera",
            "depth_camera",
            "lidar",
        ):  # a ray at an edge may fall to either side
            assert np.isclose(now, before, rtol=1e-4, atol=1e-3, equal_nan=True).mean() > 0.97, name
        else:
            assert now == pytest.approx(before, rel=1e-5, abs=1e-6, nan_ok=True), name


def voyage(m: Moved, mirror: float = 1.0) -> np.ndarray:
    """Track of an ROV through legs in current and waves, seen from the first scene, `(ticks, 3)`."""

    def at(*point: float) -> list[float]:
        return m.place([point[0], mirror * point[1], *point[2:]])

    agents = {
        "rov": {
            "vehicle": "bluerov2_heavy",
            "start": {"position_m": at(0.0, 0.0, -4.0), "heading_deg": m.angle(mirror * 20.0)},
            "mission": [
                {
                    "type": "goto",
                    "points": [at(3.0, -2.0, -5.0), at(4.5, 1.0, -4.5)],
                    "face": at(9.0, 3.0),
                    "speed_mps": 0.4,
                },
            ],
        }
    }
    waves = [
        {
            "type": "regular",
            "height_m": 0.4,
            "period_s": PERIOD_S,
            "towards_deg": m.angle(mirror * 33.0),
            "phase_deg": m.phase(mirror * 33.0, 70.0),
        }
    ]
    scenario = scene(m, agents, waves=waves)
    scenario["world"] = {"type": "flat", "depth_m": 60.0, "size_m": [1500.0, 1500.0]}
    scenario["ocean"]["currents"][0]["towards_deg"] = m.angle(mirror * -65.0)
    sim = pl.Simulation.load(scenario)
    sim.reset()
    track = []
    for _ in range(500):
        sim.step()
        track.append(sim.state["rov"].position[0].copy())
    return m.back(np.array(track))


@pytest.fixture(scope="module")
def first_voyage():
    return voyage(Moved())


@pytest.mark.parametrize(("shift", "heading"), SHIFTS[:1])
def test_a_mission_in_current_and_waves_goes_the_same_way(first_voyage, shift, heading):
    again = voyage(Moved(shift, heading))
    assert np.ptp(first_voyage[:, :2], axis=0).min() > 1.0  # it goes somewhere, both ways
    # deep-water phase at the new origin: the water is 60 m deep, tanh(k h) = 1 - 2e-9; the loop adds less than it damps
    assert np.abs(again - first_voyage).max() < 1e-5


def test_a_mirrored_mission_goes_the_mirrored_way(first_voyage):
    again = voyage(Moved(), mirror=-1.0)
    # its propellers' torques are no mirror image of one another: millimetres; a sign that is wrong makes decimetres
    assert np.abs(again * [1.0, -1.0, 1.0] - first_voyage).max() < 2e-3
