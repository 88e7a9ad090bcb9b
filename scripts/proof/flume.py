"""A ship's section across a wave flume: excitation when held, motions when free, waves as they came."""

from __future__ import annotations

import gzip
import tempfile
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
from flume_waves import DEPTH_M, SAMPLE_S, about, separated, synthesis, wavenumbers
from numpy.typing import NDArray
from page import Chapter, Row, keep, relative, table
from scipy.interpolate import CubicSpline
from scipy.signal import hilbert

import pelagos as pl
from pelagos.hydro.algebra import add, cross, matvec, transpose
from pelagos.hydro.section import SectionWaves, section_added_mass, section_waves
from pelagos.report import theme

FOLDER: Final = "05_waves_floating_body_flume"
TITLE: Final = "A section in beam waves"
SOURCE: Final = (
    "NTNU wave flume 2025, ship-like section (KRSundsdal1/2D-ship-cross-section-in-regular-waves, CC0). Kept: "
    "tables/flume_waves.csv, flume_held.csv, flume_free.csv."
)
Array = NDArray[np.float64]

OMEGA: Final = {
    1: 4.143,
    4: 5.194,
    6: 5.425,
    7: 5.646,
    8: 5.860,
    10: 7.004,
    11: 7.830,
    14: 9.905,
}  # by number of the wave [rad/s]
ALONE: Final = {"1011": 1, "1041": 4, "1071": 7, "1102": 10, "1141": 14}
APART_M: Final = 5.475  # first and last gauge, as these five say together
HELD: Final = {"2012": 1, "2041": 4, "2062": 6, "2082": 8, "2112": 11}
FREE: Final = {"3012_1": 1, "3041_2": 4, "3061_1": 6, "3102_1": 10}
RESONANT: Final = (4, 6)  # roll's own frequency is 4.99 rad/s, heave's 5.37 rad/s, as its decay tests say

LENGTH_M, BEAM_M, DRAUGHT_M, HEIGHT_M, BILGE_M = 0.586, 0.40, 0.20, 0.256, 0.0512
MASS_KG, KEEL_TO_GRAVITY_M, GYRATION_M = 46.8, 0.106, 0.360 * 0.40
SLED_KG, RAILS_KG_S, SPRINGS_N_M = 0.303, 8.70, 59.4  # moves in sway only; damping in sway and heave; in sway
GRAVITY_M: Final = DRAUGHT_M - KEEL_TO_GRAVITY_M  # below the waterline
DENSITY: Final = 999.1  # of fresh water at 15 degC
STEP_S: Final = 0.01
KEPT_S: Final = 0.125
BEGIN_S: Final = 20.0  # the wave is there


def chapter(data: Path | None) -> Chapter:
    """Rows and picture."""
    if data is not None and (data / FOLDER).is_dir():
        _keep(data / FOLDER)
    held, free, alone = table("flume_held.csv"), table("flume_free.csv"), table("flume_waves.csv")
    rows: list[Row] = []
    for number, phase in zip(alone["wave"].astype(int), alone["phase"], strict=True):
        linear = float(wavenumbers(np.array([OMEGA[number]]))[0])
        turns = round((linear * APART_M - phase) / (2 * np.pi))
        long = 2 * np.pi * APART_M / (phase + 2 * np.pi * turns)
        rows.append(relative(f"no hull, {_named(number)}: wavelength", "m", long, 2 * np.pi / linear, 10.0))
    for i, number in enumerate(held["wave"].astype(int)):
        found = section_waves(section(), OMEGA[number], depth=DEPTH_M)
        ratio = np.abs(found.excitation) * DENSITY * LENGTH_M
        wave = _named(number)
        rows += [
            relative(f"held, {wave}: force in sway over the wave's amplitude", "N/m", held["sway"][i], ratio[0], 10.0),
            relative(f"held, {wave}: force in heave", "N/m", held["heave"][i], ratio[1], 10.0),
            relative(f"held, {wave}: reflected wave", "", held["reflected"][i], abs(found.reflected), 10.0),
        ]  # fmt: skip
    runs = []
    for number in sorted(set(free["wave"].astype(int))):
        seen = {key: values[free["wave"] == number] for key, values in free.items()}
        ran = _simulated(seen, number)
        runs.append((number, seen, ran))
        bar = 20.0 if number in RESONANT else 10.0
        for name, unit, scale in (("sway", "mm", 1e3), ("heave", "mm", 1e3), ("roll", "deg", 180 / np.pi)):
            pair = [scale * 2**0.5 * float(np.std(one[name])) for one in (seen, ran)]
            rows.append(relative(f"free, {_named(number)}: amplitude of {name}", unit, *pair, bar))
    return Chapter(TITLE, _ABOUT, SOURCE, rows, _MISSED, _picture(runs), "flume")


