"""T200 tables, lags, battery, allocation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from vehicle_flight import fly

from pelagos import jit
from pelagos.vehicles.actuators import t200
from pelagos.vehicles.actuators.lag import Lag
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
