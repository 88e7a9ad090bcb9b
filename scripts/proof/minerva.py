"""Devices of ROV Minerva at sea: acoustic fixes, velocity log, ranges of its beams, pressure, heading."""

from __future__ import annotations

import csv
import gzip
from pathlib import Path
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray
from page import Chapter, absolute, keep, relative, table

import pelagos as pl
from pelagos.report import theme

FOLDER: Final = "04_rov_minerva_sea"
TITLE: Final = "The devices of an ROV at sea"
SOURCE: Final = (
    "ROV Minerva of NTNU, Trondheimsfjord, 2015 (NTNU-MCS/CS_EnterpriseI_archive, MIT). Kept, of the six minutes in "
    "which the log moves least: tables/minerva_fixes.csv, minerva_log.csv (each new value), minerva_depth.csv; "
    "minerva_updates.csv, shares of both dives."
)
Array = NDArray[np.float64]

FILES: Final = ("minerva_20150518--1813.csv.gz", "minerva_20150518--1829_first900s.csv.gz")
MINUTES: Final = 6
_INVALID: Final = -30.0  # the log writes -32.768
_NEAREST_M, _FARTHEST_M = 0.3, 7.5  # altitudes between which the log is asked for its losses: it was set to reach 8 m
_FIX: Final = ("N_hipap", "E_hipap")
_LOG: Final = ("u_dvl", "v_dvl", "w_dvl")
_BEAMS: Final = ("alt1", "alt2", "alt3", "alt4")
_GAP_S: Final = 60.0  # between kept minutes, so that differences do not run from one to the next

# Kongsberg, HiPAP 501/451/351/101, Product description 317748/F, Sections 8.4 and 11: 241 elements over the sphere, of
# which the half that faces the target is used; transponder MPT 319 with 188 dB; at 20 dB over the noise 0.2 m in range;
# 21 to 31 kHz and 0.12 deg, recalled
_SHEET_RANGE_M, _SHEET_ANGLE_DEG = 0.2, 0.12
_RADIUS_M: Final = 0.196  # of the transducer, 392 mm across
_KEEL_M: Final = 5.0  # below the surface; assumed, the ship draws 2.7 m and lowers the transducer
# Teledyne RDI, Workhorse Navigator, data sheet: 1200 kHz, four beams at 30 deg, 3 mm/s of a horizontal component in a
# single ping at 1 m/s, 0.2 % (recalled); a horizontal component has 1/(2^0.5 sin 30 deg) of a beam's error; output
# format PD0: ranges downwards in whole cm, as Pathfinder DVL Guide (2018), Table 40
_LOG_KEYS: Final[dict[str, Any]] = {
    "frequency_hz": 1228.8e3, "beam_tilt_deg": 30.0, "range_max_m": 30.0, "noise_mps": 0.003 / 2**0.5, "rate_hz": 1.0,
    "range_resolution_m": 0.01 / 0.75**0.5,
}  # fmt: skip


