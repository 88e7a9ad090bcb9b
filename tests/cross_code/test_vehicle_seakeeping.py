"""A box barge in waves against Capytaine 3.0.0: responses in regular waves, and periods of free motion.

10 m x 4 m, 1 m of draught, as heavy as the water that it displaces, centre of gravity in the water plane, radii of
gyration 1.4 m and 2.5 m. Capytaine has 24 x 10 x 6 panels (half of them below water), a lid, deep water, waves along x;
its response is (-w^2 (M + A) - i w B + C)^-1 of the Froude-Krylov and diffraction forces. `data/capytaine_barge.json`
has added mass and damping over the density, by frequency.
"""

import json
from pathlib import Path

import numpy as np
import pytest

import pelagos as pl

TABLE = json.loads((Path(__file__).parent / "data/capytaine_barge.json").read_text())
MASS, RHO, G = 40_000.0, 1000.0, 9.81
HEAVE, ROLL, PITCH = RHO * G * 40, RHO * G * 40 * (4 / 3 - 0.5), RHO * G * 40 * (25 / 3 - 0.5)
BARGE = {
    "type": "custom",
    "density_kg_m3": RHO,
    "length_m": 10.0,
    "beam_m": 4.0,
    "height_m": 2.0,
    "mass": {
        "type": "explicit",
        "mass_kg": MASS,
        "inertia_kg_m2": [MASS * 1.4**2, MASS * 2.5**2, MASS * 2.6**2],
    },
    "added_mass": {"type": "none"},
    "terms": {"hydrostatics": {"type": "hydrostatic", "heave_n_m": HEAVE, "roll_n_m": ROLL, "pitch_n_m": PITCH}},
    "modes": {"actuators": {"type": "actuators"}},
    "default_mode": "actuators",
    "afloat": {"hulls": [{"length_m": 10.0, "beam_m": 4.0, "freeboard_m": 1.0}], "radiation": TABLE},
}


def afloat(
    vehicle: dict, waves: list[dict], seconds: float, every: float = 0.1, **moved: object
) -> tuple[np.ndarray, np.ndarray]:
    """Times [s], and heave [m], roll and pitch [rad], in waves from astern."""
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 50,
            "world": {"type": "flat", "depth_m": 400.0},
            "ocean": {"temperature_c": 4.0, "salinity": 0.0, "waves": waves},
            "agents": {
                "it": {"vehicle": vehicle, "control": "actuators", "start": {"position_m": [0, 0], "depth_m": 0}}
            },
        }
    )
    if moved:
        sim.set_state("it", **moved)
    t, rows = [], []
    while sim.time_ns < seconds * 1e9:
        sim.run(every)
        state = sim.state["it"]
        t.append(sim.time_ns * 1e-9)
        rows.append([state.position[0, 2], *state.euler[0, :2]])
    return np.array(t), np.array(rows)


def regular(height: float, omega: float, phase_deg: float = 0.0) -> dict:
    return {"type": "regular", "height_m": height, "period_s": 2 * np.pi / omega, "towards_deg": 0.0,
            "phase_deg": phase_deg}  # fmt: skip


# w [rad/s], heave [m/m] and pitch [rad/m] per metre of amplitude: Capytaine 3.0.0
RESPONSES = [(0.8, 0.9909, 0.06377), (1.0, 0.9801, 0.09795), (1.2, 0.9648, 0.13767), (1.4, 0.9450, 0.18208)]


def test_response_in_waves_from_three_lengths_up() -> None:
    """96 to 31 m of wave length, 5 cm high, all at once; after 40 s, ten pi seconds hold whole periods of each.
    Diffraction by relative motion leaves some per cent; the issue's 5 % hold."""
    omega, heave, pitch = np.array(RESPONSES).T
    waves = [regular(0.05, w, phase) for w, phase in zip(omega, (0.0, 70.0, -110.0, 200.0), strict=True)]
    t, rows = afloat(BARGE, waves, 75.0, 0.2)
    late = t > 75.0 - 10 * np.pi
    phases = np.outer(t[late], omega)
    basis = np.column_stack([np.ones(late.sum()), t[late], np.cos(phases), np.sin(phases)])
    found = np.linalg.lstsq(basis, rows[late], rcond=None)[0]
    amplitude = np.hypot(found[2:6], found[6:]) / 0.025
    assert amplitude[:, 0] == pytest.approx(heave, rel=0.05)
    assert amplitude[:, 2] == pytest.approx(pitch, rel=0.05)