def _named(number: int) -> str:
    return f"{2 * np.pi / OMEGA[number]:.2f} s"


def section(panels: int = 64) -> Array:
    """The section `(n, 2)`, y and z [m]."""
    half, r, d = BEAM_M / 2, BILGE_M, DRAUGHT_M

    def line(a: tuple[float, float], b: tuple[float, float]) -> Array:
        share = 0.5 * (1 - np.cos(np.pi * np.linspace(0, 1, panels // 4 + 1)))[:-1, None]
        return np.array(a) + (np.array(b) - np.array(a)) * share

    turn = np.linspace(0, np.pi / 2, panels // 8 + 1)[:-1]
    port = np.stack([r - half - r * np.cos(turn), r - d - r * np.sin(turn)], axis=-1)
    starboard = np.stack([half - r + r * np.sin(turn), r - d - r * np.cos(turn)], axis=-1)
    sides = line((-half, 0.0), (-half, r - d)), line((half, r - d), (half, 0.0))
    return np.concatenate([sides[0], port, line((r - half, -d), (half - r, -d)), starboard, sides[1], [[half, 0.0]]])


def rig(flow: Any, parameters: Any) -> list[Any]:
    """Rails and springs (6): they hold the centre of gravity, and stand still while the water moves."""
    arm = [0.0, 0.0, GRAVITY_M]
    speed = matvec(flow.rotation, add(flow.nu[:3], cross(flow.nu[3:], arm)))
    north = flow.position[0] + matvec(flow.rotation, arm)[0]
    force = matvec(
        transpose(flow.rotation), [-RAILS_KG_S * speed[0] - SPRINGS_N_M * north, 0.0, -RAILS_KG_S * speed[2]]
    )
    return [*force, *cross(arm, force)]


def vehicle(hull: Path) -> dict[str, Any]:
    """The model, its x axis across the section: sway, heave and roll of the flume are surge, heave and pitch."""
    idle = {"type": "linear_damping", "diagonal": [0.0, 20.0, 0.0, 1.0, 0.0, 1.0]}
    return {
        "type": "custom", "title": "section of NTNU's flume", "density_kg_m3": DENSITY, "gravity_m_s2": 9.81,
        "length_m": BEAM_M, "beam_m": LENGTH_M, "height_m": HEIGHT_M,
        "mass": {
            "type": "explicit", "mass_kg": MASS_KG, "inertia_kg_m2": [1.5, MASS_KG * GYRATION_M**2, 1.5],
            "center_of_gravity_m": [0.0, 0.0, GRAVITY_M],
        },
        "added_mass": {"type": "diagonal", "diagonal": [0.0, 10.0, 0.0, 0.1, 0.0, 0.1]},
        "terms": {
            "hydrostatics": {"type": "hydrostatic", "heave_n_m": 2299.5, "roll_n_m": 44.0, "pitch_n_m": 28.9},
            "idle": idle,
            "rig": {"type": "function", "target": "flume:rig"},
        },
        "actuators": {}, "modes": {"wrench": {"type": "wrench"}}, "default_mode": "wrench",
        "afloat": {"mesh": str(hull), "radiation": _coefficients(), "restoring": "hull"},
    }  # fmt: skip


@cache
def _solved() -> tuple[tuple[SectionWaves, ...], Array]:
    points = section()
    return tuple(section_waves(points, w, depth=DEPTH_M) for w in np.linspace(1.0, 16.0, 31)), section_added_mass(
        points, depth=DEPTH_M
    )


def _coefficients() -> dict[str, Any]:
    """Of the section, FRD over the density, with the sled that moves in sway only as added mass."""
    found, endless = _solved()
    to = np.zeros((6, 3))
    to[[0, 2, 4], [0, 1, 2]] = LENGTH_M**0.5 * np.array([1.0, -1.0, 1.0])
    sled = np.array([1.0, 0.0, 0.0, 0.0, GRAVITY_M, 0.0])
    on = LENGTH_M**0.5 * np.array([(to @ one.diffraction) for one in found])
    from_ahead = on * np.array([-1, 1, 1, 1, -1, 1])  # the section is the same from both sides
    both = np.stack([on, from_ahead], axis=1)
    omega = [one.omega for one in found]
    return {
        "source": "pelagos.hydro.section",
        "omega_radps": omega,
        "added_mass_infinite": (to @ endless @ to.T + SLED_KG / DENSITY * np.outer(sled, sled)).tolist(),
        "damping": [(to @ one.damping @ to.T).tolist() for one in found],
        "diffraction": {
            "omega_radps": omega, "heading_deg": [0.0, 180.0],
            "real": both.real.tolist(), "imaginary": both.imag.tolist(),
        },
    }  # fmt: skip


def _hull(path: Path) -> Path:
    """The model's mesh, x across the section, cut into bands that follow the wave's pressure."""
    import trimesh

    top = HEIGHT_M - DRAUGHT_M
    ring = np.concatenate([[[-BEAM_M / 2, top]], section(), [[BEAM_M / 2, top]]])
    count = len(ring)
    sides = np.stack([np.column_stack([ring[:, 0], np.full(count, y), ring[:, 1]]) for y in (-0.5, 0.5)])
    sides[:, :, 1] *= LENGTH_M
    faces = []
    for i in range(count):
        j = (i + 1) % count
        faces += [[i, j, count + j], [i, count + j, count + i]]
    strips = [(i, count - 1 - i) for i in range(count // 2)]
    for (a, b), (c, d) in pairwise(strips):  # the ends, in bands from side to side
        for shift in (0, count):
            faces += [[shift + a, shift + c, shift + d], [shift + a, shift + d, shift + b]]
    (a, b), middle = strips[-1], count // 2
    if count % 2:
        faces += [[a, middle, b], [count + a, count + middle, count + b]]
    solid = trimesh.Trimesh(sides.reshape(-1, 3), faces)
    solid.merge_vertices()
    solid.fix_normals()
    solid.export(path)
    return path


def _simulated(seen: dict[str, Array], number: int) -> dict[str, Array]:
    """Sway and heave of the centre of gravity [m] and roll [rad] at the record's times, by its waves alone."""
    waves = synthesis(seen["t"], seen["wave_m"], OMEGA[number])
    with tempfile.TemporaryDirectory() as folder:
        sim = pl.Simulation.load(
            {
                "name": "flume", "tick_rate_hz": 1 / STEP_S, "duration_s": 200.0,
                "world": {"type": "flat", "depth_m": 40.0},
                "ocean": {"waves": waves, "waves_depth_m": DEPTH_M, "temperature_c": 15.0, "salinity": 0.0},
                "agents": {"model": {"vehicle": vehicle(_hull(Path(folder) / "hull.ply")), "control": "wrench",
                                     "start": {"position_m": [0.0, 0.0, 0.0]}}},
            },
            trust=True,
        )  # fmt: skip
        count = round(float(seen["t"][-1] - seen["t"][0]) / STEP_S)
        motion = np.tile([0.0, -GRAVITY_M, 0.0], (count + 1, 1))
        for i in range(count):
            sim.step({"model": np.zeros(6)})
            state = sim.state["model"]
            pitch = float(state.euler[0, 1])  # bow down
            x, _, z = state.position[0]
            motion[i + 1] = x - GRAVITY_M * np.sin(pitch), z - GRAVITY_M * np.cos(pitch), -pitch
    t = np.arange(count + 1) * STEP_S + seen["t"][0]
    return {
        name: about(seen["t"], CubicSpline(t, m)(seen["t"]), OMEGA[number])
        for name, m in zip(("sway", "heave", "roll"), motion.T, strict=True)
    }


def _keep(folder: Path) -> None:
    phases = []
    for name, number in ALONE.items():
        t, columns = _record(folder / f"{name}_40Hz.csv.gz")
        first, last = (hilbert(about(t, columns[:, i], OMEGA[number])) for i in (2, 6))
        steady = np.abs(last) > 0.8 * np.abs(last).max()  # of Re a exp(i omega t): waves that travel on lag behind
        phases.append([number, float(np.angle(np.vdot(last[steady], first[steady])))])
    keep(
        "flume_waves.csv",
        f"{SOURCE}\nPhase of the wave from the first to the last gauge [rad]",
        dict(zip(("wave", "phase"), np.array(phases).T, strict=True)),
    )
    held: dict[str, list[float]] = {key: [] for key in ("wave", "sway", "heave", "reflected")}
    for name, number in HELD.items():
        t, columns = _record(folder / f"{name}_40Hz.csv.gz")
        came, left = separated(columns[:, 2:6].T, OMEGA[number])
        late = (t > BEGIN_S) & (t < t[-1] - 5)
        force = [about(t, columns[:, i], OMEGA[number]) for i in (8, 9)]
        incident, *others = (hilbert(x)[late] for x in (came, *force, left))
        over = [float(abs(np.vdot(incident, x) / np.vdot(incident, incident))) for x in others]
        for key, value in zip(held, (number, *over), strict=True):
            held[key].append(value)
    keep(
        "flume_held.csv",
        f"{SOURCE}\nForces [N] over the incident wave's amplitude [m]; waves by number",
        {key: np.array(values) for key, values in held.items()},
    )
    parts = []
    for name, number in FREE.items():
        t, columns = _record(folder / f"{name}_40Hz.csv.gz")
        came, _ = separated(columns[:, 2:6].T, OMEGA[number])
        motions = [about(t, columns[:, i], OMEGA[number]) for i in (7, 8, 9)]
        every = slice(round(5 / SAMPLE_S), None, round(KEPT_S / SAMPLE_S))
        parts.append(np.column_stack([np.full(len(t), number), t, came, *motions])[every])
    names = ("wave", "t", "wave_m", "sway", "heave", "roll")
    keep(
        "flume_free.csv",
        f"{SOURCE}\nWave at the model as the gauges tell it and motions, of the wave's band: s, m, rad",
        dict(zip(names, np.concatenate(parts).T, strict=True)),
        4,
    )


def _record(path: Path) -> tuple[Array, Array]:
    """Time (n) [s] and all columns."""
    values = np.array([
        [float(x) for x in line.split(",")] for line in gzip.decompress(path.read_bytes()).decode().splitlines()[1:]
    ])  # fmt: skip
    return values[:, 0], values


def _picture(runs: list[tuple[int, dict[str, Array], dict[str, Array]]]) -> bytes:
    with theme.style():
        figure = theme.figure(10.5, 5.2)
        axes = figure.subplots(2, 3)
        omega = [one.omega for one in _solved()[0]]
        force = np.abs([one.excitation for one in _solved()[0]]) * DENSITY * LENGTH_M
        held = table("flume_held.csv")
        at = [OMEGA[n] for n in held["wave"].astype(int)]
        for k, name in enumerate(("sway", "heave")):
            axes[0, k].plot(omega, force[:, k], color=theme.TRUTH, label="computed")
            axes[0, k].plot(at, held[name], "o", color=theme.SENSOR, label="measured")
            axes[0, k].set_ylabel(f"{name} force [N/m]")
        axes[0, 2].plot(omega, [abs(one.reflected) for one in _solved()[0]], color=theme.TRUTH)
        axes[0, 2].plot(at, held["reflected"], "o", color=theme.SENSOR)
        axes[0, 2].set_ylabel("reflected over incident")
        for one in axes[0]:
            one.set_xlabel("frequency [rad/s]")
            one.set_xlim(3, 9)
            one.set_ylim(bottom=0)
        axes[0, 0].legend()
        _, seen, ran = runs[1]
        for one, (name, unit, scale) in zip(
            axes[1], (("sway", "mm", 1e3), ("heave", "mm", 1e3), ("roll", "deg", 180 / np.pi)), strict=True
        ):
            one.plot(seen["t"], scale * seen[name], color=theme.SENSOR, label="measured")
            one.plot(seen["t"], scale * ran[name], color=theme.TRUTH, label="simulated")
            one.set_xlabel("time [s], waves of 1.21 s")
            one.set_ylabel(f"{name} [{unit}]")
            one.set_xlim(18, 45)
        axes[1, 0].legend()
        picture = theme.as_png(figure)
        plt.close(figure)
    return picture


_ABOUT: Final = """\
Nothing is fitted: geometry, mass, radius of gyration, springs and the rails' friction are the laboratory's, and
potential flow (`pelagos.hydro.section`, a panel method in two dimensions) gives added mass, damping, Froude-Krylov and
diffraction forces. What the hull sends back is reflected again by the wave maker, so that waves grow and fade through a
record: four gauges tell the wave that comes from that which goes back. Held, the force is compared with that wave's
amplitude; free, a vehicle of Pelagos with pressure on its mesh, diffraction and memory goes through the wave as it
came, for the whole record, and the spread of both motions is compared.
"""
_MISSED: Final = """\
Sway near 1.2 s is what remains where the wave's force and the coupling with roll nearly cancel: 3 to 4 mm. That sway is
14 % too large in waves of 0.90 s, though the force on the held hull is within 3 %, is not explained; the guides' static
friction (0.2 to 0.5 N) and the rig's mass beyond the sled's are not in the model. Eddies are not either: at resonance
heave is 16 to 19 % and roll at most 9 % too large. Water that passes the ends (gaps of 7 mm) is the likely reason why a
little less is reflected. The moment in roll on the held hull was measured about an axis whose height is not told.
"""
