"""Real sonars' images and soundings beside simulated ones of the same setting: speckle, resolution, detection, rays."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
import sonar_records as records
from numpy.typing import NDArray
from page import Chapter, Row, absolute, at_most, keep, relative, table
from PIL import Image
from sonar_records import LAGS, QUANTILES

import pelagos as pl
from pelagos import jit
from pelagos.acoustics.refraction import LEVELS, path_end, profile_from
from pelagos.report import theme
from pelagos.sensors.sonar.ping.fan import arcs_of

FOLDER: Final = "14_sonar"
TITLE: Final = "Images and soundings of sonars"
SOURCE: Final = (
    "one ping of an Oculus M1200d, 2.1 MHz (apl-ocean-engineering/liboculus, BSD); 923 pings of an R2Sonic 2026, "
    "400 kHz (CIDCO-dev/MBES-lib, MIT); 8 pings of a deep-water sounder (UKHO/gsfpy, MIT). "
    "Kept: tables/sonar_speckle.csv, tables/sonar_soundings.csv, tables/sonar_rays.csv, tables/sonar_profile.csv."
)
Array = NDArray[Any]

TVG: Final = (15.0, 0.081)  # of the R2Sonic's header: spreading k of k log10 r, absorption [dB/m]
PULSE_M, BEAM = 0.5 * 1515.0 * 35e-6, np.radians(0.5)  # half of its pulse's length [m], width of its beams
ABSORPTION: Final = 0.1  # [dB/m] at 400 kHz in the simulated water
GAMMA: Final = 127 / 255  # of the Oculus' header: the exponent of its 8-bit levels
BANDS: Final = ((0, 5), (5, 15), (15, 25), (25, 35), (35, 45), (45, 55), (55, 62))  # [deg] off nadir
_ROWS, _BEAMS = slice(450, 700), slice(20, 236)  # of the Oculus: behind the saturated part of its bottom
_WINDOW: Final = (21, 31)
_PARAMETERS: Final = "contrast, then quantiles and correlations along rows, and along beams"


def chapter(data: Path | None) -> Chapter:
    """Rows and picture."""
    folder = data / FOLDER if data is not None and (data / FOLDER).is_dir() else None
    if folder is not None:
        _keep(folder)
    measured, soundings = _unpacked(table("sonar_speckle.csv")["oculus"]), table("sonar_soundings.csv")
    polar, swath = _oculus(), _soundings()
    simulated = records.speckle(polar[_ROWS, _BEAMS], _WINDOW)
    rows = [
        *_speckle_rows("Oculus, one ping", measured, simulated, "row of 2.84 mm", "beam"),
        *_sounding_rows(soundings, swath),
        *_ray_rows(),
    ]
    picture = _picture(folder, (measured, simulated), polar, (soundings, swath))
    return Chapter(TITLE, _ABOUT, SOURCE, rows, _MISSED, picture, "sonar")


def _speckle_rows(name: str, measured: dict[str, Any], simulated: dict[str, Any], first: str, second: str) -> list[Row]:
    quantiles = [np.asarray(s["quantiles"]) for s in (measured, simulated)]
    inner = slice(1, -1)  # 5 to 95 %
    off = float(np.abs(quantiles[1] / quantiles[0] - 1.0)[inner].max() * 100)
    rows = [
        relative(f"{name}: speckle contrast", "", measured["contrast"], simulated["contrast"], 10.0),
        at_most(f"{name}: quantiles of the level over its mean, 5 to 95 %, largest deviation", off, "%", 10.0),
    ]
    for key, what in (("first", first), ("second", second)):
        values = (float(s[key][1]) for s in (measured, simulated))
        rows.append(absolute(f"{name}: correlation with the next {what}", "", *values, 0.1))
    return rows


def _sounding_rows(measured: dict[str, Array], simulated: dict[str, Array]) -> list[Row]:
    rows = []
    for k, (low, high) in enumerate(BANDS):
        if k % 2 == 1:
            name = f"R2Sonic, {low} to {high} deg"
            scatter = (1e3 * float(x["scatter_m"][k]) for x in (measured, simulated))
            rows.append(relative(f"{name}: depth from ping to ping, deviation", "mm", *scatter, None))
            found = (100 * float(x["phase"][k]) for x in (measured, simulated))
            rows.append(absolute(f"{name}: found by phase", "%", *found, None))
    nadir = (float(x["level_db"][0] - x["level_db"][3]) for x in (measured, simulated))
    rows.append(absolute("R2Sonic: level at 0 to 5 deg over that at 25 to 35 deg", "dB", *nadir, None))
    fall = [_fall(x) for x in (measured, simulated)]
    rows.append(absolute("R2Sonic: level at 55 to 62 deg over that at 25 to 35 deg", "dB", *fall, 3.0))
    return rows


def _fall(bands: dict[str, Array]) -> float:
    return float(bands["level_db"][6] - bands["level_db"][3])


def _ray_rows() -> list[Row]:
    rays, profile = table("sonar_rays.csv"), table("sonar_profile.csv")
    deep, aside, time = rays["depth_m"], rays["aside_m"], rays["time_s"]
    angle = np.degrees(np.arctan2(aside, deep))
    for _ in range(8):  # the ray that comes out as far aside as recorded, by secants
        step = 0.01
        here, there = traced(angle, time, profile)[1], traced(angle + step, time, profile)[1]
        angle = angle + step * (aside - here) / (there - here)
    found = traced(angle, time, profile)[0]
    wide = aside > 0.6 * deep
    return [
        at_most("deep sounder: depth by time, distance aside and profile, rms", _rms(found / deep - 1.0), "%", 0.1),
        at_most("deep sounder: the same beyond 31 deg", _rms((found / deep - 1.0)[wide]), "%", 0.1),
    ]


def _rms(values: Array) -> float:
    return float(100 * np.sqrt(np.mean(values**2)))


def traced(angle_deg: Array, time_s: Array, profile: dict[str, Array]) -> tuple[Array, Array]:
    """Depth and horizontal distance [m] of ray ends, by the arcs that a sonar's soundings are placed along."""
    reach = 0.5 * time_s * profile["speed_mps"][0]
    lowest, top = -1.2 * float(reach.max()), 0.0
    heights = np.linspace(lowest, top, LEVELS)
    speeds = np.interp(-heights, profile["depth_m"], profile["speed_mps"])
    parts = [jit.Float(np.asarray(v, np.float32)) for v in (speeds - speeds[-1], [speeds[-1]], [lowest])]
    made = profile_from(*parts, jit.Float([float(heights[1] - heights[0])]))
    a = np.radians(np.abs(angle_deg))
    way = jit.Array3f(*(jit.Float(v.astype(np.float32)) for v in (np.sin(a), 0.0 * a, -np.cos(a))))
    row = jit.UInt32(np.zeros(len(a), np.uint32))
    reached = jit.Float(reach.astype(np.float32))
    ends = np.array(path_end(made, row, way, reached, arcs=arcs_of(float(reach.max()))))
    return -ends[2], np.hypot(ends[0], ends[1])