def natural(stiffness: float, inertia: float, axis: int) -> float:
    """Period [s] of free motion about an equilibrium, with Capytaine's added mass at its own frequency."""
    omega, added = np.array(TABLE["omega_radps"]), RHO * np.array(TABLE["added_mass"])[:, axis, axis]
    w = 2.0
    for _ in range(50):
        w = np.sqrt(stiffness / (inertia + np.interp(w, omega, added)))
    return 2 * np.pi / w


def test_periods_of_heave_and_roll() -> None:
    """Let go, 5 cm high and 3 deg over. Damping of 0.13 of critical lengthens heave's by 1 - 0.13^2 / 2.

    Added mass is interpolated between 0.2 rad/s, heave's damping is fitted by four exponentials: 2 %. Roll is coupled
    to sway, whose added mass takes 1 to 3 % from its inertia: 4 %.
    """
    roll = np.radians(3.0)
    level = {"attitude": (np.cos(roll / 2), np.sin(roll / 2), 0.0, 0.0), "position": (0.0, 0.0, 0.05)}
    t, rows = afloat(BARGE, [regular(1e-6, 1.0)], 16.0, **level)
    assert _period(t, rows[:, 0]) == pytest.approx(natural(HEAVE, MASS, 2) / np.sqrt(1 - 0.126**2), rel=0.02)
    assert _period(t, rows[:, 1]) == pytest.approx(natural(ROLL, MASS * 1.96, 3), rel=0.04)


def test_wamv_periods() -> None:
    """Let go in a calm, pressure on its pontoons against sqrt(C / (M + A)) of the formulas for their waterplane.

    Without a panel method's coefficients, so that A is one number. Polygons of 8 strips hold 3 % less waterplane, which
    is 1.5 % of the period; the pontoons' sides are not upright under water; roll's moment is coupled to sway by the
    centre of gravity, 0.2 m up: 4 % in all.
    """
    rho = 1025.0
    wamv = pl.Vehicle.from_catalogue("wamv")
    whole = wamv.config.body.mass_matrix
    area = 2 * 4.9 * 0.426 * 0.76
    stiff = rho * G * area * np.array([1.0, 1.027**2 + 0.426**2 / 20]) - [0.0, 180 * G * 0.2]
    roll = np.radians(2.0)
    start = {"attitude": (np.cos(roll / 2), np.sin(roll / 2), 0.0, 0.0), "position": (0.0, 0.0, 0.02)}
    t, rows = _fine({"type": "wamv", "afloat": {"radiation": None}}, 4.0, **start)
    for c, axis, damping in zip(stiff, (2, 3), (500, 500), strict=True):
        w = np.sqrt(c / whole[axis, axis])
        ratio = damping / (2 * w * whole[axis, axis])
        found = _period(t, rows[:, axis - 2])
        assert found == pytest.approx(2 * np.pi / w / np.sqrt(1 - ratio**2), rel=0.04)


def _fine(vehicle: dict, seconds: float, **moved: object) -> tuple[np.ndarray, np.ndarray]:
    wave = {"type": "regular", "height_m": 1e-6, "period_s": 6.0}
    ocean = {"waves": [wave]}
    start = {"position_m": [0, 0], "depth_m": 0}
    sim = pl.Simulation.load(
        {
            "tick_rate_hz": 200,
            "world": {"type": "flat", "depth_m": 400.0},
            "ocean": ocean,
            "agents": {"it": {"vehicle": vehicle, "control": "actuators", "start": start}},
        }
    )
    sim.run(1.0)
    sim.set_state("it", **moved)
    t, rows = [], []
    while sim.time_ns < (1 + seconds) * 1e9:
        sim.run(0.01)
        state = sim.state["it"]
        t.append(sim.time_ns * 1e-9 - 1)
        rows.append([state.position[0, 2], *state.euler[0, :2]])
    return np.array(t), np.array(rows)


def _period(t: np.ndarray, x: np.ndarray) -> float:
    """Of a decaying oscillation: least squares of two exponentials and a level in the differences of samples."""
    from scipy.optimize import curve_fit

    y = x - x[-len(x) // 4 :].mean()

    def decay(t, a, b, rate, w):
        return np.exp(-rate * t) * (a * np.cos(w * t) + b * np.sin(w * t))

    best = min(
        (_fit(curve_fit, decay, t, y, w) for w in (1.2, 1.7, 2.3, 4.0, 6.0, 8.0, 11.0)), key=lambda found: found[1]
    )
    return 2 * np.pi / abs(best[0])


def _fit(curve_fit, decay, t, y, w):
    try:
        p, _ = curve_fit(decay, t, y, (y[0], 0.0, 0.1 * w, w), maxfev=4000)
    except RuntimeError:
        return w, np.inf
    return p[3], float(np.sum((decay(t, *p) - y) ** 2))
