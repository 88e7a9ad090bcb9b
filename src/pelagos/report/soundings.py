"""The recorded soundings in the world, gridded, beside the ground that they were taken from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.math.so3 import rotate_np
from pelagos.messages.point_cloud import POINT_CLOUD
from pelagos.messages.soundings import POINT
from pelagos.report.mission import Mission

CELLS: Final = 460  # along the longer side of a map
Height = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True)
class Soundings:
    """Soundings in the world.

    Attributes:
        points: `(k, 3)` NWU [m].
        pings: how many pings they are from.
        beams: beams a ping.
    """

    points: NDArray[np.float64]
    pings: int
    beams: int

    @property
    def share(self) -> float:
        """Beams that found the bottom, of all."""
        return len(self.points) / max(self.pings * self.beams, 1)


@dataclass(frozen=True)
class Grid:
    """A map of cells, rows north, columns west (both upwards), as `(nx, ny)`.

    Attributes:
        x, y: `(nx,)`, `(ny,)` middles of the cells NWU [m].
        cell: edge [m].
        mean: mean height of the soundings in a cell [m]; NaN where there are none.
        count: soundings in a cell.
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    cell: float
    mean: NDArray[np.float64]
    count: NDArray[np.int64]


def collect(mission: Mission) -> Soundings | None:
    """All soundings of the first multibeam, placed with the true pose; None where there are none."""
    found = mission.channels("multibeam", POINT_CLOUD)
    if not found:
        return None
    recorded = list(mission.recording.messages(found[0].topic))
    clouds = [np.frombuffer(bytes(r.message.data), dtype=POINT) for r in recorded]
    t = np.array([r.t_ns for r in recorded]) * 1e-9
    local = np.stack([np.stack([c["x"], c["y"], c["z"]], axis=-1) for c in clouds]).astype(np.float64)  # (p, beams, 3)
    position, q = mission.mounts[found[0].about["sensor"]]
    pose = mission.motion.at(t)
    body = rotate_np(q, local) + position
    world = rotate_np(pose.attitude[:, None, :], body) + pose.position[:, None, :]
    finite = np.isfinite(world).all(axis=-1)
    return Soundings(world[finite], len(recorded), local.shape[1]) if finite.any() else None


def grid(points: NDArray[np.float64], *, cells: int = CELLS) -> Grid:
    """Mean height in square cells; the outermost quarter per cent of the points on each side is left out."""
    low, high = np.percentile(points[:, :2], [0.25, 99.75], axis=0)
    cell = max(_round_up(float((high - low).max()) / cells), 0.1)
    size = np.maximum(np.ceil((high - low) / cell).astype(int), 1)
    x = low[0] + cell * (np.arange(size[0]) + 0.5)
    y = low[1] + cell * (np.arange(size[1]) + 0.5)
    mean, count = _means(points, x, y, cell)
    return Grid(x, y, cell, mean, count)


def _means(
    points: NDArray[np.float64], x: NDArray[np.float64], y: NDArray[np.float64], cell: float
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Mean height and number of points in each cell `(nx, ny)`."""
    low, size = np.array([x[0] - cell / 2, y[0] - cell / 2]), np.array([len(x), len(y)])
    index = np.floor((points[:, :2] - low) / cell).astype(int)
    inside = ((index >= 0) & (index < size)).all(axis=1)
    flat = index[inside, 0] * size[1] + index[inside, 1]
    count = np.bincount(flat, minlength=size.prod())
    total = np.bincount(flat, weights=points[inside, 2], minlength=size.prod())
    mean = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    return mean.reshape(size), count.reshape(size)


@dataclass(frozen=True)
class Accuracy:
    """Soundings against the ground below them.

    Attributes:
        error: `(k,)` height of the sounding less that of the ground [m], of those on the ground.
        cells: `(nx, ny)` mean height of those on the ground [m]; NaN where there are none.
        bias, std: mean and standard deviation of `error` [m].
        elsewhere: share of soundings that are farther than `limit` from the ground: on structures, or wrong.
        limit: [m].
    """

    error: NDArray[np.float64]
    cells: NDArray[np.float64]
    bias: float
    std: float
    elsewhere: float
    limit: float


def accuracy(points: NDArray[np.float64], cells: Grid, height: Height) -> Accuracy | None:
    """Compare with the ground; None where it has no height there."""
    error = points[:, 2] - height(points[:, 0], points[:, 1])
    known = np.isfinite(error)
    points, error = points[known], error[known]
    if len(error) == 0:
        return None
    scale = 1.4826 * float(np.median(np.abs(error - np.median(error))))
    limit = max(_round_up(6.0 * scale), 0.05)
    near = np.abs(error - np.median(error)) <= limit
    kept = error[near]
    mean, _ = _means(points[near], cells.x, cells.y, cells.cell)
    return Accuracy(kept, mean, float(kept.mean()), float(kept.std()), 1.0 - float(near.mean()), limit)


def _round_up(value: float) -> float:
    """The next of 1, 2, 5 times a power of ten."""
    if value <= 0:
        return 0.0
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(f * power for f in (1, 2, 5, 10) if f * power >= value * (1 - 1e-9)))
