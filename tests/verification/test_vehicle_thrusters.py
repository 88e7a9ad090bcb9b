"""T200 tables, lags, battery, allocation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from vehicle_flight import fly

from pelagos import jit
from pelagos.vehicles.actuators import t200
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.actuators.third_order import VON_BENZON, Modes, ThirdOrder
from pelagos.vehicles.control.allocation import allocation_of
from pelagos.vehicles.vehicle import Vehicle

TABLES = t200.t200_tables


def thrust(us, volts):
    throttle = jit.Float64((np.asarray(us, dtype=float) - 1500) / 400)
    return np.array(t200.table_thrust(throttle, jit.Float64(volts), TABLES(16.0)))


@pytest.mark.parametrize("row", range(6))
def test_every_point_of_the_table(row):
    table = t200.measured()[row]
    assert thrust(table[:, 0], t200.VOLTAGES[row]) == pytest.approx(table[:, 5] * 9.80665, abs=1e-9)


def test_voltage_labels():
    """1900 us at 16 V gives 5.2450 kgf (a circulating copy of the table has another curve under this label)."""
    assert float(thrust([1900], 16.0)[0]) / 9.80665 == pytest.approx(5.2450, abs=5e-5)
    assert float(thrust([1700], 18.0)[0]) == pytest.approx(float(thrust([1700], 20.0)[0]), rel=1e-9)


def test_dead_band_and_ends():
    assert (thrust(np.arange(1472, 1529, 4), 16.0) == 0).all()
    assert thrust([1000, 2200], 16.0) == pytest.approx(thrust([1100, 1900], 16.0))
    assert thrust([1800], 25.0) == pytest.approx(thrust([1800], 20.0))


def test_between_points():
    """Half way between two rows and columns: the mean of the four, and within 0.02 kgf of each side's mean."""
    t = t200.measured()[3, :, 5] * 9.80665
    got = thrust(t200.measured()[3, :-1, 0] + 2, 16.0)
    assert got == pytest.approx((t[:-1] + t[1:]) / 2, abs=1e-9)


def test_inverse_for_control_laws():
    """Thrust from 1 N to nine tenths of the largest: within 6 % of what was asked, or 0.5 N."""
    rov = Vehicle.from_catalogue("bluerov2_heavy").model.actuators["front_port"]
    for sign, limit in ((1, rov.thrust_limits[1]), (-1, -rov.thrust_limits[0])):
        wanted = sign * np.linspace(1.0, 0.9 * limit, 40)
        throttle = np.array(rov.command(jit.Float64(wanted)))
        got = thrust(1500 + 400 * throttle, 16.0)
        assert (np.abs(got - wanted) < np.maximum(0.5, 0.06 * np.abs(wanted))).all()


def test_battery_sags_under_load():
    """V = E - R I(V): to 0.25 V at a quarter of sag, against the table interpolated in voltage."""
    battery = t200.Battery(16.0, 0.03, t200.current_exponent())
    for throttle in (0.0, 0.5, 1.0):
        volts = float(battery.voltage([jit.Float64(throttle)] * 8, TABLES(16.0))[0])
        column = t200.measured()[:, round(100 + 100 * throttle), 2]
        drawn = 8 * np.interp(volts, t200.VOLTAGES, column)
        assert volts == pytest.approx(16.0 - 0.03 * drawn, abs=0.25)
    assert float(battery.voltage([jit.Float64(0.0)] * 8, TABLES(16.0))[0]) == 16.0


@pytest.mark.parametrize("h", [0.001, 0.02, 0.5])
def test_lag_does_not_depend_on_the_step(h):
    """After one time constant the distance is 1/e, exactly, in any number of steps."""
    lag, state = Lag(0.5, -10.0, 10.0), jit.Float64(0.0)
    for _ in range(round(0.5 / h)):
        state = lag.advanced(state, jit.Float64(1.0), h)
    assert float(state[0]) == pytest.approx(1 - math.exp(-1), rel=1e-9)


def test_rate_limit_and_saturation():
    lag, state = Lag(0.0, -0.3, 0.3, rate_limit=0.1), jit.Float64(0.0)
    for k in range(5):
        state = lag.advanced(state, jit.Float64(9.0), 1.0)
        assert float(state[0]) == pytest.approx(min(0.1 * (k + 1), 0.3))


def response(seconds: float, h: float, command: float = 1.0) -> np.ndarray:
    """The throttle of von Benzon's thruster after every step of h, from rest, with a constant command."""
    follower = ThirdOrder(Modes.of(*VON_BENZON), -1.0, 1.0)
    state, kept, found = jit.Float64(0.0), [jit.Float64(0.0)] * 2, [0.0]
    for _ in range(round(seconds / h)):
        state, *kept = follower.after(state, kept, jit.Float64(command), jit.Float64(h))
        found.append(float(state[0]))
    return np.array(found)


def test_poles_of_the_third_order():
    modes = Modes.of(*VON_BENZON)
    assert modes.real[0] == pytest.approx(-13.160, abs=1e-3)
    assert modes.pair[0] == pytest.approx(-37.920 + 82.596j, abs=1e-3)
    assert modes.real[1] + 2 * modes.pair[1].real == pytest.approx(0, abs=1e-9)  # two poles more than zeros