def chapter(data: Path | None) -> Chapter:
    """Rows and picture."""
    if data is not None and (data / FOLDER).is_dir():
        _keep_tables(data / FOLDER)
    fixes, log, depth, updates = (table(f"minerva_{n}.csv") for n in ("fixes", "log", "depth", "updates"))
    place = {k: float(updates[k][0]) for k in ("north_m", "east_m", "depth_m", "altitude_m")}
    own, sheet = simulated(place, len(log["u_mps"]))
    level = _pooled(_white(fixes, "north_m"), _white(fixes, "east_m"))
    beams = np.stack([log[f"beam_{b}_m"] for b in range(4)])
    found = {k: float(v[0]) for k, v in updates.items()}
    rows = [
        relative("HiPAP, horizontal, from one fix to the next: `range_bearing`, figures of the sheet", "cm",
                 100 * level, 100 * sheet, 20.0),
        relative("HiPAP, horizontal, from one fix to the next: `usbl`, array, levels and accuracy of the sheet", "cm",
                 100 * level, 100 * own["fix"], 20.0),
        relative("velocity log, ahead and aside, one ping", "mm/s",
                 1e3 * _pooled(_white(log, "u_mps"), _white(log, "v_mps")), 1e3 * own["level"], 20.0),
        relative("velocity log, downwards, one ping", "mm/s", 1e3 * _white(log, "w_mps"), 1e3 * own["down"], 20.0),
        relative("ranges of the four beams, what no plane bed explains", "cm", 100 * _off_plane(beams, log["t_s"]),
                 100 * own["ranges"], 20.0),
        relative("depth by pressure, from one sample to the next", "mm", 1e3 * _white(depth, "depth_m"),
                 1e3 * own["depth"], 20.0),
        absolute("velocity log, pings without lock, 0.3 to 7.5 m above the bed", "%", 100 * found["unlocked"],
                 100 * own["unlocked"], 2.0),
        absolute("velocity log, locked pings without one of four ranges", "%", 100 * found["short"],
                 100 * own["short"], 2.0),
        absolute("HiPAP, fixes that do not come within 1.5 s of the last", "%", 100 * found["late"],
                 100 * own["late"], 2.0),
        absolute("HiPAP, fixes beyond 5 deviations from the line of their neighbours", "%",
                 100 * found["outliers"], 100 * own["outliers"], 2.0),
    ]  # fmt: skip
    return Chapter(TITLE, _ABOUT, SOURCE, rows, _MISSED, _picture(log, own), "minerva")


def spread(values: Array) -> float:
    """Standard deviation by the median absolute deviation."""
    return float(1.4826 * np.median(np.abs(values - np.median(values))))


def white(values: Array) -> float:
    """Spread of white noise under a motion, by third differences, whose variance is 20 times its own."""
    return spread(np.diff(values, 3)) / 20**0.5


def _stretches(t: Array) -> list[NDArray[np.intp]]:
    """Rows of each kept minute."""
    return np.split(np.arange(len(t)), np.flatnonzero(np.diff(t) > _GAP_S / 2) + 1)


def _white(kept: dict[str, Array], name: str) -> float:
    thirds = [np.diff(kept[name][rows], 3) for rows in _stretches(kept["t_s"])]
    return spread(np.concatenate(thirds)) / 20**0.5


def _pooled(a: float, b: float) -> float:
    return float(np.sqrt((a * a + b * b) / 2))


def _off_plane(beams: Array, t: Array) -> float:
    """Spread of one range [m]: over a plane bed 1/r of opposite beams has the same sum, whatever its slope."""
    r = np.where(beams > 0, beams, np.nan)
    mean = np.nanmean(r, axis=0)
    off = mean**2 * (1 / r[0] + 1 / r[1] - 1 / r[2] - 1 / r[3]) / 2
    thirds = np.concatenate([np.diff(off[rows], 3) for rows in _stretches(t)])
    return spread(thirds[np.isfinite(thirds)]) / 20**0.5


def _late(t: Array) -> float:
    return float((np.diff(t) > 1.5).mean())


def _outliers(t: Array, places: Array) -> float:
    """Share of places `(n, 2)` that are beyond 5 deviations from the mean of their neighbours in time."""
    off = np.hypot(*(places[1:-1] - (places[:-2] + places[2:]) / 2).T)
    near = (t[2:] - t[:-2]) < 3.0
    return float((off[near] > 5 * np.median(off[near]) / 1.1774).mean())  # the median of Rayleigh's law is 1.1774


