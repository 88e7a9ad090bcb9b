"""Free roll of a KVLCC2 model: period, and damping by the formula and by sections."""

from __future__ import annotations

import gzip
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
from page import Chapter, Row, keep, relative, table
from scipy.signal import savgol_filter

from pelagos.manoeuvres import run_manoeuvre
from pelagos.manoeuvres.measures import decay_measures, half_cycles
from pelagos.manoeuvres.orders import Orders
from pelagos.manoeuvres.trial import Trial
from pelagos.report import theme
from pelagos.vehicles.vehicle import Vehicle

FOLDER: Final = "02_ship_kvlcc2_rolldecay"
TITLE: Final = "A tanker's free roll"
SOURCE: Final = (
    "SSPA, roll decay at rest, model 1:68, test 21338 (martinlarsalbert/Prediction-of-roll-motion-using-fully-"
    "nonlinear-potential-flow-and-Ikedas-method, MIT). Kept: tables/roll.csv."
)
SCALE: Final = 68.0


MODEL_DENSITY: Final = 1000.0  # of the tank's water, as the description says
FULLEST: Final = 0.99
"""Largest area coefficient that the formula's authors made it for."""


def model(*, variant: str | None = None, fullest: float = 1.0) -> dict[str, Any]:
    """The catalogue's ship at the model's size, floating free, without helm and propeller.

    Sections of a variant that has them are made no fuller than `fullest`.
    """
    kept = Vehicle.from_dict({"type": "kvlcc2", "variant": variant}).config.model_dump(mode="python")
    k, share = SCALE, MODEL_DENSITY / kept["density_kg_m3"]
    mass, terms = kept["mass"], kept["terms"]
    stiff, damped, roll = terms["hydrostatics"], terms["damping"]["diagonal"], dict(terms["roll"])
    size = [k**-3] * 3 + [k**-5] * 3
    roll |= {key: roll[key] and roll[key] / k for key in ("draught_m", "gravity_depth_m")}
    if roll["sections"] is not None:
        given = roll["sections"]
        box = np.array(given["beam_m"]) * np.array(given["draught_m"])
        roll["sections"] = {
            **{key: [x / k for x in given[key]] for key in ("x_m", "beam_m", "draught_m")},
            "area_m2": (np.minimum(given["area_m2"], fullest * box) / k**2).tolist(),
        }
    return {
        "type": "custom", "density_kg_m3": MODEL_DENSITY, "length_m": kept["length_m"] / k,
        "beam_m": kept["beam_m"] / k, "height_m": kept["height_m"] / k,
        "mass": {"type": "explicit", "mass_kg": mass["mass_kg"] * share / k**3,
                 "inertia_kg_m2": [x * share / k**5 for x in mass["inertia_kg_m2"]],
                 "center_of_gravity_m": [x / k for x in mass["center_of_gravity_m"]]},
        "added_mass": {"type": "diagonal", "diagonal": [
            x * share * s for x, s in zip(kept["added_mass"]["diagonal"], size, strict=True)]},
        "terms": {
            "hydrostatics": {"type": "hydrostatic", "heave_n_m": stiff["heave_n_m"] * share / k**2,
                             "roll_n_m": stiff["roll_n_m"] * share / k**4,
                             "pitch_n_m": stiff["pitch_n_m"] * share / k**4},
            "damping": {"type": "linear_damping",
                        "diagonal": [x * share * s * k**0.5 for x, s in zip(damped, size, strict=True)]},
            "roll": roll,
        },
        "modes": {"actuators": {"type": "actuators"}, "wrench": {"type": "wrench"}}, "default_mode": "wrench",
    }  # fmt: skip


def chapter(data: Path | None) -> Chapter:
    """Rows and picture."""
    if data is not None and (data / FOLDER).is_dir():
        _keep(data / FOLDER)
    t = table("roll.csv")
    time, roll = t["time_s"], t["roll_rad"]
    roll = savgol_filter(roll, 11, 3)  # over 1.1 s of the model: noise makes extremes of its own
    turns = np.flatnonzero(np.diff(np.sign(np.diff(roll))) != 0) + 1
    begin = int(turns[np.abs(roll[turns] - roll[-100:].mean()) > np.radians(2)][0])
    orders = Orders(angle_deg=float(np.degrees(np.abs(roll[begin]))), seconds=float(time[-1] - time[begin]))
    stopped = {"type": "kvlcc2", "actuators": {"rudder": {"revolutions_hz": 1e-3}}}  # or it would gather way, and lift
    ship = run_manoeuvre(stopped, "decay", replace(orders, seconds=orders.seconds * SCALE**0.5))
    models = {
        "by the formula": run_manoeuvre(model(), "decay", orders),
        "by sections": run_manoeuvre(model(variant="sections"), "decay", orders),
        f"by sections, none fuller than {FULLEST}": run_manoeuvre(
            model(variant="sections", fullest=FULLEST), "decay", orders
        ),
    }
    measured = {m.name: m.value for m in decay_measures(time[begin:], roll[begin:])}
    simulated = {m.name: m.value for m in ship.measures}
    mean = "damping ratio, mean"
    others = {"by sections": "some 10 to 30 % for full ships (recalled)"}
    rows: list[Row] = [
        relative("period of free roll, at the ship's size", "s", measured["period"] * SCALE**0.5,
                 simulated["period"], 2.0),
        relative(f"{mean} of the decay", "", measured[mean], simulated[mean], 15.0),
    ]  # fmt: skip
    for words, trial in models.items():
        own = {m.name: m.value for m in trial.measures}[mean]
        bar = 15.0 if words == "by sections" else None
        rows.append(
            relative(f"the same at the model's size, {words}", "", measured[mean], own, bar, others.get(words, ""))
        )
    picture = _drawn(time[begin:] - time[begin], np.sign(roll[begin]) * roll[begin:], models)
    return Chapter(TITLE, _ABOUT, SOURCE, rows, _MISSED, picture, "roll")


