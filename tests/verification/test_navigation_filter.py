"""The error-state filter: Jacobians against differences, an ideal inertial unit, and consistency over many seeds."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import chi2

import pelagos as pl
from pelagos.errors import ScenarioError
from pelagos.math.rotation import apply, conjugate, from_vector, product, skew, to_vector
from pelagos.math.so3 import matrix_np
from pelagos.navigation import measurement
from pelagos.navigation.error_state import SIZE, InertialNoise, Lanes, SlowNoise
from pelagos.sim.guidance.aboard import Fix
from pelagos.sim.navigator import External

QUIET = InertialNoise(0, 0, 0, 0, 0, 0, 0, 0)
SLOW = SlowNoise((0.0,) * 7, (300.0,) * 3 + (1e9,) * 4)
LEVER = np.array([0.4, -0.2, 0.15])
TURN = matrix_np(from_vector(np.array([[0.3, -0.5, 1.1]])))[0]
FIELD = np.array([22e-6, -1.5e-6, -42e-6])
BEACON = np.array([40.0, -25.0, -18.0])


def lanes() -> Lanes:
    """Three lanes with nothing zero and nothing equal."""
    rng = np.random.default_rng(5)
    q = from_vector(rng.normal(size=(3, 3)))
    made = Lanes.at(rng.normal(size=(3, 3)) * 9, rng.normal(size=(3, 3)), q, np.full(SIZE, 1e-3))
    made.gyroscope, made.accelerometer = 1e-3 * rng.normal(size=(3, 3)), 1e-2 * rng.normal(size=(3, 3))
    made.slow = rng.normal(size=(3, 7)) * [2, 2, 3, 0.02, 1e-7, 1e-7, 1e-7]
    made.rate = rng.normal(size=(3, 3)) * 0.2
    return made


def moved(start: Lanes, column: int, by: float) -> Lanes:
    """The same with one error added to the truth that the lanes stand for."""
    error = np.zeros((3, SIZE))
    error[:, column] = by
    made = Lanes(**{k: v.copy() for k, v in vars(start).items()})
    made.position += error[:, 0:3]
    made.velocity += error[:, 3:6]
    made.attitude = product(made.attitude, from_vector(error[:, 6:9]))
    made.rate = made.rate - error[:, 9:12]
    made.gyroscope, made.accelerometer = made.gyroscope + error[:, 9:12], made.accelerometer + error[:, 12:15]
    made.slow = made.slow + error[:, 15:]
    return made


MODELS = {
    "dvl": lambda x: measurement.bottom_velocity(x, np.zeros((3, 3)), LEVER, TURN),
    "gps": lambda x: measurement.satellite_position(x, np.zeros((3, 3)), LEVER),
    "depth": lambda x: measurement.depth(x, np.zeros(3), LEVER),
    "magnetometer": lambda x: measurement.magnetic_field(x, np.zeros((3, 3)), FIELD, TURN),
    "range": lambda x: measurement.beacon_range(x, np.zeros(3), LEVER, BEACON),
    "place": lambda x: measurement.beacon_place(x, np.zeros((3, 3)), LEVER, TURN, BEACON, np.array([0.5, 0.3, 0.8])),
}


@pytest.mark.parametrize("name", MODELS)
def test_jacobians_of_measurements(name):
    """Central differences of what is expected (minus the innovation of a reading of 0), each error in turn."""
    start = lanes()
    jacobian, _ = MODELS[name](start)
    unit = 1e-6 if name == "magnetometer" else 1.0
    for column in range(SIZE):
        h = 1e-9 if column >= 19 else 1e-5
        up, down = (MODELS[name](moved(start, column, s * h))[1] for s in (1, -1))
        assert jacobian[:, :, column] == pytest.approx(-(up - down) / (2 * h), abs=2e-6 * unit, rel=2e-5)


def test_transition_of_errors():
    """F against differences of two predicted nominal states; the covariance of one error shows F's columns."""
    rng = np.random.default_rng(6)
    force, rate, h = rng.normal(size=(3, 3)) + np.array([0, 0, 9.8]), 0.3 * rng.normal(size=(3, 3)), 0.01
    for column in range(SIZE):
        tiny = 1e-9 if column >= 19 else 1e-6
        first, second = lanes(), moved(lanes(), column, tiny)
        first.covariance = np.zeros((3, SIZE, SIZE))
        first.covariance[:, column, column] = 1.0
        for one in (first, second):
            one.predict(force, rate, h, QUIET, SLOW)
        turned = to_vector(product(conjugate(first.attitude), second.attitude))
        parts = [second.position - first.position, second.velocity - first.velocity, turned]
        parts += [second.gyroscope - first.gyroscope, second.accelerometer - first.accelerometer]
        found = np.concatenate([*parts, second.slow - first.slow], axis=1) / tiny
        expected = np.sqrt(np.diagonal(first.covariance, axis1=1, axis2=2))
        assert np.abs(found) == pytest.approx(expected, abs=2e-3, rel=5e-3)


