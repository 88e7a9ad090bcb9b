"""A vertical section through the water in the scene: a curtain from surface to ground in the colours of a field."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from pelagos.drawing.colours import DEPTHS, painted, shades
from pelagos.drawing.water import MATTER, SALT, SPEEDS, WARMTH, sampled
from pelagos.errors import LookupFailed
from pelagos.viewer.currents import extent, first_current
from pelagos.world.world import World

WAYS: Final = ("north", "east")
_ACROSS: Final = 81
_DOWN: Final = 33
_DEEPEST_M: Final = 50.0  # where there is no ground

_FIELDS: Final[dict[str, tuple[str, str, object]]] = {
    "sound_speed": ("speed of sound", "m/s", DEPTHS), "temperature": ("temperature", "°C", WARMTH),
    "salinity": ("practical salinity", "", SALT), "current": ("speed of the current", "m/s", SPEEDS),
}  # fmt: skip


@dataclass(frozen=True)
class Asked:
    """Section that is asked for: `what` of `sections`, and the compass direction that it lies along."""

    what: str
    along: Literal["north", "east"] = "north"


@dataclass(frozen=True)
class Curtain:
    """A section as a mesh: `vertices` `(v, 3)` NWU [m], `faces` `(f, 3)`, `colours` `(v, 3)` sRGB.

    Attributes:
        title, unit: of the field.
        low, high: of its values.
        shades: of the legend, from low to high, "#rrggbb".
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    colours: NDArray[np.uint8]
    title: str
    unit: str
    low: float
    high: float
    shades: list[str]


def sections(ocean: Any) -> dict[str, str]:
    """Titles of the fields that a section can show, by name."""
    return {name: title for name, (title, _, _) in _FIELDS.items()} | {f"tracer:{n}": n for n in ocean.tracers}


def curtain(ocean: Any, world: World, asked: Asked, place: NDArray[np.float64], t_s: float) -> Curtain:
    """The section through a place `(3,)` NWU [m] at a time [s]; called by a thread that may use the device.

    Raises:
        LookupFailed: the ocean has no such field.
    """
    if asked.what not in sections(ocean):
        raise LookupFailed("section", asked.what, sections(ocean))
    field, title, unit, colours = _field(ocean, asked.what)
    low, high = extent(world)
    axis = WAYS.index(asked.along)
    line = np.tile(np.asarray(place, dtype=np.float64)[:2], (_ACROSS, 1))
    line[:, axis] = np.linspace(low[axis], high[axis], _ACROSS)
    ground = np.asarray(world.height(line[:, 0], line[:, 1]), dtype=np.float64)
    bed = np.where(np.isfinite(ground), np.minimum(ground, 0.0), _bottom(world))
    points = np.empty((_ACROSS, _DOWN, 3))
    points[..., :2] = line[:, None]
    points[..., 2] = bed[:, None] * np.linspace(0.0, 1.0, _DOWN)
    values = sampled(field, points.reshape(-1, 3), np.full(points[..., 0].size, t_s))
    value = np.linalg.norm(values, axis=1) if values.shape[1] > 1 else values[:, 0]
    wet = np.isfinite(value) & np.repeat(bed < 0, _DOWN)
    least, most = (float(value[wet].min()), float(value[wet].max())) if wet.any() else (math.nan, math.nan)
    span = (least, most) if wet.any() else (0.0, 1.0)  # over land alone nothing is drawn
    return Curtain(
        points.reshape(-1, 3).astype(np.float32), _faces(wet.reshape(_ACROSS, _DOWN)),
        painted(value, *span, colours), title, unit, least, most,
        shades(colours),
    )  # fmt: skip


def _field(ocean: Any, what: str) -> tuple[Callable[[Any, Any], Any], str, str, Any]:
    if what.startswith("tracer:"):
        name = what.removeprefix("tracer:")
        return partial(ocean.tracer, name), name, "", MATTER
    title, unit, colours = _FIELDS[what]
    return first_current(ocean) if what == "current" else getattr(ocean, what), title, unit, colours


def _bottom(world: World) -> float:
    """Height at which the section ends over no ground [m]."""
    low = float(world.bounds[0, 2])
    return low if math.isfinite(low) and low < 0 else -_DEEPEST_M


def _faces(wet: NDArray[np.bool_]) -> NDArray[np.uint32]:
    """Two triangles for every cell with four corners in the water."""
    n = np.arange(wet.size, dtype=np.uint32).reshape(wet.shape)
    keep = wet[:-1, :-1] & wet[1:, :-1] & wet[1:, 1:] & wet[:-1, 1:]
    p, q, u, v = (c[keep] for c in (n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]))
    return np.concatenate([np.stack([p, q, u], -1), np.stack([p, u, v], -1)])
