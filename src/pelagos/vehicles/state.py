"""The state of a vehicle: a Dr.Jit struct, one lane a copy of the fleet, in the frames of the books."""

from __future__ import annotations

from pelagos import jit
from pelagos.jit import Array


@jit.struct
class VehicleState:
    """World NED, body FRD, everything float64; `vehicles.vehicle` converts from and to NWU and FLU.

    Attributes:
        position: `Array3f64`, of the body's origin, NED [m].
        attitude: `Array4f64`, (w, x, y, z), FRD -> NED.
        velocity: `Array3f64`, over ground, FRD [m/s].
        angular_velocity: `Array3f64`, FRD [rad/s].
        acceleration: `Array3f64`, rate of change of `velocity`'s components over the last step, FRD [m/s^2].
        angular_acceleration: `Array3f64`, likewise, FRD [rad/s^2].
        actuators: list of `Float64`, in the order of `Vehicle.actuator_names`; then what some keep beside it.
        controller: list of `Float64`: the mode that ran last (0: none) and its memory.
    """

    position: Array
    attitude: Array
    velocity: Array
    angular_velocity: Array
    acceleration: Array
    angular_acceleration: Array
    actuators: list[Array]
    controller: list[Array]
