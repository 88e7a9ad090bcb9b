"""Many short motions at once, with their tangents: one recorded step, played for every lane.

A lane is one shot (a stretch of the record with an initial state of its own) and one direction, a parameter or a
coordinate of the initial state. Forward mode through the step gives every lane's derivative exactly. Sources:
A. Griewank, A. Walther, "Evaluating Derivatives", 2nd ed., SIAM 2008, Section 3.1; multiple shooting: H. G. Bock,
"Recent advances in parameter identification techniques for O.D.E.", Birkhaeuser 1983.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.identification.constants import Place, with_numbers
from pelagos.identification.coordinates import COORDINATES
from pelagos.identification.depth import deep_model, near_surface
from pelagos.identification.parameters import Compiled, Family
from pelagos.identification.record import Record
from pelagos.identification.water import Surroundings, Water, water_of
from pelagos.jit import Array
from pelagos.math.rotation import from_vector, product
from pelagos.vehicles.model import Model
from pelagos.vehicles.nearby import level_ground
from pelagos.vehicles.state import VehicleState
from pelagos.vehicles.tables import Tables
from pelagos.vehicles.vehicle import Vehicle

_MODE: Final = "actuators"
_PLACE: Final = 13  # position, quaternion, nu
_MOTION: Final = 19  # and nu_dot


@dataclass(frozen=True)
class Shots:
    """Beginnings of shots.

    Attributes:
        starts: row of the record `(s,)`.
        steps: how many steps each has.
        preroll: steps before it in which actuators follow their commands `(s,)`, at most so many rows as there are.
        position: NED `(s, 3)`; attitude: quaternion `(s, 4)`; nu: over ground `(s, 6)`.
        idle: whether actuators are at rest, in the state 0, when its preroll begins `(s,)`; else they are then at their
            commands.
    """

    starts: NDArray[np.int64]
    steps: int
    preroll: NDArray[np.int64]
    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    nu: NDArray[np.float64]
    idle: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.starts)


class Shooter:
    """Plays shots of one vehicle with one record's commands.

    Attributes:
        substeps: see `divide`; grid_s: step of the record's grid [s].

    Args:
        vehicle: with a mode "actuators".
        model: whose numbers at `places` are replaced.
        places: see `parameters.Compiled`.
        commands: by actuator `(n,)`.
        h: step of the record's grid [s].
        substeps: how many steps of the simulation one of the grid is.
        water: that the shots are in; None: open sea of one density, deep and at rest.
        flows: whether there is a current, known or sought.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        model: Model,
        places: Sequence[Place],
        commands: Mapping[str, NDArray[np.float64]],
        h: float,
        *,
        substeps: int = 1,
        water: Water | None = None,
        flows: bool = False,
    ) -> None:
        size = max((len(c) for c in commands.values()), default=1)
        self._tables = [jit.Float64(commands.get(name, np.zeros(size))) for name in vehicle.actuator_names]
        jit.align(self._tables)
        self.grid_s, self._size = h, size
        self.divide(substeps)
        self._kept = vehicle.sizes.kept
        self._actuators = len(vehicle.actuator_names)
        self._around = (water_of(None) if water is None else water).around(vehicle)
        self._conservative = vehicle.config.integrator == "conservative"

        def numbered(constants: Sequence[Array]) -> Model:
            found: Model = with_numbers(model, dict(zip(places, constants, strict=True)))
            return found

        def surroundings(constants: Sequence[Array], around: Surroundings) -> Surroundings:
            if not flows:
                return around
            north, east = constants[len(places) : len(places) + 2]
            return around.in_current(north, east, in_air=vehicle.model.in_air)

        def advance(x: list[Array], constants: list[Array], commands: list[Array], around: Any) -> list[Array]:
            *given, step = commands
            made = vehicle.with_model(numbered(constants[: len(places)]))
            return _step(made, x, given, step, surroundings(constants, around))

        def deeply(x: list[Array], constants: list[Array], commands: list[Array], around: Any) -> list[Array]:
            *given, step = commands
            deep = deep_model(numbered(constants[: len(places)]))
            assert deep is not None
            return _step(vehicle.with_model(deep), x, given, step, surroundings(constants, around))

        def near(x: list[Array], constants: list[Array], step: Array, around: Any) -> Array:
            return near_surface(vehicle.with_model(numbered(constants[: len(places)])), x, around, step)

        def follow(x: list[Array], constants: list[Array], commands: list[Array], around: Any) -> list[Array]:
            held, *given, step = commands
            moved = numbered(constants[: len(places)]).advanced(x, given, step)
            return [dr.select(held > 0, a, jit.Float64(b)) for a, b in zip(x, moved, strict=True)]

        self._advance, self._follow = _recorded(advance), _recorded(follow)
        self._deep = None if deep_model(model) is None else _recorded(deeply)
        self._is_near = jit.freeze(near)
        self._see, self._see_tangent = _recorded(_seen_step)

    def divide(self, substeps: int) -> None:
        """Take so many steps of the simulation from one row of the record to the next."""
        self.substeps = substeps
        self._h = dr.opaque(jit.Float64, self.grid_s / substeps)

    def play(
        self, shots: Shots, compiled: Compiled, free: Sequence[int], *, tangents: bool
    ) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
        """The motion of every shot, and its derivatives.

        Args:
            shots: where they begin.
            compiled: numbers, and their slopes by the parameters.
            free: coordinates (0 to 11) of the initial state that are free: NED, a small turn about body axes, nu.
            tangents: whether derivatives are wanted.

        Returns:
            coordinates `(steps + 1, 12, s)`, and by parameters and then free coordinates
            `(steps + 1, 12, s, p + f)` or None.
        """
        p = compiled.slopes.shape[1]
        advance = self._advance if not tangents or self._deep is None or self._near(shots, compiled) else self._deep
        directions = max(1, p + len(free)) if tangents else 1
        s = len(shots)
        numbers = [jit.Float64(float(v)) for v in (*compiled.values, *compiled.outside)]
        x = [jit.Float64(column) for column in np.repeat(self._start(shots), directions, axis=1)]
        at = jit.Int32(np.repeat(shots.starts, directions))
        dx: list[Array] = []
        slopes: list[Array] = []
        if tangents:
            dx = [jit.Float64(c.ravel()) for c in _directions(shots, self._kept, free, p, directions)]
            padded = np.zeros((len(numbers), directions))
            padded[:, :p] = compiled.slopes
            slopes = [jit.Float64(np.tile(row, s)) for row in padded]
        dr.make_opaque(numbers)
        jit.align(x, dx, slopes, at)
        x, dx = self._roll_actuators(shots, x, dx, numbers, slopes, at, directions)
        if self._conservative:
            begins = np.repeat(shots.idle & (shots.preroll == 0), directions)
            x, dx = self._under_way(advance, begins, self._given(at), x, dx, numbers, slopes)
        rows: list[list[Array]] = []
        row = at
        for k in range(shots.steps + 1):  # nothing waits for a result before the end
            if tangents:
                seen, dseen = self._see_tangent(x, dx, numbers, slopes, [], None)
                rows.append([*seen, *dseen])
            else:
                rows.append(self._see(x, numbers, [], None))
            dr.eval(rows[-1])
            if k < shots.steps:
                given = self._given(row)
                for _ in range(self.substeps):
                    x, dx = self._one(advance, x, dx, numbers, slopes, given)
                row = row + 1  # the same program in every step: k itself would make a new one
                dr.eval(row)
        values = np.array([[np.array(c) for c in step] for step in rows]).reshape(shots.steps + 1, -1, s, directions)
        out = values[:, : len(COORDINATES), :, 0]
        return out, values[:, len(COORDINATES) :, :, : p + len(free)] if tangents else None

    def _near(self, shots: Shots, compiled: Compiled) -> bool:
        """True if any shot feels the surface."""
        numbers = [jit.Float64(float(v)) for v in (*compiled.values, *compiled.outside)]
        x = [jit.Float64(column) for column in self._start(shots)]
        row, step = jit.Int32(shots.starts), dr.opaque(jit.Float64, self.grid_s)
        near = dr.zeros(jit.Float64, len(shots))
        dr.make_opaque(numbers, near)
        jit.align(x, row)
        x, _ = self._roll_actuators(shots, x, [], numbers, [], row, 1)
        for k in range(shots.steps + 1):
            near = dr.maximum(near, self._is_near(x, numbers, step, self._around))
            dr.eval(near)
            if k < shots.steps:
                given = self._given(row)
                for _ in range(self.substeps):
                    x, _ = self._one(self._advance, x, [], numbers, [], given)
                row = row + 1
                dr.eval(row)
        return bool((np.array(near) > 0).any())

    def _one(self, step: Any, x: Any, dx: Any, numbers: Any, slopes: Any, commands: Any) -> tuple[Any, Any]:
        if dx:
            x, dx = step[1](x, dx, numbers, slopes, commands, self._around)
        else:
            x = step[0](x, numbers, commands, self._around)
        dr.eval(x, dx)
        return x, dx

    def _given(self, row: Array) -> list[Array]:
        row = dr.clip(row, 0, self._size - 1)
        found = [dr.gather(jit.Float64, table, jit.UInt32(row)) for table in self._tables]
        dr.eval(found)
        return [*found, self._h]

    def _start(self, shots: Shots) -> NDArray[np.float64]:
        """Channels of the initial states `(19 + kept, s)`."""
        still = np.zeros((6 + self._kept, len(shots)))
        return np.concatenate([shots.position.T, shots.attitude.T, shots.nu.T, still])

    def _under_way(
        self, advance: Any, begins: NDArray[np.bool_], given: list[Array], x: Any, dx: Any, numbers: Any, slopes: Any
    ) -> tuple[Any, Any]:
        """Give each shot the acceleration of a step before its first, by which the conservative integrator foresees the
        velocity in the middle of the first: that of the first step itself, and 0 where a run begins, as there.
        """
        moving = jit.Float64((~begins).astype(np.float64))
        jit.align(moving)
        y, dy = self._one(advance, x, dx, numbers, slopes, given)
        gone = slice(_PLACE, _MOTION)
        found = [*x[:_PLACE], *(moving * a for a in y[gone]), *x[_MOTION:]]
        slope = [*dx[:_PLACE], *(moving * a for a in dy[gone]), *dx[_MOTION:]] if dx else dx
        dr.eval(found, slope)
        return found, slope

    def _roll_actuators(
        self, shots: Shots, x: Any, dx: Any, numbers: Any, slopes: Any, at: Array, directions: int
    ) -> tuple[Any, Any]:
        if not self._kept:
            return x, dx
        longest, lanes = int(shots.preroll.max()), dr.width(at)
        mine = jit.Int32(np.repeat(shots.preroll, directions))
        driven = jit.Float64(np.repeat(~shots.idle, directions).astype(np.float64))
        jit.align(mine, driven)
        own = [
            *(driven * command for command in self._given(at - mine)[:-1]),
            *(dr.zeros(jit.Float64, lanes) for _ in range(self._kept - self._actuators)),
        ]
        down = [dr.zeros(jit.Float64, lanes) for _ in own] if dx else []
        before = dr.opaque(jit.Int32, longest)
        dr.make_opaque(own, down)
        for _ in range(longest):
            held = dr.select(before > mine, jit.Float64(1.0), 0.0)  # until a shot's own preroll begins
            dr.schedule(held)  # for the kernel of the next line
            given = [held, *self._given(at - before)]
            for _ in range(self.substeps):
                own, down = self._one(self._follow, own, down, numbers, slopes, given)
            before = before - 1
            dr.eval(before)
        return [*x[:_MOTION], *own], [*dx[:_MOTION], *down] if dx else dx


