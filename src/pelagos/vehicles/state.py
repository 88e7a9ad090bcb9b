"""The state of a vehicle: a Dr.Jit struct, one lane a copy of the fleet, in the frames of the books."""

from __future__ import annotations

from typing import Final

import drjit as dr

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


_MOTION: Final = (("position", 3), ("attitude", 4), ("velocity", 3), ("angular_velocity", 3), ("acceleration", 3),
                  ("angular_acceleration", 3))  # fmt: skip


def channels_of(state: VehicleState) -> list[Array]:
    """Every `Float64` of a state, in the order of its fields."""
    motion = [component for name, _ in _MOTION for component in getattr(state, name)]
    return [*motion, *state.actuators, *state.controller]


def pack(state: VehicleState, packed: Array, lane: Array, n: int) -> None:
    """Write a state of `n` lanes into one `Float64`, channel after channel.

    A frozen call pays for every array that goes in or out: one array costs 20 us less than 32 of them.
    """
    for c, value in enumerate(channels_of(state)):
        dr.scatter(packed, value, lane + c * n)


def unpack(packed: Array, n: int, *, actuators: int) -> VehicleState:
    """The inverse of `pack`; `actuators` of the channels after the motion are actuators, the rest the controller."""
    lane = dr.arange(jit.UInt32, n)
    values = [dr.gather(jit.Float64, packed, lane + c * n) for c in range(dr.width(packed) // n)]
    parts: dict[str, Array] = {}
    for name, size in _MOTION:
        kind = jit.Array4f64 if size == 4 else jit.Array3f64
        parts[name], values = kind(values[:size]), values[size:]
    return VehicleState(**parts, actuators=values[:actuators], controller=values[actuators:])