def test_rotations():
    v = np.array([[0.3, -0.4, 0.5], [-2.0, 1.0, 0.7]])
    assert to_vector(from_vector(v)) == pytest.approx(v, abs=1e-12)
    u = np.array([[1.0, 2.0, -3.0], [0.5, -1.0, 4.0]])
    assert apply(skew(v), u) == pytest.approx(np.cross(v, u))
    q, p = from_vector(v), from_vector(u[::-1])
    assert matrix_np(product(q, p)) == pytest.approx(matrix_np(q) @ matrix_np(p))


def test_a_measurement_beyond_the_gate_is_refused():
    start = lanes()
    h, y = measurement.depth(start, start.slow[:, 3] - start.position[:, 2], np.zeros(3))
    noise = np.full((3, 1, 1), 1e-4)
    before = start.position.copy()
    start.update(h, y + np.array([[0.5], [0.01], [0.01]]), noise, np.array([True, True, False]), gate=25.0)
    assert (start.position[0] == before[0]).all()  # 50 standard deviations
    assert start.position[1, 2] < before[1, 2] - 1e-5  # deeper than thought
    assert (start.position[2] == before[2]).all()  # no reading


def test_a_measurement_adds_its_information():
    """P^-1 + H^T R^-1 H, by which it moves the errors; lanes that refuse it or have none stay. Two numbers: the gate is
    for the mean of their squares.
    """
    rng, start = np.random.default_rng(9), lanes()
    root, h, y = rng.normal(size=(3, SIZE, SIZE)), rng.normal(size=(3, 2, SIZE)), 0.3 * rng.normal(size=(3, 2))
    p, noise = root @ np.swapaxes(root, 1, 2) + np.eye(SIZE), np.array([[0.5, 0.1], [0.1, 0.2]]) * np.ones((3, 1, 1))
    start.covariance, y[1] = p.copy(), 900.0
    before = start.take(slice(None))
    squared = y[0] @ np.linalg.inv(h[0] @ p[0] @ h[0].T + noise[0]) @ y[0]
    start.update(h, y, noise, np.array([True, True, False]), gate=squared / 1.5)
    told = h[0].T @ np.linalg.inv(noise[0])
    left = np.linalg.inv(np.linalg.inv(p[0]) + told @ h[0])
    error = left @ told @ y[0]
    turned = to_vector(product(conjugate(before.attitude), start.attitude))
    changed = ("position", "velocity", "gyroscope", "accelerometer", "slow")
    by = {key: vars(start)[key] - vars(before)[key] for key in changed}
    found = np.concatenate([by["position"], by["velocity"], turned, *(by[key] for key in changed[2:])], axis=1)
    assert found[0] == pytest.approx(error, rel=1e-7, abs=1e-9)
    assert np.abs(found[1:]).max() < 1e-12
    anew = np.eye(SIZE)
    anew[6:9, 6:9] -= 0.5 * skew(error[None, 6:9])[0]
    assert start.covariance[0] == pytest.approx(anew @ left @ anew.T, rel=1e-7, abs=1e-9)
    assert start.covariance[1:] == pytest.approx(p[1:], rel=1e-9)