def test_step_response_of_the_third_order():
    """H(s) = (6136 s + 108700)/(s^3 + 89 s^2 + 9258 s + 108700): 63.2 % at 20.0 ms, 90 % first at 29.3 ms, 0.9579 at
    50 ms, 0.9220 at 100 ms (it dips), never above 1, and 1 in the end."""
    y = response(1.0, 1e-4)
    assert np.argmax(y >= 0.632) * 1e-4 == pytest.approx(0.0200, abs=1e-4)
    assert np.argmax(y >= 0.9) * 1e-4 == pytest.approx(0.0293, abs=1e-4)
    assert y[[500, 1000]] == pytest.approx([0.9579, 0.9220], abs=5e-5)
    assert y.max() < 1
    assert y[-1] == pytest.approx(1, abs=1e-5)


@pytest.mark.parametrize("h", [0.001, 0.02, 0.05])
def test_third_order_does_not_depend_on_the_step(h):
    fine = response(0.2, 1e-3, 0.5)
    assert response(0.2, h, 0.5) == pytest.approx(fine[:: round(h / 1e-3)], abs=1e-12)


def test_third_order_against_its_differential_equation():
    """`rates` and `after` are one system: the derivative at the start of a step, against a difference of 10 ns."""
    follower = ThirdOrder(Modes.of(*VON_BENZON), -1.0, 1.0)
    state, kept, u = jit.Float64(0.3), [jit.Float64(0.1), jit.Float64(-0.05)], jit.Float64(0.8)
    slopes = [float(r[0]) for r in follower.rates(state, kept, u)]
    after = follower.after(state, kept, u, jit.Float64(1e-8))
    differences = [(float(a[0]) - float(b[0])) / 1e-8 for a, b in zip(after, [state, *kept], strict=True)]
    assert slopes == pytest.approx(differences, rel=1e-4)


@pytest.mark.parametrize("integrator", ["semi_implicit", "runge_kutta"])
def test_a_vehicle_with_third_order_thrusters(integrator):
    """Its throttles follow H(s); it accelerates sooner than with a lag of 0.1 s, to about the same speed."""
    full = {"mode": "actuators", "command": [0.5] * 4 + [0] * 4}
    quick = Vehicle.from_catalogue("bluerov2_heavy", variant="third_order_thrusters", integrator=integrator)
    slow = Vehicle.from_catalogue("bluerov2_heavy", variant="slow_thrusters", integrator=integrator)
    flights = [fly(v, 10.0, h=0.02, **full) for v in (quick, slow)]
    assert flights[0].actuators[:11, 0] == pytest.approx(response(0.2, 0.02, 0.5), abs=1e-12)
    assert flights[0].nu[5, 0] > 1.2 * flights[1].nu[5, 0]
    assert flights[0].nu[-1, 0] == pytest.approx(flights[1].nu[-1, 0], rel=0.03)


@pytest.mark.parametrize("name", ["bluerov2_heavy", "hovering_auv"])
def test_allocation_gives_the_wrench_and_the_smallest_norm(name):
    model = Vehicle.from_catalogue(name).model
    allocation = allocation_of(model, range(6))
    effects = np.array([t.effect for t in allocation.thrusters.values()]).T
    wanted = np.array([10.0, -5.0, 4.0, 0.3, -0.5, 1.0])
    got = np.array([float(f[0]) for f in allocation.thrusts([jit.Float64(w) for w in wanted])])
    assert effects @ got == pytest.approx(wanted, abs=1e-9)
    assert got == pytest.approx(np.linalg.pinv(effects) @ wanted, abs=1e-9)


def test_saturated_allocation_keeps_the_direction():
    allocation = allocation_of(Vehicle.from_catalogue("hovering_auv").model, range(6))
    effects = np.array([t.effect for t in allocation.thrusters.values()]).T
    wanted = np.array([900.0, 300.0, 0.0, 0.0, 0.0, 20.0])
    got = np.array([float(f[0]) for f in allocation.thrusts([jit.Float64(w) for w in wanted])])
    wrench = effects @ got
    assert np.abs(got).max() == pytest.approx(77.55)
    assert wrench / np.linalg.norm(wrench) == pytest.approx(wanted / np.linalg.norm(wanted), abs=1e-9)


def test_reaction_torque_exists():
    """One vertical pair with the same hand turns the vehicle in yaw."""
    flight = fly(
        Vehicle.from_catalogue("bluerov2_heavy"), 1.0, mode="actuators", command=[0, 0, 0, 0, 0.8, -0.8, -0.8, 0.8]
    )
    assert abs(flight.nu[-1, 5]) > 0.05


def test_saturation_by_priority():
    """Upright, then depth, then heading are given whole while the way ahead takes what is left, in its direction."""
    allocation = allocation_of(Vehicle.from_catalogue("hovering_auv").model, range(6))
    effects = np.array([t.effect for t in allocation.thrusters.values()]).T
    wanted = np.array([900.0, -300.0, 40.0, 3.0, -5.0, 12.0])
    thrusts, shares = allocation.prioritised([jit.Float64(w) for w in wanted])
    wrench = effects @ np.array([float(f[0]) for f in thrusts])
    assert wrench[2:] == pytest.approx(wanted[2:], abs=1e-9)
    share = float(shares[0][0])
    assert 0 < share < 0.5
    assert wrench[:2] == pytest.approx(share * wanted[:2], abs=1e-9)
    assert np.abs([float(f[0]) for f in thrusts]).max() == pytest.approx(77.55)
    more = [jit.Float64(w) for w in (0.0, 0.0, 0.0, 0.0, 500.0, 0.0)]
    assert float(allocation.prioritised(more)[1][4][0]) < 1  # and the first of all is cut where it must be
