"""Vehicles in regular waves against linear theory: deep water, k = w^2/g, orbits a e^{-k d} at depth d."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pelagos as pl

HEIGHT_M, PERIOD_S = 1.0, 6.0
K = (2 * math.pi / PERIOD_S) ** 2 / 9.81


def ride(vehicle: str, depth_m: float, *, seconds: float = 48.0, heading_deg: float = 0.0) -> dict[str, float]:
    """Amplitudes of surge, heave [m], roll and pitch [rad] at the waves' period, by least squares."""
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 100,
            "world": {"type": "flat", "depth_m": 200.0},
            "ocean": {"waves": [{"type": "regular", "height_m": HEIGHT_M, "period_s": PERIOD_S, "towards_deg": 0.0}]},
            "agents": {
                "it": {
                    "vehicle": vehicle,
                    "control": "actuators",
                    "start": {"position_m": [0.0, 0.0], "depth_m": depth_m, "heading_deg": heading_deg},
                }
            },
        }
    )
    if depth_m > 0:  # let go with the water's own motion (a crest is overhead), or it keeps sinking past its orbit
        speed = HEIGHT_M / 2 * 2 * math.pi / PERIOD_S * math.exp(-K * depth_m)
        sim.set_state("it", velocity=(speed, 0.0, 0.0))
    t, rows = [], []
    while sim.time_ns < seconds * 1e9:
        sim.run(0.2)
        state = sim.state["it"]
        t.append(sim.time_ns * 1e-9)
        rows.append([state.position[0, 0], state.position[0, 2], state.euler[0, 0], state.euler[0, 1]])
    keep = np.array(t) > seconds - 4 * PERIOD_S
    when, values = np.array(t)[keep], np.array(rows)[keep]
    # the vehicle drifts slowly through the waves: a little freedom in the period of encounter, and a trend
    best = None
    for period in PERIOD_S * np.linspace(0.97, 1.03, 25):
        w = 2 * math.pi / period
        basis = np.stack([np.ones_like(when), when, when**2, np.cos(w * when), np.sin(w * when)], axis=-1)
        found, residual, *_ = np.linalg.lstsq(basis, values, rcond=None)
        if best is None or residual.sum() < best[0]:
            best = residual.sum(), np.hypot(found[3], found[4])
    return dict(zip(("surge", "heave", "roll", "pitch"), best[1], strict=True)) | {"depth": -values[:, 1].mean()}


@pytest.mark.parametrize("depth_m", [6.0, 12.0])
def test_a_neutral_vehicle_moves_with_the_water(depth_m):
    """It displaces its own weight, so the pressure that moves the water moves it: e^{-kd} at its own depth.

    Lift and damping act on what little relative motion there is, and let it drift by some centimetres a second: 5 %.
    """
    found = ride("remus100", depth_m)
    orbit = HEIGHT_M / 2 * math.exp(-K * found["depth"])
    assert found["heave"] == pytest.approx(orbit, rel=0.05)
    assert found["surge"] == pytest.approx(orbit, rel=0.05)


def test_half_a_wave_length_down_it_barely_moves_and_at_periscope_depth_it_does():
    found = ride("remus100", math.pi / K)
    assert found["heave"] < 0.06 * HEIGHT_M / 2  # e^{-pi} = 0.043
    shallow = ride("remus100", 0.05 * 2 * math.pi / K)
    assert shallow["heave"] == pytest.approx(HEIGHT_M / 2 * math.exp(-K * shallow["depth"]), rel=0.08)
    assert shallow["heave"] > 0.45 * HEIGHT_M / 2 > 7 * found["heave"]


@pytest.mark.parametrize("vehicle", ["wamv", "surface_vessel", "otter"])
def test_long_waves_carry_what_floats(vehicle):
    """56 m long waves under hulls of 2 to 5 m: heave goes to the elevation, pitch to the slope ka = 3.2 deg."""
    found = ride(vehicle, 0.0)
    assert found["heave"] == pytest.approx(HEIGHT_M / 2, rel=0.06)
    assert found["pitch"] == pytest.approx(K * HEIGHT_M / 2, rel=0.15)


@pytest.mark.parametrize(("period_s", "low", "high"), [(20.0, 0.9, 1.05), (8.0, 0.0, 0.1)])
def test_a_ship_rides_long_waves_and_bridges_short_ones(period_s: float, low: float, high: float):
    """161 m: waves of four lengths lift it whole, those of 0.6 lengths hardly (their push adds up to little)."""
    start = {"position_m": [0.0, 0.0], "depth_m": 0.0, "speed_mps": 7.7}
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 20,
            "world": {"type": "flat", "depth_m": 200.0, "size_m": [6000, 6000]},
            "ocean": {"waves": {"type": "regular", "height_m": 4.0, "period_s": period_s, "towards_deg": 180.0}},
            "agents": {"it": {"vehicle": "mariner", "start": start}},
        }
    )
    sim.run(120.0)
    z = []
    for _ in range(80):
        sim.run(0.5)
        z.append(float(sim.state["it"].position[0, 2]))
    assert low * 2.0 <= 0.5 * (max(z) - min(z)) <= high * 2.0


def test_waves_from_abeam_roll():
    found = ride("wamv", 0.0, heading_deg=90.0)
    assert found["roll"] > 100 * found["pitch"]
    # the slope's amplitude; the hull's breadth takes (k b)^2 / 24 = 0.3 % of it, and it rolls in a third of the period
    assert found["roll"] == pytest.approx(K * HEIGHT_M / 2, rel=0.02)


def test_a_tanker_in_a_moderate_sea_goes_as_in_calm_water():
    """Waves much shorter than the hull hardly move it; taken as a point it was carried off at 17 m/s in 150 s."""
    found = {}
    for state in (None, 4):
        scenario = {
            "tick_rate_hz": 20,
            "world": {"type": "flat", "depth_m": 200},
            "ocean": {"waves": [] if state is None else [{"type": "sea_state", "state": state}]},
            "agents": {"it": {"vehicle": "kvlcc2", "control": "actuators"}},
        }
        sim = pl.Simulation.load(scenario)
        sim.run(150.0)
        found[state] = sim.state["it"].velocity[0]
    assert found[None][0] > 2.0
    assert found[4] == pytest.approx(found[None], abs=0.2)
