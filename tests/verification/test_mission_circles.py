"""Circles are as wide as they are asked for: the heading's lag behind its set-point in a steady turn is made up for."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.sim.guidance.steering.choice import KEEPING


def off_circle(vehicle: str, leg: dict[str, Any], radius: float, seconds: int) -> np.ndarray:
    """Distance outside of a circle about the origin [m], every second."""
    sim = pl.Simulation.load({
        "world": {"type": "flat", "depth_m": 30}, "tick_rate_hz": 20,
        "agents": {"a": {
            "vehicle": vehicle, "mission": [leg],
            "start": {"position_m": [-radius, -0.5 * radius], "depth_m": leg.get("depth_m", 0.0), "heading_deg": -70},
        }},
    })  # fmt: skip
    found = []
    for _ in range(seconds):
        sim.step(ticks=20)
        found.append(np.hypot(*sim.state["a"].position[0, :2]) - radius)
    return np.array(found)


@pytest.mark.parametrize(
    ("vehicle", "radius", "without", "way"),
    [
        ("surface_vessel", 20.0, 8.3, "clockwise"),
        ("couguv", 27.0, 4.0, "counterclockwise"),
        pytest.param("surface_vessel", 20.0, 8.3, "counterclockwise", marks=pytest.mark.slow),
        pytest.param("couguv", 27.0, 4.0, "clockwise", marks=pytest.mark.slow),
    ],
)
def test_an_orbit_has_its_radius(vehicle: str, radius: float, without: float, way: str) -> None:
    """Without the lead the circle lies `without` outside in the mean: lookahead times the tangent of the lag."""
    leg = {"type": "orbit", "center": [0, 0], "radius_m": radius, "turns": 9, "direction": way}
    if vehicle == "couguv":
        leg["depth_m"] = 10.0
    off = off_circle(vehicle, leg, radius, 170)[-60:]
    assert abs(off.mean()) < 0.15 * without
    assert np.abs(off).max() < 0.35 * without


def test_those_that_cannot_stop_keep_to_a_circle_with_room_for_a_current() -> None:
    """1.3 turning circles about the place: a torpedo at its least radius has no rudder left where the stream pushes."""
    leg = {"type": "station_keeping", "point": [0, 0], "seconds": 900, "depth_m": 10.0}
    off = off_circle("torpedo", leg, KEEPING * 20.0, 180)[-80:]
    assert np.abs(off).max() < 0.25 * 20.0


@pytest.mark.parametrize(("vehicle", "radius", "way"), [
    ("otter", 2.5, "clockwise"), pytest.param("wamv", 4.0, "counterclockwise", marks=pytest.mark.slow),
])  # fmt: skip
def test_a_craft_that_turns_on_the_spot_slows_down_on_a_small_circle(vehicle: str, radius: float, way: str) -> None:
    """At cruising speed the Otter makes no circle below 6.6 m, the WAM-V none below 11.5 m."""
    leg = {"type": "orbit", "center": [0, 0], "radius_m": radius, "turns": 9, "direction": way}
    off = off_circle(vehicle, leg, radius, 100)[-35:]
    assert np.abs(off).max() < 0.25


@pytest.mark.parametrize(("vehicle", "radius"), [("mariner", 150), ("remus100", 5), ("fixed_wing", 80)])
def test_a_circle_below_what_a_vehicle_can_turn_is_refused(vehicle: str, radius: float) -> None:
    leg = {"type": "orbit", "center": [0, 0], "radius_m": radius}
    with pytest.raises(pl.ScenarioError, match=f"smallest circle of {vehicle} at"):
        off_circle(vehicle, leg, radius, 0)
