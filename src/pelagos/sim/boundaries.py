"""Ground and walls near the vehicles that feel them, found by rays at the beginning of every tick."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.errors import ValidityWarning
from pelagos.jit import Array
from pelagos.math.frames import flip_yz
from pelagos.math.so3 import rotate
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import NO_BODY, Rays
from pelagos.sim.batch import Batch
from pelagos.sim.model import Model
from pelagos.sim.set_points import vectors
from pelagos.vehicles.flow import FAR_M, LEVEL
from pelagos.vehicles.nearby import Walls
from pelagos.vehicles.terms.bank import Bank
from pelagos.vehicles.terms.boundary import Boundary
from pelagos.vehicles.vehicle import Vehicle

_LENGTHS: Final = 2.0  # reach of the rays: beyond it a spheroid's added mass changes by less than 1e-3
_DEEPEST_M: Final = 2e4  # reach of the ray below ships: U^2/(g h) and h/T tell how far they feel, not their length
_SIDES: Final = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))  # ahead, port, astern, starboard
_RAYS: Final = 1 + len(_SIDES)


class Boundaries:
    """Finds the planes near vehicles with a term that feels them.

    Attributes:
        any: there are such vehicles, which are looked after in every tick.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self._calls: dict[str, tuple[Callable[..., Walls], tuple[Any, ...]]] = {}
        feeling = [batch for batch in model.batches.values() if batch.vehicle.model.feels_planes]
        self.any = bool(feeling)
        self._untold = {batch.name for batch in feeling if not _by_images(batch.vehicle)}  # of the end of the ground

    def walls(self, batch: Batch, row: NDArray[np.float64]) -> Walls | None:
        """Ground and walls near the vehicles of a batch, from its motion `(rows, CHANNELS)` now; None: nothing is asked
        for, or there is nothing that stands.
        """
        if not batch.vehicle.model.feels_planes or self._model.scene.static is None:
            return None
        if batch.name not in self._calls:
            self._calls[batch.name] = self._build(batch)
        if batch.name in self._untold:
            self._tell_of_the_end(batch, row)
        call, arguments = self._calls[batch.name]
        attitude = jit.Array4f64(*(jit.padded(column) for column in row[:, 3:7].T))
        position = vectors(row[:, 0:3])
        dr.make_opaque(attitude, position)
        return call(position, attitude, *arguments)

    def _tell_of_the_end(self, batch: Batch, row: NDArray[np.float64]) -> None:
        """Warn, once, where a ship that feels the depth of its water is beyond all ground."""
        low, high = self._model.world.bounds[:, :2]
        beyond = np.flatnonzero(((row[:, :2] < low) | (row[:, :2] > high)).any(axis=1))
        if not len(beyond):
            return
        self._untold.discard(batch.name)
        x, y = row[beyond[0], :2]
        warnings.warn(
            f"agents.{batch.members[beyond[0] // batch.n]}: at x {x:.0f}, y {y:.0f} m there is no ground below, which "
            f"ends at x {low[0]:.0f} and {high[0]:.0f}, y {low[1]:.0f} and {high[1]:.0f} m: the water counts as deep "
            "there; give the world a larger extent (size_m of a flat one)",
            ValidityWarning,
            stacklevel=2,
        )

    def _build(self, batch: Batch) -> tuple[Callable[..., Walls], tuple[Any, ...]]:
        below, beside = (dr.opaque(jit.Float, reach(batch.vehicle)) for reach in (reach_below_m, reach_beside_m))
        both_sides = any(isinstance(term, Bank) for term in batch.vehicle.model.terms.values())
        return self._model.scene.compile(_look(batch.rows, opposite=both_sides)), (below, beside)


def reach_beside_m(vehicle: Vehicle) -> float:
    """Distance from which a vehicle feels walls beside it [m]."""
    return _LENGTHS * vehicle.config.length_m


def reach_below_m(vehicle: Vehicle) -> float:
    """Distance from which it feels the ground below it [m]: by images as walls, by the depth of water from anywhere."""
    beside = reach_beside_m(vehicle)
    return beside if _by_images(vehicle) else max(beside, _DEEPEST_M)


def _by_images(vehicle: Vehicle) -> bool:
    """True for a hull that feels planes by its image in them, as those under water do."""
    return any(isinstance(term, Boundary) for term in vehicle.model.terms.values())


def _look(n: int, *, opposite: bool) -> Callable[..., Walls]:
    """Ground and the nearest wall of n vehicles, and `opposite` that on the other side of each."""

    def look(caster: Caster, position: Array, attitude: Array, below: Array, beside: Array) -> Walls:
        lane = dr.arange(jit.UInt32, n * _RAYS)
        vehicle, ray = lane % n, lane // n  # of one direction after another
        q = dr.gather(jit.Array4f64, attitude, vehicle)
        forward = rotate(q, jit.Array3f64(1.0, 0.0, 0.0))
        flat = dr.sqrt(dr.square(forward[0]) + dr.square(forward[1]))
        stands = flat < 1e-6  # nose up: any direction will do
        x = dr.select(stands, 1.0, forward[0] / dr.maximum(flat, 1e-6))
        y = dr.select(stands, 0.0, forward[1] / dr.maximum(flat, 1e-6))
        direction = jit.Array3f64(0.0, 0.0, -1.0) + jit.Array3f64(0 * x, 0 * x, 0 * x)
        for k, (ahead, port) in enumerate(_SIDES):
            side = jit.Array3f64(ahead * x - port * y, ahead * y + port * x, 0 * x)
            direction = dr.select(ray == k + 1, side, direction)
        origin = dr.gather(jit.Array3f64, position, vehicle)
        hits = Caster(caster.static, None, caster.tables).cast(Rays(
            origin, jit.Array3f(direction), dr.select(ray == 0, below, beside), vehicle,
            dr.full(jit.UInt32, NO_BODY, n * _RAYS),
        ))  # fmt: skip
        normal = jit.Array3f64(hits.normal)
        wall = dr.abs(normal[2]) < LEVEL
        gap = jit.Float64(hits.t) * dr.abs(dr.dot(normal, direction))
        gap = dr.select(hits.valid & (wall == (ray > 0)), gap, FAR_M)  # level ground that slopes up to a side is ground
        normal = dr.select(gap < FAR_M, normal, -direction)
        dr.eval(gap, normal)
        ground, *sides = (_of(gap, normal, n, k) for k in range(_RAYS))
        nearest, across = sides[0], sides[2]
        for k, side in enumerate(sides[1:], start=1):
            nearer = side[0] < nearest[0]
            across = _either(nearer, sides[k - 2], across)
            nearest = _either(nearer, side, nearest)
        found = [ground, nearest, across] if opposite else [ground, nearest]
        return Walls([flip_yz(position - d * m) for d, m in found], [flip_yz(m) for _, m in found])

    return look


def _either(first: Array, a: tuple[Array, Array], b: tuple[Array, Array]) -> tuple[Array, Array]:
    """Of two distances with normals, the first where `first` is true."""
    return dr.select(first, a[0], b[0]), dr.select(first, a[1], b[1])


def _of(gap: Array, normal: Array, n: int, ray: int) -> tuple[Array, Array]:
    """Distance and normal that one ray of each of n vehicles found."""
    at = dr.arange(jit.UInt32, n) + ray * n
    return dr.gather(jit.Float64, gap, at), dr.gather(jit.Array3f64, normal, at)