def simulated(place: dict[str, float], pings: int) -> tuple[dict[str, Any], float]:
    """Statistics of the simulated devices at rest where the ROV was, and of the acoustic fix by the sheet's figures."""
    deep, altitude = place["depth_m"], place["altitude_m"]
    rov = [place["north_m"], -place["east_m"], -deep]
    modem = {"device": "x150", "frequency_hz": 26e3, "bandwidth_hz": 10e3, "source_level_db": 188.0,
             "bit_rate_bps": 1000.0}  # fmt: skip
    target = {"position_m": [0.0, 0.0, 0.0], "agent": "rov"}
    sim = pl.Simulation.load({
        "name": "fjord", "tick_rate_hz": 20.0, "duration_s": 100_000.0, "seed": 4,
        "world": {"type": "flat", "depth_m": deep + altitude},
        "agents": {
            "ship": {
                "vehicle": {"type": "bluerov2"}, "control": "actuators", "start": {"position_m": [0.0, 0.0, -_KEEL_M]},
                "sensors": {
                    "usbl": {"type": "usbl", "elements_m": _elements(), "interrogate": ["rov"], "interrogate_s": 1.0,
                             "bearing_noise_deg": _SHEET_ANGLE_DEG, "range_noise_m": _SHEET_RANGE_M, **modem},
                    "sheet": {"type": "range_bearing", "targets": {"rov": target}, "range_noise_m": _SHEET_RANGE_M,
                              "azimuth_noise_rad": np.radians(_SHEET_ANGLE_DEG),
                              "elevation_noise_rad": np.radians(_SHEET_ANGLE_DEG)},
                },
            },
            "rov": {
                "vehicle": {"type": "bluerov2"}, "control": "actuators", "start": {"position_m": rov},
                "sensors": {"dvl": {"type": "dvl", **_LOG_KEYS}, "depth": {"type": "depth", "rate_hz": 5.0},
                            "modem": {"type": "modem", **modem}},
            },
        },
    })  # fmt: skip
    found: dict[str, list[Any]] = {k: [] for k in ("fix", "fix_t", "sheet", "speed", "ranges", "lock", "depth")}
    at = {"ship": np.array([0.0, 0.0, -_KEEL_M]), "rov": np.array(rov)}
    upright, none = np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3)
    while len(found["speed"]) < pings:
        for name, position in at.items():
            sim.set_state(name, position=position, attitude=upright, velocity=none, angular_velocity=none)
        seen = sim.step()
        if "usbl" in seen["ship"] and np.isfinite(seen["ship"]["usbl"].extras["fix"]).all():
            found["fix"].append(seen["ship"]["usbl"].extras["fix"][0])
            found["fix_t"].append(sim.time_ns * 1e-9)
        if "sheet" in seen["ship"]:
            found["sheet"].append(seen["ship"]["sheet"].data[0, 0])
        if "dvl" in seen["rov"]:
            reading = seen["rov"]["dvl"]
            found["speed"].append(reading.data[0])
            found["ranges"].append(reading.extras["ranges"][0])
            found["lock"].append(bool(reading.valid[0]))
        if "depth" in seen["rov"]:
            found["depth"].append(reading_of(seen["rov"]["depth"].data))
    return _statistics({k: np.array(v) for k, v in found.items()})


def reading_of(data: Any) -> float:
    """The one number of a reading."""
    return float(np.ravel(data)[0])


def _statistics(found: dict[str, Array]) -> tuple[dict[str, Any], float]:
    speed, ranges, t = found["speed"], found["ranges"].T, found["fix_t"]
    far, azimuth, elevation = found["sheet"].T
    level = far * np.cos(elevation)
    sheet = _pooled(white(level * np.cos(azimuth)), white(level * np.sin(azimuth)))
    vertical = ranges * np.cos(np.radians(_LOG_KEYS["beam_tilt_deg"]))
    # beams of the simulated log in order around the vertical; the recorded one names opposite ones together
    own = {
        "fix": _pooled(white(found["fix"][:, 0]), white(found["fix"][:, 1])),
        "level": _pooled(white(speed[:, 0]), white(speed[:, 1])), "down": white(speed[:, 2]), "u": speed[:, 0],
        "ranges": _off_plane(vertical[[0, 2, 1, 3]], np.arange(len(speed)) * 1.0),
        "depth": white(found["depth"]), "unlocked": float(1 - found["lock"].mean()),
        "short": float(np.isnan(ranges).any(axis=0).mean()), "late": _late(t),
        "outliers": _outliers(t, found["fix"][:, :2]),
    }  # fmt: skip
    return own, sheet


def _elements() -> list[list[float]]:
    """Lower half of 241 points spread evenly over a sphere (a spiral of golden angles)."""
    k = np.arange(241)
    z = 1 - 2 * (k + 0.5) / 241
    turn = k * np.pi * (3 - 5**0.5)
    level = np.sqrt(1 - z * z)
    points = _RADIUS_M * np.stack([level * np.cos(turn), level * np.sin(turn), z], axis=1)
    return [[round(float(x), 5) for x in p] for p in points[points[:, 2] < 0]]


