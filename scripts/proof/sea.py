"""Seas made from what buoys measured, measured again with a buoy in the simulated sea."""

from __future__ import annotations

import csv
import gzip
from pathlib import Path
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
from page import Chapter, Row, at_most, keep, table
from scipy.signal import csd, welch

from pelagos import jit
from pelagos.math.geodesy import GeoOrigin
from pelagos.ocean import spectrum
from pelagos.ocean.site import Site
from pelagos.ocean.wave_system import TableWavesConfig
from pelagos.ocean.waves import Waves, make_waves
from pelagos.report import theme

FOLDER: Final = "11_waves_buoys"
TITLE: Final = "Seas of wave buoys"
SOURCE: Final = (
    "NDBC 46042 (1996) and 41010 (2019), U.S. public domain; Spotter off Monterey, 2021 (wavespectra, MIT). "
    "Kept: nine spectra in tables/buoys.csv."
)
RATE_HZ: Final = 2.0
SECONDS: Final = 2 * 3600.0
_PIECE: Final = 512  # samples of a piece of the periodogram: 256 s
NAMES: Final = ("Spotter 2021", "NDBC 46042, 1996", "NDBC 41010, 2019")


def chapter(data: Path | None) -> Chapter:
    """Rows and picture."""
    if data is not None and (data / FOLDER).is_dir():
        _keep(data / FOLDER)
    t = table("buoys.csv")
    rows: list[Row] = []
    shown = []
    forms: dict[str, list[float]] = {}
    found: dict[str, list[float]] = {n: [] for n in ("Hs", "Tp", "Tz", "spread")}
    for n in np.unique(t["record"]):
        chosen = t["record"] == n
        f, s = t["f_hz"][chosen], t["s_m2_hz"][chosen]
        a1, b1 = t["a1"][chosen], t["b1"][chosen]
        directional = bool(np.isfinite(a1).all())
        exponent = _exponent(f, s, a1, b1) if directional else 10.0
        seen = buoy(sea(f, s, exponent, int(n)))
        ours, theirs = statistics(seen.f, seen.s, f[0], f[-1]), statistics(f, s, f[0], f[-1])
        for k, name in enumerate(("Hs", "Tp", "Tz")):
            found[name].append(100 * (ours[k] / theirs[k] - 1))
        if directional:
            measured = spread(f, s, a1, b1)
            found["spread"].append(100 * (spread(seen.f, seen.s, seen.a1, seen.b1, f[0], f[-1]) / measured - 1))
        for name, form in _forms(f, theirs[0], float(1 / f[np.argmax(s)])).items():
            forms.setdefault(name, []).append(_misfit(f, s, form))
        shown.append((NAMES[int(n) // 3], f, s, seen))
    words = {"Hs": "significant height", "Tp": "peak period", "Tz": "mean period", "spread": "directional spread"}
    for name, off in found.items():
        rows.append(
            at_most(
                f"{words[name]} of the simulated sea against the buoy's, rms of {len(off)} records", _rms(off), "%", 5.0
            )
        )
    for name, off in forms.items():
        rows.append(
            Row(
                f"{name} with the measured Hs and Tp: energy that stands at other frequencies, mean",
                "",
                "",
                100 * float(np.mean(off)),
                "%",
                None,
            )
        )
    return Chapter(TITLE, _ABOUT, SOURCE, rows, "", _drawn(shown[::4]), "sea")


class Seen:
    """A buoy's record of a simulated sea: f [Hz], s [m^2/Hz], first directional moments."""

    def __init__(self, f: np.ndarray, s: np.ndarray, a1: np.ndarray, b1: np.ndarray) -> None:
        self.f, self.s, self.a1, self.b1 = f, s, a1, b1


def sea(f: np.ndarray, s: np.ndarray, exponent: float, seed: int) -> Waves:
    """A sea with a measured spectrum."""
    form = TableWavesConfig(frequency_hz=tuple(f), density_m2phz=tuple(s), spreading=exponent, components_count=800)
    made = make_waves((form,), Site(GeoOrigin(36.7, -121.9), seed=seed), depth=None)
    assert made is not None
    return made


def buoy(waves: Waves) -> Seen:
    """Two hours of a buoy at one place: heave and slopes at 2 Hz, and their spectra (Longuet-Higgins et al. 1963)."""
    t = jit.Float64(np.arange(0, SECONDS, 1 / RATE_HZ))
    x = jit.Float64(0.0)
    heave = np.array(waves.elevation(x, x, t))
    north, west = (np.array(v) for v in waves.slope(x, x, t))
    f, s = welch(heave, RATE_HZ, nperseg=_PIECE)
    _, nn = welch(north, RATE_HZ, nperseg=_PIECE)
    _, ww = welch(west, RATE_HZ, nperseg=_PIECE)
    _, hn = csd(heave, north, RATE_HZ, nperseg=_PIECE)
    _, hw = csd(heave, west, RATE_HZ, nperseg=_PIECE)
    scale = np.sqrt(np.maximum(s * (nn + ww), 1e-30))
    return Seen(f, s, hn.imag / scale, hw.imag / scale)


def statistics(f: np.ndarray, s: np.ndarray, low: float, high: float) -> tuple[float, float, float]:
    """Significant height [m], peak period [s] (by the centroid of S^4, which jumps from no bin to bin), Tm02 [s]."""
    grid = np.linspace(low, high, 4000)
    here = np.interp(grid, f, s)
    m0, m2 = np.trapezoid(here, grid), np.trapezoid(here * grid**2, grid)
    return (
        4 * float(np.sqrt(m0)),
        float(np.trapezoid(here**4, grid) / np.trapezoid(here**4 * grid, grid)),
        float(np.sqrt(m0 / m2)),
    )


def spread(f: np.ndarray, s: np.ndarray, a1: np.ndarray, b1: np.ndarray, low: float = 0.0, high: float = 9.0) -> float:
    """Directional spread [deg]: sqrt(2 (1 - m1)) of each frequency, weighted with its energy (Kuik et al. 1988)."""
    used = (f >= low) & (f <= high)
    m1 = np.minimum(np.hypot(a1, b1), 1.0)
    width = np.sqrt(2 * (1 - m1))
    return float(np.degrees(np.average(width[used], weights=s[used])))


def _exponent(f: np.ndarray, s: np.ndarray, a1: np.ndarray, b1: np.ndarray) -> float:
    """Of cos^2s(angle/2) with the buoy's spread: m1 = s/(s + 1)."""
    m1 = 1 - np.radians(spread(f, s, a1, b1)) ** 2 / 2
    return float(m1 / (1 - m1))


def _forms(f: np.ndarray, height: float, period: float) -> dict[str, np.ndarray]:
    return {
        "Pierson-Moskowitz": spectrum.jonswap(f, height, period, 1.0),
        "JONSWAP 3.3": spectrum.jonswap(f, height, period, 3.3),
        "Torsethaugen": spectrum.torsethaugen(f, height, period),
    }


def _misfit(f: np.ndarray, s: np.ndarray, form: np.ndarray) -> float:
    return float(0.5 * np.trapezoid(np.abs(form - s), f) / np.trapezoid(s, f))


def _rms(off: list[float]) -> float:
    return float(np.sqrt(np.mean(np.square(off))))


def _keep(folder: Path) -> None:
    columns: dict[str, list[float]] = {n: [] for n in ("record", "f_hz", "s_m2_hz", "a1", "b1")}

    def add(record: int, f: np.ndarray, s: np.ndarray, a1: np.ndarray, b1: np.ndarray) -> None:
        for name, values in zip(columns, (np.full(len(f), record), f, s, a1, b1), strict=True):
            columns[name].extend(values)

    with (folder / "spotter_20210929b.csv").open(encoding="utf-8", newline="") as file:
        rows = [[c.strip() for c in row] for row in csv.reader(file)]
    names = rows[0]
    for k, row in enumerate((rows[1], rows[8], rows[15])):
        part = {
            p: np.array([float(row[i]) for i, n in enumerate(names) if n.startswith(p) and n[len(p) :].isdigit()])
            for p in ("f_", "varianceDensity_", "a1_", "b1_")
        }
        add(k, part["f_"], part["varianceDensity_"], part["a1_"], part["b1_"])
    for place, (name, head, parts) in enumerate(
        (("46042w1996.txt.gz", 4, (10, 3000, 7000)), ("41010w2019part.txt.gz", 5, (5, 45, 90)))
    ):
        lines = gzip.decompress((folder / name).read_bytes()).decode().splitlines()
        first = next(k for k, line in enumerate(lines) if line.lstrip("#").startswith("YY"))
        f = np.array([float(x) for x in lines[first].split()[head:]])
        for k, n in enumerate(parts):
            s = np.array([float(x) for x in lines[first + n].split()[head : head + len(f)]])
            add(3 + 3 * place + k, f, s, np.full(len(f), np.nan), np.full(len(f), np.nan))
    keep(
        "buoys.csv",
        "Buoys: 0-2 Spotter 2021 (wavespectra, MIT), 3-5 NDBC 46042 1996, 6-8 NDBC 41010 2019 (public domain).\n"
        "S [m^2/Hz], first directional moments a1, b1.",
        {k: np.array(v) for k, v in columns.items()},
    )


def _drawn(shown: list[tuple[str, np.ndarray, np.ndarray, Seen]]) -> bytes:
    with theme.style():
        figure = theme.figure(10.5, 3.2)
        for axes, (name, f, s, seen) in zip(figure.subplots(1, len(shown)), shown, strict=True):
            height, period = statistics(f, s, f[0], f[-1])[0], float(1 / f[np.argmax(s)])
            axes.plot(f, s, color=theme.SENSOR, label="buoy")
            axes.plot(seen.f, seen.s, color=theme.TRUTH, lw=1, label="buoy in the simulated sea")
            axes.plot(
                f,
                spectrum.jonswap(f, height, period),
                color=theme.SECOND,
                lw=1,
                ls="--",
                label="JONSWAP, same Hs and Tp",
            )
            axes.set_xlim(0.03, 0.35)
            axes.set_title(f"{name}: Hs {height:.2f} m")
            axes.set_xlabel("frequency [Hz]")
        figure.axes[0].set_ylabel("S [m$^2$/Hz]")
        figure.axes[0].legend(fontsize=8)
        made = theme.as_png(figure)
        plt.close(figure)
        return made


_ABOUT: Final = """\
Nine spectra of buoys become seas (`waves: {type: table}`, 800 components, spreading with the exponent that has the
buoy's spread); a buoy at one place of each records heave and slopes for two hours at 2 Hz and is analysed like a
real one. Below, how far usual forms with the measured height and period are from the measured spectra: no row is
judged there, real seas have several wave systems.
"""
