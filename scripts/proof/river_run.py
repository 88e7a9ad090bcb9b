"""The simulated crossing of a river: a log and a profiler that move as recorded, over the recorded bed and flow."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from page import table
from river_record import (
    CELL_M,
    CELLS,
    FIRST_M,
    MOVING_S,
    TILT,
    Array,
    Pings,
    alignment,
    downstream,
    log_law,
    pings,
    turned,
)

import pelagos as pl
from pelagos import jit
from pelagos.jit import Array as DeviceArray
from pelagos.math.geodesy import GeoOrigin

# Teledyne RDI, Workhorse Navigator, data sheet: 1200 kHz, at 30 deg 3 mm/s of a horizontal component in a single ping
# at 1 m/s (recalled; as in the chapter of an ROV's devices), of which a beam has 2^0.5 sin 30 deg; ranges in whole cm
LOG: Final[dict[str, Any]] = {
    "frequency_hz": 1228.8e3, "beam_tilt_deg": 20.0, "range_max_m": 30.0, "noise_mps": 0.003 / 2**0.5, "rate_hz": 2.0,
    "beam_azimuth_deg": [90.0, -90.0, 0.0, 180.0], "range_resolution_m": 0.01 / np.cos(TILT),
}  # fmt: skip
# Teledyne RDI, Workhorse Sentinel, data sheet: 1200 kHz, single ping, broadband: 14.0, 7.0, 3.6 and 1.8 cm/s of a
# horizontal component in cells of 0.25, 0.5, 1 and 2 m (recalled; the maker's PlanADCP, as LADCP software cites it, has
# 6.94, 3.55 and 1.73 cm/s at 300 kHz in 2, 4 and 8 m: the same by cell and frequency); of which a beam has 2^0.5 sin 20
# deg
_SHEET_MPS: Final = 0.140
_PARTS: Final = (
    4  # profilers, one below the other, that make one: a quarter of the cells compiles in a tenth of the time
)
PROFILER: Final[dict[str, Any]] = {
    "frequency_hz": 1228.8e3, "beam_tilt_deg": 20.0, "beam_azimuth_deg": [90.0, -90.0, 0.0, 180.0],
    "cells": CELLS // _PARTS, "cell_m": CELL_M, "noise_cell_exponent": 1.0,
    "noise_mps": _SHEET_MPS * CELL_M * 2**0.5 * np.sin(TILT), "rate_hz": 2.0,
}  # fmt: skip
GRAIN_MM: Final = 0.177  # fine sand, 0.125 to 0.25 mm, of which the bed here is made in parts (Toniolo 2013)
_REFUSED_MPS: Final = 0.1  # error velocity beyond which the log was set to refuse a ping, by its own leader
_DRAUGHT_M: Final = 0.3  # of the transducer; assumed, and without effect
_MIDDLE_DEG: Final = (64.56, -149.07)
_RESOLUTION_M: Final = 2.5  # of the bed: some twenty soundings each, so that little of their scatter is in it
_LOG_MEAN: Final = -0.786  # mean of ln(y/h) between 0.05 and 0.9 of the depth, which the kept means are of
# I. Nezu and H. Nakagawa, Turbulence in Open-Channel Flows (1993): rms of the three components 2.30, 1.63 and 1.27 u*
# exp(-z/h); 1.17 u* in the mean of all and of the depth. Eddies along the flow at half the depth: 0.78 h; a spectrum
# that begins with k^(-5/3) at a wave number k has those at 0.94/k
_RMS_OVER_FRICTION: Final = float(np.sqrt((2.30**2 + 1.63**2 + 1.27**2) / 3 * (1 - np.exp(-2.0)) / 2))
_LARGEST_OVER_DEPTH: Final = 2 * np.pi * 0.78 / 0.94


@dataclass(frozen=True)
class Crossing:
    """What the simulated devices tell: pings of the log over still and over sandy bed, and the water.

    Attributes:
        still, sand: of two logs, as recorded ones.
        water: `(m, cells, 3)` along the river, aside, up [m/s], of the pings over moving bed.
    """

    still: Pings
    sand: Pings
    water: Array


def _flow() -> tuple[tuple[float, ...], ...]:
    """East, depth [m] and mean speed [m/s] along the way over moving bed; direction; slope of the law, draught [m]."""
    flow, kept, p = table("river_flow.csv"), table("river_profile.csv"), pings()
    east = p.place[p.within(MOVING_S), 0]
    near = np.flatnonzero((flow["east_m"] > east.min()) & (flow["east_m"] < east.max()))
    near = np.arange(near[0] - 1, near[-1] + 2)
    friction, surface, _ = log_law(kept["part_of_depth"], kept["along_mps"])
    share = friction / 0.4 / (surface + _LOG_MEAN * friction / 0.4)
    columns = (tuple(map(float, flow[k][near])) for k in ("east_m", "depth_m", "along_mps"))
    return (*columns, tuple(map(float, downstream(flow))), (share, _LOG_MEAN, _DRAUGHT_M))


def stream(position: DeviceArray, t: DeviceArray, *, flow: tuple[tuple[float, ...], ...] = _flow()) -> DeviceArray:
    """The river's mean flow: measured means, linear across, by depth the logarithmic law that fits best; NWU [m/s].

    u = U (1 + a (ln(y/h) + 0.786)): the mean of what is free of the bed's echo is U.
    """
    import drjit as dr

    east, depths, speeds, towards, (share, free, draught) = flow
    at = -position[1]
    deep, mean = jit.Float64(depths[0]), jit.Float64(speeds[0])
    for i in range(len(east) - 1):
        part = dr.clip((at - east[i]) / (east[i + 1] - east[i]), 0.0, 1.0)
        deep += part * (depths[i + 1] - depths[i])
        mean += part * (speeds[i + 1] - speeds[i])
    up = dr.clip(1.0 + (position[2] + draught) / deep, 0.01, 1.0)
    speed = mean * (1.0 + share * (dr.log(up) - free)) + 0.0 * t
    return jit.Array3f64(towards[1] * speed, -towards[0] * speed, 0.0 * speed)


def crossing(p: Pings, friction: float) -> Crossing:
    """Observe at every recorded pose; `friction` velocity of the flow [m/s]."""
    heading = p.heading + p.declination + alignment(p)
    attitude, velocity = _motion(p, heading)
    at = np.stack([p.place[:, 1], -p.place[:, 0], np.full(len(p.t), -_DRAUGHT_M)], axis=1)
    with tempfile.TemporaryDirectory() as folder:
        sim = pl.Simulation.load(_over_bed(p, heading, friction, Path(folder) / "bed.csv"), trust=True)
    seen = sim.observe("boat", at, attitude, velocity=velocity)
    logs = [_pings(p, seen[name], attitude, heading) for name in ("still", "sand")]
    rows = p.within(MOVING_S)
    profilers = {f"adcp_{k}": {"type": "adcp", "blank_m": FIRST_M + (CELLS // _PARTS * k - 0.5) * CELL_M, **PROFILER}
                 for k in range(_PARTS)}  # fmt: skip
    # a level bed below all cells that are looked at; the water flows past with its eddies (Taylor's hypothesis)
    deep = _scenario({"type": "flat", "depth_m": 12.0}, _eddies(p, friction), profilers)
    sim = pl.Simulation.load(deep, trust=True)
    at[:, 0] -= float(np.mean(table("river_flow.csv")["along_mps"])) * p.t
    water = sim.observe("boat", at[rows], attitude[rows], velocity=velocity[rows])
    cells = np.concatenate([water[name].data for name in profilers], axis=1)
    return Crossing(*logs, _water(p.speed[rows], cells, attitude[rows]))


def _scenario(world: dict[str, Any], eddies: dict[str, Any], sensors: dict[str, Any]) -> dict[str, Any]:
    boat = {"vehicle": {"type": "bluerov2"}, "control": "actuators", "start": {"position_m": [0.0, 0.0, -_DRAUGHT_M]}}
    flow = {"type": "python", "function": f"{__name__}:stream"}
    return {"name": "tanana", "tick_rate_hz": 2.0, "duration_s": 400.0, "seed": 10, "world": world,
            "ocean": {"currents": [flow, eddies]}, "agents": {"boat": {**boat, "sensors": sensors}}}  # fmt: skip


def _over_bed(p: Pings, heading: Array, friction: float, file: Path) -> dict[str, Any]:
    """Two logs over the bed as their beams sounded it."""
    x, y, z = _soundings(p, heading)
    latitude, longitude = GeoOrigin(*_MIDDLE_DEG).to_latlon(x, y)
    lines = [f"{lon:.8f},{lat:.8f},{up:.3f}" for lon, lat, up in zip(longitude, latitude, z, strict=True)]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    world = {"type": "bathymetry", "path": str(file), "sign": "up", "crs": "EPSG:4326", "resolution_m": _RESOLUTION_M,
             "centre_deg": list(_MIDDLE_DEG), "size_m": [240.0, 480.0]}  # fmt: skip
    logs = {"still": {"type": "dvl", **LOG}, "sand": {"type": "dvl", **LOG, "bed_grain_mm": GRAIN_MM}}
    return _scenario(world, _eddies(p, friction), logs)


def _eddies(p: Pings, friction: float) -> dict[str, Any]:
    depth = float(np.nanmean(p.ranges[p.within(MOVING_S)]))
    return {"type": "turbulence", "rms_mps": _RMS_OVER_FRICTION * friction, "modes": 400,
            "largest_m": _LARGEST_OVER_DEPTH * depth, "smallest_m": CELL_M}  # fmt: skip


def _soundings(p: Pings, heading: Array) -> tuple[Array, Array, Array]:
    """Where each beam met the bed: x north, y west, z up [m]."""
    aside = p.ranges * np.tan(TILT)
    starboard, forward = aside * np.array([-1.0, 1.0, 0.0, 0.0]), aside * np.array([0.0, 0.0, 1.0, -1.0])
    level = turned(np.stack([starboard, forward], axis=-1), heading[:, None])
    ok = np.isfinite(p.ranges)
    east, north = (p.place[:, None, k] + level[..., k] for k in range(2))
    return north[ok], -east[ok], -(p.ranges + _DRAUGHT_M)[ok]


def _motion(p: Pings, heading: Array) -> tuple[Array, Array]:
    """Attitude `(n, 4)` and velocity `(n, 3)` in the body frame FLU: heading, then pitch bow up, then roll port up."""
    half = np.stack([-heading, -p.pitch, p.roll]) / 2
    (cz, cy, cx), (sz, sy, sx) = np.cos(half), np.sin(half)
    attitude = np.stack([cz * cy * cx + sz * sy * sx, cz * cy * sx - sz * sy * cx, cz * sy * cx + sz * cy * sx,
                         sz * cy * cx - cz * sy * sx], axis=1)  # fmt: skip
    ground = np.stack([p.speed[:, 1], -p.speed[:, 0], np.zeros(len(p.t))], axis=1)
    return attitude, np.einsum("nji,nj->ni", _matrix(attitude), ground)


def _matrix(q: Array) -> Array:
    """`(n, 3, 3)` body to world."""
    w, x, y, z = q.T
    rows = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]  # fmt: skip
    return np.moveaxis(np.array(rows), -1, 0)


def _pings(p: Pings, reading: Any, attitude: Array, heading: Array) -> Pings:
    """A simulated log's readings as recorded ones: ranges downwards along its axis, velocity levelled."""
    speeds, lost = reading.extras["beam_velocity"], ~reading.extras["beam_valid"]
    error = (speeds[:, 0] + speeds[:, 1] - speeds[:, 2] - speeds[:, 3]) / (2**0.5 * 2 * np.sin(TILT))
    ground = np.einsum("nij,nj->ni", _matrix(attitude), reading.data)
    across = np.stack([-ground[:, 1], ground[:, 0]], axis=1)  # east, north
    level = turned(across, -heading)
    ranges = reading.extras["ranges"] * np.cos(TILT)
    refused = np.abs(error) > _REFUSED_MPS
    level = np.where(refused[:, None], np.nan, level)
    error = np.where(refused | lost.any(axis=1), np.nan, error)
    return replace(p, ranges=ranges, lost=lost, over_ground=level, error=error)


def _water(speed: Array, cells: Array, attitude: Array) -> Array:
    """`(m, cells, 3)` along the river, aside, up: what profilers tell relative to them, and their own speed by GPS."""
    relative = np.einsum("nij,ncj->nci", _matrix(attitude), cells)
    along = downstream(table("river_flow.csv"))
    level = np.stack([-relative[..., 1], relative[..., 0]], axis=-1) + speed[:, None]
    turn: NDArray[np.float64] = np.stack([along, [-along[1], along[0]]], axis=1)
    return np.concatenate([level @ turn, relative[..., 2:]], axis=-1)