def _picture(log: dict[str, Array], own: dict[str, Any]) -> bytes:
    with theme.style():
        figure = theme.figure(10.5, 2.6)
        left, right = figure.subplots(1, 2)
        first = _stretches(log["t_s"])[0]
        t = log["t_s"][first] - log["t_s"][first][0]
        for b in range(4):
            left.step(t, log[f"beam_{b}_m"][first], where="post", label=f"beam {b + 1}")
        left.set_xlabel("time [s]")
        left.set_ylabel("range downwards [m]")
        left.legend(ncols=2)
        thirds = np.concatenate([np.diff(log["u_mps"][rows], 3) for rows in _stretches(log["t_s"])]) / 20**0.5
        bins = np.linspace(-15, 15, 31)
        right.hist(1e3 * thirds, bins, density=True, color=theme.SENSOR, alpha=0.5, label="measured")
        right.hist(1e3 * np.diff(own["u"], 3) / 20**0.5, bins, density=True, histtype="step", color=theme.TRUTH,
                   label="simulated")  # fmt: skip
        right.set_xlabel("velocity ahead, white part [mm/s]")
        right.set_ylabel("share by mm/s")
        right.legend()
        picture = theme.as_png(figure)
        plt.close(figure)
    return picture


def _read(file: Path) -> dict[str, Array]:
    rows = list(csv.reader(gzip.decompress(file.read_bytes()).decode().splitlines()))
    return dict(zip(rows[0], np.array(rows[1:], dtype=np.float64).T, strict=True))


def _new(dive: dict[str, Array], names: tuple[str, ...]) -> NDArray[np.intp]:
    """Rows in which a device's value is another than before: its updates."""
    changed = np.any([np.diff(dive[n]) != 0 for n in names], axis=0)
    return np.flatnonzero(changed) + 1


def _keep_tables(folder: Path) -> None:
    dives = [_read(folder / name) for name in FILES]
    minutes = []
    for number, dive in enumerate(dives):
        for start in np.arange(0.0, dive["t"][-1] - 60.0, 30.0):
            rows = np.flatnonzero((dive["t"] >= start) & (dive["t"] < start + 60.0))
            speed = np.stack([dive[n][rows] for n in _LOG])
            if len(rows) > 200 and (np.abs(speed) < 5).all() and all((dive[b][rows] > 0).all() for b in _BEAMS):
                minutes.append((float((speed**2).mean()), number, float(start)))
    chosen: list[tuple[int, float]] = []
    for _, number, start in sorted(minutes):
        if len(chosen) < MINUTES and all(n != number or abs(s - start) >= 60.0 for n, s in chosen):
            chosen.append((number, start))
    _keep_minutes(dives, sorted(chosen))


def _keep_minutes(dives: list[dict[str, Array]], chosen: list[tuple[int, float]]) -> None:
    fixes, log, depth, place = [], [], [], []
    for k, (number, start) in enumerate(chosen):
        dive = dives[number]
        shift = 2 * _GAP_S * k - start
        inside = (dive["t"] >= start) & (dive["t"] < start + 60.0)
        place.append([
            *(np.mean(dive[_FIX[a]][inside] - dive[ship][inside]) for a, ship in enumerate(("ship_N", "ship_E"))),
            dive["depth_raw"][inside].mean(), np.mean([dive[b][inside].mean() for b in _BEAMS]),
        ])  # fmt: skip
        for rows, names, out in ((_new(dive, _FIX), _FIX, fixes), (_new(dive, _LOG), (*_LOG, *_BEAMS), log),
                                 (np.flatnonzero(inside), ("depth_raw",), depth)):  # fmt: skip
            rows = rows[inside[rows]]
            values = np.stack([dive[n][rows] - (dive[n][rows][0] if n in _FIX else 0.0) for n in names], axis=1)
            out.append(np.column_stack([dive["t"][rows] + shift, values]))
    names = {
        "fixes": ("t_s", "north_m", "east_m"),
        "log": ("t_s", "u_mps", "v_mps", "w_mps", *(f"beam_{b}_m" for b in range(4))),
        "depth": ("t_s", "depth_m"),
    }  # fmt: skip
    for name, parts in (("fixes", fixes), ("log", log), ("depth", depth)):
        keep(f"minerva_{name}.csv", SOURCE, dict(zip(names[name], np.concatenate(parts).T, strict=True)), 6)
    north, east, deep, altitude = np.mean(place, axis=0)
    shares = _shares(dives)
    columns = {"north_m": north, "east_m": east, "depth_m": deep, "altitude_m": altitude, **shares}
    keep("minerva_updates.csv", SOURCE, {k: np.array([v]) for k, v in columns.items()}, 4)