def _recorded(step: Callable[[list[Array], list[Array], list[Array], Any], list[Array]]) -> tuple[Any, Any]:
    """`step(x, constants, commands, around)` recorded, plain and with tangents."""

    def pushed(
        x: list[Array], dx: list[Array], constants: list[Array], slopes: list[Array], commands: list[Array], around: Any
    ) -> tuple[list[Array], list[Array]]:
        lane = dr.zeros(jit.Float64, dr.width(dx))
        free = [jit.Float64(dr.detach(v)) + lane for v in (*x, *constants)]
        dr.enable_grad(free)
        for v, d in zip(free, (*dx, *slopes), strict=True):
            dr.set_grad(v, d)
        after = step(free[: len(x)], free[len(x) :], commands, around)
        dr.enqueue(dr.ADMode.Forward, free)
        dr.traverse(dr.ADMode.Forward, flags=dr.ADFlag.ClearEdges)  # keep what outputs have that others depend on
        return [dr.detach(v) + lane for v in after], [
            dr.detach(dr.grad(v)) + lane if dr.grad_enabled(v) else lane * 1.0 for v in after
        ]

    return jit.freeze(step), jit.freeze(pushed)


def shooter_of(family: Family, record: Record, water: Water | None = None, *, integrator: str = "") -> Shooter:
    """Plays a family's shots with a record's commands; `integrator`: another than the family's."""
    config = family.config_at([p.coordinate(p.prior) for p in family.parameters])
    vehicle = Vehicle(config.model_copy(update={"integrator": integrator}) if integrator else config)
    return Shooter(
        vehicle, family.model, family.places, record.commands, record.step_s, water=water, flows=family.flows
    )


