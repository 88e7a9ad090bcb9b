"""REMUS 100 (and, when in the catalogue, Otter) against the numbers of Fossen's Python Vehicle Simulator.

Gate 1e-9 relative: the reference is reproduced to about 1e-14 by any program with the same equations, and 1e-9 leaves
room for another order of summation and another maths library. A sum that cancels is compared on its column's scale.
"""

from __future__ import annotations

import numpy as np
import pytest
from fossen_euler import current_ned, replay, table

from pelagos import jit
from pelagos.vehicles.books import columns
from pelagos.vehicles.flow import make_flow, rotation_from_euler
from pelagos.vehicles.vehicle import Vehicle

RUDDER = 0.087266462599716474  # 5 deg


def worst(got: np.ndarray, expected: np.ndarray) -> float:
    """Largest error, relative to each value, but to no less than 1e-3 of its column's largest."""
    scale = np.maximum(np.abs(expected), 1e-3 * np.abs(expected).max(axis=0))
    return float((np.abs(got - expected) / np.maximum(scale, 1e-30)).max())


@pytest.fixture(scope="module")
def remus() -> Vehicle:
    return Vehicle.from_catalogue("remus100")


def test_remus_accelerations_and_actuator_rates(remus):
    _, rows = table("remus_pointwise")
    speed, towards = rows[:, 0], np.deg2rad(rows[:, 1])
    current = np.stack([speed * np.cos(towards), speed * np.sin(towards), 0 * speed], axis=-1)
    nu_dot, act_dot = remus.accelerations(rows[:, 2:8], rows[:, 8:14], rows[:, 14:17], rows[:, 17:20], current)
    assert worst(nu_dot, rows[:, 20:26]) < 1e-9
    assert worst(act_dot, rows[:, 26:29]) < 1e-9


def test_remus_one_row_equals_many(remus):
    _, rows = table("remus_pointwise")
    one, _ = remus.accelerations(rows[7, 2:8], rows[7, 8:14], rows[7, 14:17], rows[7, 17:20])
    many, _ = remus.accelerations(rows[:, 2:8], rows[:, 8:14], rows[:, 14:17], rows[:, 17:20])
    assert np.allclose(one[0], many[7], rtol=1e-13, atol=1e-13)


def test_remus_single_terms(remus):
    _, rows = table("remus_terms")
    nu, (roll, pitch) = columns(rows[:, :6]), columns(rows[:, 6:8])
    zero = jit.Float64(0.0)
    rotation = rotation_from_euler(roll, pitch, zero)
    flow = make_flow([zero, zero, zero], rotation, nu, (0.0, 0.0, 0.0))
    model = remus.published.model
    found = {name: term.wrench(flow) for name, term in model.terms.items()} | {"C": model.inertia.coriolis(flow)}
    for name, first, sign in (("C", 8, -1), ("lift_drag", 14, 1), ("cross_flow", 20, 1), ("restoring", 26, -1)):
        got = np.stack([np.broadcast_to(np.array(jit.Float64(c)), len(rows)) for c in found[name]], axis=-1)
        assert worst(sign * got, rows[:, first : first + 6]) < 1e-9, name


# name: (steps between rows after the second, commands at t)
RUNS = {
    "remus_stepInput": lambda t: [_until(t, 100, RUDDER), _until(t, 50, -RUDDER), 1525.0],
    "remus_turn_r5_1200": lambda t: [RUDDER, 0.0, 1200.0],
    "remus_straight_1525": lambda t: [0.0, 0.0, 1525.0],
    "remus_straight_800": lambda t: [0.0, 0.0, 800.0],
}


def _until(t, end, value):
    import drjit as dr

    return dr.select(t > end, 0.0, jit.Float64(value))


@pytest.mark.parametrize("name", RUNS)
def test_remus_trajectory(remus, name):
    """Positions to 1e-9 m, everything else to 1e-9 of its column, over the whole run."""
    _, rows = table(name)
    got = _like(rows, replay(remus, round(rows[-1, 0] / 0.02), 25, command=RUNS[name]))
    assert np.abs(got[:, 1:13] - rows[:, 1:13]).max() < 1e-9
    assert worst(got[:, 13:], rows[:, 13:]) < 1e-9


def test_remus_autopilot_reproduces_the_recorded_run_and_commands(remus):
    """Depth PID and heading sliding mode in a current of 0.5 m/s towards 170 deg."""
    _, rows = table("remus_main_example")
    control = remus.published.controllers["depth_heading"]
    got = replay(
        remus,
        10000,
        25,
        control=control,
        setpoint=(30.0, np.deg2rad(50.0), 1525.0),
        current=current_ned(0.5, 170.0),
    )
    got = _like(rows, got)
    assert np.abs(got[:, 1:13] - rows[:, 1:13]).max() < 1e-9
    assert worst(got[:, 13:], rows[:, 13:]) < 1e-9


def _like(rows: np.ndarray, got: np.ndarray) -> np.ndarray:
    """The rows of `got` at the times of `rows`."""
    index = np.round(rows[:, 0] / got[1, 0]).astype(int)
    assert np.allclose(got[index, 0], rows[:, 0], atol=1e-9)
    return got[index]


@pytest.fixture(scope="module")
def otter() -> Vehicle:
    return Vehicle.from_catalogue("otter")


def test_otter_accelerations_and_actuator_rates(otter):
    _, rows = table("otter_pointwise")
    speed, towards = rows[:, 0], np.deg2rad(rows[:, 1])
    current = np.stack([speed * np.cos(towards), speed * np.sin(towards), 0 * speed], axis=-1)
    nu_dot, act_dot = otter.accelerations(rows[:, 2:8], rows[:, 8:14], rows[:, 14:16], rows[:, 16:18], current)
    assert worst(nu_dot, rows[:, 18:24]) < 1e-9
    assert worst(act_dot, rows[:, 24:26]) < 1e-9