def _drawn(time: np.ndarray, roll: np.ndarray, models: dict[str, Trial]) -> bytes:
    """The decay, and the damping ratio of its cycles over their mean amplitude."""
    with theme.style():
        figure = theme.figure(10.5, 3.4)
        decay, ratio = figure.subplots(1, 2)
        decay.plot(time, np.degrees(roll), color=theme.SENSOR, label="measured")
        ratio.plot(*_by_amplitude(time, roll), ".", color=theme.SENSOR, ms=3, label="measured")
        for (words, trial), dashes in zip(models.items(), ("-", "--", ":"), strict=True):
            passed, angle = trial.track.time, trial.track.attitude[:, 0]
            decay.plot(passed, np.degrees(angle), dashes, color=theme.TRUTH, lw=0.7, label=words)
            ratio.plot(*_by_amplitude(passed, angle), dashes, color=theme.TRUTH, label=words)
        decay.set_xlim(0, 60)
        decay.set_xlabel("time, at the model's size [s]")
        decay.set_ylabel("roll [deg]")
        ratio.set_xlabel("mean amplitude [deg]")
        ratio.set_ylabel("damping ratio")
        ratio.set_ylim(bottom=0)
        ratio.legend(fontsize=8)
        picture = theme.as_png(figure)
        plt.close(figure)
    return picture


def _by_amplitude(time: np.ndarray, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean amplitude [deg] and damping ratio, each over eight half cycles, which evens out an angle of rest."""
    cycles, mean = half_cycles(time, angle), np.full(8, 1 / 8)
    return np.degrees(np.convolve(cycles.amplitude, mean, "valid")), np.convolve(cycles.ratio, mean, "valid")


def _keep(folder: Path) -> None:
    lines = gzip.decompress((folder / "model_test_21338.csv.gz").read_bytes()).decode().splitlines()
    names = lines[0].split(",")
    values = np.array([[float(x) for x in line.split(",")] for line in lines[1:]])
    time, roll = (values[:, names.index(n)] if n in names else values[:, 0] for n in ("time", "phi"))
    keep("roll.csv", SOURCE, {"time_s": time[::10], "roll_rad": roll[::10]}, 6)


_ABOUT: Final = """\
The catalogue's `kvlcc2` let go from the model's first extreme, at rest, its propeller stopped. Mass, metacentric height
and radius of gyration are those of the model test's description; added inertia in roll is assumed (17 %). Damping is
`roll_damping`: the formula of Kawahara, Maekawa and Ikeda for cargo ships, by the hull's form alone; and Ikeda's method
itself, of which the formula is a fit, by the sections of SSPA's hydrostatics of the hull (`variant: sections`), with
waves of Pelagos' own strips. Friction is the ship's, almost nothing, or the model's, where the ship is made 1:68.
"""
_MISSED: Final = """\
The hull is at the edge of those that the formula was fitted to: block coefficient 0.81 of at most 0.85, midship 0.998
taken as its limit of 0.99. At small angles both come near the test once friction is the model's (0.0016 of the damping
ratio): 0.0046 by sections, of which waves are 0.0030, 0.0052 by the formula, 0.0045 measured. Eddies damp too much, by
sections most: at 6 deg 0.017 in all, 0.010 by the formula, 0.0053 measured. Ikeda's coefficient hangs on the area
coefficient, which stands for the sharpness of the bilge: a radius of 2.4 m under 58 m of beam makes 0.998, where his
factor f3 = 1 + 4 exp(-165 000 (1 - 0.998)^2) takes the velocity at the bilge times 3, and eddies are four times those
of 0.99, which is the fullest that the authors made their formula for. With no section fuller than that the method gives
0.0076 at 6 deg. What remains is where eddies begin: measured damping is constant up to 5 deg and grows from there, that
of the method grows from 0 on. The sign of the centre of gravity's depth (2.2 m below the waterline) is not to blame:
above it, damping by the formula would be 2 % less at 2 deg and 11 % more at 8 deg.
"""
