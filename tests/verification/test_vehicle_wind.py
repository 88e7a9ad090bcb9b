"""Wind on surface craft, with and without waves: the speed at which the push of the air is the drag of the water."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import pelagos as pl
from pelagos.ocean.wind import WindConfig


def drift(vehicle: Any, seconds: float = 90.0, **ocean: Any) -> pl.Simulation:
    agents = {"it": {"vehicle": vehicle, "control": "actuators", "start": {"position_m": [0.0, 0.0], "depth_m": 0.0}}}
    world = {"type": "flat", "depth_m": 60.0}
    sim = pl.Simulation.load({"seed": 3, "tick_rate_hz": 50, "world": world, "ocean": ocean, "agents": agents})
    sim.run(seconds)
    return sim


@pytest.mark.parametrize("waves", [None, 1e-4])
@pytest.mark.parametrize("seakeeping", ["pressure", "slope"])
def test_before_the_wind_air_and_water_balance(waves: float | None, seakeeping: str) -> None:
    """WAM-V, wind from astern, 10 m/s: 0.5 rho_a c_x A_f (V - u)^2 = 51.3 u + 72.4 u^2 (its catalogue's drag).

    Time constant 2 s. Running before the wind it turns aside in the end, as boats do; here that has not begun.
    """
    ocean: dict[str, Any] = {"wind": {"speed_mps": 10.0, "from_deg": 180.0}}
    if waves is not None:
        ocean["waves"] = {"type": "regular", "height_m": waves, "period_s": 5.0}
    state = drift({"type": "wamv", "seakeeping": seakeeping}, 25.0, **ocean).state["it"]
    shear = 5.73e-2 * np.sqrt(1 + 0.15 * 10.0)
    v = 10.0 * (1 + shear * np.log(0.7 / 10))  # at the superstructure's height, ISO 19901-1
    u = brentq(lambda u: 0.5 * 1.225 * 0.7 * 1.2 * (v - u) ** 2 - 51.3 * u - 72.4 * u * u, 0.0, 5.0)
    assert state.velocity[0, 0] == pytest.approx(u, rel=1e-3)
    assert abs(state.velocity[0, 1]) < 0.02 * u


@pytest.mark.parametrize(
    "vehicle", ["wamv", "otter", "surface_vessel", pytest.param("mariner", marks=pytest.mark.slow)]
)
def test_every_surface_craft_goes_down_wind_in_still_water(vehicle: str) -> None:
    """West wind (from 270 deg): eastwards, which is -y. Without wind what has no engine running stays where it is."""
    blown = drift(vehicle, 60.0, wind={"speed_mps": 12.0, "from_deg": 270.0}).state["it"]
    calm = drift(vehicle, 60.0, wind={"speed_mps": 0.0, "gusts": 1.0}).state["it"]
    assert blown.position[0, 1] < -(0.5 if vehicle == "mariner" else 2.0)
    assert abs(calm.position[0, 1]) < 0.2
    assert vehicle == "mariner" or np.abs(calm.position[0, :2]).max() < 0.05
    assert np.abs(blown.euler[0, :2]).max() < 0.2  # it heels, and does not capsize


def test_gusts_push_in_bursts() -> None:
    """The vehicle's acceleration follows the gusts; the same seed gives the same wind, another seed another."""
    wind = {"speed_mps": 12.0, "from_deg": 180.0, "gusts": 1.0}
    sim = drift("wamv", 30.0, wind=wind)
    speeds = []
    for _ in range(120):
        sim.run(1.0)
        speeds.append(float(sim.state["it"].velocity[0, 0]))
    steady = drift("wamv", 60.0, wind={**wind, "gusts": 0.0}).state["it"].velocity[0, 0]
    assert np.std(speeds) > 0.03 * steady
    assert np.mean(speeds) == pytest.approx(steady, rel=0.25)
    again = drift("wamv", 30.0, wind=wind)
    again.run(120.0)
    assert again.state["it"].velocity.tobytes() == sim.state["it"].velocity.tobytes()


def test_a_calm_is_a_calm() -> None:
    """Without wind the term is nothing at all."""
    assert WindConfig().model_dump()["speed_mps"] == 0.0
    waves = {"type": "sea_state", "state": 3}
    with_it = drift("wamv", 5.0, waves=waves).state["it"]
    without = drift({"type": "wamv", "terms": {"windage": None}}, 5.0, waves=waves).state["it"]
    assert with_it.position.tobytes() == without.position.tobytes()
