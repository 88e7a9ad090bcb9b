"""Moves one agent through a block of ticks: a single frozen call, however long the block."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.jit import Array
from pelagos.ocean.ocean import Ocean
from pelagos.sim.trajectory import CHANNELS, Trajectory, channels
from pelagos.vehicles.actuators.t200 import T200Tables
from pelagos.vehicles.state import VehicleState
from pelagos.vehicles.vehicle import Vehicle

Wrench = tuple[Array, Array]
Block = Callable[..., tuple[VehicleState, Array]]


class Driver:
    """The step loop of one agent for `n` copies; a block of 20 ticks and 20 blocks of one give the same bytes."""

    def __init__(self, vehicle: Vehicle, *, n: int, dt_ns: int) -> None:
        self.vehicle = vehicle
        self._n = n
        self._frozen: dict[tuple[int, str], Block] = {}
        self._h = dr.opaque(jit.Float64, dt_ns * 1e-9)
        self._copies = dr.opaque(jit.UInt32, n)
        self.no_wrench: Wrench = (dr.zeros(jit.Array3f64, n), dr.zeros(jit.Array3f64, n))
        dr.make_opaque(self.no_wrench)

    def advance(
        self,
        state: VehicleState,
        command: list[Array],
        ocean: Ocean,
        *,
        mode: str,
        tick: int,
        ticks: int,
        wrench: Wrench | None = None,
    ) -> tuple[VehicleState, Trajectory]:
        """Advance from `tick` by `ticks`, with a constant command and outside wrench (FRD, about the body's origin).

        Returns:
            The new state, and the motion at ticks `tick + 1 .. tick + ticks`.
        """
        if self.vehicle.model.on_host:
            return self._plain(state, command, ocean, mode, tick, ticks, wrench)
        key = (ticks, mode)
        if key not in self._frozen:
            self._frozen[key] = jit.freeze(_block(self.vehicle, n=self._n, ticks=ticks, mode=mode))
        at, count = dr.opaque(jit.UInt32, tick), dr.opaque(jit.UInt32, ticks)  # the same kernel for all lengths
        force = self.no_wrench if wrench is None else wrench
        new, packed = self._frozen[key](
            state, command, ocean, at, count, self._h, self._copies, force, self.vehicle.tables
        )
        return new, Trajectory(packed=packed, n=self._n, ticks=ticks, first_tick=tick + 1)

    def _plain(
        self,
        state: VehicleState,
        command: list[Array],
        ocean: Ocean,
        mode: str,
        tick: int,
        ticks: int,
        wrench: Wrench | None,
    ) -> tuple[VehicleState, Trajectory]:
        """The same tick by tick, unrecorded, for a vehicle with a term in NumPy."""
        force, tables = self.no_wrench if wrench is None else wrench, self.vehicle.tables
        rows = []
        for i in range(tick, tick + ticks):
            t = jit.Float64(dr.opaque(jit.UInt32, i)) * self._h
            state = self.vehicle.step(state, command, ocean, t, force, self._h, mode, tables)
            dr.eval(state)
            rows.append(np.stack([np.broadcast_to(np.array(c), self._n) for c in channels(state)], axis=-1))
        packed = jit.Float64(np.concatenate(rows).ravel())
        return state, Trajectory(packed=packed, n=self._n, ticks=ticks, first_tick=tick + 1)


def _block(vehicle: Vehicle, *, n: int, ticks: int, mode: str) -> Block:
    def block(
        state: VehicleState,
        command: list[Array],
        ocean: Ocean,
        tick: Array,
        count: Array,
        h: Array,
        copies: Array,
        wrench: Wrench,
        tables: T200Tables | None,
    ) -> tuple[VehicleState, Array]:
        packed = dr.zeros(jit.Float64, ticks * n * CHANNELS)
        lane = dr.arange(jit.UInt32, n)

        def unfinished(i: Array, state: VehicleState) -> Any:
            return i < count

        def advance(i: Array, state: VehicleState) -> tuple[Array, VehicleState]:
            t = jit.Float64(tick + i) * h
            state = vehicle.step(state, command, ocean, t, wrench, h, mode, tables)
            at = (i * copies + lane) * CHANNELS
            for c, value in enumerate(channels(state)):
                dr.scatter(packed, value, at + c)
            return i + 1, state

        _, state = dr.while_loop((dr.zeros(jit.UInt32, n), state), unfinished, advance, mode="symbolic")
        return state, packed

    return block
