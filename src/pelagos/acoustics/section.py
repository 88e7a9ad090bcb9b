"""A vertical section through the sea between two places: sound speed against depth, and the bottom along the way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos import jit
from pelagos.acoustics.layered_water import LEVELS, Floor, Water
from pelagos.acoustics.sea_surface import bubble_loss_db

_BELOW: Final = 100.0  # [m] between levels that only fill the table, below every bottom
_FAITHFUL: Final = 2e-3  # [m/s] by which fewer levels may miss a profile


@dataclass(frozen=True)
class Section:
    """Water and boundaries on the way of sound; depths are positive down from the surface [m].

    Attributes:
        depth: `(k,)` of the profile's levels, increasing [m]; the water is uniform beyond them.
        speed: `(k,)` of sound [m/s]; where water changes along the way `(columns, k)`.
        bottom_x: `(m,)` distance of the bottom's nodes from the source, increasing from 0 [m].
        bottom_depth: `(m,)`; straight between nodes and level behind the last [m].
        absorption: as `speed`, or one number [dB/m].
        density_ratio, sound_speed_ratio, loss: of the bottom behind each node, `(m,)` or one number; see
            `fluid_reflection`.
        frequency: of the sound [Hz].
        wind_speed: 10 m above the surface [m/s], for the loss by bubbles.
        begins: `(columns,)` distances at which columns of the water begin, increasing from 0 [m].
    """

    depth: NDArray[np.float64]
    speed: NDArray[np.float64]
    bottom_x: NDArray[np.float64] = field(default_factory=lambda: np.zeros(1))
    bottom_depth: NDArray[np.float64] = field(default_factory=lambda: np.full(1, 1e5))
    absorption: ArrayLike = 0.0
    density_ratio: ArrayLike = 1.0
    sound_speed_ratio: ArrayLike = 1.0
    loss: ArrayLike = 0.0
    frequency: float = 1e4
    wind_speed: float = 0.0
    begins: NDArray[np.float64] = field(default_factory=lambda: np.zeros(1))

    def speed_at(self, depth: ArrayLike, x: ArrayLike = 0.0) -> NDArray[np.float64]:
        """Of sound [m/s] at a depth and a distance from the source [m]."""
        z, speeds = np.asarray(depth, np.float64), np.atleast_2d(self.speed)
        if len(speeds) == 1:
            return np.asarray(np.interp(z, self.depth, speeds[0]))
        z, place = np.broadcast_arrays(z, np.asarray(x, np.float64))
        column = np.searchsorted(self.begins, place, side="right") - 1
        by_column = np.stack([np.interp(z, self.depth, c) for c in speeds])
        return np.asarray(np.take_along_axis(by_column, column[None], axis=0)[0])

    def bottom_at(self, x: ArrayLike) -> NDArray[np.float64]:
        """Depth of the bottom [m]."""
        return np.asarray(np.interp(np.asarray(x, np.float64), self.bottom_x, self.bottom_depth))


class Sections(tuple[Section, ...]):
    """Sections that are traced more than once, with the tables that the first one makes."""

    @cached_property
    def tables(self) -> tuple[Water, Floor]:
        """See `on_device`."""
        return _tables(self)


def mirrored(section: Section, reach: float) -> Section:
    """The same between source and `reach` [m], seen from there: distances are counted backwards from it."""
    inside = section.bottom_x < reach
    x = np.append(section.bottom_x[inside], reach)
    depth = np.append(section.bottom_depth[inside], section.bottom_at(reach))

    def behind(values: ArrayLike) -> NDArray[np.float64]:
        """A piece's material, by its far node."""
        pieces = np.broadcast_to(np.asarray(values, np.float64), section.bottom_x.shape)[inside]
        return np.append(pieces[::-1], pieces[0])

    columns = section.begins < reach
    begins = np.append(0.0, reach - section.begins[columns][:0:-1])

    def along(values: ArrayLike) -> NDArray[np.float64]:
        table = np.asarray(values, np.float64)
        return table[columns][::-1] if table.ndim == 2 else table

    return replace(
        section, speed=along(section.speed), absorption=along(section.absorption), bottom_x=reach - x[::-1],
        bottom_depth=depth[::-1], density_ratio=behind(section.density_ratio), begins=begins,
        sound_speed_ratio=behind(section.sound_speed_ratio), loss=behind(section.loss),
    )  # fmt: skip


