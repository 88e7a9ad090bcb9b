"""Tide of Honolulu predicted a quarter of a year ahead, and sound speed and density of a CTD cast."""

from __future__ import annotations

import gzip
from pathlib import Path
from typing import Final

import gsw
import matplotlib.pyplot as plt
import numpy as np
from page import Chapter, Row, at_least, at_most, keep, table

from pelagos import jit
from pelagos.acoustics.sound_speed import chen_millero, mackenzie
from pelagos.ocean.analytic_current import TIDE_PERIOD_H
from pelagos.ocean.tide import TideConfig, make_tide
from pelagos.report import theme

FOLDER: Final = "13_ctd_tide_bathy"
TITLE: Final = "Tide, sound speed and density"
SOURCE: Final = (
    "sea level of Honolulu, 2010 (wesleybowman/UTide, MIT); CastAway CTD, 2017 (pyoceans/python-ctd, BSD 3-clause). "
    "Kept: every third hour in tables/honolulu.csv, tables/castaway.csv."
)
SPLIT: Final = 0.75  # share of the year that is analysed


def chapter(data: Path | None) -> Chapter:
    """Rows and picture."""
    if data is not None and (data / FOLDER).is_dir():
        _keep(data / FOLDER)
    rows, picture = tide()
    return Chapter(TITLE, _ABOUT, SOURCE, [*rows, *cast()], _MISSED, picture, "water")


def tide() -> tuple[list[Row], bytes]:
    """The last quarter of the year from constituents of the first three."""
    t = table("honolulu.csv")
    hours, level = t["hour"], t["level_m"]
    early = hours < SPLIT * hours[-1]
    omega = 2 * np.pi / np.array(list(TIDE_PERIOD_H.values()))
    waves = np.concatenate(
        [np.cos(np.outer(hours, omega)), np.sin(np.outer(hours, omega)), np.ones((len(hours), 1))], axis=1
    )
    found = np.linalg.lstsq(waves[early], level[early], rcond=None)[0]
    n = len(omega)
    amplitude, phase = np.hypot(found[:n], found[n : 2 * n]), np.degrees(np.arctan2(found[n : 2 * n], found[:n]))
    made = make_tide(
        tuple(
            TideConfig(constituent=name, amplitude_m=a, phase_deg=p)
            for name, a, p in zip(TIDE_PERIOD_H, amplitude, phase, strict=True)
        ),
        float(found[-1]),
    )
    assert made is not None
    simulated = np.array(made.level(jit.Float64(hours * 3600.0)))
    off = (simulated - level)[~early]
    varying = off - off.mean()
    inside = (simulated - level)[early]
    spread = level[~early] - level[~early].mean()
    rows = [
        at_least(
            "tide, variance of the unseen quarter explained, about its mean",
            1 - float(varying @ varying / (spread @ spread)),
            0.95,
        ),
        at_most("tide, rms about its mean, unseen quarter", float(varying.std()) * 100, "cm", 5.0),
        Row("tide, rms of the analysed part", "", "", float((inside - inside.mean()).std()) * 100, "cm", None),
        Row(
            "mean level of the unseen quarter",
            f"{level[~early].mean() * 100:.1f} cm",
            f"{simulated[~early].mean() * 100:.1f} cm",
            float(off.mean()) * 100,
            "cm",
            None,
        ),
    ]
    with theme.style():
        figure = theme.figure(10.5, 2.8)
        axes = figure.subplots()
        shown = hours > hours[-1] - 24 * 14
        axes.plot(hours[shown] / 24, level[shown], color=theme.SENSOR, label="measured")
        axes.plot(
            hours[shown] / 24, simulated[shown], color=theme.TRUTH, label="from ten constituents of the record before"
        )
        axes.set_xlabel("day of 2010")
        axes.set_ylabel("sea level [m]")
        axes.legend(ncols=2)
        picture = theme.as_png(figure)
        plt.close(figure)
    return rows, picture


def cast() -> list[Row]:
    """Sound speed and density of the ocean's equation of state, and of two older formulas, against the instrument's."""
    c = table("castaway.csv")
    absolute = gsw.SA_from_SP(c["salinity"], c["dbar"], 150.23, -36.22)
    conservative = gsw.CT_from_t(absolute, c["celsius"], c["dbar"])
    speed, density = gsw.sound_speed(absolute, conservative, c["dbar"]), gsw.rho(absolute, conservative, c["dbar"])
    t, s, z, bar = (jit.Float64(x) for x in (c["celsius"], c["salinity"], c["depth_m"], c["dbar"] / 10))
    rows = [
        at_most(
            "sound speed by TEOS-10 against the instrument's, rms",
            _rms(speed - c["sound_m_s"]),
            "m/s",
            0.2,
            "0.15 m/s: data sheet",
        )
    ]
    rows.append(
        at_most(
            "sound speed by Chen and Millero, rms", _rms(np.array(chen_millero(t, s, bar)) - c["sound_m_s"]), "m/s", 0.2
        )
    )
    rows.append(
        at_most("sound speed by Mackenzie, rms", _rms(np.array(mackenzie(t, s, z)) - c["sound_m_s"]), "m/s", 0.2)
    )
    rows.append(
        at_most("density by TEOS-10 against the instrument's, rms", _rms(density - c["density"]), "kg/m3", 0.05)
    )
    return rows


def _rms(x: np.ndarray) -> float:
    return float(np.sqrt((x**2).mean()))


def _keep(folder: Path) -> None:
    rows = np.array(
        [line.split() for line in gzip.decompress((folder / "HNL2010.asc.gz").read_bytes()).decode().splitlines()],
        float,
    )
    known = np.abs(rows[:, 1]) < 9000
    rows = rows[known][::3]
    keep(
        "honolulu.csv",
        "Sea level of Honolulu 2010, every third hour: wesleybowman/UTide, MIT.",
        {"hour": (rows[:, 0] - rows[0, 0]) * 24, "level_m": rows[:, 1] / 1000},
        7,
    )
    lines = [
        x.split(",")
        for x in (folder / "castaway_data.csv").read_text(encoding="utf-8").splitlines()
        if x and not x.startswith("%")
    ]
    values = np.array([[float(x) for x in row] for row in lines[1:]])
    names = {"dbar": 0, "depth_m": 1, "celsius": 2, "salinity": 5, "sound_m_s": 6, "density": 7}
    keep(
        "castaway.csv",
        "CastAway CTD, 2017-08-22, 36.2 S 150.2 E: pyoceans/python-ctd, BSD 3-clause.",
        {k: values[:, n] for k, n in names.items()},
        8,
    )


_ABOUT: Final = """\
Ten constituents of [`tide`](ocean.md) are analysed from three quarters of a record of sea level and predict the last.
The mean level of a quarter is weather and season, not tide: it is listed and taken out. The cast: temperature,
salinity and pressure of the instrument go into the ocean's equation of state; its own sound speed and density are the
other side.
"""
_MISSED: Final = ""
