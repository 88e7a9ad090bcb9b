"""A pipeline on the seabed: coated joints with collars, partly buried, with a free span on supports."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pelagos.world import shapes
from pelagos.world.mesh import Mesh, join
from pelagos.world.terrain import HeightField

_JOINT = 12.2  # [m], the usual length of a pipe joint


@dataclass(frozen=True)
class Pipeline:
    """Course of a pipe.

    Attributes:
        path: `(k, 2)` middle line x, y, evenly spaced [m].
        radius: outer, coating included [m].
        burial: `(k,)` how deep the pipe's bottom lies below the undisturbed ground [m].
        span: (first, last) distance along the path between which it hangs free [m].
    """

    path: NDArray[np.float64]
    radius: float
    burial: NDArray[np.float64]
    span: tuple[float, float]

    @property
    def along(self) -> NDArray[np.float64]:
        """`(k,)` distance along the path [m]."""
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.path, axis=0), axis=1))])

    def levels(self, ground: HeightField) -> NDArray[np.float64]:
        """`(k,)` height of the axis [m]: a stiff pipe follows the ground smoothed over two joints."""
        from scipy.ndimage import gaussian_filter1d  # a quarter of the time that all imports take

        step = float(np.mean(np.diff(self.along)))
        bed = gaussian_filter1d(ground.height(self.path[:, 0], self.path[:, 1]), 2 * _JOINT / step, mode="nearest")
        return np.asarray(bed + self.radius - gaussian_filter1d(self.burial, 4.0 / step, mode="nearest"))

    def scour(self, ground: HeightField, depth: float) -> None:
        """Wash the ground out beneath the free span, `depth` [m] below the pipe's bottom in its middle; in place."""
        axis, along = self.levels(ground), self.along
        first, last = self.span
        where = (along > first - 6) & (along < last + 6)
        x, y = ground.x[:, None], ground.y[None, :]
        centre = self.path[where]
        arch = np.sin(np.pi * np.clip((along[where] - first) / (last - first), 0, 1)) ** 0.7
        bottom = axis[where] - self.radius - depth * arch
        i0, i1 = np.searchsorted(ground.x, [centre[:, 0].min() - 8, centre[:, 0].max() + 8])
        j0, j1 = np.searchsorted(ground.y, [centre[:, 1].min() - 8, centre[:, 1].max() + 8])
        d2 = (x[i0:i1, :, None] - centre[:, 0]) ** 2 + (y[:, j0:j1, None] - centre[:, 1]) ** 2
        nearest = d2.argmin(axis=-1)
        away = np.sqrt(np.take_along_axis(d2, nearest[..., None], axis=-1)[..., 0])
        target, open_ = bottom[nearest], arch[nearest]
        block = ground.z[i0:i1, j0:j1]
        weight = open_ * np.exp(-((away / 2.6) ** 2))
        block += weight * np.minimum(target - block, 0.0)


def pipe_mesh(pipe: Pipeline, ground: HeightField) -> Mesh:
    """The pipe with a collar at each field joint; closed."""
    along = pipe.along
    collars = np.arange(_JOINT / 2, along[-1], _JOINT)
    edges = [c + d for c in collars for d in (-0.26, -0.25, 0.25, 0.26)]
    stations = np.unique(np.concatenate([np.arange(0, along[-1], 1.0), [along[-1]], edges]))
    stations = stations[stations <= along[-1]]  # the last collar may be cut off
    stations = stations[np.append(np.diff(stations) > 1e-6, True)]  # a pipe of whole metres ends where its last one is
    z = pipe.levels(ground)
    points = np.stack([np.interp(stations, along, c) for c in (pipe.path[:, 0], pipe.path[:, 1], z)], axis=1)
    near = np.abs(stations[:, None] - collars).min(axis=1)
    return shapes.tube(points, np.where(near < 0.255, pipe.radius * 1.14, pipe.radius), sides=24)


def supports(pipe: Pipeline, ground: HeightField, count: int) -> Mesh:
    """Concrete saddles beneath the free span, set into the ground."""
    along, z = pipe.along, pipe.levels(ground)
    first, last = pipe.span
    made = []
    for s in np.linspace(first, last, count + 2)[1:-1]:
        x, y, axis = (float(np.interp(s, along, c)) for c in (pipe.path[:, 0], pipe.path[:, 1], z))
        dx = float(np.interp(s + 0.5, along, pipe.path[:, 0])) - x
        dy = float(np.interp(s + 0.5, along, pipe.path[:, 1])) - y
        foot = float(ground.height(x, y)) - 0.3
        top = axis - pipe.radius * 0.6
        block = shapes.box((0.7, 1.5, top - foot)).moved((0, 0, (top + foot) / 2))
        base = shapes.box((1.3, 2.2, 0.5)).moved((0, 0, foot + 0.2))
        made.append(join([block, base]).turned(yaw=float(np.arctan2(dy, dx))).moved((x, y, 0)))
    return join(made)
