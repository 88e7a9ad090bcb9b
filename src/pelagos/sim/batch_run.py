"""The changing part of a batch: states, commands and control modes of its rows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.ocean.ocean import Ocean
from pelagos.sim.driver import Driver, Wrench
from pelagos.sim.set_points import columns
from pelagos.sim.state import mixed
from pelagos.sim.trajectory import Trajectory
from pelagos.vehicles.nearby import Walls


@dataclass
class Order:
    """One control mode of a batch, and the command of the rows in it.

    Attributes:
        mode: of the vehicle.
        rows: `(rows,)` which are in this mode.
        values: `(rows, k)` set-points of all rows, 0 for those in another mode.
        command: the same, one `Float64` a channel; empty until a step asks for it.
        source: memory from which that is read.
    """

    mode: str
    rows: NDArray[np.bool_]
    values: NDArray[np.float64]
    command: list[Array]
    source: object = None


class BatchRun:
    """The changing part of a batch: what a step reads and replaces.

    Attributes:
        vehicle: Dr.Jit state of its rows, packed (`Driver.pack`).
        row: `(rows, CHANNELS)` motion at the current tick.
        begin_vehicle, begin_row: the same two where the copies' episodes began.
        orders: by control mode; most batches have one.
    """

    def __init__(self, vehicle: Array, mode: str, row: NDArray[np.float64]) -> None:
        self.vehicle, self.row = vehicle, row
        self.begin_vehicle, self.begin_row = vehicle, row
        self.orders = [Order(mode, np.ones(len(row), dtype=bool), np.empty((len(row), 0)), [])]

    @property
    def command_values(self) -> NDArray[np.float64]:
        """`(rows, k)` set-points in the mode of the first row."""
        return self._order(slice(0, 1)).values

    def part(self, rows: slice) -> dict[str, Any]:
        """Part of an agent that is kept: plain values and copies of arrays."""
        order, count = self._order(rows), len(self.row)
        vehicles = {
            name: np.array(packed).reshape(-1, count)[:, rows].copy()
            for name, packed in (("vehicle", self.vehicle), ("begin_vehicle", self.begin_vehicle))
        }
        begin = self.begin_row[rows].copy()
        kept = {"mode": order.mode, "command": order.values[rows].copy(), "row": self.row[rows].copy()}
        return {**vehicles, **kept, "begin_row": begin}

    @classmethod
    def joined(cls, parts: Sequence[Mapping[str, Any]]) -> Self:
        """The run of several agents from what was kept of each."""
        n = len(parts[0]["row"])
        run = cls(_packed(parts, "vehicle"), parts[0]["mode"], np.concatenate([p["row"] for p in parts]))
        run.begin_vehicle = _packed(parts, "begin_vehicle")
        run.begin_row = np.concatenate([p["begin_row"] for p in parts])
        for member, part in enumerate(parts):
            rows = slice(member * n, (member + 1) * n)
            if run.mode_of(rows) == part["mode"]:
                run.hold(rows, part["command"])
            else:
                run.change_mode(rows, part["mode"], part["command"])
        return run

    def mode_of(self, rows: slice) -> str:
        """The control mode of an agent."""
        return self._order(rows).mode

    def values_of(self, rows: slice) -> NDArray[np.float64]:
        """`(n, k)` the command of an agent."""
        return np.asarray(self._order(rows).values[rows].copy())

    def command_of(self, row: int) -> NDArray[np.float64]:
        """`(k,)` the command of one row."""
        return np.asarray(self._order(slice(row, row + 1)).values[row])

    def hold(self, rows: slice, values: NDArray[np.float64]) -> None:
        """Hold another command in some rows; a mission's is without those of what is carried, which stay."""
        order = self._order(rows)
        if values.shape[1] < order.values.shape[1]:
            values = np.concatenate([values, order.values[rows, values.shape[1] :]], axis=1)
        if order.values.shape[1] != values.shape[1]:
            order.values = np.zeros((len(self.row), values.shape[1]))
        elif order.command and not np.count_nonzero(order.values[rows] != values):
            return
        else:
            order.values = order.values.copy()
        order.values[rows] = values
        order.command = []

    def change_mode(self, rows: slice, mode: str, values: NDArray[np.float64]) -> None:
        """Another control mode for some rows, and a command in it."""
        for order in self.orders:
            order.rows = order.rows.copy()
            order.rows[rows] = False
        self.orders = [order for order in self.orders if order.rows.any() or order.mode == mode]
        if not any(order.mode == mode for order in self.orders):
            everywhere = np.zeros((len(self.row), values.shape[1]))
            self.orders.append(Order(mode, np.zeros(len(self.row), dtype=bool), everywhere, []))
        next(order for order in self.orders if order.mode == mode).rows[rows] = True
        self.hold(rows, values)

    def restart(self, fresh: BatchRun, where: NDArray[np.bool_], command: Callable[[str], NDArray[np.float64]]) -> None:
        """Some rows begin anew as in `fresh`; control modes stay, with the command of each at its beginning."""
        self.begin_vehicle = mixed(self.begin_vehicle, fresh.begin_vehicle, where)
        self.begin_row = np.where(where[:, None], fresh.begin_row, self.begin_row)
        self.vehicle = mixed(self.vehicle, fresh.vehicle, where)
        self.row = np.where(where[:, None], fresh.row, self.row)
        for order in self.orders:
            order.values = np.where((where & order.rows)[:, None], command(order.mode), order.values)
            order.command = []

    def advance(
        self, driver: Driver, ocean: Ocean, tick: int, ticks: int, wrench: Wrench | None, *, every: bool,
        factors: list[Array], walls: Walls | None = None,
    ) -> tuple[Array, Trajectory]:  # fmt: skip
        """The packed state after a block of ticks, and the motion in it; `factors` are those that the driver names.

        Where members are in several modes, all rows go through each, and every row keeps what its own mode made.
        """
        made = []
        for order in self.orders:
            if not order.command:
                order.command, order.source = columns(order.values)
            step = driver.advance(
                self.vehicle,
                [*order.command, *factors] if factors else order.command,
                ocean,
                mode=order.mode,
                tick=tick,
                ticks=ticks,
                wrench=wrench,
                every=every,
                walls=walls,
            )
            made.append((order.rows, *step))
        _, state, trajectory = made[0]
        if len(made) == 1:
            return state, trajectory
        states, motion = np.array(state).reshape(-1, len(self.row)), trajectory.numpy().copy()
        told = trajectory.told()
        for rows, other, moved in made[1:]:
            states[:, rows] = np.array(other).reshape(-1, len(self.row))[:, rows]
            motion[:, rows] = moved.numpy()[:, rows]
            told[:, rows] = moved.told()[:, rows]
        commands = None if trajectory.commands is None else jit.from_numpy(jit.Float64, told)
        state, packed = (jit.from_numpy(jit.Float64, values) for values in (states, motion))
        return state, replace(trajectory, packed=packed, commands=commands)

    def _order(self, rows: slice) -> Order:
        if len(self.orders) == 1:  # it holds all rows
            return self.orders[0]
        return next(order for order in self.orders if order.rows[rows].all())


def _packed(parts: Sequence[Mapping[str, Any]], name: str) -> Array:
    """Packed states of several agents as one."""
    return jit.from_numpy(jit.Float64, np.concatenate([part[name] for part in parts], axis=1))
