"""The catalogue against an independent transcription of Fossen's equations: states and manoeuvres nobody recorded."""

from __future__ import annotations

import numpy as np
import pytest
from fossen_numpy import BY_NAME, OTTER, REMUS, TORPEDO, euler_runs

from pelagos.vehicles.vehicle import Vehicle

ROWS = 200


def relative(got: np.ndarray, expected: np.ndarray) -> float:
    """Largest error, relative to each value, but to no less than 1e-3 of its column's largest."""
    scale = np.maximum(np.abs(expected), 1e-3 * np.abs(expected).max(axis=0))
    return float((np.abs(got - expected) / np.maximum(scale, 1e-30)).max())


def random_states(name: str) -> dict[str, np.ndarray]:
    """Attitudes short of vertical, speeds both ways, actuator states and commands up to 1.3 times their limits."""
    generator = np.random.default_rng(3)
    reference = BY_NAME[name]
    low, high = reference.limits
    afloat = name == "otter"
    tilt = (0.3, 0.3) if afloat else (np.pi, 1.4)
    angles = generator.uniform(-1, 1, (ROWS, 3)) * (*tilt, 4.0)
    position = generator.uniform(-1, 1, (ROWS, 3)) * (100, 100, 0.3 if afloat else 40)
    return {
        "eta": np.hstack([position, angles]),
        "nu": generator.uniform(-1, 1, (ROWS, 6)) * (3, 0.8, 0.8, 0.5, 0.5, 0.5),
        "actuators": 1.3 * generator.uniform(low, high, (ROWS, len(low))),
        "command": 1.3 * generator.uniform(low, high, (ROWS, len(low))),
        "current": generator.uniform(-1, 1, (ROWS, 3)) * (0.8, 0.8, 0) * (np.arange(ROWS) % 4 > 0)[:, None],
    }


@pytest.mark.parametrize("name", BY_NAME)
def test_accelerations_at_random_states_and_currents(name):
    states, reference = random_states(name), BY_NAME[name]
    nu_dot, act_dot = Vehicle.from_catalogue(name).accelerations(**states)
    rows = list(zip(*states.values(), strict=True))
    expected = np.array([reference.nu_dot(eta, nu, act, current) for eta, nu, act, _, current in rows])
    assert relative(nu_dot, expected) < 1e-9
    rates = np.array([reference.actuators_after(act, command, 1.0) - act for _, _, act, command, _ in rows])
    loops = np.array([rule != "after" for rule in reference.clip])  # those of fins with limits after the lag: below
    assert relative(act_dot[:, loops], rates[:, loops]) < 1e-9


def test_rates_of_the_torpedo_integrate_to_its_lag() -> None:
    """x' = (c - x)/T: small Euler steps give c + (x_0 - c) e^(-t/T) until the limit, and stay there.

    A step of h = 1 ms at T = 0.1 s is off by t h/(2 T^2) e^(-t/T) of the distance: at 0.1 s, 0.2 % of it.
    """
    torpedo = Vehicle.from_catalogue("torpedo")
    command, limit, h = np.array([[0.2, -0.1, 0.6, -0.4, 900.0]]), np.deg2rad(15), 1e-3
    state = np.array([[0.1, 0.05, -0.2, 0.0, 400.0]])
    first, ended = state.copy(), []
    for k in range(300):
        _, rates = torpedo.accelerations([[0] * 6], [[1, 0, 0, 0, 0, 0]], state, command)
        state = state + h * rates
        if k == 99:
            ended.append(state.copy())
    exact = command + (first - command) * np.exp(-1)
    assert ended[0][0, [0, 1]] == pytest.approx(exact[0, [0, 1]], abs=0.006 * 0.15)
    assert state[0, 2] == pytest.approx(limit, abs=6e-3)  # at the limit, up to one step of h (c - limit)/T
    assert state[0, 3] == pytest.approx(-limit, abs=6e-3)


