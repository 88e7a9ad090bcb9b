"""A vertical section through the sea between two places: sound speed against depth, and the bottom along the way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos import jit
from pelagos.acoustics.layered_rays import LEVELS, Floor, Water
from pelagos.acoustics.sea_surface import bubble_loss_db

_BELOW: Final = 100.0  # [m] between levels that only fill the table, below every bottom
_FAITHFUL: Final = 2e-3  # [m/s] by which fewer levels may miss a profile


@dataclass(frozen=True)
class Section:
    """What sound meets on its way; depths are positive down from the surface [m].

    Attributes:
        depth: `(k,)` of the profile's levels, increasing [m]; the water is uniform beyond them.
        speed: `(k,)` of sound [m/s].
        bottom_x: `(m,)` distance of the bottom's nodes from the source, increasing from 0 [m].
        bottom_depth: `(m,)`; straight between nodes and level behind the last [m].
        absorption: `(k,)` or one number [dB/m].
        density_ratio, sound_speed_ratio, loss: of the bottom behind each node, `(m,)` or one number; see
            `fluid_reflection`.
        frequency: of the sound [Hz].
        wind_speed: 10 m above the surface [m/s], for the loss by bubbles.
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

    def speed_at(self, depth: ArrayLike) -> NDArray[np.float64]:
        """Of sound [m/s]."""
        return np.asarray(np.interp(np.asarray(depth, np.float64), self.depth, self.speed))

    def bottom_at(self, x: ArrayLike) -> NDArray[np.float64]:
        """Depth of the bottom [m]."""
        return np.asarray(np.interp(np.asarray(x, np.float64), self.bottom_x, self.bottom_depth))


def on_device(sections: Sequence[Section], *, nodes: int | None = None) -> tuple[Water, Floor]:
    """Sections as rows of tables.

    Args:
        nodes: of each bottom; the most that one has where not given.
    """
    profiles = [_levels(s) for s in sections]
    count = max(len(s.bottom_x) for s in sections) if nodes is None else nodes
    bubbles = [float(bubble_loss_db(1.0, s.frequency, s.wind_speed)) if s.wind_speed > 0 else 0.0 for s in sections]
    floors = [_floor(s, count) for s in sections]
    tables = [np.concatenate(p) for part in (profiles, floors) for p in zip(*part, strict=True)]
    depth, speed, absorption, bubble, x, bottom, density, ratio, loss = arrays = [
        jit.Float64(table) for table in (*tables[:3], np.array(bubbles), *tables[3:])
    ]
    per_row = jit.UInt32(np.full(len(sections), count, np.uint32))
    jit.settle(*arrays, per_row)  # together: to wait for each takes as long as to copy it
    return Water(depth, speed, absorption, bubble), Floor(x, bottom, density, ratio, loss, per_row)


def thinned(
    depth: NDArray[np.float64], speed: NDArray[np.float64], *, levels: int, error: float = _FAITHFUL
) -> NDArray[np.intp]:
    """Rows of a profile that stand for it within `error` [m/s], or the best `levels` of them, by repeated splitting."""
    kept = [0, len(depth) - 1]
    while len(kept) < levels:
        line = np.interp(depth, depth[kept], speed[kept])
        worst = int(np.argmax(np.abs(line - speed)))
        if abs(line[worst] - speed[worst]) <= error:
            break
        kept = sorted({*kept, worst})
    return np.array(kept)


def _levels(section: Section) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """`LEVELS` levels from the surface to below the bottom."""
    depth, speed = np.asarray(section.depth, float), np.asarray(section.speed, float)
    absorption = np.broadcast_to(np.asarray(section.absorption, float), depth.shape)
    if len(depth) > LEVELS - 4:
        rows = thinned(depth, speed, levels=LEVELS - 4)
        depth, speed, absorption = depth[rows], speed[rows], absorption[rows]
    if depth[0] > 0.0:
        depth, speed, absorption = (np.concatenate([[f], a]) for f, a in
                                    ((0.0, depth), (speed[0], speed), (absorption[0], absorption)))  # fmt: skip
    left = LEVELS - len(depth)
    lowest = max(float(depth[-1]), float(np.max(section.bottom_depth)))
    return (
        np.concatenate([depth, lowest + _BELOW * (1 + np.arange(left))]),
        np.concatenate([speed, np.full(left, speed[-1])]),
        np.concatenate([absorption, np.full(left, absorption[-1])]),
    )


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
