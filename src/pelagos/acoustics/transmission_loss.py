"""The sound field of a source in a vertical section: Gaussian beams about the rays of a fan.

Source: M. B. Porter and H. P. Bucker, J. Acoust. Soc. Am. 82, 1349 (1987), doi 10.1121/1.395269 (beams); F. B. Jensen,
W. A. Kuperman, M. B. Porter, H. Schmidt, Computational Ocean Acoustics (2nd ed., 2011), Section 3.4 (beams as wide as
the tube of rays they stand for), doi 10.1007/978-1-4419-8678-8.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.layered_rays import QUIET, Launch, Ray, depart, march_by
from pelagos.acoustics.layered_water import Floor, Water
from pelagos.acoustics.section import Section, mirrored, on_device
from pelagos.jit import Array

_REACH: Final = 4.0  # standard deviations of a beam beyond which nothing is left of it
_BOUNCES: Final = 200
_LEGS: Final = 8  # times that slopes may turn a ray back or forth


@dataclass(frozen=True)
class RayPaths:
    """Rays past equally spaced stations.

    Attributes:
        x: `(stations,)` [m].
        angle: `(rays,)` at the source, positive down [rad].
        depth: `(rays, stations)`, not a number where a ray never came [m].
        surface, bottom: `(rays, stations)` bounces until there.
    """

    x: NDArray[np.float64]
    angle: NDArray[np.float64]
    depth: NDArray[np.float64]
    surface: NDArray[np.float64]
    bottom: NDArray[np.float64]


@dataclass(frozen=True)
class Field:
    """Sound on a grid.

    Attributes:
        x: `(columns,)` distances from the source [m].
        depth: `(rows,)` [m].
        pressure: `(columns, rows)` complex, re that at 1 m.
        intensity: `(columns, rows)`, beams summed without their phase, re that at 1 m.
    """

    x: NDArray[np.float64]
    depth: NDArray[np.float64]
    pressure: NDArray[np.complex128]
    intensity: NDArray[np.float64]

    @property
    def loss_db(self) -> NDArray[np.float64]:
        """Coherent transmission loss [dB re 1 m]."""
        return np.asarray(-20.0 * np.log10(np.maximum(np.abs(self.pressure), 1e-15)))

    @property
    def incoherent_loss_db(self) -> NDArray[np.float64]:
        """Incoherent transmission loss [dB re 1 m]."""
        return np.asarray(-10.0 * np.log10(np.maximum(self.intensity, 1e-30)))


def ray_paths(
    section: Section, source: float, angles: NDArray[np.float64], reach: float, *, stations: int = 400,
    bounces: int = _BOUNCES,
) -> RayPaths:  # fmt: skip
    """Rays of a fan from a depth `source` [m], at `angles` [rad], to a distance `reach` [m]."""
    count = len(angles)
    values, _ = _marched([section], np.zeros(count, np.int64), np.full(count, source), angles, np.full(count, reach),
                      stations, bounces)  # fmt: skip
    depth, surface, bottom = (np.array(values[k]).reshape(-1, stations)[:count] for k in (0, 6, 7))
    x = np.arange(1, stations + 1, dtype=np.float64) * np.float64(reach / stations)
    return RayPaths(x, angles, depth, surface, bottom)


def ray_depths(
    sections: Sequence[Section], path: NDArray[np.int64], source: NDArray[np.float64], angle: NDArray[np.float64],
    reach: NDArray[np.float64], *, stations: int,
) -> NDArray[np.float64]:  # fmt: skip
    """`(k, stations)` depths of rays in different sections at equal parts of their reach [m], NaN where none came.

    Args:
        path: `(k,)` which section.
        source, angle, reach: `(k,)` depth [m], angle [rad], distance [m].
    """
    values, _ = _marched(sections, path, source, angle, reach, stations, _BOUNCES)
    return np.array(values[0]).reshape(-1, stations)[: len(path)]


def field(
    section: Section, source: float, *, reach: float, columns: int, depths: NDArray[np.float64],
    widest: float, beams: int = 2000,
) -> Field:  # fmt: skip
    """Pressure on a grid.

    Args:
        section: what sound meets.
        source: its depth [m].
        reach: distance of the last column [m].
        columns: equally spaced.
        depths: of the rows [m].
        widest: half the fan's opening [rad].
        beams: of the fan.
    """
    angles = np.linspace(-widest, widest, beams)
    values, angles, spacing = *_there_and_back(section, source, angles, reach, columns), angles[1] - angles[0]
    beams = len(angles)
    x = np.arange(1, columns + 1, dtype=np.float64) * np.float64(reach / columns)
    z = np.array(values[0])
    speed = section.speed_at(np.where(np.isfinite(z), z, 0.0), np.tile(x, beams))
    grid = (
        jit.from_numpy(jit.Float64, np.repeat(x, len(depths))),
        jit.from_numpy(jit.Float64, np.tile(depths, columns)),
    )
    sizes = [jit.from_numpy(jit.UInt32, np.array([v], np.uint32)) for v in (beams, columns, len(depths))]
    constants = [
        dr.opaque(jit.Float64, float(v)) for v in (section.frequency, spacing, float(section.speed_at(source)))
    ]
    profile = (
        jit.from_numpy(jit.Float64, speed),
        jit.from_numpy(jit.Float64, np.cos(angles)),
        jit.from_numpy(jit.Float64, x),
    )
    beam = _beams()(values[:6], values[8], *profile, sizes, constants)
    real, imaginary, intensity = _summed()(beam, grid, sizes)
    shape = (columns, len(depths))
    pressure = (np.array(real) + 1j * np.array(imaginary)).reshape(shape)
    return Field(x, np.asarray(depths), pressure, np.array(intensity).reshape(shape))


def _marched(
    sections: Sequence[Section], path: NDArray[np.int64], source: NDArray[np.float64], angle: NDArray[np.float64],
    reach: NDArray[np.float64], stations: int, bounces: int, *, rounded: bool = True,
) -> tuple[list[Array], Ray]:  # fmt: skip
    """See `march_by`; numbers of rays are rounded up, so that calls of similar size share one kernel."""
    water, floor = on_device(sections)
    count = len(angle)
    width = max(64, 1 << (count - 1).bit_length()) if rounded else count
    rows = np.minimum(np.arange(width), count - 1)
    launch = Launch(
        jit.from_numpy(jit.UInt32, path[rows].astype(np.uint32)), jit.from_numpy(jit.Float64, source[rows]),
        jit.from_numpy(jit.Float64, np.asarray(angle, np.float64)[rows]), jit.from_numpy(jit.Float64, reach[rows]),
        jit.from_numpy(jit.UInt32, np.full(width, bounces, np.uint32)),
    )  # fmt: skip
    found: tuple[list[Array], Ray] = _station_kernel(stations)(water, floor, launch)
    return found


@cache
def _station_kernel(stations: int) -> Any:
    def trace(water: Water, floor: Floor, launch: Launch) -> tuple[list[Array], Ray]:
        start = dr.zeros(jit.UInt32, dr.width(launch.row))
        return march_by(water, floor, launch, depart(water, launch), start, stations=stations)

    return jit.freeze(trace)


def _there_and_back(
    section: Section, source: float, angles: NDArray[np.float64], reach: float, stations: int
) -> tuple[list[Array], NDArray[np.float64]]:
    """Values of `march_by`, and angles at the source, of the rays of a fan, and again of those that slopes turn back
    and forth, which pass stations once more as rays of their own."""
    count = len(angles)
    lanes = np.zeros(count, np.int64), np.full(count, source), angles, np.full(count, reach)
    values, ray = _marched([section], *lanes, stations, _BOUNCES, rounded=False)
    legs: list[Any] = [values]
    taken = [angles]
    sides = (section, mirrored(section, reach))
    for leg in range(1, _LEGS + 1):
        rows = _turned(ray)
        if not len(rows):
            break
        angles = angles[rows]
        values, ray = _resumed(sides[leg % 2], ray, rows, reach, stations)
        order = np.arange(stations - 2, -1, -1) if leg % 2 else np.arange(stations)
        legs.append([_ordered(v, len(rows), stations, order) for v in values])
        taken.append(angles)
    if len(legs) == 1:
        return values, angles
    joined = [np.concatenate([np.array(leg[k]) for leg in legs]) for k in range(len(values))]
    return [jit.from_numpy(jit.Float64, v) for v in joined], np.concatenate(taken)


def _turned(ray: Ray) -> NDArray[np.intp]:
    """Rows of the rays that a slope has turned back, and that are still to be heard."""
    bounces = np.array(ray.surface) + np.array(ray.bottom)
    left = (np.array(ray.real) ** 2 + np.array(ray.imaginary) ** 2) * 10.0 ** (-0.1 * np.array(ray.loss))
    return np.flatnonzero((np.array(ray.slowness) < 0.0) & (bounces <= _BOUNCES) & (left > QUIET))


def _resumed(side: Section, ray: Ray, rows: NDArray[np.intp], reach: float, stations: int) -> tuple[list[Array], Ray]:
    """`march_by` of rays that were turned, in the section as they see it now."""
    water, floor = on_device([side])
    width = max(64, 1 << (len(rows) - 1).bit_length())
    own = {f.name: np.zeros(width, np.array(getattr(ray, f.name)).dtype) for f in fields(Ray)}
    for name, values in own.items():
        values[: len(rows)] = np.array(getattr(ray, name))[rows]
    here = reach - own["x"][: len(rows)]
    own["x"][: len(rows)], own["slowness"] = here, np.abs(own["slowness"])
    own["alive"][: len(rows)] = True
    for name, edges in (("node", side.bottom_x), ("column", side.begins)):
        own[name][: len(rows)] = np.clip(np.searchsorted(edges, here, side="right") - 1, 0, len(edges) - 1)
    station = np.zeros(width, np.uint32)
    station[: len(rows)] = np.maximum(np.ceil(here * stations / reach) - 1.0, 0.0)
    start = Ray(*(jit.from_numpy(type(getattr(ray, f.name)), own[f.name]) for f in fields(Ray)))
    launch = Launch(
        dr.zeros(jit.UInt32, width), dr.zeros(jit.Float64, width), dr.zeros(jit.Float64, width),
        dr.full(jit.Float64, reach, width), dr.full(jit.UInt32, _BOUNCES, width),
    )  # fmt: skip
    dr.eval(launch)
    found: tuple[list[Array], Ray] = _resumed_kernel(stations)(
        water, floor, launch, start, jit.from_numpy(jit.UInt32, station)
    )
    return found


@cache
def _resumed_kernel(stations: int) -> Any:
    def trace(water: Water, floor: Floor, launch: Launch, ray: Ray, station: Array) -> tuple[list[Array], Ray]:
        return march_by(water, floor, launch, ray, station, stations=stations)

    return jit.freeze(trace)


def _ordered(values: Array, count: int, stations: int, order: NDArray[np.intp]) -> NDArray[np.float64]:
    """Values of `count` rays by station from the source on; not a number at those that these rays do not pass."""
    found = np.full((count, stations), np.nan)
    found[:, : len(order)] = np.array(values).reshape(-1, stations)[:count, order]
    return found.ravel()


@cache
def _beams() -> Any:
    return jit.freeze(_beam)


@cache
def _summed() -> Any:
    return jit.freeze(_sum)


def _beam(
    rays: list[Array], bounced: Array, speed: Array, cosines: Array, x: Array, sizes: list[Array],
    constants: list[Array],
) -> list[Array]:  # fmt: skip
    """Beams by ray and station: depth of the axis, 1/width in depth, amplitude, intensity, phase, and its slope."""
    z, sine, time, level, spread, caustics = rays
    _, columns, _ = sizes
    frequency, spacing, speed_at_source = constants
    lane = dr.arange(jit.UInt32, dr.width(z))
    ray = lane // columns
    cosine = dr.sqrt(dr.maximum(1.0 - sine * sine, 1e-12))
    tube = dr.maximum(dr.abs(spread) * spacing, 1e-12)
    width = dr.maximum(tube, dr.minimum(0.2 * frequency * time, math.pi) * speed / frequency)
    tubes = speed / speed_at_source * dr.gather(jit.Float64, cosines, ray) * spacing
    tubes = tubes / (dr.gather(jit.Float64, x, lane - ray * columns) * tube) * dr.exp(-0.2302585092994046 * level)
    size = dr.sqrt(tubes / (2.0 * math.pi)) * tube / width
    energy = tubes / math.sqrt(2.0 * math.pi) * tube / width
    omega = 2.0 * math.pi * frequency
    phase = bounced + caustics * (0.5 * math.pi) - omega * time
    turns = dr.round(phase * (0.5 / math.pi))
    values = [z, cosine / width, size, energy, phase - 2.0 * math.pi * turns, -omega * sine / speed]
    here = dr.isfinite(z)
    return [dr.select(here, v, 0.0 if k else 1e9) for k, v in enumerate(values)]


def _sum(
    beam: list[Array], grid: tuple[Array, Array], sizes: list[Array]
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Real and imaginary pressure and intensity at every point of the grid."""
    beams, columns, rows = sizes
    x, depth = grid
    column = dr.arange(jit.UInt32, dr.width(x)) // rows

    def heard(k: Array, real: Array, imaginary: Array, intensity: Array, away: Array, part: Array) -> tuple[Any, ...]:
        size, energy, phase, slope = (dr.gather(jit.Float64, a, k * columns + column) for a in beam[2:])
        bell = dr.exp(-0.5 * part * part)
        s, c = dr.sincos(phase + slope * away)
        return k, real + size * bell * c, imaginary + size * bell * s, intensity + energy * bell, away, part

    def add(k: Array, real: Array, imaginary: Array, intensity: Array) -> tuple[Array, ...]:
        z, narrow = (dr.gather(jit.Float64, a, k * columns + column) for a in beam[:2])
        away = depth - z
        part = away * narrow
        state = (k, real, imaginary, intensity, away, part)
        found = dr.if_stmt(state, dr.abs(part) < _REACH, heard, lambda *s: s, mode="symbolic")
        return k + 1, found[1], found[2], found[3]

    zero = dr.zeros(jit.Float64, dr.width(x))
    start = (dr.zeros(jit.UInt32, dr.width(x)), zero, zero + 0.0, zero + 0.0)
    found = dr.while_loop(start, lambda k, *_: k < beams, add, mode="symbolic")
    return found[1], found[2], found[3]
