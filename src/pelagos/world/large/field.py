"""Things on a large ground: fields of objects at places of it, by metres or by latitude and longitude."""

from __future__ import annotations

from typing import Final, Self

import numpy as np
from pydantic import ConfigDict, Field, model_validator

from pelagos.config.described import Described
from pelagos.errors import WorldError
from pelagos.math.geodesy import GeoOrigin
from pelagos.world.config import Positive
from pelagos.world.generate.objects import ExclusionConfig, ObjectConfig, Placer
from pelagos.world.generate.scatter import Places
from pelagos.world.large.ground import LargeGround
from pelagos.world.site import Site
from pelagos.world.terrain import HeightField

_MAX_NODES: Final = 4_000_000  # of the ground beneath a field, while it is filled


class FieldConfig(Described):
    """A rectangle of a large world with things in it."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    centre_m: tuple[float, float] | None = None
    """Its middle, x and y [m]."""
    centre_deg: tuple[float, float] | None = None
    """Its middle, latitude and longitude [deg], instead of `centre_m`."""
    size_m: tuple[Positive, Positive]
    """Its extent along x and y [m]."""
    seed: int = Field(default=1, ge=0)
    """Seed of everything random in it."""
    objects: tuple[ObjectConfig, ...]
    """Things in it, as in `generated` worlds; their places `at_m` count from the field's middle."""
    exclude: tuple[ExclusionConfig, ...] = ()
    """Discs where nothing is placed, counted from the field's middle."""

    @model_validator(mode="after")
    def _one_middle(self) -> Self:
        if (self.centre_m is None) == (self.centre_deg is None):
            raise ValueError("give the field's middle either as centre_m or as centre_deg")
        for thing in self.objects:
            if thing.kind == "pipeline":
                raise ValueError("a pipeline digs into its ground, which a large world does not change; use cable")
        return self


def fill(site: Site, fields: tuple[FieldConfig, ...], ground: LargeGround, origin: GeoOrigin) -> list[str]:
    """Set the things of every field on the ground; returns what was placed, in words.

    Raises:
        WorldError: a field lies outside the world.
    """
    placed = []
    for index, field in enumerate(fields):
        middle = _middle(field, origin)
        low, high = middle - np.array(field.size_m) / 2, middle + np.array(field.size_m) / 2
        where = f"large: fields[{index}]"
        if low[0] < ground.x0 or low[1] < ground.y0 or high[0] > ground.x1 or high[1] > ground.y1:
            raise WorldError(
                f"{where}: x {low[0]:.0f} .. {high[0]:.0f}, y {low[1]:.0f} .. {high[1]:.0f} m does not lie in the "
                f"world, x {ground.x0:.0f} .. {ground.x1:.0f}, y {ground.y0:.0f} .. {ground.y1:.0f} m"
            )
        places = Places((float(low[0]), float(high[0])), (float(low[1]), float(high[1])))
        for zone in field.exclude:
            for x, y, radius in zone.discs:
                places.take(middle[0] + x, middle[1] + y, radius)
        placer = Placer(site, places, _beneath(ground, low, high))
        streams = np.random.SeedSequence(field.seed).spawn(len(field.objects))
        noted = len(site.notes)
        for config, stream in zip(field.objects, streams, strict=True):
            at = tuple((float(middle[0] + x), float(middle[1] + y)) for x, y in config.at_m)
            count = placer.place(config.model_copy(update={"at_m": at}), np.random.Generator(np.random.PCG64(stream)))
            placed.append(f"{count} {config.kind}")
        site.notes[noted:] = [f"fields[{index}]: {note}" for note in site.notes[noted:]]
    return placed


def _middle(field: FieldConfig, origin: GeoOrigin) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    if field.centre_m is not None:
        return np.array(field.centre_m)
    assert field.centre_deg is not None
    x, y = origin.to_xy(*field.centre_deg)
    return np.array([float(x), float(y)])


def _beneath(
    ground: LargeGround,
    low: np.ndarray[tuple[int], np.dtype[np.float64]],
    high: np.ndarray[tuple[int], np.dtype[np.float64]],
) -> HeightField:
    """The ground in a rectangle, on its own finest nodes; on every second, fourth, ... of them where they are many."""
    levels = [n.level for n in ground.insets if all(n.low[k] < high[k] and low[k] < n.high[k] for k in range(2))]
    level = min(levels, default=0)
    while True:
        step = ground.spacing_at(level)
        first = np.floor((low - [ground.x0, ground.y0]) / step).astype(np.int64)
        last = np.maximum(np.ceil((high - [ground.x0, ground.y0]) / step).astype(np.int64), first + 2)
        if np.prod(last - first + 1) <= _MAX_NODES:
            break
        level += 1
    i, j = np.meshgrid(*(np.arange(a, b + 1) for a, b in zip(first, last, strict=True)), indexing="ij")
    corner = ground.x0 + first[0] * step, ground.y0 + first[1] * step
    return HeightField(float(corner[0]), float(corner[1]), step, ground.nodes(level, i, j))