@pytest.mark.parametrize("heading", [0.6, -2.2])
def test_a_solution_from_outside_is_level_and_looks_along_its_heading(heading):
    """Compass headings turn to the right of north; y is west."""
    fix = Fix(np.array([[1.0, -2.0, -3.0]]), np.array([heading]), np.array([[0.4, -0.3, 0.1]]))
    position, attitude, velocity = External(fix).motion
    assert matrix_np(attitude)[0, :, 0] == pytest.approx([math.cos(heading), -math.sin(heading), 0.0])
    assert matrix_np(attitude)[0, :, 2] == pytest.approx([0.0, 0.0, 1.0])
    assert (position[0] == [1.0, -2.0, -3.0]).all()
    assert (velocity[0] == [0.4, -0.3, 0.1]).all()


def test_a_solution_from_outside_is_kept_and_begins_anew_copy_by_copy():
    rng = np.random.default_rng(3)
    made = [External(Fix(rng.normal(size=(3, 3)), rng.normal(size=3), rng.normal(size=(3, 3)))) for _ in range(2)]
    kept, fresh = (one.memory() for one in made)
    where = np.array([False, True, False])
    mixed = made[0].renewed(kept, fresh, where)
    made[1].recall(mixed)
    for part in ("position", "heading", "velocity"):
        found = getattr(made[1].fix, part)
        np.testing.assert_array_equal(found[~where], kept[part][~where])
        np.testing.assert_array_equal(found[where], fresh[part][where])
    assert (made[1].rate == np.zeros((3, 3))).all()


# in the simulator

SENSORS = {
    "imu": {"type": "imu", "rate_hz": 100, "position_m": [0.1, 0.05, -0.02]},
    "dvl": {"type": "dvl", "rate_hz": 5, "position_m": [-0.2, 0, -0.1], "orientation_deg": [0, 0, 45]},
    "depth": {"type": "depth", "rate_hz": 10},
    "gps": {"type": "gps", "rate_hz": 1, "position_m": [-0.4, 0, 0.2]},
    "magnetometer": {"type": "magnetometer", "rate_hz": 10},
}
PERFECT = {
    f"{which}_{what}": 0
    for which in ("accelerometer", "gyroscope")
    for what in ("noise_density", "bias_instability", "bias_std", "scale_std", "resolution")
} | {"misalignment_std": 0}


def scenario(mission, sensors=SENSORS, navigation="ekf", **start):
    start = {"position_m": [0, 0], "depth_m": 0, "speed_mps": 1.0, **start}
    return {
        "tick_rate_hz": 100, "duration_s": 900, "origin": {"latitude_deg": 45, "longitude_deg": 13},
        "world": {"type": "flat", "depth_m": 20},
        "ocean": {"currents": [{"type": "uniform", "speed_mps": 0.2, "towards_deg": 60}]},
        "agents": {"a": {"vehicle": "remus100", "start": start,
                         "navigation": navigation, "mission": mission, "sensors": sensors}},
    }  # fmt: skip


def lap(depth):
    return [{"type": "gps_fix", "timeout_s": 5},
            {"type": "waypoints", "points": [[40, 0], [40, -40], [0, -40], [0, 0]], "depth_m": depth},
            {"type": "repeat", "times": 20, "last": 1}]  # fmt: skip


def errors(sim):
    """True less estimated position, velocity and attitude of the inertial unit `(n, 9)`, and its covariance."""
    sim.stepper.missions.commands(sim.stepper.tick, {n: r.row for n, r in sim.stepper.runs.items()})
    state, found = sim.state["a"], sim.stepper.missions.navigators["a"].lanes
    arm = np.broadcast_to(SENSORS["imu"]["position_m"], (sim.n, 3))
    r = matrix_np(state.attitude)
    velocity = apply(r, state.velocity + np.cross(state.angular_velocity, arm))
    turn = to_vector(product(conjugate(found.attitude), state.attitude))
    position = state.position + apply(r, arm)
    error = np.concatenate([position - found.position, velocity - found.velocity, turn], axis=1)
    return error, found.covariance[:, :9, :9]