STRONG = (0.4, -0.3, 0.0)
MANOEUVRES = {
    # name: reference, command(t), current
    "remus turn to port": ("remus100", lambda t: (-0.2, 0.0, 1400.0), (0, 0, 0)),
    "remus dive": ("remus100", lambda t: (0.0, 0.12 if t < 15 else -0.1, 1525.0), (0, 0, 0)),
    "remus braking": ("remus100", lambda t: (0.05, 0.0, 1525.0 if t < 15 else -1525.0), (0, 0, 0)),
    "remus spiral in a current": ("remus100", lambda t: (0.15, 0.06, 1300.0), STRONG),
    "remus too much asked": ("remus100", lambda t: (0.5 * np.sin(t), -0.4, 1800.0), STRONG),
    "torpedo turn": ("torpedo", lambda t: (0.1, -0.1, 0, 0, 1400.0), (0, 0, 0)),
    "torpedo dive and roll": ("torpedo", lambda t: (0.02, 0.02, -0.08, 0.08, 1525.0), (0, 0, 0)),
    "torpedo spiral in a current": ("torpedo", lambda t: (0.1, -0.12, 0.05, -0.06, 1300.0), STRONG),
    "torpedo too much asked": ("torpedo", lambda t: (0.4, -0.4, 0.3 * np.sin(t), 0.1, 1700.0), STRONG),
    "torpedo braking": ("torpedo", lambda t: (0, 0.01, 0, 0, 1525.0 if t < 12 else -1000.0), (0, 0, 0)),
    "otter turn": ("otter", lambda t: (90.0, 40.0), (0, 0, 0)),
    "otter turns on the spot": ("otter", lambda t: (-60.0, 60.0), (0.3, 0.2, 0)),
    "otter full ahead, full astern": ("otter", lambda t: (130.0, 130.0) if t < 15 else (-130.0, -130.0), STRONG),
}


@pytest.mark.parametrize("name", BY_NAME)
def test_manoeuvres_by_fossens_loop(name):
    """30 s of Fossen's loop around `Vehicle.accelerations`, against the same loop around the transcription: all
    manoeuvres of a vehicle at once, in steps of 50 ms."""
    reference, vehicle = BY_NAME[name], Vehicle.from_catalogue(name)
    commands, currents = zip(*(case[1:] for case in MANOEUVRES.values() if case[0] == name), strict=True)

    def of_pelagos(eta, nu, act, flow):
        return vehicle.accelerations(eta, nu, act, np.zeros(act.shape), flow)[0]

    def of_fossen(*states):
        return np.array([reference.nu_dot(*row) for row in zip(*states, strict=True)])

    flows = np.array(currents, float)
    got, expected = (euler_runs(reference, f, 30.0, commands, flows, 0.05) for f in (of_pelagos, of_fossen))
    assert (np.abs(expected[-1, :, :2]).max(axis=1) > 0.5).all()
    assert np.abs(got - expected).max() < 1e-9


def test_the_transcription_has_the_recorded_data():
    """It is believed because it meets the recorded accelerations, too."""
    from fossen_euler import table

    for name, reference, first in (("remus", REMUS, 20), ("otter", OTTER, 18)):
        _, rows = table(f"{name}_pointwise")
        k = len(reference.lag)
        towards = np.deg2rad(rows[:, 1])
        current = rows[:, :1] * np.stack([np.cos(towards), np.sin(towards), 0 * towards], axis=-1)
        states = zip(rows[:, 2:8], rows[:, 8:14], rows[:, 14 : 14 + k], current, strict=True)
        assert relative(np.array([reference.nu_dot(*s) for s in states]), rows[:, first : first + 6]) < 1e-9
        act, command = rows[:, 14 : 14 + k], rows[:, 14 + k : 14 + 2 * k]
        rates = [reference.actuators_after(a, c, 1.0) - a for a, c in zip(act, command, strict=True)]
        assert relative(np.array(rates), rows[:, first + 6 : first + 6 + k]) < 1e-9
    assert TORPEDO.lag[4] == 0.1
