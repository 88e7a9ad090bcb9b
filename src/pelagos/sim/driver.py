"""Moves one agent through a block of ticks: a single frozen call, however long the block."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.ocean.ocean import Ocean
from pelagos.sim.trajectory import CHANNELS, Trajectory, channels
from pelagos.vehicles.control.overheard import overheard
from pelagos.vehicles.nearby import Walls
from pelagos.vehicles.state import VehicleState, channels_of, pack, unpack
from pelagos.vehicles.tables import Tables
from pelagos.vehicles.varied import varied
from pelagos.vehicles.vehicle import Vehicle

Wrench = tuple[Array, Array]
Block = Callable[..., tuple[Array, ...]]


@jit.struct
class _Constants:
    """Constants of every call; one struct, because each argument of a frozen call costs."""

    h: Array
    copies: Array
    no_wrench: Wrench
    tables: Tables | None


class Driver:
    """The step loop of one agent for `n` copies; a block of 20 ticks and 20 blocks of one give the same bytes.

    It keeps states packed (`pack`): a frozen call pays for every array that goes in or out.

    Attributes:
        vehicle: what moves.
        vary: its parameters on which every lane has factors of its own; see `varied`.
        tells: whether trajectories have the commands to actuators too.
    """

    def __init__(
        self, vehicle: Vehicle, *, n: int, dt_ns: int, vary: tuple[str, ...] = (), tells: bool = False
    ) -> None:
        self.vehicle, self.vary, self.tells = vehicle, vary, tells
        self._n = n
        self._frozen: dict[tuple[int, str, bool, bool], Block] = {}
        still = (dr.zeros(jit.Array3f64, n), dr.zeros(jit.Array3f64, n))
        self._constants = jit.without_constants(
            _Constants(dr.opaque(jit.Float64, dt_ns * 1e-9), dr.opaque(jit.UInt32, n), still, vehicle.tables)
        )
        dr.make_opaque(self._constants)
        self._counts: dict[int, Array] = {}

    def pack(self, state: VehicleState) -> Array:
        """A state as `advance` takes it."""
        values = [np.broadcast_to(np.array(c), self._n) for c in channels_of(state)]
        return jit.from_numpy(jit.Float64, np.concatenate(values))

    def unpack(self, packed: Array) -> VehicleState:
        """The state that `advance` gave back."""
        state = unpack(packed, self._n, self.vehicle.sizes)
        dr.eval(state)
        return state

    def actuators(self, packed: Array) -> NDArray[np.float64]:
        """`(n, k)` states of the actuators, in the order of `Vehicle.actuator_names`."""
        count = len(self.vehicle.actuator_names)
        return np.array(packed).reshape(-1, self._n)[CHANNELS : CHANNELS + count].T

    def advance(
        self,
        state: Array,
        command: list[Array],
        ocean: Ocean,
        *,
        mode: str,
        tick: int,
        ticks: int,
        wrench: Wrench | None = None,
        every: bool = True,
        walls: Walls | None = None,
    ) -> tuple[Array, Trajectory]:
        """Advance from `tick` by `ticks`, with a constant command and outside wrench (FRD, about the body's origin).

        Args:
            state: packed.
            command: set-points of the mode, and a factor on each parameter that `vary` names.
            ocean: what moves the vehicle.
            mode: of `Vehicle.modes`.
            tick: of the state.
            ticks: how far.
            wrench: two `Array3f64` of n lanes.
            every: the motion of every tick is asked for, not that of the last alone.
            walls: near the vehicles, of this tick.

        Returns:
            The new state, packed, and the motion at ticks `tick + 1 .. tick + ticks`, or at the last of them.
        """
        constants = self._constants if walls is None else self._beside(walls)
        if self.vehicle.model.on_host:
            return self._plain(state, command, ocean, mode, range(tick, tick + ticks), wrench, constants)
        rows = ticks if every else 1
        key = (rows, mode, wrench is None, every)  # with the last tick alone, one recording serves all lengths
        if key not in self._frozen:
            block = _block(self, n=self._n, rows=rows, mode=mode, every=every)
            self._frozen[key] = jit.freeze(block if wrench is not None else _alone(block))
        if ticks not in self._counts:
            self._counts[ticks] = dr.opaque(jit.UInt32, ticks)  # the same kernel for all lengths
        at, rest = dr.opaque(jit.UInt32, tick), () if wrench is None else (wrench,)
        new, packed, *told = self._frozen[key](state, command, ocean, at, self._counts[ticks], constants, *rest)
        return new, Trajectory(packed, self._n, rows, tick + ticks + 1 - rows, *told)

    def lanes(self, command: list[Array]) -> tuple[Vehicle, list[Array]]:
        """The vehicle with the factors of every lane, which follow the set-points; and the set-points."""
        if not self.vary:
            return self.vehicle, command
        count = len(command) - len(self.vary)
        return varied(self.vehicle, dict(zip(self.vary, command[count:], strict=True))), command[:count]

    def _beside(self, walls: Walls) -> _Constants:
        """The constants with walls; their own classes have no place for these (`jit.without_constants`)."""
        c, tables = self._constants, self.vehicle.tables
        found = Tables(None, None, walls) if tables is None else Tables(tables.thrusters, tables.hull, walls)
        return _Constants(c.h, c.copies, c.no_wrench, found)

    def _plain(
        self,
        packed: Array,
        command: list[Array],
        ocean: Ocean,
        mode: str,
        ticks: range,
        wrench: Wrench | None,
        c: _Constants,
    ) -> tuple[Array, Trajectory]:
        """The same tick by tick, unrecorded, for a vehicle with a term in NumPy."""
        state = self.unpack(packed)
        force, rows, told = c.no_wrench if wrench is None else wrench, [], []
        tells = self.tells and bool(self.vehicle.actuator_names)
        vehicle, command = self.lanes(command)
        vehicle, heard = overheard(vehicle, mode)
        for i in ticks:
            t = jit.Float64(dr.opaque(jit.UInt32, i)) * c.h
            state = vehicle.step(state, command, ocean, t, force, c.h, mode, c.tables)
            dr.eval(state)
            rows.append(self._columns(channels(state)))
            if tells:
                told.append(self._columns(heard.told()))
        motion, *commands = (jit.from_numpy(jit.Float64, np.concatenate(part)) for part in (rows, told) if part)
        return self.pack(state), Trajectory(motion, self._n, len(ticks), ticks.start + 1, *commands)

    def _columns(self, values: list[Array]) -> NDArray[np.float64]:
        """`(n, k)` of k arrays."""
        return np.stack([np.broadcast_to(np.array(v), self._n) for v in values], axis=-1)


def _block(driver: Driver, *, n: int, rows: int, mode: str, every: bool) -> Block:
    kept = len(driver.vehicle.actuator_names)
    tells = driver.tells and every and kept > 0

    def block(
        start: Array, command: list[Array], ocean: Ocean, tick: Array, count: Array, constants: _Constants,
        wrench: Wrench,
    ) -> tuple[Array, ...]:  # fmt: skip
        motion, end = dr.empty(jit.Float64, rows * n * CHANNELS), dr.zeros(jit.Float64, dr.width(start))
        lane = dr.arange(jit.UInt32, n)
        vehicle, set_points = driver.lanes(command)
        told: list[Array] = []
        if tells:
            vehicle, heard = overheard(vehicle, mode)
            told = [dr.empty(jit.Float64, rows * n * kept)]

        def keep(i: Array, state: VehicleState) -> Array:  # in the loop: behind it, every channel would be a kernel
            pack(state, end, lane, n)
            if not every:
                note(state, lane * CHANNELS)
            return i + 0

        def note(state: VehicleState, at: Array) -> None:
            for c, value in enumerate(channels(state)):
                dr.scatter(motion, value, at + c)

        def unfinished(i: Array, state: VehicleState) -> Any:
            return i < count

        def advance(i: Array, state: VehicleState) -> tuple[Array, VehicleState]:
            t = jit.Float64(tick + i) * constants.h
            state = vehicle.step(state, set_points, ocean, t, wrench, constants.h, mode, constants.tables)
            if every:
                note(state, (i * constants.copies + lane) * CHANNELS)
            if tells:
                for k, value in enumerate(heard.told()):
                    dr.scatter(told[0], value, (i * constants.copies + lane) * kept + k)
            dr.if_stmt((i, state), i + 1 == count, keep, lambda i, state: i + 0, mode="symbolic")
            return i + 1, state

        state = unpack(start, n, vehicle.sizes)
        dr.while_loop((dr.zeros(jit.UInt32, n), state), unfinished, advance, mode="symbolic")
        return end, motion, *told

    return block


def _alone(block: Block) -> Block:
    """A block without an outside wrench."""

    def alone(*arguments: Any) -> tuple[Array, ...]:
        return block(*arguments, arguments[-1].no_wrench)

    return alone