def _between(t, begin, end, value):
    import drjit as dr

    return dr.select((t > begin) & (t < end), jit.Float64(value), 0.0)


@pytest.mark.parametrize(
    ("name", "every", "command"),
    [
        ("otter_stepInput", 25, lambda t: [_between(t, 30, 100, 80.0), _between(t, 30, 100, 120.0)]),
        ("otter_straight_80", 5, lambda t: [80.0, 80.0]),
    ],
)
def test_otter_trajectory(otter, name, every, command):
    _, rows = table(name)
    got = _like(rows, replay(otter, round(rows[-1, 0] / 0.02), every, command=command))
    assert np.abs(got[:, 1:13] - rows[:, 1:13]).max() < 1e-9
    assert worst(got[:, 13:], rows[:, 13:]) < 1e-9


@pytest.mark.parametrize(("name", "axes"), [("supply", [0, 1, 5]), ("semisub", [0, 1, 2, 3, 4, 5])])
def test_dynamically_positioned_vessels(name, axes):
    """Surge, sway and yaw of the supply vessel, all six axes of the semi-submersible, in a current.

    These programs leave out that a steady current turns in the axes of a body that turns: (v_c r, -u_c r) is added.
    """
    _, rows = table(f"{name}_pointwise")
    speed, towards = rows[:, 0], np.deg2rad(rows[:, 1])
    current = np.stack([speed * np.cos(towards), speed * np.sin(towards), 0 * speed], axis=-1)
    vessel = Vehicle.from_catalogue(name)
    got, rates = vessel.accelerations(rows[:, 2:8], rows[:, 8:14], rows[:, 14:20], rows[:, 20:26], current)
    across = towards - rows[:, 7]
    turn = np.zeros((len(rows), 6))
    turn[:, 0], turn[:, 1] = speed * np.sin(across) * rows[:, 13], -speed * np.cos(across) * rows[:, 13]
    assert worst(got[:, axes], (rows[:, 26:32] + turn)[:, axes]) < 1e-9
    assert worst(rates, rows[:, 32:38]) < 1e-9


@pytest.mark.parametrize("name", ["frigate", "zeefakkel"])
def test_yaw_by_nomoto(name):
    """Yaw and the steering gear, at speeds between those of the tables."""
    _, rows = table(f"{name}_pointwise")
    zero = np.zeros(len(rows))
    nu = np.stack([rows[:, 0], zero, zero, zero, zero, rows[:, 1]], axis=-1)
    got, rates = Vehicle.from_catalogue(name).accelerations(np.zeros((1, 6)), nu, rows[:, 2:3], rows[:, 3:4])
    assert worst(got[:, 5:], rows[:, 4:5]) < 1e-9
    assert worst(rates, rows[:, 5:6]) < 1e-9
    assert (got[:, 1] == 0).all()  # the way follows the bow


def test_dsrv_in_the_vertical_plane():
    """Heave and pitch of Healey's derivatives, which the program takes as if length and speed were 1.

    Its w and q are therefore w' = w/u and q' = q L/u, its accelerations those by u^2/L and u^2/L^2; only the righting
    moment knows its speed, sqrt(U0^2 + w^2), and is linear in pitch. The difference is taken through its mass matrix.
    """
    _, rows = table("dsrv_pointwise")
    w, q, theta, delta, command = rows[:, :5].T
    u, length, zero = 4.11, 5.0, 0 * w
    nu = np.stack([zero + u, zero, w * u, zero, q * u / length, zero], axis=-1)
    eta = np.stack([zero, zero, zero + 9.0, zero, theta, zero], axis=-1)
    states = np.stack([delta, zero, zero], axis=-1)
    commands = np.stack([command, zero, zero], axis=-1)
    got, rates = Vehicle.from_catalogue("dsrv").accelerations(eta, nu, states, commands)
    mass = np.array([[0.036391 + 0.031545, 0.000130], [0.000146, 0.001925 + 0.001573]])
    more = -0.156276 * (np.sin(theta) / u**2 - theta / (u**2 + w**2))
    expected = rows[:, 5:7] + np.linalg.solve(mass, np.stack([zero, more])).T
    assert worst(got[:, [2, 4]] * [length / u**2, length**2 / u**2], expected) < 1e-9
    assert worst(rates[:, :1], rows[:, 7:8]) < 1e-9


def test_dsrv_is_the_same_to_the_side_as_upwards():
    """A body of revolution: turned by 90 degrees about its axis, sway is heave and yaw is pitch with the other sign."""
    plane = {"derivatives": {"Zuud": -0.027695}}
    undone = {
        "mass": {"center_of_buoyancy_m": [0, 0, 0]},
        "coriolis": {"rigid": "momentum"},
        "actuators": {"stern_plane": plane},
    }
    dsrv = Vehicle.from_catalogue("dsrv", as_published=undone)
    down = dsrv.accelerations([[0, 0, 9, 0, 0, 0]], [[3.0, 0, 0.4, 0, -0.05, 0]], [[0.1, 0, 0]], [[0.1, 0, 0]])[0][0]
    side = dsrv.accelerations([[0, 0, 9, 0, 0, 0]], [[3.0, 0.4, 0, 0, 0, 0.05]], [[0, 0.1, 0]], [[0, 0.1, 0]])[0][0]
    assert side[[0, 1, 5]] == pytest.approx(down[[0, 2, 4]] * [1, 1, -1], rel=1e-9)
