"""A boat's crossing of the Tanana with a profiler that tracks the bottom: what is kept of the recording, and figures.

East and north are of the ground, from the first fix on; velocities of the water are along the river, aside and up.
"""

from __future__ import annotations

import gzip
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import pd0
from numpy.typing import NDArray
from page import keep, table

from pelagos.math.geodesy import GeoOrigin

FOLDER: Final = "10_dvl_adcp_bottomtrack"
FILE: Final = "tanana_transects_08_10_10_0_002_10-08-10_142214.PD0.gz"
SOURCE: Final = (
    "Teledyne RDI 1200 kHz, 20 deg, of a boat with GPS that crosses the Tanana at Nenana, 10 August 2010 "
    "(tanana_transects_08_10_10_0_002 of MHKiT-Python, BSD). Kept: tables/river_pings.csv; of the water "
    "river_flow.csv, river_profile.csv, river_water.csv."
)
Array = NDArray[np.float64]

TILT: Final = np.radians(20.0)
RECORDED, CELL_M, FIRST_M = 47, 0.25, 0.57  # cells, as the leader has them; FIRST_M is the middle of the first
CELLS: Final = 28  # of them looked at, to 7.4 m
DEPTHS: Final = FIRST_M + CELL_M * np.arange(CELLS)
STILL_S: Final = (64.0, 137.0)  # from the last turn at the bank to where bottom track and GPS part
MOVING_S: Final = (137.0, 240.0)  # to where the bottom is lost for good
LATE_S: Final = 0.3  # by which the velocity of the receiver leads the log's clock, where they agree best over still bed
_STRETCH_S: Final = 15.0  # over which the flow is averaged
_FREE: Final = 0.9  # of the depth; below, the side lobes' echo of the bed: 1 - cos 20 deg is 0.06


@dataclass(frozen=True)
class Pings:
    """What a log and a receiver tell of each ping.

    Attributes:
        t: [s]; heading: of the compass, magnetic [rad]; declination: of the receiver's own tables [rad].
        pitch, roll: bow up, port up [rad].
        ranges: `(n, 4)` downwards, of the beams to port, to starboard, forward and aft [m], NaN where lost.
        lost: `(n, 4)`, the beam has no echo of the bed that correlates.
        over_ground: `(n, 2)` starboard and forward by bottom track [m/s]; error: its error velocity; NaN without.
        place, speed: `(n, 2)` east and north by GPS [m], [m/s].
    """

    t: Array
    heading: Array
    declination: float
    pitch: Array
    roll: Array
    ranges: Array
    lost: NDArray[np.bool_]
    over_ground: Array
    error: Array
    place: Array
    speed: Array

    def within(self, span: tuple[float, float]) -> NDArray[np.bool_]:
        """Pings of a stretch of time [s]."""
        return (self.t >= span[0]) & (self.t < span[1])

    @property
    def seen(self) -> NDArray[np.bool_]:
        """There is a velocity over ground."""
        return np.isfinite(self.over_ground[:, 0])


def pings() -> Pings:
    """The kept recording."""
    c = table("river_pings.csv")
    mask = c["lost"].astype(int)
    return Pings(
        c["t_s"], np.radians(c["heading_deg"]), float(np.radians(c["declination_deg"][0])), np.radians(c["pitch_deg"]),
        np.radians(c["roll_deg"]), np.stack([c[f"range_{b}_m"] for b in range(4)], axis=1),
        np.stack([mask >> b & 1 for b in range(4)], axis=1).astype(bool),
        np.stack([c["starboard_mps"], c["forward_mps"]], axis=1), c["error_mps"],
        np.stack([c["east_m"], c["north_m"]], axis=1), np.stack([c["east_mps"], c["north_mps"]], axis=1),
    )  # fmt: skip


