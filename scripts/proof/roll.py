"""Free roll of a KVLCC2 model: period and damping."""

from __future__ import annotations

import gzip
from pathlib import Path
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
from page import Chapter, Row, keep, relative, table
from scipy.signal import savgol_filter

from pelagos.manoeuvres import run_manoeuvre
from pelagos.manoeuvres.measures import decay_measures
from pelagos.manoeuvres.orders import Orders
from pelagos.report import theme

FOLDER: Final = "02_ship_kvlcc2_rolldecay"
TITLE: Final = "A tanker's free roll"
SOURCE: Final = (
    "SSPA, roll decay at rest, model 1:68, test 21338 (martinlarsalbert/Prediction-of-roll-motion-using-fully-"
    "nonlinear-potential-flow-and-Ikedas-method, MIT). Kept: tables/roll.csv."
)
SCALE: Final = 68.0


def chapter(data: Path | None) -> Chapter:
    """Rows and picture."""
    if data is not None and (data / FOLDER).is_dir():
        _keep(data / FOLDER)
    t = table("roll.csv")
    time, roll = t["time_s"] * SCALE**0.5, t["roll_rad"]
    roll = savgol_filter(roll, 11, 3)  # over 1.1 s of the model: noise makes extremes of its own
    turns = np.flatnonzero(np.diff(np.sign(np.diff(roll))) != 0) + 1
    begin = int(turns[np.abs(roll[turns] - roll[-100:].mean()) > np.radians(2)][0])
    angle = float(np.degrees(np.abs(roll[begin])))
    stopped = {"type": "kvlcc2", "actuators": {"rudder": {"revolutions_hz": 1e-3}}}  # or it would gather way, and lift
    trial = run_manoeuvre(stopped, "decay", Orders(angle_deg=angle, seconds=float(time[-1] - time[begin])))
    measured = {m.name: m.value for m in decay_measures(time[begin:], roll[begin:])}
    simulated = {m.name: m.value for m in trial.measures}
    mean = "damping ratio, mean"
    others = "Ikeda's method by sections: some 10 to 30 % for full ships (recalled)"
    rows: list[Row] = [
        relative("period of free roll, at the ship's size", "s", measured["period"], simulated["period"], 2.0),
        relative(f"{mean} of the decay", "", measured[mean], simulated[mean], 15.0, others),
    ]  # fmt: skip
    with theme.style():
        figure = theme.figure(10.5, 2.8)
        axes = figure.subplots()
        side = np.sign(roll[begin])
        axes.plot(time[begin:] - time[begin], side * np.degrees(roll[begin:]), color=theme.SENSOR, label="measured")
        axes.plot(trial.track.time, np.degrees(trial.track.attitude[:, 0]), color=theme.TRUTH, label="simulated")
        axes.set_xlabel("time, at the ship's size [s]")
        axes.set_ylabel("roll [deg]")
        axes.legend()
        picture = theme.as_png(figure)
        plt.close(figure)
    return Chapter(TITLE, _ABOUT, SOURCE, rows, _MISSED, picture, "roll")


def _keep(folder: Path) -> None:
    lines = gzip.decompress((folder / "model_test_21338.csv.gz").read_bytes()).decode().splitlines()
    names = lines[0].split(",")
    values = np.array([[float(x) for x in line.split(",")] for line in lines[1:]])
    time, roll = (values[:, names.index(n)] if n in names else values[:, 0] for n in ("time", "phi"))
    keep("roll.csv", SOURCE, {"time_s": time[::10], "roll_rad": roll[::10]}, 6)


_ABOUT: Final = """\
The catalogue's `kvlcc2` let go from the model's first extreme, at rest, its propeller stopped. Mass, metacentric height
and radius of gyration are those of the model test's description; added inertia in roll is assumed (17 %). Damping is
`roll_damping`: the formula of Kawahara, Maekawa and Ikeda for cargo ships, by the hull's form alone.
"""
_MISSED: Final = """\
The hull is at the edge of those that the formula was fitted to: block coefficient 0.81 of at most 0.85, midship 0.998
taken as its limit of 0.99. At small angles waves damp as the test shows; eddies at large ones damp too much. Ikeda's
method by sections, of which the formula is a fit, is not in Pelagos. Friction is the ship's, almost nothing; the
model's would add 0.0015. The limit is not to blame: with 0.998 the formula's eddies are 27 % larger, and all damping
8 % at 2 deg and 17 % at 8 deg. Nor is the sign of the centre of gravity's depth (2.2 m below the waterline): above it,
damping would be 2 % less at 2 deg and 11 % more at 8 deg.
"""
