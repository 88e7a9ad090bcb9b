"""Engines of ships: how they follow orders, who orders them, who needs them."""

from __future__ import annotations

import numpy as np
import pytest

import pelagos as pl
from pelagos import Vehicle, jit
from pelagos.errors import ScenarioError
from pelagos.vehicles.actuators.engine import ShaftLag


def test_a_shaft_follows_by_its_time_constant():
    """One time constant leaves 1/e of the way; beyond `above` the time constant is `constant` over the revolutions."""
    lag = ShaftLag(20.0, 0.0, 3.0, 0.5, 6.0)
    for start, seconds in ((0.2, 20.0), (1.5, 4.0)):
        after = float(np.array(lag.after(jit.Float64(start), [], jit.Float64(2.5), jit.Float64(seconds))[0])[0])
        assert after == pytest.approx(2.5 - (2.5 - start) / np.e, rel=1e-12)
    assert float(np.array(lag.after(jit.Float64(2.9), [], jit.Float64(9.0), jit.Float64(1e3))[0])[0]) == 3.0


def test_the_heading_mode_orders_the_engine():
    scenario = {
        "tick_rate_hz": 10,
        "world": {"type": "flat", "depth_m": 100},
        "agents": {"it": {"vehicle": "container"}},
    }
    sim = pl.Simulation.load(scenario)
    sim.run(60.0)
    vehicle = sim.model.agents["it"].vehicle
    turns = sim.state["it"].actuators[0, vehicle.actuator_names.index("engine")]
    assert turns == pytest.approx(70 / 60, rel=1e-3)


@pytest.mark.parametrize(("changed", "message"), [
    ({"rudder": {"engine": "motor"}}, "actuator 'rudder' needs an actuator 'motor' of the type ship_engine"),
    ({"engine": {"quickened_constant": None}}, "give both quickened_above_hz and quickened_constant"),
    ({"engine": {"service_hz": 3.0}}, "service_hz 3 must not be above limit_hz"),
    ({"rudder": {"derivatives": {"Ywv": 1.0}}}, "derivative 'Ywv' must be X, Y, K or N"),
])  # fmt: skip
def test_what_cannot_be_is_refused(changed, message):
    with pytest.raises(ScenarioError, match=message):
        Vehicle.from_catalogue("container", actuators=changed)


@pytest.mark.parametrize(("name", "changed", "message"), [
    ("tanker", {"rudder": {"hull": {"Ywrong": 1.0}}}, "hull: give each of Xuu, .*not so: Ywrong"),
    ("tanker", {"rudder": {"propeller": {"Tuv": 1.0}}}, "propeller: give each of Tuu, .*not so: Tuv"),
    ("npsauv", {"rudder": {"derivatives": {"Quud": 1.0}}}, "derivative 'Quud' must be X, Y, Z, K, M or N"),
    ("npsauv", {"propeller": {"plane": "rudders"}}, "needs an actuator 'rudders' of the type plane"),
])  # fmt: skip
def test_names_that_cannot_be_are_refused(name, changed, message):
    with pytest.raises(ScenarioError, match=message):
        Vehicle.from_catalogue(name, actuators=changed)


def test_hull_derivatives_have_no_deflection():
    with pytest.raises(ScenarioError, match="derivative 'Zuud' must be"):
        Vehicle.from_catalogue("npsauv", terms={"hull": {"derivatives": {"Zuud": 1.0}}})
