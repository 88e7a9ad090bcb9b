"""Trajectory of a block of ticks: the motion of one agent at every tick, and the lanes that sensors ask for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.frames import flip_quaternion, flip_yz
from pelagos.sensors.sensor import Kinematics

if TYPE_CHECKING:
    from pelagos.sim.batch import Batch
from pelagos.vehicles.state import VehicleState

CHANNELS: Final = 19  # position 3, attitude 4, velocity 3, angular velocity 3, acceleration 3, angular acceleration 3


_SMALL: Final = 50_000  # numbers


def channels(state: VehicleState) -> list[Array]:
    """The motion in NWU and FLU, `CHANNELS` arrays `Float64` in the order of `Kinematics`."""
    velocity, spin = flip_yz(state.velocity), flip_yz(state.angular_velocity)
    acceleration = flip_yz(state.acceleration) + dr.cross(spin, velocity)
    position, attitude = flip_yz(state.position), flip_quaternion(state.attitude)
    return [*position, *attitude, *velocity, *spin, *acceleration, *flip_yz(state.angular_acceleration)]


@dataclass(frozen=True)
class Trajectory:
    """Ticks `first_tick .. first_tick + ticks - 1` of one agent.

    Attributes:
        packed: `Float64`, `(ticks, n, CHANNELS)` in one row.
        n: rows: copies, of each vehicle of a batch.
        ticks: length of the block.
        first_tick: the tick of the first row.
        commands: `Float64`, `(ticks, n, actuators)` in one row: those that acted in the step which ends at each tick;
            None where nobody asks.
    """

    packed: Array
    n: int
    ticks: int
    first_tick: int
    commands: Array | None = None

    def numpy(self) -> NDArray[np.float64]:
        """`(ticks, n, CHANNELS)`."""
        return np.asarray(self.packed.numpy().copy().reshape(self.ticks, self.n, CHANNELS))

    def told(self) -> NDArray[np.float64]:
        """`(ticks, n, actuators)` commands in the step that ends at each tick; no ticks where nobody asked."""
        if self.commands is None:
            return np.empty((0, self.n, 0))
        return np.asarray(self.commands.numpy().copy().reshape(self.ticks, self.n, -1))

    def last(self) -> NDArray[np.float64]:
        """`(n, CHANNELS)` at the last tick."""
        size = self.n * CHANNELS
        if self.ticks == 1 or self.ticks * size < _SMALL:  # cheaper whole than by a kernel of its own
            row: NDArray[np.float64] = self.numpy()[-1]
            return row
        first = dr.opaque(jit.UInt32, (self.ticks - 1) * size)
        last = dr.gather(jit.Float64, self.packed, dr.arange(jit.UInt32, size) + first)
        found: NDArray[np.float64] = np.array(last).reshape(self.n, CHANNELS)
        return found

    @staticmethod
    def join(blocks: Sequence[Trajectory]) -> Trajectory:
        """Blocks that follow one another as one."""
        if len(blocks) == 1:
            return blocks[0]
        packed = jit.from_numpy(jit.Float64, np.concatenate([np.array(b.packed) for b in blocks]))
        told = [b.commands for b in blocks]
        commands = None
        if not any(c is None for c in told):
            commands = jit.from_numpy(jit.Float64, np.concatenate([np.array(c) for c in told]))
        return replace(blocks[0], packed=packed, ticks=sum(b.ticks for b in blocks), commands=commands)

    def due(self, period: int) -> range:
        """The ticks of this block that are multiples of `period`."""
        start = -(-self.first_tick // period) * period
        return range(start, self.first_tick + self.ticks, period)


class LaneSelector:
    """Cuts the lanes of due ticks out of a trajectory, one frozen call for each number of lanes."""

    def __init__(self, *, n: int, dt_ns: int) -> None:
        self._n = self.rows = n
        self._frozen: dict[int, Callable[..., Kinematics]] = {}
        self._dt = dr.opaque(jit.UInt64, dt_ns)
        self._copies = dr.opaque(jit.UInt32, n)

    def lanes(self, trajectory: Trajectory, ticks: range, names: tuple[Array, Array]) -> Kinematics:
        """The motion at `ticks`, tick-major; `names` as from `Episodes.names`."""
        count = len(ticks) * self._n
        if count not in self._frozen:
            self._frozen[count] = jit.freeze(_selector(count))
        u32 = jit.UInt32
        start = dr.opaque(u32, ticks.start - trajectory.first_tick)
        step, first = dr.opaque(u32, ticks.step), dr.opaque(u32, trajectory.first_tick)
        return self._frozen[count](trajectory.packed, start, step, first, self._copies, self._dt, *names)


class RowNames:
    """Names of the random streams of a batch's rows.

    Those of one vehicle are named by its copies' episodes. Sensors that read for several look these up in tables, by
    row: the names that lanes carry are the rows, and the tables follow the episodes.

    Attributes:
        posed: the tables stand for poses now, whoever asks about the rows meanwhile.
    """

    def __init__(self, batch: Batch) -> None:
        self._batch, self.posed = batch, False
        self._before: tuple[Array, Array] | None = None
        self._found: tuple[Array, Array] | None = None
        self._streams: Array = None
        self._keys: dict[int, tuple[Array, Array]] = {}  # of tables that stand for poses now

    def of(self, names: tuple[Array, Array]) -> tuple[Array, Array]:
        """By row, as `Episodes.names` by copy."""
        batch = self._batch
        if len(batch.members) == 1:
            return names
        if self._found is None or self._before is not names:
            streams, began = (np.tile(np.array(values), len(batch.members)) for values in names)
            rows = np.arange(batch.rows, dtype=np.uint32)
            self._found = jit.from_numpy(jit.UInt32, rows), jit.from_numpy(jit.UInt32, began)
            self._streams = jit.from_numpy(jit.UInt32, streams)
            self._before = names
        for table in batch.streams if not self.posed else ():
            table.environment = self._streams
            table.first, table.second = self._keys.pop(id(table), (table.first, table.second))
        return self._found

    def at_poses(self, lanes: Kinematics, member: int) -> None:
        """Have the tables be those of poses of one member, whose streams `lanes` name; until `of` is asked when they
        are no longer `posed`.
        """
        if len(self._batch.members) == 1:
            return
        self.posed = True
        count = len(lanes.tick)
        for table in self._batch.streams:
            self._keys.setdefault(id(table), (table.first, table.second))
            first, second = self._keys[id(table)]
            table.first, table.second = (
                dr.full(jit.UInt32, int(words[member * self._batch.n]), count) for words in (first, second)
            )
            table.environment = lanes.environment
            dr.make_opaque(table.first, table.second)
        lanes.environment = dr.arange(jit.UInt32, count)
        lanes.copy = lanes.copy + member * self._batch.n
        dr.make_opaque(lanes.environment, lanes.copy)


def of_rows(motion: Kinematics, rows: slice, of: int) -> Kinematics:
    """The lanes of some rows among `of` of a motion, tick-major as before."""
    wide = len(motion.tick)
    chosen = np.arange(wide, dtype=np.uint32).reshape(-1, of)[:, rows].ravel()
    made = at_lanes(motion, jit.UInt32(chosen))
    dr.eval(made)
    return made


def at_lanes(motion: Kinematics, lanes: Array) -> Kinematics:
    """A motion at some of its lanes, which may repeat: `UInt32` indices."""
    parts = {field.name: getattr(motion, field.name) for field in fields(Kinematics)}
    return Kinematics(**{name: v if v is None else dr.gather(type(v), v, lanes) for name, v in parts.items()})


def _selector(count: int) -> Callable[..., Kinematics]:
    def select(
        packed: Array, start: Array, step: Array, first: Array, n: Array, dt: Array, stream: Array, began: Array
    ) -> Kinematics:
        lane = dr.arange(jit.UInt32, count)
        copy = lane % n
        row = start + lane // n * step
        at = (row * n + copy) * CHANNELS
        c = [dr.gather(jit.Float64, packed, at + i) for i in range(CHANNELS)]
        tick = first + row
        age = tick - dr.gather(jit.UInt32, began, copy)
        return kinematics(
            c,
            tick=age,
            t_ns=jit.UInt64(tick) * dt,
            age_ns=jit.UInt64(age) * dt,
            environment=dr.gather(jit.UInt32, stream, copy),
            copy=copy,
        )

    return select


def kinematics(
    c: list[Array], *, tick: Array, t_ns: Array, age_ns: Array, environment: Array, copy: Array
) -> Kinematics:
    """`CHANNELS` arrays -> `Kinematics`."""
    v3: Any = jit.Array3f64
    return Kinematics(
        position=v3(c[0:3]),
        attitude=jit.Array4f64(c[3:7]),
        velocity=v3(c[7:10]),
        angular_velocity=v3(c[10:13]),
        acceleration=v3(c[13:16]),
        angular_acceleration=v3(c[16:19]),
        t_ns=t_ns,
        tick=tick,
        environment=environment,
        copy=copy,
        age_ns=age_ns,
    )
