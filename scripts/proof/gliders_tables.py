"""Small tables of the gliders' dives from their recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import gsw
import numpy as np
from page import keep
from scipy.signal import savgol_filter

from pelagos.identification.table import read_table

SHALLOW: Final = 5.0  # m: waves and foam above
SETTLING: Final = 60.0  # s after the engine moved
STILL: Final = 0.03  # of the engine's volume over a minute, in parts of 250 cc


def keep_tables(data: Path) -> None:
    """Write both tables."""
    _slocum(data / "06_glider_slocum_comet")
    _seaglider(data / "07_glider_seaglider")


def _even(time: np.ndarray, values: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    known = np.isfinite(values)
    grid = np.arange(time[known][0], time[known][-1], step)
    return grid, np.interp(grid, time[known], values[known])


def _slocum(folder: Path) -> None:
    parts = []
    for dive in range(3):
        flight = read_table(folder / f"comet-2016-174-05-00{dive}_flight.csv.gz")
        ctd = read_table(folder / f"comet-2016-174-05-00{dive}_ctd.csv.gz")
        ctd = {k: v[ctd["sci_water_cond"] > 0.1] for k, v in ctd.items()}
        dbar, order = ctd["sci_water_pressure"] * 10, np.argsort(ctd["t_s"])
        salinity = gsw.SP_from_C(ctd["sci_water_cond"] * 10, ctd["sci_water_temp"], dbar)
        absolute = gsw.SA_from_SP(salinity, dbar, 15.1, 54.75)
        density = gsw.rho(absolute, gsw.CT_from_t(absolute, ctd["sci_water_temp"], dbar), dbar)
        grid, depth = _even(ctd["t_s"][order], -gsw.z_from_p(dbar[order], 54.75), 1.0)
        up = -savgol_filter(depth, 21, 2, deriv=1)
        time = flight["t_s"]
        engine = flight["m_ballast_pumped"]
        values = {
            "dive": np.full(len(time), float(dive)),
            "time_s": time,
            "depth_m": np.interp(time, grid, depth),
            "rise_m_s": np.interp(time, grid, up),
            "pitch_rad": flight["m_pitch"],
            "density": np.interp(time, ctd["t_s"][order], density[order]),
            "engine_m3": engine * 1e-6,
            "battery_in": flight["m_battpos"],
        }
        calm = _calm(time, engine) & (values["depth_m"] > SHALLOW) & (time > grid[0]) & (time < grid[-1])
        parts.append({k: v[calm] for k, v in values.items()})
    keep(
        "slocum.csv",
        "Slocum comet, Baltic Sea, 2016-06-23: smerckel/gliderflight, MIT. Calm parts of three files.",
        {k: np.concatenate([p[k] for p in parts])[::2] for k in parts[0]},
        6,
    )


def _calm(time: np.ndarray, engine: np.ndarray) -> np.ndarray:
    """Samples with a known engine that has not moved for a while, nor soon will."""
    known = np.isfinite(engine)
    level = np.interp(time, time[known], engine[known])
    kept = [np.ptp(level[(time > t - SETTLING) & (time < t + 20)]) < STILL * 250 for t in time]
    return known & np.array(kept)


def _seaglider(folder: Path) -> None:
    from netCDF4 import Dataset

    parts = []
    for dive in (10, 12):
        d = Dataset(folder / f"p24900{dive}.nc")
        d.set_auto_mask(False)
        start = float(d["time"][0]) if "time" in d.variables else 0.0
        time = np.array(d["time"][:]) - start
        depth, engine = np.array(d["depth"][:]), np.array(d["eng_vbdCC"][:])
        clock, sa, ct, dbar = (
            np.array(d[n][:]) for n in ("ctd_time", "absolute_salinity", "conservative_temperature", "ctd_pressure")
        )
        clock = clock - start
        good = np.isfinite(sa) & np.isfinite(ct)
        there = {n: np.interp(time, clock[good], v[good]) for n, v in (("sa", sa), ("ct", ct), ("p", dbar))}
        grid, even = _even(time, depth, 5.0)
        up = -savgol_filter(even, 11, 2, deriv=1, delta=5.0)
        angle, own = (np.interp(time, clock, np.array(d[n][:], float)) for n in ("glide_angle", "vert_speed"))
        values = {
            "dive": np.full(len(time), float(dive)),
            "time_s": time,
            "depth_m": depth,
            "rise_m_s": np.interp(time, grid, up),
            "pitch_rad": np.radians(d["eng_pitchAng"][:]),
            "density": gsw.rho(there["sa"], there["ct"], 0.0),
            "engine_m3": engine * 1e-6,
            "temperature_c": there["ct"],
            "glide_rad": np.radians(angle),
            "operators_m_s": own / 100,
        }
        calm = _calm(time, engine) & (depth > SHALLOW)
        parts.append({k: v[calm] for k, v in values.items()})
    keep(
        "seaglider.csv",
        "Seaglider SG249, Washington shelf, 2024: iop-apl-uw/basestation3, BSD 3-clause. Calm parts, dives 10 and 12.",
        {k: np.concatenate([p[k] for p in parts])[::3] for k in parts[0]},
        6,
    )