def alignment(p: Pings) -> float:
    """Angle from the compass, with the receiver's declination, to the log's forward direction [rad], over still bed."""
    s = p.within(STILL_S) & p.seen
    log, gps = turned(p.over_ground, p.heading + p.declination)[s], p.speed[s]
    return -float(np.angle(((gps[:, 0] + 1j * gps[:, 1]) * (log[:, 0] - 1j * log[:, 1])).sum()))


def turned(velocity: Array, heading: Array) -> Array:
    """`(..., 2)` starboard and forward -> east and north, by the heading from north to east [rad]."""
    starboard, forward = velocity[..., 0], velocity[..., 1]
    cos, sin = np.cos(heading), np.sin(heading)
    return np.stack([starboard * cos + forward * sin, forward * cos - starboard * sin], axis=-1)


def way(p: Pings, over_ground: Array, heading: Array) -> Array:
    """`(n, 2)` way by bottom track from its first ping on [m]; across gaps linear."""
    seen = np.isfinite(over_ground[:, 0])
    velocity = turned(over_ground, heading)
    whole = np.stack([np.interp(p.t, p.t[seen], velocity[seen, k]) for k in range(2)], axis=1)
    steps = np.diff(p.t)[:, None] * (whole[1:] + whole[:-1]) / 2
    return np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


def downstream(flow: dict[str, Array]) -> Array:
    """Unit vector, east and north, of the river's mean direction."""
    return np.array([np.sin(np.radians(flow["towards_deg"][0])), np.cos(np.radians(flow["towards_deg"][0]))])


def profile(water: Array, depth: Array) -> tuple[Array, Array]:
    """Mean velocity along the river by parts of the depth: middles of twentieths, and velocities [m/s]."""
    part = DEPTHS / depth[:, None]
    middles = np.arange(0.075, _FREE, 0.05)
    bins = [water[..., 0][(np.abs(part - q) < 0.025) & np.isfinite(water[..., 0])] for q in middles]
    return middles, np.array([b.mean() for b in bins])


def log_law(middles: Array, speeds: Array) -> tuple[float, float, float]:
    """Friction velocity [m/s] (von Karman 0.4), speed at the surface [m/s], exponent of the power law that fits best.

    u = u_s + (u*/0.4) ln(y/h): a line in ln(y/h), y from the bed.
    """
    up = np.log(1 - middles)
    slope, surface = np.polyfit(up, speeds, 1)
    return 0.4 * float(slope), float(surface), float(np.polyfit(up, np.log(speeds), 1)[0])


def spreads(water: Array, depth: Array) -> dict[str, float]:
    """Of the water, above 0.9 of the depth: noise of the vertical velocity, and spreads about profile and ping [m/s].

    Noise: differences over r of velocities with noise have the mean square 2 s^2 + b r^(2/3), of noise and of eddies of
    the inertial range (Kolmogorov); 0.5 to 1.25 m, since a pulse of 0.3 m joins next cells, and eddies end.
    """
    middles, speeds = profile(water, depth)
    part = DEPTHS / depth[:, None]
    free = (part < _FREE) & np.isfinite(water).all(axis=-1)
    up = np.where(free, water[..., 2], np.nan)
    lags = np.arange(2, 6)
    squares = np.array([np.nanmean((up[:, k:] - up[:, :-k]) ** 2) for k in lags])
    fit = np.linalg.lstsq(np.stack([np.ones(len(lags)), (lags * CELL_M) ** (2 / 3)], axis=1), squares, rcond=None)[0]
    along = np.where(free, water[..., 0] - np.interp(part, middles, speeds), np.nan)
    found = {"noise_up": float(np.sqrt(max(fit[0], 0.0) / 2))}
    for name, x in (("along", along), ("up", up)):
        found[name] = float(np.nanstd(x - np.nanmean(x, axis=1, keepdims=True)))
    return found