def _step(vehicle: Vehicle, x: list[Array], commands: list[Array], h: Array, around: Surroundings) -> list[Array]:
    """One step of a run."""
    tables = around.tables
    if around.depth is not None:
        thrusters = None if tables is None else tables.thrusters
        tables = Tables(thrusters, None, level_ground(x[0:3], around.depth, around.reach))
    still = jit.Array3f64(0.0)
    state = VehicleState(
        position=jit.Array3f64(*x[0:3]), attitude=jit.Array4f64(*x[3:7]), velocity=jit.Array3f64(*x[7:10]),
        angular_velocity=jit.Array3f64(*x[10:13]), acceleration=jit.Array3f64(*x[13:16]),
        angular_acceleration=jit.Array3f64(*x[16:19]), **vehicle.sizes.lists(list(x[_MOTION:])), mode=jit.Float64(0.0),
        controller=[jit.Float64(0.0)] * 64,
    )  # fmt: skip
    new = vehicle.step(state, commands, around.ocean, jit.Float64(0.0), (still, still), h, _MODE, tables)
    return [
        *new.position, *new.attitude, *new.velocity, *new.angular_velocity, *new.acceleration,
        *new.angular_acceleration, *new.actuators, *new.actuator_memory, *new.radiation,
    ]  # fmt: skip


