"""The state of a vehicle: a Dr.Jit struct, one lane a copy of the fleet, in the frames of the books."""

from __future__ import annotations

from dataclasses import dataclass
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
        actuators: list of `Float64`, in the order of `Vehicle.actuator_names`.
        actuator_memory: list of `Float64`, what some keep beside their state.
        radiation: list of `Float64`, memory of the waves that the hull radiated.
        mode: `Float64`, number of the control mode that ran last, from 1 on; 0: none.
        controller: list of `Float64`, that mode's memory.
    """

    position: Array
    attitude: Array
    velocity: Array
    angular_velocity: Array
    acceleration: Array
    angular_acceleration: Array
    actuators: list[Array]
    actuator_memory: list[Array]
    radiation: list[Array]
    mode: Array
    controller: list[Array]


@dataclass(frozen=True)
class StateSizes:
    """Lengths of the lists of a state, all but the controller's: attributes as of `VehicleState`."""

    actuators: int
    actuator_memory: int
    radiation: int

    @property
    def kept(self) -> int:
        """Of all three together."""
        return self.actuators + self.actuator_memory + self.radiation

    def lists(self, values: list[Array]) -> dict[str, list[Array]]:
        """The three lists, by name, of their values one after another."""
        first, second = self.actuators, self.actuators + self.actuator_memory
        return {
            "actuators": values[:first],
            "actuator_memory": values[first:second],
            "radiation": values[second : self.kept],
        }


_MOTION: Final = (("position", 3), ("attitude", 4), ("velocity", 3), ("angular_velocity", 3), ("acceleration", 3),
                  ("angular_acceleration", 3))  # fmt: skip


def channels_of(state: VehicleState) -> list[Array]:
    """Every `Float64` of a state, in the order of its fields."""
    motion = [component for name, _ in _MOTION for component in getattr(state, name)]
    return [*motion, *state.actuators, *state.actuator_memory, *state.radiation, state.mode, *state.controller]


def pack(state: VehicleState, packed: Array, lane: Array, n: int) -> None:
    """Write a state of `n` lanes into one `Float64`, channel after channel.

    A frozen call pays for every array that goes in or out: one array costs 20 us less than 32 of them.
    """
    for c, value in enumerate(channels_of(state)):
        dr.scatter(packed, value, lane + c * n)


def unpack(packed: Array, n: int, sizes: StateSizes) -> VehicleState:
    """The inverse of `pack`."""
    lane = dr.arange(jit.UInt32, n)
    values = [dr.gather(jit.Float64, packed, lane + c * n) for c in range(dr.width(packed) // n)]
    parts: dict[str, Array] = {}
    for name, size in _MOTION:
        kind = jit.Array4f64 if size == 4 else jit.Array3f64
        parts[name], values = kind(values[:size]), values[size:]
    mode, *controller = values[sizes.kept :]
    return VehicleState(**parts, **sizes.lists(values), mode=mode, controller=controller)