def _pings(sensor: dict[str, Any], depth: float, altitude: float, places: Array) -> list[Any]:
    """Readings of a sonar that is held at places along x, one a ping, over flat sand."""
    sim = pl.Simulation.load({
        "seed": 4,
        "tick_rate_hz": 10,
        "world": {"type": "flat", "depth_m": depth},
        "agents": {"auv": {"vehicle": "remus100", "start": {"position_m": [0, 0], "depth_m": depth - altitude},
                           "sensors": {"sonar": {"rate_hz": 10, **sensor}}}},
    })  # fmt: skip
    found = []
    for x in places:
        sim.set_state("auv", position=np.array([[x, 0.0, altitude - depth]]), attitude=np.array([[1.0, 0, 0, 0]]),
                      velocity=np.zeros((1, 3)))  # fmt: skip
        found.append(sim.step()["auv"]["sonar"])
    return found


def _oculus() -> Array:
    """Levels `(rows, beams)` of one ping over sand, with the exponent of the device's 8 bits."""
    sonar = {
        "type": "imaging_sonar", "device": "oculus_m1200d_high", "beams": 256, "bins": 703, "range_min_m": 1e-3,
        "range_max_m": 703 * 2.842e-3, "scale": "linear", "orientation_deg": [0, 25, 0], "rays_per_beam": 256,
        "position_m": [1.5, 0, 0],
    }  # fmt: skip
    reading = _pings(sonar, 10.0, 0.75, np.array([0.0, 0.3]))[1]
    return np.asarray(np.sqrt(reading.data[0].T.astype(float)) ** GAMMA)


