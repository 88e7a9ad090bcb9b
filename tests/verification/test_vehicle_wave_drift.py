"""Bodies under waves in the mean: water that goes along speeds up by Du/Dt, not by its rate of change at a place."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.vehicles.integrate import Rigid

HEIGHT, PERIOD = 1.0, 6.0
OMEGA = 2 * math.pi / PERIOD
K = OMEGA**2 / 9.81
LONG = {"type": "regular", "height_m": HEIGHT, "period_s": PERIOD, "towards_deg": 30.0}


def sphere(density_ratio: float) -> dict[str, Any]:
    """A smooth sphere of 0.1 m radius without weight or drag: inertia and the water's pressure alone."""
    radius, rho = 0.1, 1026.0
    volume = 4 / 3 * math.pi * radius**3
    mass = density_ratio * rho * volume
    turn = 0.4 * mass * radius**2
    half = 0.5 * rho * volume
    return {
        "type": "custom", "length_m": 2 * radius, "diameter_m": 2 * radius, "density_kg_m3": rho,
        "mass": {"type": "explicit", "mass_kg": mass, "inertia_kg_m2": [turn] * 3, "volume_m3": volume},
        "added_mass": {"type": "diagonal", "diagonal": [half, half, half, 0, 0, 0]},
        "modes": {"wrench": {"type": "wrench"}}, "default_mode": "wrench",
    }  # fmt: skip


def track(vehicle: Any, control: str, depth: float, seconds: float, *, ratio: float, **ocean: Any) -> np.ndarray:
    """Positions `(samples, 3)` NWU every 0.1 s of a body that starts with `ratio` of its water's velocity.

    Steps of semi-implicit Euler know the velocity in the middle between two times: it is given half a step early.
    """
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 50,
            "world": {"type": "flat", "depth_m": 200.0},
            "ocean": {"waves": LONG, **ocean},
            "agents": {"it": {"vehicle": vehicle, "control": control,
                              "start": {"position_m": [0.0, 0.0], "depth_m": depth}}},
        }
    )  # fmt: skip
    sim.set_state("it", velocity=tuple(ratio * v for v in water((0.0, 0.0, -depth), -0.01)))
    places = []
    for _ in range(round(seconds * 10)):
        sim.run(0.1)
        places.append(sim.state["it"].position[0])
    return np.array(places)


def water(place: tuple[float, float, float], t: float) -> np.ndarray:
    """Linear theory in deep water, NWU."""
    ahead = math.cos(math.radians(30)), -math.sin(math.radians(30))
    phase = K * (ahead[0] * place[0] + ahead[1] * place[1]) - OMEGA * t
    size = HEIGHT / 2 * OMEGA * math.exp(K * place[2])
    return np.array([ahead[0] * size * math.cos(phase), ahead[1] * size * math.cos(phase), size * math.sin(phase)])


