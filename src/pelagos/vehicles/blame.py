"""Blame for a state that is not finite: the largest or first such term of a vehicle's equation of motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.math.frames import flip_quaternion_np, flip_yz_np
from pelagos.vehicles.books import columns
from pelagos.vehicles.integrate import Rigid
from pelagos.vehicles.vehicle import Vehicle


def blame(
    vehicle: Vehicle,
    position: NDArray[np.float64],
    attitude: NDArray[np.float64],
    velocity: NDArray[np.float64],
    angular_velocity: NDArray[np.float64],
) -> str:
    """Term that is largest, or not finite, at one vehicle's state `(3,)`, `(4,)`, `(3,)`, `(3,)`, NWU and FLU."""
    frd = np.concatenate([flip_yz_np(velocity), flip_yz_np(angular_velocity)])
    at = flip_yz_np(position)
    q = jit.Array4f64(*(float(c) for c in flip_quaternion_np(attitude)))
    rigid = Rigid(columns(at[None]), q, columns(frd[None]))
    zero = [jit.Float64(0.0) for _ in vehicle.model.actuators]
    found = vehicle.model.wrenches(vehicle.flow(rigid, None, jit.Float64(0.0)), zero, vehicle.tables)
    sizes = {name: max(abs(float(jit.Float64(c)[0])) for c in load) for name, load in found.items()}
    broken = [name for name, size in sizes.items() if not np.isfinite(size)]
    if broken:
        return f"not finite: {', '.join(broken)}"
    name = max(sizes, key=lambda k: sizes[k])
    return f"largest term: {name}, {sizes[name]:.3g} N or N m"