def _shares(dives: list[dict[str, Array]]) -> dict[str, float]:
    """What is lost, late or far off in both dives, at depth and between the altitudes that are asked for."""
    counts = np.zeros(8)
    for dive in dives:
        altitude = np.max([dive[b] for b in _BEAMS], axis=0)
        known = np.flatnonzero(altitude > 0)
        last = altitude[known[np.clip(np.searchsorted(known, np.arange(len(altitude)), side="right") - 1, 0, None)]]
        pings = _new(dive, _LOG)
        pings = pings[(pings > known[0]) & (last[pings - 1] > _NEAREST_M) & (last[pings - 1] < _FARTHEST_M)]
        locked = dive["u_dvl"][pings] > _INVALID
        counts[:4] += [len(pings), (~locked).sum(), locked.sum(),
                       sum(any(dive[b][p] == 0 for b in _BEAMS) for p in pings[locked])]  # fmt: skip
        rows = _new(dive, _FIX)
        rows = rows[(dive["t"][rows] > dive["t"][known[0]])]
        t, places = dive["t"][rows], np.stack([dive[n][rows] for n in _FIX], axis=1)
        counts[4:] += [len(t), _late(t) * len(t), len(t), _outliers(t, places) * len(t)]
    return {"unlocked": counts[1] / counts[0], "short": counts[3] / counts[2], "late": counts[5] / counts[4],
            "outliers": counts[7] / counts[6], "pings": counts[0], "fixes": counts[4]}  # fmt: skip


_ABOUT: Final = """\
The ROV hovers some 2 m above the bed, 58 m deep and 23 m aside of its ship. Simulated devices stand still in the mean
geometry of the six kept minutes, over sand, with the figures of their makers; nothing is fitted. Noise is what third
differences leave, at the device's own pace, so that slow motion goes out and quick motion stays in: the recorded
figures are upper limits. Ranges need no such care: over a plane bed the inverse ranges of opposite beams have the
same sum. The recorded compass is a constant, and the heading that of the attitude sensor's filter: neither is
compared.
"""
_MISSED: Final = """\
HiPAP: a fix scatters by 4 cm from one to the next. Its sheet's 0.12 deg and 0.2 m at 20 dB over the noise are three
times that, in `range_bearing` (whose azimuth has them as an angle about the vertical) and in `usbl` (across the way);
here there are more decibels, and what of the sheet's figures stays from one fix to the next does not scatter. Before
`usbl` had `bearing_noise_deg` and `range_noise_m` it made 0.03 mm, of thermal and sea noise alone (at 60 m and 188
dB): the record lies between. Ship and transducer at rest is what the simulated geometry assumes; one fix in fifty
comes late, which is what a hull between or an echo in the way may do, and neither is in the simulated scene. Velocity
log: the vehicle's own motion from one second to the next (thrusters, tether) is in the recorded figures, most of it
downwards; what is left for the log is at most what stands here. Ranges come in steps of 4.2 cm, which alone make 1.2
cm where the vehicle moves over several of them; no sheet tells that step. The simulated log has the 1 cm of its output
format and 0.2 % of the range; at rest, steps of 4.2 cm would show nothing. Depth: the gauge is not told, the simulated
one is the default, whose noise is 0.5 mm too large here. All losses of lock but two lie below 0.3 m or beyond the 8 m
that the log was set to.
"""
