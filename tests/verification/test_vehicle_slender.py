"""Slender bodies under waves: the water along the hull, strip by strip, against sums over many strips."""

from __future__ import annotations

import math
from typing import Any

import drjit as dr
import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.hydro.wave_load import morison, strip_wrench
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.slender_waves import slender_waves
from pelagos.vehicles.flow import rotation_from_euler
from pelagos.vehicles.integrate import Rigid

T = 7.3


def ocean_of(**waves: Any) -> Any:
    depth = waves.pop("depth_m", None)
    return build_ocean(OceanConfig.model_validate({"waves": waves, "waves_depth_m": depth}), seed=2)


def strips(ocean: Any, place: np.ndarray, axis: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Velocity and acceleration `(strips, 3)` NWU of the water at places x along the axis."""
    at = place + x[:, None] * axis
    motion = ocean.waves.motion(jit.Array3f64(*(jit.Float64(c) for c in at.T)), jit.Float64(T), stretch=False)
    return np.array(motion.velocity).T, np.array(motion.acceleration).T


def carried(ocean: Any, place: np.ndarray, axis: np.ndarray, x: np.ndarray) -> np.ndarray:
    """u . grad u at the same places `(strips, 3)`, by central differences along the velocity."""
    at = place + x[:, None] * axis
    u, e = strips(ocean, place, axis, x)[0], 1e-3

    def velocity(p: np.ndarray) -> np.ndarray:
        w = ocean.waves.motion(jit.Array3f64(*(jit.Float64(c) for c in p.T)), jit.Float64(T), stretch=False).velocity
        return np.array(w).T

    return (velocity(at + e * u) - velocity(at - e * u)) / (2 * e)


@pytest.mark.parametrize("depth", [None, 12.0])
@pytest.mark.parametrize("pitch", [0.0, 0.3, -0.8])
def test_mean_and_change_are_those_of_many_strips(depth: float | None, pitch: float) -> None:
    """A 5 m hull in waves of 20 to 100 m: kL/2 <= 0.8, where three points of Gauss are exact to (kL/2)^6 / 2100."""
    ocean = ocean_of(type="jonswap", significant_height_m=1.5, peak_period_s=6.0, depth_m=depth)
    keep = np.array(ocean.waves.table).reshape(-1, 8)
    long = keep[keep[:, 5] < 2 * math.pi / 20]
    long = np.concatenate([long, np.tile([0, 0, 0, 0, 0, 1.0, 1, 1], (-len(long) % 8, 1))])
    ocean.waves.table = jit.Float64(long.ravel())
    place, axis = np.array([3.0, -2.0, -5.0]), np.array([math.cos(pitch) * 0.8, math.cos(pitch) * 0.6, math.sin(pitch)])
    found = slender_waves(
        ocean.waves, tuple(map(jit.Float64, place)), tuple(map(jit.Float64, axis)), 5.0, jit.Float64(T)
    )
    x = (np.arange(2000) + 0.5) / 2000 * 5.0 - 2.5
    for exact, mean, change in zip(
        strips(ocean, place, axis, x), (found.velocity, found.acceleration),
        (found.velocity_change, found.acceleration_change), strict=True,
    ):  # fmt: skip
        size = np.abs(exact).max()
        assert np.array(mean).ravel() == pytest.approx(exact.mean(axis=0), abs=2e-4 * size)
        assert np.array(change).ravel() == pytest.approx((x @ exact) / (x @ x), abs=2e-3 * size / 2.5)


def test_load_of_a_cylinder_is_morisons_by_strips() -> None:
    """A held cylinder, C_M = 2 and C_D = 1.1, under a wave of six of its lengths, from ahead and below: 2 %.

    Its inertia is that of its strips: M_A = rho A L and rho A L^3 / 12, and as much again for the displaced water.
    """
    rho, length, diameter = 1025.0, 4.0, 0.5
    area = math.pi * diameter**2 / 4
    mass, turn = rho * area * length, rho * area * length**3 / 12
    vehicle = pl.Vehicle.from_dict(
        {
            "type": "custom", "density_kg_m3": rho, "length_m": length, "diameter_m": diameter,
            "mass": {"type": "explicit", "mass_kg": mass, "inertia_kg_m2": [25.0, turn, turn]},
            "added_mass": {"type": "diagonal", "diagonal": [0.0, mass, mass, 0.0, turn, turn]},
            "coriolis": {"rigid": "none"},
            "terms": {"drag": {"type": "cross_flow", "coefficient": 1.1, "strips": 40}},
            "modes": {"wrench": {"type": "wrench"}}, "default_mode": "wrench",
        }
    )  # fmt: skip
    ocean = ocean_of(type="regular", height_m=1.2, period_s=math.sqrt(2 * math.pi * 24.0 / 9.81), towards_deg=20)
    pitch, yaw = 0.15, 0.3
    rotation = rotation_from_euler(jit.Float64(0.0), jit.Float64(pitch), jit.Float64(yaw))
    rows = np.array([[float(jit.Float64(c)[0]) for c in row] for row in rotation])
    q = jit.Array4f64(*_quaternion(pitch, yaw))
    position = np.array([1.0, 2.0, 3.0])  # NED
    flow = vehicle.flow(Rigid([jit.Float64(v) for v in position], q, [jit.Float64(0.0)] * 6), ocean, jit.Float64(T))
    inertia = np.diag(vehicle.config.body.mass_matrix) * [float(jit.Float64(r)[0]) for r in flow.current_rate]
    drag = [float(jit.Float64(v)[0]) for v in vehicle.model.terms["drag"].wrench(flow)]
    found = inertia + np.array(drag)

    x = (np.arange(400) + 0.5) / 400 * length - length / 2
    flip = np.array([1.0, -1.0, -1.0])
    velocity, acceleration = strips(ocean, position * flip, rows[:, 0] * flip, x)
    acceleration = acceleration + carried(ocean, position * flip, rows[:, 0] * flip, x)  # inertia takes Du/Dt
    forces, places = [], []
    for at, v, a in zip(x, velocity * flip @ rows, acceleration * flip @ rows, strict=True):
        v3, a3 = [jit.Float64(float(c)) for c in v], [jit.Float64(float(c)) for c in a]
        forces.append(morison(rho, diameter, 2.0, 1.1, v3, a3, [1.0, 0.0, 0.0]))
        places.append([float(at), 0.0, 0.0])
    exact = [float(jit.Float64(c)[0]) for c in strip_wrench(forces, places, length / 400)]
    # Morison's |u| u holds for both directions across together, the vehicle's strips take each alone: inertia leads
    assert found[1:3] == pytest.approx(exact[1:3], rel=0.02, abs=0.02 * np.abs(exact[1:3]).max())
    assert found[4:] == pytest.approx(exact[4:], abs=0.02 * np.abs(exact[4:]).max())
    assert abs(exact[4]) > 50.0  # there is a moment to speak of


def _quaternion(pitch: float, yaw: float) -> tuple[float, float, float, float]:
    cp, sp, cy, sy = math.cos(pitch / 2), math.sin(pitch / 2), math.cos(yaw / 2), math.sin(yaw / 2)
    return cp * cy, -sp * sy, sp * cy, cp * sy


def test_a_hull_without_righting_moment_lies_along_its_line_of_water() -> None:
    """Pitch goes to that of the water it displaces, k a e^{-kd} 3 (sin q - q cos q) / q^3 with q = kL/2: 10 %.

    Damping of relative pitch changes nothing, since there is no relative pitch.
    """
    period, height, depth = 5.0, 0.8, 4.0
    k = (2 * math.pi / period) ** 2 / 9.81
    vehicle = {"type": "remus100", "mass": {"center_of_gravity_m": [0, 0, 0]}, "terms": {"lift_drag": None}}
    start = {"position_m": [0.0, 0.0], "depth_m": depth, "heading_deg": 0.0}
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 100,
            "world": {"type": "flat", "depth_m": 100.0},
            "ocean": {"waves": {"type": "regular", "height_m": height, "period_s": period, "phase_deg": 0.0}},
            "agents": {"it": {"vehicle": vehicle, "control": "actuators", "start": start}},
        }
    )
    orbit = height / 2 * math.exp(-k * depth) * 2 * math.pi / period
    sim.set_state("it", velocity=(orbit, 0.0, 0.0), angular_velocity=(0.0, 0.0, 0.0))
    pitch = []
    for _ in range(150):
        sim.run(0.1)
        pitch.append(float(sim.state["it"].euler[0, 1]))
    q = k * 1.6 / 2
    expected = k * height / 2 * math.exp(-k * depth) * 3 * (math.sin(q) - q * math.cos(q)) / q**3
    w, t = 2 * math.pi / period, 0.1 * (1 + np.arange(150))
    basis = np.stack([np.ones_like(t), t, t**2, np.cos(w * t), np.sin(w * t)], axis=-1)[50:]
    found = np.linalg.lstsq(basis, np.array(pitch)[50:], rcond=None)[0]
    swing = math.hypot(found[3], found[4])
    assert swing == pytest.approx(expected, rel=0.1)


def test_frozen_is_plain() -> None:
    ocean = ocean_of(type="sea_state", state=4)

    def along(waves: Any, x: Any, t: Any) -> Any:
        m = slender_waves(waves, (x, 0.5 * x, -3.0 - 0 * x), (0.8 + 0 * x, 0.0, 0.6), 2.0, t)
        return [m.elevation, *m.velocity, *m.acceleration, *m.velocity_change, *m.acceleration_change]

    x, t = jit.Float64([0.0, 5.0, 9.0]), jit.Float64(3.0)
    plain, frozen = along(ocean.waves, x, t), jit.freeze(along)(ocean.waves, x, t)
    dr.eval(plain, frozen)
    for a, b in zip(plain, frozen, strict=True):
        assert np.array(a).tobytes() == np.array(b).tobytes()
