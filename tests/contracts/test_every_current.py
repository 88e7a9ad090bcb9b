"""Every control mode of every vehicle feels the water that moves; a vehicle without drive goes where the water goes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.vehicles.load import catalogue_names

NAMES = sorted(catalogue_names())
AFLOAT = {
    "otter", "wamv", "surface_vessel", "mariner", "kvlcc2", "tanker", "container", "supply", "semisub", "frigate",
    "zeefakkel", "navalvessel",
}  # fmt: skip
IN_AIR = {"quadrotor", "fixed_wing"}
SHIPS = AFLOAT - {"otter", "wamv", "surface_vessel"}
KIN = {"bluerov2_heavy", "hovering_auv", "wamv", "surface_vessel", "couguv", "torpedo", "lrauv"}
"""Vehicles of whose kinds of modes and families others are in every run."""
HEAVY = {"npsauv", "dsrv"}  # slender bodies of tonnes
WITHOUT_DRIVE = ("actuators", "wrench", "acceleration")


def swim(vehicle: Any, mode: str, seconds: float, *, rate_hz: float = 50.0, **ocean: Any) -> pl.Simulation:
    depth = 0.0 if vehicle in AFLOAT | IN_AIR else 8.0
    start = {"position_m": [0.0, 0.0], "depth_m": depth}
    agents = {"it": {"vehicle": vehicle, "control": mode, "start": start}}
    world = {"type": "flat", "depth_m": 60.0}
    sim = pl.Simulation.load({"tick_rate_hz": rate_hz, "world": world, "ocean": ocean, "agents": agents})
    return swum(sim, vehicle, seconds)


def swum(sim: pl.Simulation, vehicle: Any, seconds: float) -> pl.Simulation:
    if vehicle in IN_AIR:
        sim.set_state("it", position=(0.0, 0.0, 200.0))  # without thrust it falls for 120 m
    sim.run(seconds)
    return sim


def swum_anew(sim: pl.Simulation, vehicle: Any, mode: str, seconds: float) -> Any:
    """The state after a run from the start in another mode."""
    sim.reset()
    sim.set_mode("it", mode)
    return swum(sim, vehicle, seconds).state["it"]


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow) if n in SHIPS | KIN else n for n in NAMES])
def test_every_mode_feels_a_current(name: str) -> None:
    """Half a metre a second eastwards (wind for what flies): without drive it is soon carried, with one it has to work.

    A ship of 17 000 t, or 320 000 t, has only begun to move after 5 s.
    """
    moving = {"wind": {"speed_mps": 5.0, "from_deg": 270.0}} if name in IN_AIR else {
        "currents": {"type": "uniform", "speed_mps": 0.5, "towards_deg": 90.0}
    }  # fmt: skip
    modes = pl.Vehicle.from_catalogue(name).modes
    sims = [swim(name, modes[0], 0.02, **ocean) for ocean in ({}, moving)]
    for mode in modes:
        still, carried = (swum_anew(sim, name, mode, 5.0) for sim in sims)
        way = carried.position[0] - still.position[0]
        assert np.isfinite(way).all(), mode
        works = np.abs(carried.actuators - still.actuators).max() > 1e-2 * max(1.0, np.abs(still.actuators).max())
        assert works or np.linalg.norm(way) > (0.005 if name in SHIPS else 0.1), mode  # what holds its place works
        if mode in WITHOUT_DRIVE and name not in {*SHIPS, "fixed_wing"}:
            assert way[1] < -(0.1 if name in HEAVY else 0.3 * 2.5), (mode, way)


@pytest.mark.parametrize("name", ["remus100", "bluerov2_heavy", "wamv"])
def test_accelerations_are_exact_in_still_water_and_carried_by_a_current(name: str) -> None:
    """v = a t in still water, and that on top of a drift that ends as the current's, while the vehicle turns."""
    command = np.zeros((1, 6))
    command[0, 0] = 0.02

    def ride(**ocean: Any) -> pl.Simulation:
        sim = swim(name, "acceleration", 0.02, **ocean)
        sim.step({"it": command})
        sim.run(10.0)
        return sim

    still = ride()
    t = still.time_ns * 1e-9 - 0.02
    assert still.state["it"].velocity[0] == pytest.approx([0.02 * t, 0, 0], abs=1e-9)
    flowing = ride(currents={"type": "uniform", "speed_mps": 0.4, "towards_deg": 0.0})
    more = flowing.state["it"].velocity[0] - still.state["it"].velocity[0]
    assert 0.02 < more[0] < 0.4
    assert more[1:] == pytest.approx([0, 0], abs=1e-2)


def test_a_turning_hull_with_prescribed_accelerations_ends_up_with_the_current() -> None:
    sim = swim(
        "bluerov2_heavy", "acceleration", 0.02, currents={"type": "uniform", "speed_mps": 0.4, "towards_deg": 90}
    )
    sim.set_state("it", angular_velocity=(0.0, 0.0, 0.5))
    sim.run(60.0)
    before = sim.state["it"].position[0].copy()
    sim.run(10.0)
    state = sim.state["it"]
    assert (state.position[0] - before) / 10.0 == pytest.approx([0.0, -0.4, 0.0], abs=2e-3)
    assert state.angular_velocity[0] == pytest.approx([0.0, 0.0, 0.5], abs=1e-9)


@pytest.mark.parametrize("name", ["remus100", "hovering_auv", "otter"])
def test_adrift_in_a_gyre_it_goes_round_with_the_water(name: str) -> None:
    """A gyre that turns like a body: the analytic path is a circle about its centre, once in a period.

    The pressure that turns the water turns a vehicle of its weight too; without that it would be flung out to more than
    twice the radius. Steps of 50 ms let the circle grow by h omega^2 t / 2, 0.25 %.
    """
    period, radius = 400.0, 40.0
    gyre = {"type": "gyre", "radius_m": 100.0, "period_s": period}
    sim = swim(name, "actuators", 0.02, rate_hz=20.0, currents=gyre)
    depth = 0.0 if name in AFLOAT else 8.0
    omega = 2 * np.pi / period
    sim.set_state("it", position=(radius, 0.0, -depth), velocity=(0.0, omega * radius, 0.0))
    angles, radii = [], []
    for _ in range(40):
        sim.run(period / 40)
        x, y = sim.state["it"].position[0, :2]
        angles.append(np.arctan2(y, x))
        radii.append(np.hypot(x, y))
    swept = np.unwrap(np.concatenate([[0.0], angles]))
    assert swept == pytest.approx(2 * np.pi * np.arange(41) / 40, abs=0.01)
    assert np.array(radii) == pytest.approx(radius, rel=0.004)


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow) if n in SHIPS - {"mariner"} else n for n in sorted(AFLOAT)]
)
def test_what_floats_goes_up_with_the_tide(name: str) -> None:
    """Without waves: high water 0.8 m above the mean at t = 0."""
    sim = swim(name, "actuators", 40.0, rate_hz=20.0, tide={"constituent": "M2", "amplitude_m": 0.8})
    assert sim.state["it"].position[0, 2] == pytest.approx(0.8, abs=0.05)
