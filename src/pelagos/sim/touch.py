"""Contact of a batch's vehicles by hull rays with what does not move."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.contact.probe import HullProbes, hull_probes, probe_wrench
from pelagos.jit import Array
from pelagos.math.frames import flip_quaternion, flip_yz
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import NO_BODY
from pelagos.sim.driver import Wrench
from pelagos.vehicles.state import StateSizes, unpack
from pelagos.vehicles.vehicle import Vehicle

if TYPE_CHECKING:
    from pelagos.sim.batch import Batch
    from pelagos.sim.model import Model


class Touch:
    """The contact of a batch's vehicles with ground and structures."""

    def __init__(self, batch: Batch, model: Model) -> None:
        self._batch, self._model = batch, model
        self._call: Callable[..., tuple[Array, Array]] | None = None
        self._arguments: tuple[Any, ...] = ()

    def wrench(self, now: Array, free: Array) -> Wrench | None:
        """Force and moment about the body's origin, FRD, `Array3f64` of the batch's rows [N], [N m].

        Args:
            now: packed states at the beginning of the tick.
            free: after it, without contact.

        Returns:
            None where nothing touches.
        """
        if self._model.scene.static is None:
            return None
        if self._call is None:
            self._call, self._arguments = self._build()
        force, moment = self._call(now, free, *self._arguments)
        return (force, moment) if dr.any(dr.norm(force) > 0.0) else None

    def _build(self) -> tuple[Callable[..., tuple[Array, Array]], tuple[Any, ...]]:
        rows, vehicle = self._batch.rows, self._batch.vehicle
        arguments = (
            self._model.world.material_tables(),
            probes_of(vehicle),
            dr.opaque(jit.UInt32, NO_BODY, rows),
            dr.arange(jit.UInt32, rows),
            dr.opaque(jit.Float64, self._model.clock.dt_ns * 1e-9),
        )
        dr.make_opaque(arguments)
        return self._model.scene.compile(_touch(rows, vehicle.sizes)), arguments


def probes_of(vehicle: Vehicle) -> HullProbes:
    """A vehicle's contact probes, with its mass and added mass."""
    starts, vectors = vehicle.probes
    turn = np.diag([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])  # FRD -> FLU
    mass = turn @ vehicle.config.body.mass_matrix @ turn
    return hull_probes(starts, vectors, mass, vehicle.config.hull_grip)


def _touch(n: int, sizes: StateSizes) -> Callable[..., tuple[Array, Array]]:
    def touch(
        caster: Caster, now: Array, after: Array, materials: Any, probes: HullProbes, own: Array, copy: Array, h: Array
    ) -> tuple[Array, Array]:
        state, free = (unpack(packed, n, sizes) for packed in (now, after))
        force, moment = probe_wrench(
            Caster(caster.static, None, caster.tables),
            materials,
            probes,
            position=flip_yz(state.position),
            attitude=flip_quaternion(state.attitude),
            velocity=flip_yz(free.velocity),
            angular_velocity=flip_yz(free.angular_velocity),
            own=own,
            copy=copy,
            h=h,
        )
        return flip_yz(force), flip_yz(moment)

    return touch
