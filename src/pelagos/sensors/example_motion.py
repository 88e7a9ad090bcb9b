"""Motion of your own for a sensor: to try one without a simulation."""

from __future__ import annotations

from collections.abc import Sequence

import drjit as dr
import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos import jit
from pelagos.errors import CommandError
from pelagos.jit import Array
from pelagos.sensors.sensor import Kinematics


def lanes(
    ticks: Sequence[int] | NDArray[np.int64],
    *,
    dt_ns: int,
    environments: Sequence[int] = (0,),
    position: ArrayLike = (0.0, 0.0, 0.0),
    attitude: ArrayLike = (1.0, 0.0, 0.0, 0.0),
    velocity: ArrayLike = (0.0, 0.0, 0.0),
    angular_velocity: ArrayLike = (0.0, 0.0, 0.0),
    acceleration: ArrayLike = (0.0, 0.0, 0.0),
    angular_acceleration: ArrayLike = (0.0, 0.0, 0.0),
) -> Kinematics:
    """Kinematics of every tick and environment, tick-major.

    Args:
        ticks: numbers of the ticks.
        dt_ns: the tick [ns].
        environments: indices of the copies.
        position, attitude, velocity, angular_velocity, acceleration, angular_acceleration: one row for all lanes, or
            `(lanes, 3)` (attitude `(lanes, 4)`); frames and units as in `Kinematics`.

    Raises:
        CommandError: rows of another shape.
    """
    n, k = len(environments), len(ticks)
    tick = np.repeat(np.asarray(ticks, dtype=np.uint32), n)
    motion = Kinematics(
        position=_vector(jit.Array3f64, position, n * k),
        attitude=_vector(jit.Array4f64, attitude, n * k),
        velocity=_vector(jit.Array3f64, velocity, n * k),
        angular_velocity=_vector(jit.Array3f64, angular_velocity, n * k),
        acceleration=_vector(jit.Array3f64, acceleration, n * k),
        angular_acceleration=_vector(jit.Array3f64, angular_acceleration, n * k),
        t_ns=jit.UInt64(tick.astype(np.uint64) * np.uint64(dt_ns)),
        tick=jit.UInt32(tick),
        environment=jit.UInt32(np.tile(np.asarray(environments, dtype=np.uint32), k)),
        copy=jit.UInt32(np.tile(np.arange(n, dtype=np.uint32), k)),
    )
    dr.make_opaque(motion)
    return motion


def _vector(kind: Array, values: ArrayLike, count: int) -> Array:
    rows = np.asarray(values, dtype=np.float64)
    size = dr.size_v(kind)
    if rows.shape not in ((size,), (1, size), (count, size)):
        raise CommandError(f"motion of {count} lanes takes rows ({size},) or ({count}, {size}), not {rows.shape}")
    return kind(np.ascontiguousarray(np.broadcast_to(rows, (count, rows.shape[-1])).T))
