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


def test_a_tumbling_body_without_drag_keeps_energy_and_momentum():
    """100 s of free tumbling about the middle axis, added mass 5 to 20 kg: energy to rounding, momentum to h |w|.

    What steps of semi-implicit Euler call the velocity is that of half a step before: 1.4 rad/s of half 20 ms turn the
    momentum by 1.4 %, a bounded difference; with Coriolis forces of the step's beginning it was 47 % in 100 s.
    """
    h = 0.02
    mass = np.array([25.0, 32.0, 40.0, 0.5, 1.4, 1.5])
    vehicle = Vehicle.from_dict(
        {
            "type": "custom", "length_m": 1.0, "beam_m": 0.6, "height_m": 0.4, "gravity_m_s2": 0.0,
            "mass": {"type": "explicit", "mass_kg": 20.0, "inertia_kg_m2": [0.4, 0.9, 1.1]},
            "added_mass": {"type": "diagonal", "diagonal": [5, 12, 20, 0.1, 0.5, 0.4]},
            "modes": {"wrench": {"type": "wrench"}}, "default_mode": "wrench",
        }
    )  # fmt: skip
    flight = fly(vehicle, 100.0, h=h, mode="wrench", nu=(0.3, -0.2, 0.1, 0.4, -1.2, -0.5), ocean=Still())
    momentum = mass * flight.nu
    energy = 0.5 * (momentum * flight.nu).sum(axis=1)
    assert np.abs(energy / energy[0] - 1).max() < 1e-11
    w, x, y, z = flight.attitude.T
    turn = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
    linear = np.einsum("ijn,nj->ni", turn, momentum[:, :3])
    angular = np.einsum("ijn,nj->ni", turn, momentum[:, 3:]) + np.cross(flight.position, linear)
    for p in (linear, angular):
        assert (np.linalg.norm(p - p[0], axis=1) / np.linalg.norm(p[0])).max() < 0.05


def test_attitude_stays_a_rotation():
    flight = fly(Vehicle.from_catalogue("remus100"), 60.0, h=0.05, **START)
    assert np.abs(np.linalg.norm(flight.attitude, axis=1) - 1).max() < 1e-12


def test_attitude_of_a_steady_spin_is_exact():
    """Constant body rates for 10 s at 1 rad/s: the angle is rate times time, whatever the step."""
    vehicle = Vehicle.from_catalogue("remus100")
    flight = fly(vehicle, 10.0, h=0.05, mode="acceleration", nu=(0, 0, 0, 0, 0, 1.0))
    assert flight.euler[-1, 2] == pytest.approx(np.angle(np.exp(10j)), abs=1e-10)