def _soundings() -> dict[str, Array]:
    """Columns of `tables/sonar_soundings.csv`, of a swath over flat sand, 10.5 m below."""
    sonar = {
        "type": "multibeam", "frequency_hz": 400e3, "swath_deg": 124.0, "beams": 256, "spacing": "equidistant",
        "beamwidth_across_deg": 0.5, "beamwidth_along_deg": 1.0, "range_max_m": 32.0, "pulse": "cw", "pulse_s": 35e-6,
        "source_level_db": 206.0,
    }  # fmt: skip
    readings = _pings(sonar, 20.0, 10.5, 0.1 * np.arange(40))
    angle = np.asarray(readings[0].extras["angle"], dtype=float)
    ranges = np.array([r.data[0] for r in readings], dtype=float)
    level = np.array([r.extras["backscatter"][0] for r in readings], dtype=float)
    phase = np.array([r.extras["detection"][0] for r in readings]) == 2
    return by_angle(np.broadcast_to(angle, ranges.shape), ranges, phase, _as_received(level, angle, ranges))


def _as_received(strength_db: Array, angle: Array, ranges: Array) -> Array:
    """Level behind the device's gain [dB], but for a constant: by the sonar equation, the footprint of pulse or beam,
    and the gain of the recording's settings."""
    long = np.minimum(PULSE_M / np.maximum(np.sin(abs(angle)), 1e-6), BEAM * ranges / np.cos(angle))
    gain = TVG[0] * np.log10(ranges) + 2 * TVG[1] * ranges
    return np.asarray(strength_db - 30 * np.log10(ranges) - 2 * ABSORPTION * ranges + 10 * np.log10(long) + gain)


def by_angle(angle: Array, ranges: Array, phase: Array, level_db: Array) -> dict[str, Array]:
    """By bands off nadir: deviation of depths from ping to ping, without a ping's own curve, over sqrt 2; share found
    by phase; mean level."""
    depth = ranges * np.cos(angle)
    off = records.off_the_bottom(depth)
    step = np.diff(off, axis=0) / np.sqrt(2.0)
    degrees = np.degrees(np.abs(angle))
    rows = []
    for low, high in BANDS:
        here = (degrees >= low) & (degrees < high)
        rows.append((records.robust_deviation(step[here[1:]]), phase[here].mean(), np.mean(level_db[here])))
    return dict(zip(("scatter_m", "phase", "level_db"), np.array(rows).T, strict=True))


def _packed(found: dict[str, Any]) -> Array:
    return np.concatenate([[found["contrast"]], found["quantiles"], found["first"], found["second"]])


def _unpacked(column: Array) -> dict[str, Any]:
    parts = np.split(column, np.cumsum([1, len(QUANTILES), LAGS]))
    return {"contrast": float(parts[0][0]), "quantiles": parts[1], "first": parts[2], "second": parts[3]}


def _keep(folder: Path) -> None:
    found = records.speckle(records.oculus(folder)[0][_ROWS, _BEAMS], _WINDOW)
    keep("sonar_speckle.csv", f"{SOURCE}\n{_PARAMETERS}", {"oculus": _packed(found)})
    r = records.r2sonic(folder)
    level = 20 * np.log10(np.maximum(r["intensity"], 1.0))
    keep("sonar_soundings.csv", f"{SOURCE}\nbands off nadir [deg]: {BANDS}",
         by_angle(r["angle"], r["range"], r["phase"], level))  # fmt: skip
    g, profile = records.gsf(folder)
    chosen = slice(None, None, 8)
    aside = np.hypot(g["across"], g["along"])
    columns = {"angle_deg": g["angle"], "time_s": g["time"], "depth_m": g["depth"], "aside_m": aside}
    keep("sonar_rays.csv", SOURCE, {n: v[:, chosen].ravel() for n, v in columns.items()}, digits=7)
    chosen_depths = np.r_[0 : len(profile) - 40 : 4, len(profile) - 40 : len(profile)]
    keep(
        "sonar_profile.csv",
        SOURCE,
        dict(zip(("depth_m", "speed_mps"), profile[chosen_depths].T, strict=True)),
        digits=7,
    )


