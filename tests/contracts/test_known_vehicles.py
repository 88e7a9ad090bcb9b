"""Where every vehicle is after some seconds in waves, wind and a current: in every mode under an uneven command, thrown
off its trim; and on every leg of a mission."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import pelagos as pl
from known import DOUBLE, check
from pelagos.vehicles.load import catalogue_names

AFLOAT = {
    "otter", "wamv", "surface_vessel", "mariner", "kvlcc2", "tanker", "container", "supply", "semisub", "frigate",
    "zeefakkel", "navalvessel",
}  # fmt: skip
IN_AIR = {"quadrotor", "fixed_wing"}
SEA = {
    "currents": [{"type": "uniform", "speed_mps": 0.3, "towards_deg": -65.0, "up_mps": 0.02}],
    "waves": {"type": "jonswap", "significant_height_m": 0.6, "peak_period_s": 4.7, "towards_deg": 130.0,
              "components_count": 24},
    "wind": {"speed_mps": 4.0, "from_deg": 200.0},
}  # fmt: skip


def motion(sim: pl.Simulation, start: Any, t: float) -> dict[str, Any]:
    """What changed since the start."""
    state = sim.state["it"]
    parts = ("attitude", "velocity", "angular_velocity", "actuators")
    found = {"way": np.array(state.position) - start} | {part: np.array(getattr(state, part)) for part in parts}
    return {f"{part} after {t:g} s": values for part, values in found.items()}


@pytest.mark.parametrize("name", sorted(catalogue_names()))
def test_modes(name: str) -> None:
    start = {"position_m": [3.0, -5.0], "heading_deg": 35.0, "depth_m": 0.0 if name in AFLOAT | IN_AIR else 4.0}
    scenario = {"seed": 3, "tick_rate_hz": 100, "world": {"type": "flat", "depth_m": 60.0}, "ocean": SEA}
    sim = pl.Simulation.load({**scenario, "agents": {"it": {"vehicle": name, "start": start}}})
    for mode in pl.Vehicle.from_catalogue(name).modes:
        sim.reset()
        sim.set_mode("it", mode)
        place = (3.0, -5.0, 40.0 if name in IN_AIR else 0.0 if name in AFLOAT else -4.0)
        sim.set_state(
            "it", position=place, attitude=(0.95, 0.06, -0.05, -0.3), velocity=(0.7, -0.2, 0.1),
            angular_velocity=(0.05, -0.08, 0.11),
        )  # fmt: skip
        held = np.ravel(np.asarray(sim.held_command("it"), dtype=np.float64))
        command = held + 0.05 * np.array([(-1) ** k * (1 + 0.3 * k) for k in range(len(held))])
        sim.step({"it": command[None]}, ticks=40)
        early = motion(sim, place, 0.4)
        sim.step(ticks=260)
        check("vehicles", f"{name} {mode}", early | motion(sim, place, 3.0), DOUBLE)


LEGS: dict[str, tuple[str, list[dict[str, Any]]]] = {
    "waypoints": ("remus100", [{"type": "waypoints", "points": [[18.0, -12.0], [22.0, 17.0]], "depth_m": 5.0}]),
    "goto": ("bluerov2_heavy", [{"type": "goto", "points": [[5.0, -4.0, -4.0], [1.0, 2.0, -6.0]],
                                 "heading_deg": 35.0}]),
    "station": ("otter", [{"type": "station_keeping", "point": [6.0, -4.0], "seconds": 60.0}]),
    "orbit": ("torpedo", [{"type": "orbit", "center": [24.0, 7.0], "radius_m": 21.0, "direction": "clockwise",
                               "turns": 1.25, "depth_m": 6.0}]),
    "dock": ("hovering_auv", [{"type": "dock", "point": [8.0, -5.0, -6.0], "heading_deg": 65.0, "approach_m": 4.0}]),
    "lawnmower": ("remus100", [{"type": "lawnmower", "corner": [10.0, -9.0], "heading_deg": 40.0, "length_m": 30.0,
                                "width_m": 30.0, "spacing_m": 15.0, "depth_m": 4.0}]),
    "survey": ("wamv", [{"type": "survey", "area": [[10.0, -9.0], [51.0, -30.0], [30.0, 22.0]], "heading_deg": 40.0,
                         "spacing_m": 12.0}]),
    "profile": ("glider", [{"type": "profile", "lower_depth_m": 20.0, "cycles": 1, "heading_deg": 55.0}]),
    "drift": ("bluerov2", [{"type": "drift", "seconds": 60.0}]),
    "dive": ("remus100", [{"type": "dive", "depth_m": 9.0}]),
    "surface": ("remus100", [{"type": "surface"}]),
    "hold": ("mariner", [{"type": "hold", "seconds": 60.0}]),
}  # fmt: skip


@pytest.mark.parametrize("leg", LEGS)
def test_legs(leg: str) -> None:
    vehicle, mission = LEGS[leg]
    start = {"position_m": [3.0, -2.0], "heading_deg": 25.0, "speed_mps": 0.4}
    if vehicle not in AFLOAT:
        start["depth_m"] = 4.0
    scenario = {"seed": 3, "tick_rate_hz": 50, "world": {"type": "flat", "depth_m": 60.0}, "ocean": SEA}
    sim = pl.Simulation.load({**scenario, "agents": {"it": {"vehicle": vehicle, "start": start, "mission": mission}}})
    place, found = np.array(sim.state["it"].position), dict[str, Any]()
    for t in (10, 20, 30):
        sim.run(10.0)
        found |= motion(sim, place, t)
    check("legs", leg, found, DOUBLE)