def on_device(sections: Sequence[Section]) -> tuple[Water, Floor]:
    """Sections as rows of tables, with as many nodes and columns as the longest one has."""
    return sections.tables if isinstance(sections, Sections) else _tables(sections)


def _tables(sections: Sequence[Section]) -> tuple[Water, Floor]:
    columns = max(len(s.begins) for s in sections)
    profiles = _profiles(sections, columns)
    count = max(len(s.bottom_x) for s in sections)
    bubbles = [float(bubble_loss_db(1.0, s.frequency, s.wind_speed)) if s.wind_speed > 0 else 0.0 for s in sections]
    floors = [_floor(s, count) for s in sections]
    tables = [np.concatenate(p) for part in (profiles, floors) for p in zip(*part, strict=True)]
    depth, speed, absorption, begins, bubble, x, bottom, density, ratio, loss = arrays = [
        jit.Float64(table) for table in (*tables[:4], np.array(bubbles), *tables[4:])
    ]
    of_water, of_floor = (jit.UInt32(np.full(len(sections), k, np.uint32)) for k in (columns, count))
    jit.align(*arrays, of_water, of_floor)  # together: to wait for each takes as long as to copy it
    water = Water(depth, speed, absorption, bubble, begins, of_water)
    return water, Floor(x, bottom, density, ratio, loss, of_floor)


def thinned(
    depth: NDArray[np.float64], speed: NDArray[np.float64], *, levels: int, error: float = _FAITHFUL
) -> NDArray[np.intp]:
    """Rows of profiles `(k,)` or `(columns, k)` that stand for them within `error` [m/s], or the best `levels` of them,
    by repeated splitting.
    """
    profiles, kept = np.atleast_2d(speed), [0, len(depth) - 1]
    while len(kept) < levels:
        missed = np.max([np.abs(np.interp(depth, depth[kept], c[kept]) - c) for c in profiles], axis=0)
        worst = int(np.argmax(missed))
        if missed[worst] <= error:
            break
        kept = sorted({*kept, worst})
    return np.array(kept)


def _profiles(sections: Sequence[Section], columns: int) -> list[list[NDArray[np.float64]]]:
    """See `_levels`; those that share their arrays are made once."""
    known: dict[tuple[float, ...], list[NDArray[np.float64]]] = {}
    made = []
    for s in sections:
        key = (*(id(a) for a in (s.depth, s.speed, s.absorption, s.begins)), float(np.max(s.bottom_depth)))
        if key not in known:
            known[key] = _levels(s, columns)
        made.append(known[key])
    return made


def _levels(section: Section, columns: int) -> list[NDArray[np.float64]]:
    """`LEVELS` levels from the surface to below the bottom: depths, speeds and absorption of all columns, and where
    these begin; those that only fill the table begin behind every path.
    """
    depth, speed = np.asarray(section.depth, float), np.atleast_2d(np.asarray(section.speed, float))
    absorption = np.broadcast_to(np.asarray(section.absorption, float), speed.shape)
    if len(depth) > LEVELS - 4:
        rows = thinned(depth, speed, levels=LEVELS - 4)
        depth, speed, absorption = depth[rows], speed[:, rows], absorption[:, rows]
    if depth[0] > 0.0:
        depth = np.concatenate([[0.0], depth])
        speed, absorption = (np.concatenate([a[:, :1], a], axis=1) for a in (speed, absorption))
    left, more = LEVELS - len(depth), columns - len(section.begins)
    lowest = max(float(depth[-1]), float(np.max(section.bottom_depth)))
    whole = [np.pad(a, ((0, more), (0, left)), mode="edge").ravel() for a in (speed, absorption)]
    begins = np.concatenate([section.begins, 1e9 * (1 + np.arange(more))])
    return [np.concatenate([depth, lowest + _BELOW * (1 + np.arange(left))]), *whole, begins]


def _floor(section: Section, count: int) -> list[NDArray[np.float64]]:
    """`count` nodes; those that only fill the table stand behind the last one."""
    x = np.asarray(section.bottom_x, float)
    more = count - len(x)

    def filled(values: ArrayLike) -> NDArray[np.float64]:
        row = np.broadcast_to(np.asarray(values, float), x.shape)
        if not more:
            return row
        return np.concatenate([row, np.full(more, row[-1])])

    far = np.concatenate([x, x[-1] + 1e9 * (1 + np.arange(more))])
    return [far, *map(filled, (section.bottom_depth, section.density_ratio, section.sound_speed_ratio, section.loss))]