def _seen_step(x: list[Array], constants: list[Array], commands: list[Array], around: Any) -> list[Array]:
    """The twelve coordinates with their offsets."""
    offsets = constants[len(constants) - len(COORDINATES) :]
    w, i, j, k = x[3:7]
    roll = dr.atan2(2 * (w * i + j * k), 1 - 2 * (i * i + j * j))
    pitch = dr.asin(dr.clip(2 * (w * j - k * i), -1, 1))
    heading = dr.atan2(2 * (w * k + i * j), 1 - 2 * (j * j + k * k))
    seen = [*x[0:3], roll, pitch, heading, *x[7:_PLACE]]
    return [a + b for a, b in zip(seen, offsets, strict=True)]


def _directions(shots: Shots, kept: int, free: Sequence[int], p: int, directions: int) -> NDArray[np.float64]:
    """Tangents of the initial states `(19 + kept, s, directions)`: of p parameters none, then of free coordinates."""
    found = np.zeros((_MOTION + kept, len(shots), directions))
    w, i, j, k = shots.attitude.T
    spin = 0.5 * np.array([[-i, w, k, -j], [-j, -k, w, i], [-k, j, -i, w]])
    for n, c in enumerate(free):
        if c < 3:
            found[c, :, p + n] = 1.0
        elif c < 6:
            found[3:7, :, p + n] = spin[c - 3]
        else:
            found[c + 1, :, p + n] = 1.0
    return found


def turned(q: NDArray[np.float64], by: NDArray[np.float64]) -> NDArray[np.float64]:
    """Attitudes `(s, 4)` after a turn `(s, 3)` about body axes [rad]."""
    new = product(q, from_vector(by))
    unit: NDArray[np.float64] = new / np.linalg.norm(new, axis=1, keepdims=True)
    return unit
