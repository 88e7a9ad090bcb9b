"""Diffraction of a floating hull: forces of components, and a held section's whole load in waves."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.hydro.section import section_added_mass, section_waves
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.vehicles.diffraction import DiffractionConfig, compile_diffraction
from pelagos.vehicles.integrate import Rigid

RHO = 999.1
RNG = np.random.default_rng(5)
OMEGA, HEADINGS = [1.0, 2.0, 3.0], [0.0, 90.0, 180.0]
REAL, IMAGINARY = (RNG.normal(size=(3, 3, 6)).round(3) for _ in range(2))
TABLE: dict[str, Any] = {
    "omega_radps": OMEGA, "heading_deg": HEADINGS, "real": REAL.tolist(), "imaginary": IMAGINARY.tolist(),
}  # fmt: skip
EVEN = np.array([1, -1, 1, -1, 1, -1])


def sea(*waves: dict[str, Any], depth: float | None = None) -> Any:
    return build_ocean(OceanConfig.model_validate({"waves": list(waves), "waves_depth_m": depth}), seed=1).waves


def wave(omega: float, towards: float, height: float, phase: float) -> dict[str, Any]:
    return {
        "type": "regular", "height_m": height, "period_s": 2 * np.pi / omega, "towards_deg": towards, "phase_deg": phase
    }  # fmt: skip


def pushed(waves: Any, x: float, y: float, heading_deg: float, t: np.ndarray) -> np.ndarray:
    """`(times, 6)`."""
    diffraction = compile_diffraction(DiffractionConfig.model_validate(TABLE))
    zero = 0 * jit.Float64(t)
    c, s = (jit.Float64(f(np.radians(heading_deg))) + zero for f in (np.cos, np.sin))
    found = diffraction.push(waves, diffraction.rows.on_device(), (zero + x, zero + y), (c, s), jit.Float64(t))
    return np.array([np.array(f) for f in found]).T


@pytest.mark.parametrize(("towards", "heading"), [(0, 0), (90, 0), (270, 0), (30, 300), (100, 100), (15, 195)])
def test_a_regular_wave_pushes_by_its_amplitude_and_phase(towards: float, heading: float) -> None:
    """a (real cos theta - imaginary sin theta), theta = k . x - omega t + phase, at a tabulated frequency and heading;
    from port sway, roll and yaw turn over. The nearest of 384 frequencies up to 3 rad/s lies up to 0.004 off, and 0.4 %
    of a difference between neighbouring rows with it.
    """
    omega, a, phase, x, y = 2.0, 0.35, 40.0, 7.0, -11.0
    t = np.linspace(0, 5, 23)
    found = pushed(sea(wave(omega, towards, 2 * a, phase)), x, y, heading, t)
    k, angle = omega**2 / 9.81, -np.radians(towards)
    theta = k * (x * np.cos(angle) + y * np.sin(angle)) - omega * t + np.radians(phase)
    relative = (towards - heading + 180) % 360 - 180
    row = HEADINGS.index(abs(relative))
    expected = a * (REAL[1, row] * np.cos(theta)[:, None] - IMAGINARY[1, row] * np.sin(theta)[:, None])
    if relative < 0 and abs(relative) != 180:
        expected *= EVEN
    assert found == pytest.approx(expected, abs=0.01 * a * 3)


def test_forces_of_waves_add() -> None:
    a, b = wave(1.3, 20.0, 0.5, 10.0), wave(2.6, 250.0, 0.2, -70.0)
    t = np.linspace(0, 9, 11)
    both, one, other = (pushed(sea(*w), 3.0, 4.0, 50.0, t) for w in ((a, b), (a,), (b,)))
    assert both == pytest.approx(one + other, abs=1e-9)
    assert np.abs(one).max() > 0.01
    assert np.abs(other).max() > 0.01


@pytest.fixture(scope="module")
def section() -> Any:
    """A box 0.8 m wide, 0.3 m deep, its bilges round, and the vehicle of 0.5 m of it, x across the section."""
    half, depth = 0.4, 0.3
    down = depth * (1 - np.cos(np.linspace(0, np.pi, 17))) / 2
    across = half * np.cos(np.linspace(np.pi, 0, 25))
    port = np.stack([0 * down - half, -down], -1)
    points = np.concatenate([port[:-1], np.stack([across, 0 * across - depth], -1), (port * [-1, 1])[::-1][1:]])
    length, omegas = 0.5, np.linspace(2.0, 6.0, 5)
    found = [section_waves(points, w, depth=1.2) for w in omegas]
    to = np.zeros((6, 3))
    to[[0, 2, 4], [0, 1, 2]] = [1.0, -1.0, 1.0]
    on = length * np.array([to @ f.diffraction for f in found])
    both = np.stack([on, on * np.array([-1, 1, 1, 1, -1, 1])], axis=1)
    mass = RHO * 2 * half * depth * length
    vehicle = {
        "type": "custom", "density_kg_m3": RHO, "length_m": 2 * half, "beam_m": length, "height_m": 0.5,
        "mass": {"type": "explicit", "mass_kg": mass, "inertia_kg_m2": [9.0, 8.0, 7.0]},
        "added_mass": {"type": "none"},
        "terms": {"hydrostatics": {"type": "hydrostatic", "heave_n_m": 3900, "roll_n_m": 10, "pitch_n_m": 100}},
        "modes": {"actuators": {"type": "actuators"}}, "default_mode": "actuators",
        "afloat": {
            "hulls": [{"length_m": 2 * half, "beam_m": length, "freeboard_m": 0.2}],
            "radiation": {
                "source": "pelagos.hydro.section", "omega_radps": omegas.tolist(),
                "added_mass_infinite": (length * to @ section_added_mass(points, depth=1.2) @ to.T).tolist(),
                "damping": [(length * to @ f.damping @ to.T).tolist() for f in found],
                "diffraction": {"omega_radps": omegas.tolist(), "heading_deg": [0, 180], "real": both.real.tolist(),
                                "imaginary": both.imag.tolist()},
            },
        },
    }  # fmt: skip
    return points, length, vehicle


@pytest.mark.parametrize("towards", [0.0, 180.0])
def test_a_held_hull_feels_what_the_panel_method_says(section: Any, towards: float) -> None:
    """Pressure of the undisturbed wave on the mesh and diffraction of the table, summed, against both of the section in
    surge, heave and pitch: the pressure's polynomials and the box's twelve strips are within 3 % of the exact one.
    """
    points, length, vehicle = section
    hull = pl.Vehicle.from_dict(vehicle)
    seakeeping = hull.model.sea
    assert seakeeping is not None
    omega, a = 4.0, 0.001
    waves = sea(wave(omega, towards, 2 * a, 0.0), depth=1.2)
    ocean = SimpleNamespace(sea=lambda places, copy=None: waves, density=lambda place, t: RHO, tide=None)
    t = np.arange(24) / 24 * 2 * np.pi / omega
    zero = dr.zeros(jit.Float64, 24)
    level = [[1 + zero, zero, zero], [zero, 1 + zero, zero], [zero, zero, 1 + zero]]
    at, now = [zero, zero, zero], jit.Float64(t)
    under = seakeeping.waves(ocean, at, level, now)
    load = seakeeping.load(ocean, under, at, level, [0.0] * 6, now, seakeeping.table())
    columns = np.array([np.broadcast_to(np.array(jit.Float64(v)), 24) for v in load])
    found = 2 * np.mean((columns - columns.mean(axis=1)[:, None]) * np.exp(1j * omega * t), axis=1) / a
    whole = section_waves(points, omega, depth=1.2).excitation * RHO * length * np.array([1, -1, 1])
    if towards == 180.0:
        whole *= [-1, 1, -1]
    assert found[[0, 2, 4]] == pytest.approx(whole, rel=0.03)
    without = replace(seakeeping, diffraction=None)
    load = without.load(ocean, under, at, level, [0.0] * 6, now, seakeeping.table())
    assert np.ptp(np.array(load[0])) < 0.8 * np.ptp(columns[0])  # diffraction is a large part of it


def test_memory_is_of_the_hulls_own_motion(section: Any) -> None:
    """With diffraction a hull at rest radiates nothing however the water moves; without, it does."""
    _, _, vehicle = section
    bare = {**vehicle, "afloat": {**vehicle["afloat"]}}
    bare["afloat"]["radiation"] = {k: v for k, v in vehicle["afloat"]["radiation"].items() if k != "diffraction"}
    waves = {"ocean": {"waves": [wave(4.0, 0.0, 0.02, 30.0)], "waves_depth_m": 1.2, "temperature_c": 15, "salinity": 0}}
    seen = []
    for what in (vehicle, bare):
        sim = pl.Simulation.load({
            "world": {"type": "flat", "depth_m": 60.0}, **waves,
            "agents": {"it": {"vehicle": what, "control": "actuators", "start": {"position_m": [0.0, 0.0, 0.0]}}},
        })  # fmt: skip
        ocean, model = sim.model.ocean, pl.Vehicle.from_dict(what)
        state = model.initial_state(np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]]))
        rigid = Rigid([*state.position], state.attitude, [*state.velocity, *state.angular_velocity])
        seaway = model.flow(rigid, ocean, jit.Float64(0.3)).seaway
        assert seaway is not None
        seen.append(float(np.abs([np.array(jit.Float64(v)) for v in seaway.velocity]).max()))
    assert seen[0] == pytest.approx(0.0, abs=1e-12)
    assert seen[1] > 0.01


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"real": REAL[:2].tolist()}, "real must be 3 x 3 x 6"),
        ({"imaginary": IMAGINARY[:, :2].tolist()}, "imaginary must be 3 x 3 x 6"),
        ({"omega_radps": [1.0, 3.0, 2.0]}, "omega_radps must increase"),
        ({"heading_deg": [0.0, 80.0, 180.0]}, "evenly from 0 to 180"),
    ],
)
def test_bad_coefficients(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        DiffractionConfig.model_validate({**TABLE, **change})
