"""The production integrators converge with their declared order, to the motion that Fossen's loop converges to."""

from __future__ import annotations

import numpy as np
import pytest
from vehicle_flight import Still, fly, quaternion

from pelagos.vehicles.vehicle import Vehicle

START = {
    "mode": "actuators",
    "command": (0.08, -0.05, 1300.0),
    "actuators": (0.02, 0.0, 1000.0),
    "nu": (1.2, 0.1, -0.05, 0.05, 0.02, -0.03),
    "attitude": tuple(quaternion(0.1, -0.2, 0.7)),
    "ocean": Still((0.3, -0.2, 0.0)),
}


def end(h: float, integrator: str) -> np.ndarray:
    vehicle = Vehicle.from_catalogue("remus100", integrator=integrator)
    flight = fly(vehicle, 4.0, h=h, **START)
    return np.concatenate([flight.position[-1], flight.attitude[-1], flight.nu[-1]])


@pytest.fixture(scope="module")
def truth() -> np.ndarray:
    return end(0.00125, "runge_kutta")


@pytest.mark.parametrize(
    ("integrator", "order", "h"), [("semi_implicit", 1, 0.01), ("conservative", 1, 0.01), ("runge_kutta", 4, 0.1)]
)
def test_order_of_convergence(truth, integrator, order, h):
    """Halving the step divides the error by 2^order, within 15 %."""
    errors = [np.linalg.norm(end(step, integrator) - truth) for step in (h, h / 2)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2 * max(1, order / 4))


def test_attitude_stays_a_rotation():
    flight = fly(Vehicle.from_catalogue("remus100"), 60.0, h=0.05, **START)
    assert np.abs(np.linalg.norm(flight.attitude, axis=1) - 1).max() < 1e-12


def test_attitude_of_a_steady_spin_is_exact():
    """Constant body rates for 10 s at 1 rad/s: the angle is rate times time, whatever the step."""
    vehicle = Vehicle.from_catalogue("remus100")
    flight = fly(vehicle, 10.0, h=0.05, mode="acceleration", nu=(0, 0, 0, 0, 0, 1.0))
    assert flight.euler[-1, 2] == pytest.approx(np.angle(np.exp(10j)), abs=1e-10)