def _picture(
    folder: Path | None,
    speckles: tuple[dict[str, Any], dict[str, Any]],
    polar: Array,
    swaths: tuple[dict[str, Array], dict[str, Array]],
) -> bytes:
    with theme.style():
        figure = theme.figure(10.5, 3.0 if folder is None else 6.2)
        below = figure.add_gridspec(1 if folder is None else 2, 3, height_ratios=None if folder is None else (4, 3))
        _curves([figure.add_subplot(below[-1, k]) for k in range(3)], speckles, swaths)
        if folder is not None:
            _images(figure, below, folder, polar)
        picture = _fewer_colours(theme.as_png(figure))
        plt.close(figure)
    return picture


def _curves(
    axes: list[Any],
    speckles: tuple[dict[str, Any], dict[str, Any]],
    swaths: tuple[dict[str, Array], dict[str, Array]],
) -> None:
    for found, mark, label in zip(speckles, ("o", "-"), ("measured", "simulated"), strict=True):
        axes[0].plot(found["quantiles"], QUANTILES, mark, color=theme.THIRD, label=label)
        axes[1].plot(found["first"], mark, color=theme.SECOND, label=f"along rows, {label}")
        axes[1].plot(found["second"], mark, color=theme.THIRD, label=f"along beams, {label}")
    axes[0].set(xlabel="Oculus: level over its mean", ylabel="share below")
    axes[0].legend(fontsize=6)
    axes[1].set(xlabel="Oculus: samples apart", ylabel="correlation")
    axes[1].legend(fontsize=6)
    middles = [0.5 * (low + high) for low, high in BANDS]
    for found, mark, label in zip(swaths, ("o", "-"), ("measured", "simulated"), strict=True):
        axes[2].plot(middles, found["level_db"] - found["level_db"][3], mark, color=theme.SENSOR, label=label)
    axes[2].set(xlabel="R2Sonic: angle off nadir [deg]", ylabel="level over that at 30 deg [dB]")
    axes[2].legend(fontsize=6)


def _images(figure: Any, grid: Any, folder: Path, polar: Array) -> None:
    """The Oculus' ping, measured and simulated."""
    level, _, _ = records.oculus(folder)
    parts = (level, polar, np.hstack([polar[_ROWS][:120, 40:120] / polar[_ROWS].mean(),
                                      level[_ROWS][:120, 40:120] / level[_ROWS].mean()]))  # fmt: skip
    titles = ("Oculus, measured (2 m of range upwards)", "sand 0.75 m below, simulated", "pieces: simulated, measured")
    for k, (title, values) in enumerate(zip(titles, parts, strict=True)):
        axes = figure.add_subplot(grid[0, k])
        axes.imshow(values[::-1], cmap="copper", aspect="auto", vmin=0.0, vmax=np.quantile(values, 0.995))
        axes.set_title(title, fontsize=8)
        axes.axis("off")


_ABOUT: Final = """\
What a picture is made of, without its motif: levels over their mean in a window of some hundred samples (histogram,
contrast) and correlation with the next sample, of even bottom. Simulated sonars have the recording's settings and
look at flat sand by the catalogue; no key was tuned. The exponent of the Oculus' 8 bits is in its header. The
R2Sonic's swath is compared by angle: what part is found by phase, how far a depth is from that of the next ping, and
the level behind the gain that its header names. Of the deep sounder's soundings each is traced along the arcs that
`multibeam` places its soundings by, through the file's own profile, so that it comes out as far aside as recorded
(its angles hold the ship's roll): its depth is then compared.
"""
_MISSED: Final = """\
The Oculus separates neighbouring rows better, and beams less, than in the catalogue: 2.5 mm are taken for c/2B of a
pulse with Hann's shading, whose echo is half as long again, and the array has `light` shading; the sheet tells
neither. Bars are not set where the records hold more than the sonar: depths from ping to ping hold the relief between
pings and errors of attitude (sand here is flat and the sonar still), and what is found by phase is the maker's
choice: the sounder keeps to amplitude out to 36 deg where estimated errors alone would change at 30. What the bed is
made of (the level at nadir is 6 dB below the catalogue's sand), which the level's fall depends on, is not told.
"""


def _fewer_colours(png: bytes) -> bytes:
    """The same picture in 96 colours: noise of speckle in all of them takes five times as many bytes."""
    found = io.BytesIO()
    shown = Image.open(io.BytesIO(png)).convert("RGB")
    shown.quantize(96, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(found, "PNG", optimize=True)
    return found.getvalue()