def mean_start_and_end(places: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Means over the first and the last two periods, and the time between them."""
    n = round(2 * PERIOD * 10)
    return places[:n].mean(axis=0), places[-n:].mean(axis=0), 0.1 * (len(places) - n)


@pytest.mark.parametrize(("vehicle", "sinks"), [("sphere", 0.06), ("remus100", 0.1)])
def test_a_neutral_body_keeps_its_mean_depth_and_drifts_with_stokes(vehicle: str, sinks: float) -> None:
    """U_s = a^2 w k e^{-2kd}; 3 % for the fourth order in ka = 0.06 and the step.

    Depth to 6 % of the orbit in 108 s; a hull of 1.6 m with a righting moment and cross-flow drag to 10 %, 3 cm.

    The force by the rate of change at a place lacks u . grad u, on average a^2 w^2 k e^{-2kd} downwards.
    """
    depth, seconds = 5.0, 120.0
    given: Any = sphere(1.0) if vehicle == "sphere" else {"type": "remus100", "terms": {"lift_drag": None}}
    places = track(given, "wrench" if vehicle == "sphere" else "actuators", depth, seconds, ratio=1.0)
    first, last, time = mean_start_and_end(places)
    orbit = HEIGHT / 2 * math.exp(-K * depth)
    assert last[2] - first[2] == pytest.approx(0.0, abs=sinks * orbit)
    middle = -places[:, 2].mean()
    stokes = (HEIGHT / 2) ** 2 * OMEGA * K * math.exp(-2 * K * middle)
    ahead = np.array([math.cos(math.radians(30)), -math.sin(math.radians(30))])
    assert (last - first)[:2] / time == pytest.approx(stokes * ahead, abs=0.03 * stokes)


def test_a_heavy_body_is_moved_by_the_pressure_on_the_water_that_it_displaces() -> None:
    """(rho V + m_a) / (m + m_a) of the water's motion: 1.5 / 10.5 for a sphere ten times heavier than its water.

    In the mean it rises by share x a^2 w^2 k e^{-2kd} t^2 / 2, 0.1 m in 12 s, which the fit allows for: 2 %.
    """
    share = 1.5 / 10.5
    places = track(sphere(10.0), "wrench", 5.0, 12.0, ratio=share)
    t = 0.1 * (1 + np.arange(len(places)))
    basis = np.stack([np.ones_like(t), t, t**2, np.cos(OMEGA * t), np.sin(OMEGA * t)], axis=-1)
    found = np.linalg.lstsq(basis, places, rcond=None)[0]
    orbit = HEIGHT / 2 * math.exp(-K * 5.0)
    assert np.hypot(*found[3:, 2]) == pytest.approx(share * orbit, rel=0.02)
    assert np.hypot(*found[3:, 0]) == pytest.approx(share * orbit * math.cos(math.pi / 6), rel=0.02)


@pytest.mark.parametrize("place", [(3.0, -2.0, 4.0), (-11.0, 7.0, 2.5)])
def test_the_flow_takes_the_material_derivative_in_a_sheared_current_under_waves(place: Any) -> None:
    """Dw/Dt of w = current and waves together, by central differences along the path, to 1e-4 of its size."""
    ocean = build_ocean(
        OceanConfig.model_validate(
            {
                "waves": LONG,
                "currents": [
                    {"type": "profile", "depth_m": [0, 10], "speed_mps": [1.2, 0.2], "towards_deg": [50, 50]},
                    {"type": "vortex", "radius_m": 8.0, "speed_mps": 0.7, "center_m": [5.0, 1.0]},
                ],
            }
        ),
        seed=3,
    )  # fmt: skip
    body = pl.Vehicle.from_dict(sphere(1.0))
    at = [jit.Float64(v) for v in place]
    q = jit.Array4f64(1.0, 0.0, 0.0, 0.0)
    flow = body.flow(Rigid(at, q, [jit.Float64(0.0)] * 6), ocean, jit.Float64(7.3))
    found = np.array([float(jit.Float64(c)[0]) for c in flow.current_rate[:3]])

    def velocity(p: np.ndarray, t: float) -> np.ndarray:
        here = jit.Array3f64(float(p[0]), float(-p[1]), float(-p[2]))
        w = ocean.current(here, jit.Float64(t)) + ocean.waves.motion(here, jit.Float64(t), stretch=False).velocity
        return np.array(w).ravel() * [1, -1, -1]

    start, e = np.array(place), 1e-4
    w = velocity(start, 7.3)
    exact = (velocity(start + e * w, 7.3 + e) - velocity(start - e * w, 7.3 - e)) / (2 * e)
    local = (velocity(start, 7.3 + e) - velocity(start, 7.3 - e)) / (2 * e)
    assert found == pytest.approx(exact, abs=2e-3 * np.linalg.norm(exact))
    assert np.linalg.norm(exact - local) > 0.1 * np.linalg.norm(exact)  # the difference that this is about
