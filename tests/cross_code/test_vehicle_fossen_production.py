"""The production step against Fossen's recorded runs: both are first-order approximations of one motion."""

from __future__ import annotations

import numpy as np
import pytest
from fossen_euler import current_ned, replay, table
from vehicle_flight import Still, fly

from pelagos.vehicles.vehicle import Vehicle

TURN = (0.087266462599716474, 0.0, 1200.0)


@pytest.fixture(scope="module")
def remus() -> Vehicle:
    return Vehicle.from_catalogue("remus100").published


def test_fossen_loop_and_production_step_converge_to_one_motion(remus):
    """The distance of the two ends halves with the step: it is the sum of two first-order errors."""
    apart = []
    for h in (0.02, 0.01, 0.005):
        euler = replay(remus, round(10 / h), round(10 / h), command=lambda t: TURN, h=h)[-1]
        flight = fly(remus, 10.0, h=h, mode="actuators", command=TURN, position=(0, 0, 0))
        apart.append(np.abs(flight.position[-1] - euler[1:4]).max() + np.abs(flight.nu[-1] - euler[7:13]).max())
    assert apart[0] < 0.03
    assert apart[2] < 0.6 * apart[1] < 0.36 * apart[0]


def test_recorded_turn(remus):
    """The steady turn of the recording: speeds to 1e-6, since it has no step error; track to 4 cm in 84 m."""
    _, rows = table("remus_turn_r5_1200")
    flight = fly(remus, rows[-1, 0], h=0.02, mode="actuators", command=TURN, position=(0, 0, 0))
    assert np.abs(flight.nu[-1] - rows[-1, 7:13]).max() < 2e-5
    assert np.abs(flight.position[-1] - rows[-1, 1:4]).max() < 0.04


def test_recorded_mission_with_autopilot_in_a_current(remus):
    """Depth 30 m, heading 50 deg, 0.5 m/s towards 170 deg, 200 s: the end within 5 cm and 1e-3 rad."""
    _, rows = table("remus_main_example")
    north, east, _ = current_ned(0.5, 170.0)
    flight = fly(
        remus,
        200.0,
        h=0.02,
        mode="depth_heading",
        command=(30.0, np.deg2rad(50), 1525.0),
        position=(0, 0, 0),
        ocean=Still((north, -east, 0.0)),
    )
    assert np.abs(flight.position[-1] - rows[-1, 1:4]).max() < 0.05
    assert np.abs(flight.euler[-1] - rows[-1, 4:7]).max() < 1e-3
    assert np.abs(flight.nu[-1] - rows[-1, 7:13]).max() < 1e-3
