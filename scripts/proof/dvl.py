"""A Doppler velocity log over a river's bed, nearly at rest: errors of its beams, ranges, lock."""

from __future__ import annotations

import gzip
from pathlib import Path
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
import pd0
from numpy.typing import NDArray
from page import Chapter, Row, absolute, keep, relative, table

import pelagos as pl
from pelagos.report import theme

FOLDER: Final = "10_dvl_adcp_bottomtrack"
TITLE: Final = "A Doppler velocity log"
SOURCE: Final = (
    "Teledyne RDI 600 kHz, 20 deg, bottom track of two pings (RDI_withBT of MHKiT-Python, BSD). Kept: tables/dvl.csv, "
    "the second half, in which it moves by some 3 cm/s."
)
Array = NDArray[np.float64]

TILT: Final = np.radians(20.0)
PINGS: Final = 2  # averaged into an ensemble


def chapter(data: Path | None) -> Chapter:
    """Rows and picture."""
    if data is not None and (data / FOLDER).is_dir():
        _keep(data / FOLDER / "RDI_withBT.000.gz")
    t = table("dvl.csv")
    ranges = np.stack([t[f"range_{b}_m"] for b in range(4)])
    error = t["error_mps"]
    seen = np.isfinite(error)
    own, own_ranges, own_lock = _simulated(float(np.nanmean(ranges)) * np.cos(TILT), len(error))
    rows: list[Row] = [
        relative("error velocity, two pings, spread", "mm/s", 1e3 * _spread(error[seen]), 1e3 * _spread(own), 20.0),
        relative("error velocity, 95th percentile of its size by the median", "", _tail(error[seen]), _tail(own), 20.0),
        relative("range along a beam, spread from one to the next", "cm", 100 * _jitter(ranges),
                 100 * _jitter(own_ranges), 20.0),
        absolute("ensembles with all four beams", "%", 100 * float(seen.mean()), 100 * own_lock, 2.0),
    ]  # fmt: skip
    with theme.style():
        figure = theme.figure(10.5, 2.6)
        axes = figure.subplots()
        bins = np.linspace(-20, 20, 41)
        for values, color, label in ((error[seen], theme.SENSOR, "measured"), (own, theme.TRUTH, "simulated")):
            kind = {"histtype": "stepfilled", "alpha": 0.5} if label == "measured" else {"histtype": "step"}
            axes.hist(1e3 * values, bins, density=True, color=color, label=label, **kind)
        axes.set_xlabel("error velocity [mm/s]")
        axes.set_ylabel("share by mm/s")
        axes.legend()
        picture = theme.as_png(figure)
        plt.close(figure)
    return Chapter(TITLE, _ABOUT, SOURCE, rows, _MISSED, picture, "dvl")


def _spread(values: Array) -> float:
    """Standard deviation by the median absolute deviation."""
    return float(1.4826 * np.median(np.abs(values - np.median(values))))


def _tail(values: Array) -> float:
    size = np.abs(values - np.median(values))
    return float(np.percentile(size, 95) / np.median(size))


def _jitter(ranges: Array) -> float:
    """Spread of white noise in series `(4, m)`, by third differences, whose variance is 20 times its own."""
    third = np.diff(ranges, 3, axis=1)
    return float(np.mean([_spread(row[np.isfinite(row)]) for row in third]) / 20**0.5)


def _simulated(altitude: float, count: int) -> tuple[Array, Array, float]:
    """Error velocities [m/s], ranges `(4, count)` [m] and share with four beams of a default log over sand, at rest."""
    sim = pl.Simulation.load({
        "name": "river", "tick_rate_hz": 10.0, "duration_s": 10_000.0, "world": {"type": "flat", "depth_m": 20.0},
        "agents": {"log": {
            "vehicle": {"type": "bluerov2"}, "control": "actuators",
            "start": {"position_m": [0.0, 0.0, altitude - 20.0]},
            "sensors": {"dvl": {"type": "dvl", "rate_hz": 10.0, "beam_tilt_deg": 20.0}},
        }},
    })  # fmt: skip
    at, upright, none = np.array([0.0, 0.0, altitude - 20.0]), np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3)
    speeds, ranges, locked = [], [], []
    for _ in range(PINGS * count):
        sim.set_state("log", position=at, attitude=upright, velocity=none, angular_velocity=none)
        reading = sim.step()["log"]["dvl"]
        speeds.append(reading.extras["beam_velocity"][0])
        ranges.append(reading.extras["ranges"][0])
        locked.append(reading.extras["beam_valid"][0].all())
    both = np.array(speeds).reshape(count, PINGS, 4).mean(axis=1)
    # scaled by the maker so that its variance is that of a horizontal component
    error = (both[:, 0] - both[:, 1] + both[:, 2] - both[:, 3]) / (2**0.5 * 2 * np.sin(TILT))
    return error, np.array(ranges).reshape(count, PINGS, 4).mean(axis=1).T, float(np.mean(locked))


def _keep(file: Path) -> None:
    rows = []
    for e in pd0.ensembles(gzip.decompress(file.read_bytes())):
        ranges, velocity = e.take("4H", pd0.TRACK, 16), e.take("4h", pd0.TRACK, 24)
        error = np.nan if pd0.NONE in velocity else velocity[3] / 1000
        rows.append([*(r / 100 if r else np.nan for r in ranges), error])
    late = np.array(rows[len(rows) // 2 :])
    columns = {f"range_{b}_m": late[:, b] for b in range(4)} | {"error_mps": late[:, 4]}
    keep("dvl.csv", SOURCE, columns, 6)


_ABOUT: Final = """\
The simulated log is `dvl` as it is by default, a 600 kHz device, with the recorded one's beams at 20 degrees, over
sand, at the recorded altitude and at rest; nothing is fitted. The error velocity is the difference of the two pairs of
beams, noise for any motion; like the recorded one it is the mean of two pings and scaled to the spread of a horizontal
velocity.
"""
_MISSED: Final = """\
Recorded ranges scatter by 0.4 % of themselves, the simulated ones by 0.2 % in each ping over a bed that is flat; what
the river's own bed adds under a log that drifts is not known.
"""
