"""The face of a model that the books have: Euler angles in, accelerations out, NumPy arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import drjit as dr
import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos import jit
from pelagos.errors import CommandError
from pelagos.hydro.algebra import matvec, transpose
from pelagos.hydro.images import Plane
from pelagos.jit import Array
from pelagos.vehicles.flow import LEVEL, CurrentRotation, make_flow, rotation_from_euler
from pelagos.vehicles.terms.bank import WALLS, Bank
from pelagos.vehicles.terms.boundary import Boundary

if TYPE_CHECKING:
    from pelagos.vehicles.tables import Tables
    from pelagos.vehicles.vehicle import Vehicle

_UNIT = 1e-6  # rounding of a normal's length
_MOMENT_S = 1e-6  # what comes aboard in so little counts as its rate
_KEPT = 16  # recordings, one a size


class Accelerations:
    """nu_dot and the actuators' rates of a model; see `Vehicle.accelerations`."""

    def __init__(self, vehicle: Vehicle) -> None:
        self._model = vehicle.model
        self._rotation: CurrentRotation = vehicle.config.current_rotation
        self._tables = vehicle.tables
        self._frozen: dict[tuple[int, int], Callable[..., Any]] = {}

    def __call__(
        self,
        eta: ArrayLike,
        nu: ArrayLike,
        actuators: ArrayLike,
        command: ArrayLike,
        current: ArrayLike,
        walls: ArrayLike = (),
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """See `Vehicle.accelerations`."""
        k = len(self._model.actuators)
        given = {
            "eta": (eta, 6),
            "nu": (nu, 6),
            "actuators": (actuators, k + self._model.kept),
            "command": (command, k),
            "current": (current, 3),
        }
        rows = {name: _rows(values, width, name) for name, (values, width) in given.items()}
        n = max(len(r) for r in rows.values())
        for name, r in rows.items():
            if len(r) not in (1, n):
                raise CommandError(f"{name} has {len(r)} rows where others have {n}")
        data = [columns(np.broadcast_to(r, (n, r.shape[1]))) for r in rows.values()]
        planes = self._planes(walls)
        size = n, len(planes)
        if size not in self._frozen:
            if len(self._frozen) >= _KEPT:
                self._frozen.clear()
            self._frozen[size] = self._evaluate if self._model.on_host else jit.freeze(self._evaluate)
        nu_dot, rates = self._frozen[size](*data, self._tables, planes)
        return _table(nu_dot, n), _table(rates, n)

    def _planes(self, walls: ArrayLike) -> list[list[Array]]:
        """Normal and distance of each."""
        given = np.asarray(walls, dtype=np.float64)
        rows = np.empty((0, 4)) if given.size == 0 else _rows(given, 4, "walls")
        if len(rows) and not self._model.feels_planes:
            raise CommandError(
                "this vehicle has no `boundary` or `bank` term, by which it would feel walls, nor any of shallow water "
                "(`squat`)"
            )
        beside = -rows[:, 2] <= LEVEL
        terms = self._model.terms.values()
        if beside.any() and not any(isinstance(term, (Boundary, Bank)) for term in terms):
            raise CommandError(
                f"walls: the plane in row {int(np.argmax(beside))} is no ground below the ship: "
                "banks and quay walls are for ships with a `bank` term"
            )
        if any(isinstance(term, Bank) for term in terms):
            if (leans := beside & (rows[:, 2] > LEVEL)).any():
                raise CommandError(f"walls: the plane in row {int(np.argmax(leans))} lies above the ship")
            if beside.sum() > WALLS:
                raise CommandError(f"walls: a ship feels {WALLS} at once; {beside.sum()} are given")
        lengths = np.linalg.norm(rows[:, :3], axis=1)
        if (np.abs(lengths - 1) > _UNIT).any():
            raise CommandError(f"walls: a normal has the length {lengths[np.argmax(np.abs(lengths - 1))]:g}, not 1")
        if (rows[:, 3] <= 0).any():
            raise CommandError(f"walls: a distance is {rows[:, 3].min():g} m; the origin lies before the wall: above 0")
        return [[dr.opaque(jit.Float64, float(x)) for x in row] for row in rows]

    def _evaluate(
        self,
        eta: list[Array],
        nu: list[Array],
        actuators: list[Array],
        command: list[Array],
        current: list[Array],
        tables: Tables | None,
        planes: list[list[Array]],
    ) -> tuple[list[Array], list[Array]]:
        rotation = rotation_from_euler(*eta[3:])
        flow = make_flow(eta[:3], rotation, nu, current, current_rotation=self._rotation)
        flow.planes = [Plane(plane[3], matvec(transpose(rotation), plane[:3])) for plane in planes]
        rates = self._model.rates(actuators, command, flow)
        flow.growth = self._model.growth(flow, actuators, command, _MOMENT_S)
        nu_dot = self._model.nu_dot(flow, self._model.limited(actuators), tables=tables)
        return [jit.Float64(a) for a in nu_dot], [jit.Float64(r) for r in rates]


def columns(rows: NDArray[np.float64]) -> list[Array]:
    """`(n, k)` -> k arrays of width n."""
    return [jit.Float64(np.ascontiguousarray(column)) for column in rows.T]


def _table(parts: list[Array], n: int) -> NDArray[np.float64]:
    if not parts:
        return np.empty((n, 0))
    return np.stack([np.broadcast_to(np.array(p), (n,)) for p in parts], axis=-1)


def _rows(values: ArrayLike, width: int, name: str) -> NDArray[np.float64]:
    rows = np.atleast_2d(np.asarray(values, dtype=np.float64))
    if rows.ndim != 2 or rows.shape[1] != width:
        raise CommandError(f"{name} must have the shape (n, {width}), not {np.shape(values)}")
    if not np.isfinite(rows).all():
        raise CommandError(
            f"{name} has values that are not finite, first in row {int(np.argwhere(~np.isfinite(rows))[0][0])}"
        )
    return rows
