"""Eigenrays through the water of a simulation: its sound speed, its ground, its surface, and what stands in the way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, TypeAlias

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.absorption import francois_garrison
from pelagos.acoustics.eigenrays import Arrivals, eigenrays
from pelagos.acoustics.section import Section, Sections, thinned
from pelagos.acoustics.transmission_loss import ray_depths
from pelagos.jit import Array
from pelagos.ocean.ocean import Ocean
from pelagos.ocean.surface_wind import surface_wind
from pelagos.ocean.water_column import STEP_M, WaterColumn
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import NO_BODY, Rays
from pelagos.raycast.scene import Scene
from pelagos.sensors.recorded import Program, Results
from pelagos.world.material import Material
from pelagos.world.world import World

NODES: Final = 33
"""Of the bottom along a path."""
_SAMPLES: Final = 65  # depths at which water that varies in place is asked
_COLUMNS: Final = 25  # of the way, from end to end, each with the water of its middle
_ALIKE: Final = 0.02  # [m/s] by which columns may differ that count as one
_LEVELS: Final = 48
_DEEP: Final = 12_000.0  # [m], where nothing lies below
_SKIN: Final = 0.05  # [m] that a cast begins beside surfaces
_HULL: Final = 1.5  # [m] before a receiver, within which what stands in the way is its own vehicle; assumed
_GROUND: Final = frozenset({4, 5, 6, 7, 8})  # labels of ground: the rays have met it already
_LEGS: Final = 24  # into which a ray is divided to see what stands in its way
_ENDS: Final = [0, NODES - 1]
_ROUNDING: Final = 4e-7  # of a depth by which casts in single precision scatter: over millimetres a slope of a degree
_STRAIGHT: Final = 1e-3  # [m] by which a bottom may depart from a straight line that stands for it

_Levels: TypeAlias = "tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]"


@dataclass(frozen=True)
class Paths:
    """Arrivals in space.

    Attributes:
        arrivals: see `Arrivals`; `path` counts the pairs asked for.
        departure, arrival: `(k, 3)` unit vectors NWU of the ray at source and receiver.
        blocked: `(k,)` something stands in the way.
        speed: `(pairs, 2)` of sound at source and receiver [m/s].
    """

    arrivals: Arrivals
    departure: NDArray[np.float64]
    arrival: NDArray[np.float64]
    blocked: NDArray[np.bool_]
    speed: NDArray[np.float64]


class WaterPaths:
    """Traces pairs of places in a world with an ocean.

    Args:
        scene: what rays are cast into.
        world: its materials.
        ocean: its water.
        frequency: of the sound [Hz].
        rays, bounces: of a fan, of a path.
    """

    def __init__(
        self, scene: Scene, world: World, ocean: Ocean, *, frequency: float, rays: int = 512, bounces: int = 8
    ) -> None:
        self._scene, self._world, self._ocean = scene, world, ocean
        self.frequency, self._rays, self._bounces = frequency, rays, bounces
        self._cast, self._cast_down = Program(_cast, scene.compile), Program(_cast_ground, scene.compile)
        self._wind = surface_wind(ocean)[0]
        self._palette: Sequence[Material] = world.palette
        self._only_ground = all(g.label in _GROUND for g in world.geometries)
        self._cuts: dict[int, _Levels] = {}  # of the column, by the number of levels above the bottom
        self._column = self._column_levels() if isinstance(ocean.masses, WaterColumn) else None

    def sections(
        self, source: NDArray[np.float64], receiver: NDArray[np.float64], t: float, copy: NDArray[np.int64]
    ) -> Sections:
        """Vertical sections between pairs of places `(m, 3)` [m] at time `t` [s]."""
        level = self.level(t)
        x, bottom, material = self._bottoms(source, receiver, level, copy)
        made = []
        straight = _straight(bottom, material)
        for k in range(len(source)):
            depth, speed, absorption, begins = self._levels(source[k], receiver[k], t, float(np.max(bottom[k])))
            nodes = _ENDS if straight[k] else slice(None)
            density, ratio, loss = (
                np.array([getattr(self._palette[m], name) for m in material[k][nodes]])
                for name in ("density_ratio", "sound_speed_ratio", "loss")
            )
            made.append(
                Section(
                    depth, speed, x[k][nodes], bottom[k][nodes], absorption=absorption, density_ratio=density,
                    sound_speed_ratio=ratio, loss=loss, frequency=self.frequency, wind_speed=self._wind,
                    begins=begins,
                )
            )  # fmt: skip
        return Sections(made)

    def level(self, t: float) -> float:
        """Of the sea at a time [m]; waves left out."""
        return sea_level(self._ocean, t)

    def trace(
        self, source: NDArray[np.float64], receiver: NDArray[np.float64], t: float, copy: NDArray[np.int64],
        own: NDArray[np.uint32] | None = None,
    ) -> Paths:  # fmt: skip
        """All arrivals of pairs of places.

        Args:
            source, receiver: `(m, 3)` NWU [m]; those in the air have none.
            t: [s].
            copy: `(m,)` of the fleet.
            own: `(m,)` rows of the moving scene that are the source's own hull.
        """
        level = self.level(t)
        sections = self.sections(source, receiver, t, copy)
        way = receiver[:, :2] - source[:, :2]
        distance = np.hypot(way[:, 0], way[:, 1])
        zs, zr = level - source[:, 2], level - receiver[:, 2]
        found = eigenrays(sections, zs, zr, distance, rays=self._rays, bounces=self._bounces)
        wet = (zs >= 0.0) & (zr >= 0.0)
        found = found.take(wet[found.path])
        heading = np.arctan2(way[:, 1], way[:, 0])[found.path]
        towards = [
            np.stack([np.cos(a) * np.cos(heading), np.cos(a) * np.sin(heading), -np.sin(a)], axis=-1)
            for a in (found.departure, found.arrival)
        ]
        at_risk = self._in_the_way(source, receiver, distance, copy, own)[found.path]
        blocked = np.zeros(len(found), dtype=bool)
        blocked[at_risk] = self._blocked(
            found.take(at_risk), sections, source, zs, distance, level, heading[at_risk], copy, own
        )
        ends = [
            np.array([float(s.speed_at(z, x)) for s, z, x in zip(sections, d, way, strict=True)])
            for d, way in ((zs, 0.0 * distance), (zr, distance))
        ]
        return Paths(found, towards[0], towards[1], blocked, np.stack(ends, axis=-1))

    def _in_the_way(
        self, source: NDArray[np.float64], receiver: NDArray[np.float64], distance: NDArray[np.float64],
        copy: NDArray[np.int64], own: NDArray[np.uint32] | None,
    ) -> NDArray[np.bool_]:  # fmt: skip
        """`(m,)`: structures, or a hull on the way, which `_blocked` has to look at."""
        spheres = self._scene.spheres
        if not self._only_ground or (self._scene.moving is not None and spheres is None):
            return np.ones(len(source), dtype=bool)
        if self._scene.moving is None or spheres is None:
            return np.zeros(len(source), dtype=bool)
        rows = np.full(len(source), NO_BODY, np.uint32) if own is None else own
        return spheres.between(source, receiver, copy, own=rows, spared=np.minimum(_HULL, distance / _LEGS))

    def _blocked(
        self, found: Arrivals, sections: Sequence[Section], source: NDArray[np.float64], zs: NDArray[np.float64],
        distance: NDArray[np.float64], level: float, heading: NDArray[np.float64], copy: NDArray[np.int64],
        own: NDArray[np.uint32] | None,
    ) -> NDArray[np.bool_]:  # fmt: skip
        """`(k,)`: a structure or a hull stands in the way of a ray."""
        if len(found) == 0:
            return np.zeros(len(found), dtype=bool)
        x = np.linspace(0.0, 1.0, _LEGS + 1) * distance[found.path][:, None]  # (k, legs + 1)
        start = zs[found.path]
        depth = ray_depths(
            sections, found.path, start, found.departure, np.maximum(distance, 1e-3)[found.path], stations=_LEGS
        )
        z = np.concatenate([start[:, None], np.where(np.isfinite(depth), depth, start[:, None])], axis=1)
        ground = np.stack([sections[p].bottom_at(row) for p, row in zip(found.path, x, strict=True)])
        z = np.clip(z, _SKIN, np.maximum(ground - _SKIN, _SKIN))
        origin = source[found.path][:, None, :]
        place = np.stack(
            [origin[..., 0] + x * np.cos(heading)[:, None], origin[..., 1] + x * np.sin(heading)[:, None], level - z],
            axis=-1,
        )
        leg = np.diff(place, axis=1)
        length = np.linalg.norm(leg, axis=-1)
        reach = length.copy()
        reach[:, -1] = np.maximum(reach[:, -1] - _HULL, 1e-3)
        shape = length.shape
        own_row = np.full(len(found), NO_BODY, np.uint32) if own is None else own[found.path]
        hits = self._ask(
            place[:, :-1].reshape(-1, 3), (leg / np.maximum(length, 1e-9)[..., None]).reshape(-1, 3), reach.ravel(),
            np.repeat(copy[found.path], _LEGS), np.repeat(own_row, _LEGS),
        )  # fmt: skip
        stands = np.isfinite(hits["t"]) & ~np.isin(hits["label"], list(_GROUND))
        return np.asarray(stands.reshape(shape).any(axis=1))

    def _bottoms(
        self, source: NDArray[np.float64], receiver: NDArray[np.float64], level: float, copy: NDArray[np.int64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
        """Nodes of the bottoms: distance, depth [m] and row of the material, `(m, NODES)` each."""
        share = np.linspace(0.0, 1.0, NODES)[:, None]
        place = source[:, None, :] + share * (receiver - source)[:, None, :]
        place[..., 2] = np.minimum(place[..., 2], level - _SKIN)
        shape = place.shape[:2]
        down = np.tile([0.0, 0.0, -1.0], (place[..., 0].size, 1))
        copies, own = np.repeat(copy, NODES), np.full(place[..., 0].size, NO_BODY, np.uint32)
        hits = self._ask(place.reshape(-1, 3), down, np.full(len(down), _DEEP), copies, own, ground=True)
        t, material = hits["t"].astype(np.float64), hits["material"].astype(np.int64)
        lost = ~np.isfinite(t)
        if lost.any():  # below a hill, or over nothing
            above = place.reshape(-1, 3)[lost].copy()
            above[:, 2] = level + 500.0
            again = self._ask(above, down[lost], np.full(int(lost.sum()), _DEEP), copies[lost], own[lost], ground=True)
            t[lost] = again["t"].astype(np.float64) - 500.0 - (level - place.reshape(-1, 3)[lost, 2])
            material[lost] = again["material"]
        depth = level - place[..., 2] + np.where(np.isfinite(t), t, _DEEP).reshape(shape)
        material = material.reshape(shape)
        if not np.isfinite(t).all():
            depth, material = _continued(depth, material, np.isfinite(t).reshape(shape))
        depth = np.maximum(depth, _SKIN)
        level_there = np.ptp(depth, axis=1) <= _ROUNDING * depth.max(axis=1)
        depth[level_there] = depth[level_there].mean(axis=1, keepdims=True)
        way = np.hypot(*(receiver - source)[:, :2].T)
        x = np.maximum(way, 1e-3)[:, None] * share[:, 0]
        return x, depth, material

    def _ask(
        self, origin: NDArray[np.float64], direction: NDArray[np.float64], reach: NDArray[np.float64],
        copy: NDArray[np.int64], own: NDArray[np.uint32], *, ground: bool = False,
    ) -> dict[str, NDArray[Any]]:  # fmt: skip
        """Cast at all, or at what stands still; numbers of rays are rounded up, so that few kernels do for all."""
        count = len(origin)
        if self._scene.static is None and (ground or self._scene.moving is None):
            return {"t": np.full(count, np.inf), "label": np.zeros(count, int), "material": np.zeros(count, int)}
        width = max(64, 1 << (count - 1).bit_length())
        rows = np.minimum(np.arange(width), count - 1)
        start, along = (np.ascontiguousarray(v[rows].T) for v in (origin, direction.astype(np.float32)))
        found = (self._cast_down if ground else self._cast)(
            jit.Array3f64(start), jit.Array3f(along), jit.from_numpy(jit.Float, reach[rows].astype(np.float32)),
            jit.from_numpy(jit.UInt32, copy[rows].astype(np.uint32)), jit.from_numpy(jit.UInt32, own[rows]),
        )  # fmt: skip
        return {name: values[:count] for name, values in found.items()}

    def _levels(self, source: NDArray[np.float64], receiver: NDArray[np.float64], t: float, bottom: float) -> _Levels:
        """Depths down to the bottom [m], sound speed [m/s] and absorption [dB/m] by column, where columns begin [m]."""
        if self._column is not None:
            depth, speed, absorption = self._column
            last = min(int(np.searchsorted(depth, bottom)) + 1, len(depth))
            if last not in self._cuts:
                rows = thinned(depth[:last], speed[:last], levels=_LEVELS) if last > _LEVELS else np.arange(last)
                self._cuts[last] = depth[rows], speed[rows], absorption[rows], np.zeros(1)
            return self._cuts[last]
        depth = np.concatenate([[0.0], np.geomspace(0.5, max(bottom, 2.0), _SAMPLES - 1)])
        share = np.linspace(0.0, 1.0, _COLUMNS)
        speed, absorption = self._asked(source + share[:, None] * (receiver - source), depth, t)
        begins = np.concatenate([[0.0], 0.5 * (share[1:] + share[:-1])])
        begins *= max(float(np.hypot(*(receiver - source)[:2])), 1e-3)
        if np.ptp(speed, axis=0).max() < _ALIKE:
            speed, absorption, begins = speed.mean(axis=0, keepdims=True), absorption[:1], begins[:1]
        rows = thinned(depth, speed, levels=_LEVELS)
        return depth[rows], speed[:, rows], absorption[:, rows], begins

    def _asked(
        self, places: NDArray[np.float64], depth: NDArray[np.float64], t: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sound speed [m/s] and absorption [dB/m] below places, `(places, depths)`."""
        shape = len(places), len(depth)
        x, y = (np.repeat(places[:, k], len(depth)) for k in (0, 1))
        z = np.tile(self.level(t) - depth, len(places))
        at, time = jit.Array3f64(*(jit.Float64(v) for v in (x, y, z))), jit.Float64(t)
        speed, temperature, salinity = (
            np.broadcast_to(np.array(f(at, time)), z.shape).astype(np.float64)
            for f in (self._ocean.sound_speed, self._ocean.temperature, self._ocean.salinity)
        )
        absorption = self._absorption(temperature, salinity, np.tile(depth, len(places)))
        return speed.reshape(shape), absorption.reshape(shape)

    def _absorption(
        self, temperature: NDArray[np.float64], salinity: NDArray[np.float64], depth: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        t, sp, d = (jit.Float64(np.ascontiguousarray(v)) for v in (temperature, salinity, np.minimum(depth, 7000.0)))
        parts = francois_garrison(self.frequency, t, sp, d)
        return np.asarray(sum(np.array(p) for p in parts)) * 1e-3

    def _column_levels(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """The ocean's own table, thinned."""
        masses = self._ocean.masses
        speed = np.array(masses.sound_speeds)
        depth: NDArray[np.float64] = STEP_M * np.arange(len(speed), dtype=np.float64)
        temperature, salinity = np.array(masses.temperatures), np.array(masses.salinities)
        rows = thinned(depth, speed, levels=400, error=1e-3)
        return depth[rows], speed[rows], self._absorption(temperature[rows], salinity[rows], depth[rows])


def sea_level(ocean: Ocean, t: float) -> float:
    """Height of the sea over z = 0 at a time [s] [m]: its tide; waves left out."""
    return 0.0 if ocean.tide is None else float(np.array(ocean.tide.level(jit.Float64(t)))[0])


def _continued(
    depth: NDArray[np.float64], material: NDArray[np.int64], met: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Bottoms `(m, NODES)` that go on level behind the edge of the world: as the nearest node that has `met` ground;
    where a path has none, it stays as deep as it is.
    """
    node = np.arange(met.shape[1])
    apart = np.where(met[:, None, :], np.abs(node[:, None] - node), len(node))  # (m, node, nearest)
    nearest = np.where(met.any(axis=1, keepdims=True), np.argmin(apart, axis=2), node)
    return np.take_along_axis(depth, nearest, axis=1), np.take_along_axis(material, nearest, axis=1)


def _straight(bottom: NDArray[np.float64], material: NDArray[np.int64]) -> NDArray[np.bool_]:
    """`(m,)`: a straight line stands for a bottom of `(m, NODES)` equally spaced depths [m]: rays run on to its end."""
    line = bottom[:, :1] + np.linspace(0.0, 1.0, NODES) * (bottom[:, -1:] - bottom[:, :1])
    same = (material == material[:, :1]).all(axis=1)
    return np.asarray(same & (np.abs(bottom - line) < _STRAIGHT).all(axis=1))


def shift_arrivals(paths: Paths, before: NDArray[np.float64], now: NDArray[np.float64]) -> Arrivals:
    """Arrivals after small motions of the ends, `(pairs, 2, 3)` each [m]: delays to first order."""
    a = paths.arrivals
    shift = (now - before)[a.path]
    speed = paths.speed[a.path]
    change = (paths.arrival * shift[:, 1]).sum(axis=1) / speed[:, 1]
    change -= (paths.departure * shift[:, 0]).sum(axis=1) / speed[:, 0]
    return replace(a, delay=a.delay + change)


def doppler(
    paths: Paths, source_velocity: NDArray[np.float64], receiver_velocity: NDArray[np.float64]
) -> NDArray[np.float64]:
    """`(k,)` received over sent frequency: (1 - v_r.t_r/c_r)/(1 - v_s.t_s/c_s); velocities `(pairs, 3)` NWU [m/s].

    Source: F. B. Jensen et al., Computational Ocean Acoustics (2nd ed., 2011), Section 8.4, doi
    10.1007/978-1-4419-8678-8.
    """
    path, speed = paths.arrivals.path, paths.speed[paths.arrivals.path]
    receiver = (receiver_velocity[path] * paths.arrival).sum(axis=1) / speed[:, 1]
    source = (source_velocity[path] * paths.departure).sum(axis=1) / speed[:, 0]
    return np.asarray((1.0 - receiver) / (1.0 - source))


def _cast(caster: Caster, origin: Array, direction: Array, reach: Array, copy: Array, own: Array) -> Results:
    hits = caster.cast(Rays(origin, direction, reach, copy, own), coherent=False)
    dr.eval(hits.t, hits.label, hits.material)
    return {"t": hits.t, "label": hits.label, "material": hits.material}


def _cast_ground(caster: Caster, origin: Array, direction: Array, reach: Array, copy: Array, own: Array) -> Results:
    """Hulls are no ground: a vehicle stands above its own place."""
    return _cast(Caster(caster.static, None, caster.tables), origin, direction, reach, copy, own)
