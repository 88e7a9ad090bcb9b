"""Viewpoints over a world: the whole of it, and the parts worth a closer look."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.raycast.geometry import Geometry
from pelagos.world.generate.objects import LINES
from pelagos.world.world import World

_GROUND: Final = 4  # the label "landscape"
_AZIMUTHS_DEG: Final = (215.0, 145.0, 325.0, 35.0, 260.0, 100.0)  # in the order in which they are tried
_WIDE_M: Final = 5000.0  # narrower worlds are shown as high as they are
_CELLS: Final = 24  # along the longer side, when the most crowded part is sought
_PART: Final = 0.12  # of the longer side: how much of a world is shown as a part of it
_ROOF: Final = 0.6  # what covers this share of a world along both sides, high up, is a roof


@dataclass(frozen=True)
class Viewpoint:
    """A view.

    Attributes:
        name: for captions.
        eye, target: `(3,)` from where to where, world NWU [m].
        exaggeration: factor on heights above the target, where the world is much wider than high.
    """

    name: str
    eye: NDArray[np.float64]
    target: NDArray[np.float64]
    exaggeration: float = 1.0


@dataclass(frozen=True)
class _Object:
    name: str
    middle: NDArray[np.float64]
    size: NDArray[np.float64]


def viewpoints(world: World) -> list[Viewpoint]:
    """The whole from above; then the largest thing, the part with the most to see, where most things stand near by, and
    the largest paused mover. Roofs are best taken off before, see `unroofed`.
    """
    low, high = world.bounds
    reach = float((high - low)[:2].max())
    if reach == 0:
        return []
    middle = np.array([*((low + high) / 2)[:2], _typical_height(world)])
    found = [_whole(world, middle, reach)]
    things = [o for o in _objects(world.still) if not _encloses(o, low, high)]
    if things:
        largest = max(things, key=lambda o: float(np.prod(np.sort(o.size)[1:])))
        found.append(_close(world, largest.name, largest.middle, 0.75 * float(np.linalg.norm(largest.size))))
        rich = _richest(things, _PART * reach, found[-1])
        if rich is not None:
            found.append(_close(world, "a part of it", rich, 0.8 * _PART * reach))
    crowd = _crowded(things, reach, found[-1].target if things else middle)
    if crowd is not None:
        found.append(_close(world, "where most things stand", crowd, min(max(0.04 * reach, 6.0), 18.0)))
    elif world.terrain is not None:
        found.append(_close(world, "the ground", middle, min(0.12 * reach, 40.0)))
    pausing = _objects(world.geometries[len(world.still) :])
    pausing = [o for o in pausing if ((o.middle > low) & (o.middle < high))[:2].all()]
    if pausing:
        shown = max(pausing, key=lambda o: float(np.prod(np.sort(o.size)[1:])))
        found.append(_close(world, shown.name, shown.middle, 0.75 * float(np.linalg.norm(shown.size))))
    return found


def _whole(world: World, middle: NDArray[np.float64], reach: float) -> Viewpoint:
    """From outside and above, the steeper the higher the walls are; from inside where most of it cannot be seen."""
    target = middle + np.array([0.0, 0.0, 0.02 * reach])
    for steep in (0.42, 0.8, 1.4):
        eye = middle + reach * np.array([-0.62, -0.42, steep])
        if _mostly_seen(world, eye, reach):
            factor = _exaggeration(world, reach)
            eye = middle + (eye - middle) * (1.35 if factor > 1 else 1.0)  # no thing is worth coming near
            name = "the whole, drained of its water" + (f", heights x {factor:g}" if factor > 1 else "")
            return Viewpoint(name, eye, middle, factor)
    low, high = world.bounds
    inside = target + np.array([0.0, 0.0, 0.4 * float(high[2] - low[2])])
    around = np.radians(np.arange(0.0, 360.0, 5.0)) + 0.01
    hits = world.cast(inside, np.stack([np.cos(around), np.sin(around), np.zeros(len(around))], axis=1), reach)
    free = np.where(hits.valid, hits.t, reach)
    best = int(np.argmax(free))
    way = np.array([np.cos(around[best]), np.sin(around[best]), 0.0])
    return Viewpoint("inside", inside + 0.93 * float(free[best]) * way, target)


def unroofed(world: World) -> World:
    """The world without what covers most of it from above: rooms without their ceilings."""
    low, high = world.bounds
    kept = [g for g in world.geometries if not _covers(g, low, high)]
    return world if len(kept) == len(world.geometries) else replace(world, geometries=tuple(kept), _live={})


def _covers(g: Geometry, low: NDArray[np.float64], high: NDArray[np.float64]) -> bool:
    if g.label == _GROUND or not len(g.faces):
        return False
    bottom, top = g.extent
    wide = (top - bottom)[:2] > _ROOF * (high - low)[:2]
    return bool(wide.all() and bottom[2] > (low[2] + high[2]) / 2)


def _encloses(thing: _Object, low: NDArray[np.float64], high: NDArray[np.float64]) -> bool:
    """Floors, walls along the rim of the world, and lines across it."""
    if thing.name in (*LINES, "pipe supports"):
        return True
    half = 0.5 * (high - low)[:2]
    if (thing.size[:2] > half).all():
        return True
    away = np.minimum(thing.middle[:2] - low[:2], high[:2] - thing.middle[:2])
    return bool((thing.size[:2] > 1.8 * half).any() and away.min() < 0.05 * half.max())


def _mostly_seen(world: World, eye: NDArray[np.float64], reach: float) -> bool:
    """Whether more than half of what lies open to the sky can be seen from the eye."""
    low, high = world.bounds
    share = np.linspace(0.15, 0.85, 6)
    x, y = np.meshgrid(*(low[k] + share * (high - low)[k] for k in (0, 1)), indexing="ij")
    above = np.stack([x.ravel(), y.ravel(), np.full(x.size, high[2] + 1.0)], axis=1)
    down = world.cast(above, (0, 0, -1), float(high[2] - low[2] + 10.0))
    ways = down.position[down.valid] - eye
    if not len(ways):
        return True
    length = np.linalg.norm(ways, axis=1)
    hits = world.cast(eye, ways, 2 * reach)
    return bool((hits.t > 0.995 * length).mean() > 0.5)


def _exaggeration(world: World, reach: float) -> float:
    """1, 2, 5, 10, ...: what makes the ground's relief four per cent of its width, where it is less than one."""
    z = world.terrain.z if world.terrain is not None else np.zeros(1)
    relief = float(np.percentile(z, 99) - np.percentile(z, 1))
    if relief <= 0 or relief > 0.01 * reach or reach < _WIDE_M:
        return 1.0
    wanted = 0.04 * reach / relief
    return max([f * 10.0**e for e in range(4) for f in (1.0, 2.0, 5.0) if f * 10.0**e <= wanted], default=1.0)