def test_an_ideal_inertial_unit_alone_knows_the_way():
    """Dives and turns for 30 s without any aid; what is left is the step's own error (2 cm measured)."""
    exact = {f"start_{k}": 0 for k in ("position_std_m", "velocity_std_mps", "level_std_deg", "heading_std_deg")}
    sensors = {"imu": {**SENSORS["imu"], **PERFECT}}
    sim = pl.Simulation.load(scenario(lap(5), sensors, {"type": "ekf", **exact}))
    sim.run(seconds=30)
    error, _ = errors(sim)
    assert np.abs(error[0, :3]).max() < 0.05
    assert np.abs(error[0, 6:]).max() < 1e-4
    position, _, velocity = sim.stepper.missions.navigators["a"].motion  # of the vehicle's origin, 11 cm from the unit
    state = sim.state["a"]
    np.testing.assert_allclose(state.position - position, error[:, :3], atol=1e-4)
    np.testing.assert_allclose(apply(matrix_np(state.attitude), state.velocity) - velocity, error[:, 3:6], atol=1e-3)


def consistency(n, seconds, every, seed):
    """Mean normalised errors squared `(times,)` of n copies, and the share within three standard deviations."""
    sim = pl.Simulation.load(scenario(lap(5)), n=n, seed=seed)
    found, within = [], []
    for _ in range(round(seconds / every)):
        sim.run(seconds=every)
        error, p = errors(sim)
        found.append((error[:, None] @ np.linalg.inv(p) @ error[..., None])[:, 0, 0].mean())
        within.append(np.abs(error) < 3 * np.sqrt(np.diagonal(p, axis1=1, axis2=2)))
    return np.array(found), np.mean(within)


def test_the_estimator_is_as_wrong_as_it_says():
    """NEES of 9 errors over 20 copies: chi-square of 180 degrees of freedom over 20, 99.9 % bounds."""
    found, within = consistency(20, 30.0, 15.0, seed=11)
    low, high = chi2.ppf([0.0005, 0.9995], 9 * 20) / 20
    assert ((low < found) & (found < high)).all(), found
    assert within > 0.985


@pytest.mark.slow
def test_the_estimator_is_consistent_over_a_hundred_seeds():
    found, within = consistency(100, 180.0, 20.0, seed=12)
    low, high = chi2.ppf([0.0005, 0.9995], 9 * 100) / 100
    assert ((low < found) & (found < high)).all(), found
    assert within > 0.99


@pytest.mark.slow  # 4 s
def test_a_copy_of_a_fleet_navigates_as_alone_and_from_a_checkpoint():
    """The same bytes; the checkpoint is taken between two calls of guidance."""
    fleet = pl.Simulation.load(scenario(lap(4)), n=3, seed=3)
    alone = pl.Simulation.load(scenario(lap(4)), n=1, seed=3, environment=2)
    for sim in (fleet, alone):
        sim.run(seconds=4.03)
    kept = fleet.checkpoint()
    for sim in (fleet, alone):
        sim.run(seconds=3.0)
    assert (fleet.state["a"].position[2] == alone.state["a"].position[0]).all()
    assert (errors(fleet)[0][2] == errors(alone)[0][0]).all()
    again = pl.Simulation.load(scenario(lap(4)), n=3, seed=3)
    again.restore(kept)
    again.run(seconds=3.0)
    assert (again.state["a"].position == fleet.state["a"].position).all()
    assert (errors(again)[0] == errors(fleet)[0]).all()


@pytest.mark.slow  # 5 s
def test_a_mission_goes_by_what_is_known():
    """Three metres of uncertainty at the start lead every copy to another place, by as much as it is wrong."""
    sensors = {k: v for k, v in SENSORS.items() if k != "gps"}
    mission = [{"type": "waypoints", "points": [[60, 0]], "depth_m": 4, "acceptance_m": 1}]
    navigation = {"type": "ekf", "start_position_std_m": 3.0}
    sim = pl.Simulation.load(scenario(mission, sensors, navigation), n=4, seed=2)
    while not sim.stepper.missions_done():
        assert sim.time_ns < 90e9
        sim.run(seconds=2.0)
    error, _ = errors(sim)
    assert np.abs(error[:, 1]).max() > 2.5
    known = sim.state["a"].position[:, 1] - error[:, 1]
    assert np.abs(known).max() < 1.0  # all believe that they are on the line y = 0


