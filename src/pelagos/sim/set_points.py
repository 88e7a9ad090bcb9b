"""Set-points of commands, and other tables of NumPy, on the device."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.vehicles.vehicle import Vehicle

if TYPE_CHECKING:
    from pelagos.sim.state import AgentState


def vectors(values: NDArray[np.float64]) -> Array:
    """`(m, 3)` as `Array3f64` in memory of Dr.Jit's own."""
    return jit.Array3f64(*(jit.from_numpy(jit.Float64, column) for column in values.T))


def columns(values: NDArray[np.float64]) -> tuple[list[Array], object]:
    """Each column of `(n, k)` set-points on the device; and the memory that it is read from, to be held until then."""
    n, count = values.shape
    if n == 1:
        return [dr.opaque(jit.Float64, float(v)) for v in values[0]], None  # faster than the way over NumPy
    if not count:
        return [], None
    packed = jit.Float64(jit.padded(values))
    return _split(count)(packed), (values, packed)


@cache
def _split(count: int) -> Callable[[Array], list[Array]]:
    """The columns of a table of so many, given in one row; one kernel."""

    def split(packed: Array) -> list[Array]:
        lane = dr.arange(jit.UInt32, dr.width(packed) // count) * count
        return [dr.gather(jit.Float64, packed, lane + i) for i in range(count)]

    return jit.freeze(split)


def idle(vehicle: Vehicle, mode: str, state: AgentState) -> NDArray[np.float64]:
    """A command that changes little: stay here at this depth and heading, actuators at rest; aeroplanes fly on."""
    n = len(state.position)
    known = {"depth": state.depth, "heading": -state.euler[:, 2], "yaw": state.euler[:, 2]}
    known |= {"height": state.position[:, 2], "airspeed": np.full(n, vehicle.config.envelope.cruise_mps)}
    known |= {axis: state.position[:, i] for i, axis in enumerate("xyz")}
    columns = [known.get(name, np.zeros(n)) for name in vehicle.command_names(mode)]
    return np.stack(columns, axis=-1) if columns else np.empty((n, 0))
