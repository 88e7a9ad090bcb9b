"""The MMG standard model against its paper's equations, written out by hand for the catalogue's tanker."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos import Vehicle
from pelagos.errors import ScenarioError
from pelagos.manoeuvres import run_manoeuvre
from pelagos.manoeuvres.orders import Orders


def by_hand(u, v, r, delta):
    """u', v', r' by Yasukawa and Yoshimura 2015, Eqs. 4 to 24, KVLCC2 at full scale."""
    rho, length, d, volume, xg = 1025.0, 320.0, 20.8, 320415000 / 1025, 11.2
    speed = np.hypot(u, v)
    vn, rn, beta = v / speed, r * length / speed, np.arctan(-v / u)
    q = 0.5 * rho * length * d * speed**2
    x = q * (-0.022 - 0.040 * vn**2 + 0.002 * vn * rn + 0.011 * rn**2 + 0.771 * vn**4)
    y = q * (-0.315 * vn + 0.083 * rn - 1.607 * vn**3 + 0.379 * vn**2 * rn - 0.391 * vn * rn**2 + 0.008 * rn**3)
    n = -0.137 * vn - 0.049 * rn - 0.030 * vn**3 - 0.294 * vn**2 * rn + 0.055 * vn * rn**2 - 0.013 * rn**3
    n *= q * length
    revolutions, dp = 1.777, 9.86
    beta_p = beta + 0.48 * rn
    straight = 1 + (1 - np.exp(-2.0 * abs(beta_p))) * ((1.6 if beta_p > 0 else 1.1) - 1)
    inflow = u * (1 - 0.35) * straight
    j = inflow / (revolutions * dp)
    kt = 0.2931 - 0.2753 * j - 0.1385 * j**2
    x += (1 - 0.220) * rho * revolutions**2 * dp**4 * kt
    beta_r = beta + 0.710 * rn
    v_r = speed * (0.640 if beta_r > 0 else 0.395) * beta_r
    eta = dp / 15.8
    u_r = 1.09 * inflow * np.sqrt(eta * (1 + 0.5 * (np.sqrt(1 + 8 * kt / (np.pi * j**2)) - 1)) ** 2 + 1 - eta)
    normal = 0.5 * rho * 112.5 * (u_r**2 + v_r**2) * 2.747 * np.sin(delta - np.arctan(v_r / u_r))
    x -= (1 - 0.387) * normal * np.sin(delta)
    y -= (1 + 0.312) * normal * np.cos(delta)
    n -= (-0.5 - 0.312 * 0.464) * length * normal * np.cos(delta)
    m, q0 = rho * volume, 0.5 * rho * length**2 * d
    mx, my, jz = 0.022 * q0, 0.223 * q0, 0.011 * q0 * length**2
    izz = m * (0.25 * length) ** 2 + xg**2 * m
    surge = (x + (m + my) * v * r + xg * m * r**2) / (m + mx)
    lateral = [[m + my, xg * m], [xg * m, izz + jz]]
    return surge, *np.linalg.solve(lateral, [y - (m + mx) * u * r, n - xg * m * u * r])


@pytest.mark.parametrize(
    ("u", "v", "r", "delta"), [(7.5, 0.4, -0.004, -0.21), (6.1, -1.3, 0.006, 0.55), (7.9, 0.02, 0.0001, 0.0)]
)
def test_accelerations_are_those_of_the_papers_equations(u, v, r, delta):
    """Sway and roll couple through the height of the centre of gravity, of which the plane model knows nothing: it is
    put into the waterline here. Added masses and inertias are those of the file, given to five digits."""
    level = {"type": "kvlcc2", "mass": {"center_of_gravity_m": [11.2, 0, 0]}}
    ship = Vehicle.from_dict(level)
    nu_dot, _ = ship.accelerations([[0] * 6], [[u, v, 0, 0, 0, r]], [[delta]], [[delta]])
    assert nu_dot[0, [0, 1, 5]] == pytest.approx(by_hand(u, v, r, delta), rel=5e-4, abs=2e-8)


@pytest.mark.parametrize(
    ("u", "v", "share"),
    [(5.0, 2.0, 1.0), (-3.0, 1.5, -1.0), (0.3, -0.2, 1.0), (0.1, 3.0, 2 / np.hypot(0.1, 3.0)), (0.0, 4.0, 0.0)],
)
def test_resistance_goes_with_the_whole_speed_and_against_the_way(u, v, share):
    """Eq. 8: rho/2 L d U^2 R0; a hull of twice the resistance is slowed by as much again, whatever its drift.

    Nearly abeam by (u/U)/0.05 of it.
    """
    slowed = []
    for resistance in (0.022, 0.044):
        ship = Vehicle.from_catalogue("kvlcc2", actuators={"rudder": {"hull": {"R0": resistance}}})
        slowed.append(ship.accelerations([[0] * 6], [[u, v, 0, 0, 0, 0.002]], [[0.1]], [[0.1]])[0][0])
    mass = np.array(ship.model.inertia.rigid, float) + np.array(ship.model.inertia.added, float)
    force = (mass @ (slowed[1] - slowed[0]))[0]
    assert force == pytest.approx(-0.5 * 1025 * 320 * 20.8 * 0.022 * (u * u + v * v) * share, rel=1e-6, abs=1.0)


def test_the_engine_holds_the_service_speed():
    """Thrust less deduction equals resistance at 15.5 knots: the surge left is below 0.2 % of the resistance's."""
    ship = Vehicle.from_catalogue("kvlcc2")
    nu_dot, _ = ship.accelerations([[0] * 6], [[7.97, 0, 0, 0, 0, 0]], [[0.0]], [[0.0]])
    resistance = 0.5 * 1025 * 320 * 20.8 * 7.97**2 * 0.022 / (320415000 + 2.4014e7)
    assert abs(nu_dot[0, 0]) < 0.002 * resistance


def test_starboard_and_port_differ_only_by_the_wake_and_the_rudders_inflow():
    """Straight ahead both gammas and both C2 drop out: the helm turns to either side alike."""
    ship = Vehicle.from_catalogue("kvlcc2")
    there = [ship.accelerations([[0] * 6], [[7.0, 0, 0, 0, 0, 0]], [[d]], [[d]])[0][0] for d in (0.3, -0.3)]
    assert there[0][[0, 1, 5]] == pytest.approx(there[1][[0, 1, 5]] * [1, -1, -1], rel=1e-9)
    assert there[0][5] > 0  # to starboard


def test_a_missing_derivative_is_named():
    with pytest.raises(ScenarioError, match=r"hull: give each of R0, .*not so: Ywrong"):
        Vehicle.from_catalogue("kvlcc2", actuators={"rudder": {"hull": {"Ywrong": 1.0}}})


@pytest.mark.slow  # 40 s
def test_turning_circle():
    """Within IMO's limits; advance and tactical diameter as the page on manoeuvres has them."""
    found = {m.name: m.value for m in run_manoeuvre({"type": "kvlcc2"}, "turning", Orders()).measures}
    assert found["advance"] == pytest.approx(2.98, abs=0.01)
    assert found["tactical diameter"] == pytest.approx(3.00, abs=0.01)