def test_an_estimator_needs_an_inertial_unit():
    with pytest.raises(ScenarioError, match="needs an imu, which a does not carry"):
        pl.Simulation.load(scenario(lap(3), {"depth": SENSORS["depth"]}))
    with pytest.raises(ScenarioError, match="navigation"):
        pl.Simulation.load(scenario(lap(3), navigation="ekv"))


def test_ranges_by_sound_find_a_vehicle_that_hardly_knows_where_it_is():
    """Three transponders, 10 m of uncertainty at the start: within its own three deviations, and these below 1 m."""
    places = {"a": [60, 40, -18], "b": [-50, 45, -18], "c": [10, -70, -18]}
    lbl = {"type": "lbl", "rate_hz": 1, "transponders": {k: {"position_m": v} for k, v in places.items()}}
    sensors = {k: v for k, v in SENSORS.items() if k != "gps"} | {"lbl": lbl}
    mission = [{"type": "waypoints", "points": [[60, 0]], "depth_m": 6}]
    navigation = {"type": "ekf", "start_position_std_m": 10.0}
    sim = pl.Simulation.load(scenario(mission, sensors, navigation, depth_m=6), n=2, seed=4)
    sim.run(seconds=12.0)
    error, p = errors(sim)
    std = np.sqrt(np.diagonal(p, axis1=1, axis2=2))
    assert (np.abs(error[:, :2]) < 3 * std[:, :2]).all()
    assert std[:, :2].max() < 1.0


def homing(beacons, sensors=None):
    """A vehicle that asks a modem on the ground for its place every two seconds."""
    usbl = {"type": "usbl", "interrogate": ["dock"], "interrogate_s": 2.0, "position_m": [0.3, 0, -0.1],
            "orientation_deg": [0, 0, 30]}  # fmt: skip
    sensors = {k: v for k, v in SENSORS.items() if k not in ("gps", "dvl")} | {"usbl": usbl} | (sensors or {})
    mission = [{"type": "waypoints", "points": [[60, 0]], "depth_m": 6}]
    navigation = {"type": "ekf", "start_position_std_m": 6.0, "start_velocity_std_mps": 0.2, "beacons": beacons}
    data = scenario(mission, sensors, navigation, depth_m=6)
    data["agents"]["dock"] = {
        "vehicle": "hovering_auv", "start": {"position_m": [45, -30], "depth_m": 14},
        "control": "station_keeping", "sensors": {"modem": {"type": "modem", "device": "x150"}},
    }  # fmt: skip
    return data


def test_the_bearings_of_a_beacon_tell_where_the_vehicle_is():
    """A beacon at a known place, range and bearing: 6 m of uncertainty become 2, and errors stay within three of them.

    NEES of the horizontal position over 12 copies: below chi-square's 99.9 % bound of 24 degrees of freedom.
    """
    sim = pl.Simulation.load(homing({"dock": [45, -30, -14]}), n=12, seed=5)
    sim.run(seconds=20.0)
    error, p = errors(sim)
    plane = error[:, :2]
    squared = (plane[:, None] @ np.linalg.inv(p[:, :2, :2]) @ plane[..., None])[:, 0, 0]
    assert squared.sum() < chi2.ppf(0.999, 24)
    assert np.sqrt(p[:, 0, 0] + p[:, 1, 1]).max() < 2.5
    assert np.hypot(*plane.T).max() < 4.0


def test_wrong_beacons_are_refused():
    with pytest.raises(ScenarioError, match="dock"):
        pl.Simulation.load(homing({"dok": [45, -30, -14]}))
    data = homing({"dock": [45, -30, -14]})
    del data["agents"]["a"]["sensors"]["usbl"]
    with pytest.raises(ScenarioError, match="found by a usbl, which a does not carry"):
        pl.Simulation.load(data)