def _seen(world: World, eye: NDArray[np.float64], target: NDArray[np.float64], share: float) -> bool:
    """Whether nothing stands in the first part of the way from the eye to the target."""
    way = target - eye
    length = float(np.linalg.norm(way))
    hits = world.cast(eye, way / length, length)
    return not hits.valid[0] or bool(hits.t[0] > share * length)


def _typical_height(world: World) -> float:
    return float(np.median(world.terrain.z)) if world.terrain is not None else float(world.bounds[0, 2])


def _objects(geometries: Sequence[Geometry]) -> list[_Object]:
    """Everything but the ground, parts of one instance together."""
    boxes: dict[int, tuple[str, NDArray[np.float64], NDArray[np.float64]]] = {}
    for g in geometries:
        if g.label == _GROUND or not len(g.faces):
            continue
        low, high = g.extent
        if g.instance in boxes:
            name, before_low, before_high = boxes[g.instance]
            boxes[g.instance] = (name, np.minimum(low, before_low), np.maximum(high, before_high))
        else:
            boxes[g.instance] = (g.name, low, high)
    return [_Object(name, (low + high) / 2, high - low) for name, low, high in boxes.values()]


def _crowded(things: list[_Object], reach: float, away_from: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Middle of the things in the fullest cell that is not in view already; None where nothing much stands."""
    if len(things) < 4:
        return None
    places = np.stack([o.middle for o in things])
    cells = np.floor(places[:, :2] / (reach / _CELLS)).astype(np.int64)
    _, which, count = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    for best in np.argsort(-count, kind="stable"):
        here = places[which.reshape(-1) == best]
        if count[best] > 1 and np.linalg.norm(here[:, :2].mean(axis=0) - away_from[:2]) > 2 * reach / _CELLS:
            return np.asarray(here[np.argmin(np.linalg.norm(here - here.mean(axis=0), axis=1))])
    return None


def _richest(things: list[_Object], radius: float, known: Viewpoint) -> NDArray[np.float64] | None:
    """The thing about which the most, and the largest, stand within a radius; None where the view is known already."""
    large = sorted(things, key=lambda o: -float(np.linalg.norm(o.size)))[:400]
    if len(large) < 3:
        return None
    places = np.stack([o.middle for o in large])
    weight = np.minimum([float(np.linalg.norm(o.size)) for o in large], radius)
    near = np.linalg.norm(places[:, None, :2] - places[None, :, :2], axis=2) < radius
    best = int(np.argmax(near @ weight))
    close = float(np.linalg.norm(known.eye - known.target)) > 1.2 * radius
    if close and np.linalg.norm(places[best] - known.target) < radius:
        return None
    return np.asarray(np.average(places[near[best]], axis=0, weights=weight[near[best]]))


def _close(world: World, name: str, target: NDArray[np.float64], radius: float) -> Viewpoint:
    """From the first side from which the target can be seen, the eye clear of the ground."""
    for azimuth in np.radians(_AZIMUTHS_DEG):
        eye = target + 1.5 * radius * np.array([np.cos(azimuth), np.sin(azimuth), 0.45])
        ground = world.height(eye[0], eye[1])
        if np.isfinite(ground):
            eye[2] = max(eye[2], float(ground) + 0.3 * radius)
        if _seen(world, eye, target, 0.5):
            return Viewpoint(name, eye, target)
    return Viewpoint(name, target + radius * np.array([-0.6, -0.4, 2.2]), target)
