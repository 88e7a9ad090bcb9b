"""Thrusters by a measured curve, and the loss of thrust in their own inflow."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos.errors import ScenarioError
from pelagos.vehicles.vehicle import Vehicle

BASE = {
    "type": "custom", "length_m": 1.1, "beam_m": 0.25, "height_m": 0.25,
    "mass": {"type": "explicit", "mass_kg": 14, "inertia_kg_m2": [0.2, 1.65, 1.76]},
    "added_mass": {"type": "diagonal", "diagonal": [2, 10, 14, 0.03, 0.8, 1]},
    "coriolis": {"rigid": "none"},
    "terms": {"weight": {"type": "submerged"}},
    "modes": {"actuators": {"type": "actuators"}}, "default_mode": "actuators",
}  # fmt: skip
VSP = {
    "type": "curve_thruster", "position_m": [-0.4, 0.1, 0], "direction": [0, 2, 0], "commands": [-1, -0.5, 0, 1],
    "thrusts_n": [-3, -1, 0, 2], "gain": 1.5, "speed_share": 0.8, "time_constant_s": 0.2,
}  # fmt: skip


def force(state, nu=(0, 0, 0, 0, 0, 0), **changes):
    """Sway force and yaw moment, from the acceleration times mass."""
    vehicle = Vehicle.from_dict({**BASE, "actuators": {"a": {**VSP, **changes}}})
    nu_dot, _ = vehicle.accelerations(np.zeros((1, 6)), np.array([nu]), np.array([[state]]), np.array([[0.0]]))
    wrench = vehicle.config.body.mass_matrix @ nu_dot[0]
    return wrench[1], wrench[5]


@pytest.mark.parametrize(("state", "thrust"), [(-1, -3), (-0.75, -2), (-0.2, -0.4), (0, 0), (0.3, 0.6), (1, 2), (4, 2)])
def test_thrust_follows_the_measured_points(state, thrust):
    """Straight between points, constant beyond them; by gain and by the square of the rotor's speed."""
    y, n = force(state)
    assert y == pytest.approx(1.5 * 0.64 * thrust, abs=1e-12)
    assert n == pytest.approx(-0.4 * y, abs=1e-12)


@pytest.mark.parametrize(
    ("state", "v", "r", "left"),
    [(1, 0.5, 0, 0.75), (1, 0.5, 0.5, 1 - 0.3 / 2), (-1, 0.5, 0, 1.25), (1, 3, 0, 0), (1, -9, 0, 1.5)],
)
def test_inflow_along_the_push_takes_thrust_away(state, v, r, left):
    """1 - sign(T) (v + x r) / 2 m/s, between 0 and 1.5."""
    y, _ = force(state, (0, v, 0, 0, 0, r), zero_thrust_m_s=2.0)
    assert y == pytest.approx(left * force(state)[0], abs=1e-12)


def test_commands_for_a_thrust_are_the_curve_backwards():
    curve = Vehicle.from_dict({**BASE, "actuators": {"a": VSP}}).model.actuators["a"].curve
    for command in (-0.9, -0.3, 0.2, 0.8):
        assert float(curve.speed(curve.thrust(command))) == pytest.approx(command, abs=1e-12)


def test_impossible_curves_are_refused():
    for change, said in (
        ({"commands": [-1, 0, 1]}, "as many thrusts_n as commands"),
        ({"commands": [-1, 0, 0, 1]}, "commands must rise"),
        ({"thrusts_n": [-3, -1, -2, 2]}, "thrusts_n must rise"),
        ({"direction": [0, 0, 0]}, "direction must not be"),
    ):
        with pytest.raises(ScenarioError, match=said):
            Vehicle.from_dict({**BASE, "actuators": {"a": {**VSP, **change}}})


def test_cubic_damping_is_odd_and_cubic():
    vehicle = Vehicle.from_dict(
        {**BASE, "terms": {"c": {"type": "cubic_damping", "diagonal": [1, 50, 3, 0.1, 0.2, 4]}}}
    )
    nu = np.array([[0.5, -0.4, 0.3, 0.2, -0.6, -0.7]])
    nu_dot, _ = vehicle.accelerations(np.zeros((1, 6)), nu, np.zeros((1, 0)), np.zeros((1, 0)))
    expected = -np.array([1, 50, 3, 0.1, 0.2, 4]) * nu[0] ** 3
    np.testing.assert_allclose(vehicle.config.body.mass_matrix @ nu_dot[0], expected, atol=1e-12)