def keep_tables(folder: Path) -> None:
    """Reduce the recording to the small tables."""
    found = list(pd0.ensembles(gzip.decompress((folder / FILE).read_bytes())))
    _keep_pings(found)
    p = pings()
    heading = p.heading + p.declination + alignment(p)
    cells = np.array([pd0.water(e, RECORDED)[:CELLS] for e in found])
    level = turned(cells[..., :2], heading[:, None]) + p.speed[:, None]
    depth = np.nanmean(p.ranges, axis=1)
    free = (DEPTHS / depth[:, None] < _FREE) & np.isfinite(level[..., 0])
    mean = level[free & p.within(MOVING_S)[:, None]].mean(axis=0)
    along = mean / np.hypot(*mean)
    water = np.concatenate([level @ np.stack([along, [-along[1], along[0]]], axis=1), cells[..., 2:]], axis=-1)
    _keep_flow(p, water, free, depth, float(np.degrees(np.arctan2(*along))))
    s = p.within(MOVING_S)
    middles, speeds = profile(water[s], depth[s])
    keep("river_profile.csv", SOURCE, {"part_of_depth": middles, "along_mps": speeds}, 5)
    keep("river_water.csv", SOURCE, {k + "_mps": np.array([v]) for k, v in spreads(water[s], depth[s]).items()}, 4)


def _keep_flow(p: Pings, water: Array, free: NDArray[np.bool_], depth: Array, towards: float) -> None:
    edges = np.arange(0.0, p.t[-1], _STRETCH_S)
    rows = []
    for a in edges:
        s = p.within((a, a + _STRETCH_S))
        rows.append([p.place[s, 0].mean(), depth[s].mean(), water[..., 0][free & s[:, None]].mean(), towards % 360])
    columns = dict(zip(("east_m", "depth_m", "along_mps", "towards_deg"), np.array(sorted(rows)).T, strict=True))
    keep("river_flow.csv", SOURCE, columns, 5)


def _keep_pings(found: list[pd0.Ensemble]) -> None:
    clock = np.array([np.dot(e.take("4B", pd0.VARIABLE, 7), [3600, 60, 1, 0.01]) for e in found])
    fixes = np.array([[t - age, north, east] for t, e in zip(clock, found, strict=True) for age, north, east in
                      pd0.fixes(e)])  # fmt: skip
    ways = np.array([[t - age, *rest] for t, e in zip(clock, found, strict=True) for age, *rest in pd0.ways(e)])
    x, y = GeoOrigin(*fixes[0, 1:]).to_xy(fixes[:, 1], fixes[:, 2])
    track = np.radians(ways[:, 1])
    gps = [(fixes[:, 0], -y, 0.0), (fixes[:, 0], x, 0.0), (ways[:, 0], ways[:, 3] * np.sin(track), LATE_S),
           (ways[:, 0], ways[:, 3] * np.cos(track), LATE_S)]  # fmt: skip
    turn = np.array([e.take("Hhh", pd0.VARIABLE, 18) for e in found]) / 100
    ranges = np.array([e.take("4H", pd0.TRACK, 16) for e in found]) / 100
    bed = pd0.velocities([e.take("4h", pd0.TRACK, 24) for e in found])
    lost = np.array([e.take("4B", pd0.TRACK, 32) for e in found]) == 0
    columns = {"t_s": clock - clock[0], "heading_deg": turn[:, 0], "pitch_deg": turn[:, 1], "roll_deg": turn[:, 2]}
    columns |= {f"range_{b}_m": np.where(ranges[:, b] > 0, ranges[:, b], np.nan) for b in range(4)}
    columns |= {"lost": lost @ [1, 2, 4, 8], "starboard_mps": -bed[:, 0], "forward_mps": -bed[:, 1]}
    columns["error_mps"] = bed[:, 3]
    names = ("east_m", "north_m", "east_mps", "north_mps")
    columns |= {n: np.interp(clock - late, t, v) for n, (t, v, late) in zip(names, gps, strict=True)}
    columns["declination_deg"] = np.full(len(found), np.median((ways[:, 1] - ways[:, 2]) % 360))
    keep("river_pings.csv", SOURCE, columns, 5)
