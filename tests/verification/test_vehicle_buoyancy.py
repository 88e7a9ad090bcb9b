"""Density of the water varies buoyancy: B = B_0 rho / rho_0, rho by TEOS-10."""

from __future__ import annotations

from typing import Any

import gsw
import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.vehicles.integrate import Rigid

LAYERS = {"temperature_c": {"depth_m": [0, 10, 20, 100], "value": [22, 22, 12, 12]}, "salinity": 37.0}


def lift(vehicle: pl.Vehicle, ocean: Any, depth: float) -> float:
    """Net force upwards of a level vehicle at rest [N]."""
    zero = [jit.Float64(0.0)] * 3
    rigid = Rigid([*zero[:2], jit.Float64(depth)], jit.Array4f64(1.0, 0.0, 0.0, 0.0), zero * 2)
    flow = vehicle.flow(rigid, ocean, jit.Float64(0.0))
    return -float(jit.Float64(vehicle.model.terms["restoring"].wrench(flow)[2])[0])


@pytest.mark.parametrize("depth", [5.0, 40.0])
def test_buoyancy_is_that_of_teos10(depth: float) -> None:
    """Neutral in the water of the surface; 10 degC colder it is lighter by 0.25 %, at the same pressure."""
    vehicle, ocean = pl.Vehicle.from_catalogue("remus100"), build_ocean(OceanConfig.model_validate(LAYERS))
    pressure = gsw.p_from_z(-depth, 45.0)
    sa = gsw.SA_from_SP(37.0, pressure, -30.0, 45.0)
    rho, rho_0 = (gsw.rho(sa, gsw.CT_from_t(sa, t, pressure), pressure) for t in (22.0 if depth < 10 else 12.0, 22.0))
    weight = vehicle.config.body.weight
    found = lift(vehicle, ocean, depth) - lift(vehicle, None, depth)
    assert found == pytest.approx(weight * (rho / rho_0 - 1), abs=2e-4 * weight * 0.01)
    assert depth < 10 or 0.002 * weight < found < 0.003 * weight


def test_where_the_water_is_the_same_nothing_changes() -> None:
    ocean = build_ocean(OceanConfig.model_validate({"temperature_c": 4.0, "salinity": 5.0}))
    assert ocean.ballast is None
    vehicle = pl.Vehicle.from_catalogue("remus100")
    assert lift(vehicle, ocean, 30.0) == lift(vehicle, None, 30.0)


def test_an_idle_vehicle_comes_to_rest_on_the_pycnocline() -> None:
    """Weighted to be neutral at 15 m in a layered sea, it sinks from above and stops there: a Lagrangian float."""
    rise = lift(pl.Vehicle.from_catalogue("hovering_auv"), None, 15.0)
    ocean = build_ocean(OceanConfig.model_validate(LAYERS))
    vehicle = pl.Vehicle.from_catalogue("hovering_auv")
    there = lift(vehicle, ocean, 15.0)
    assert there > rise
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 20,
            "world": {"type": "flat", "depth_m": 60.0},
            "ocean": LAYERS,
            "agents": {
                "it": {"vehicle": "hovering_auv", "control": "wrench", "start": {"position_m": [0, 0], "depth_m": 11.0},
                       "command": [0, 0, there, 0, 0, 0]}
            },
        }
    )  # fmt: skip
    sim.run(600.0)
    assert sim.state["it"].position[0, 2] == pytest.approx(-15.0, abs=0.4)
    assert np.abs(sim.state["it"].velocity).max() < 0.01
