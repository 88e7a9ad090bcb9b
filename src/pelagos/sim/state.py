"""State of an agent, as users see it and as the run keeps it. Everything else is constant (`sim/model.py`)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.errors import CommandError, LookupFailed, UnknownKey
from pelagos.jit import Array
from pelagos.math.so3 import euler_np
from pelagos.sim.trajectory import CHANNELS

if TYPE_CHECKING:
    from pelagos.sim.batch_run import BatchRun
    from pelagos.sim.model import Model

POSITION: Final = slice(0, 3)  # of a row of a trajectory (`CHANNELS`)
ATTITUDE: Final = slice(3, 7)
VELOCITY: Final = slice(7, 10)
ANGULAR_VELOCITY: Final = slice(10, 13)
_ACCELERATION: Final = slice(13, 16)
_ANGULAR_ACCELERATION: Final = slice(16, 19)


@dataclass(frozen=True)
class AgentState:
    """The true state of one agent, for every copy of the fleet.

    Attributes:
        position: `(n, 3)` world NWU [m].
        attitude: `(n, 4)` quaternion (w, x, y, z), body FLU to world NWU.
        velocity: `(n, 3)` over ground, body FLU [m/s].
        angular_velocity: `(n, 3)` body FLU [rad/s].
        acceleration: `(n, 3)` inertial, body FLU [m/s^2], gravity not included.
        angular_acceleration: `(n, 3)` body FLU [rad/s^2].
        actuators: `(n, k)` actuator states in the vehicle's own units.
    """

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    velocity: NDArray[np.float64]
    angular_velocity: NDArray[np.float64]
    acceleration: NDArray[np.float64]
    angular_acceleration: NDArray[np.float64]
    actuators: NDArray[np.float64]

    @classmethod
    def of(cls, row: NDArray[np.float64], actuators: NDArray[np.float64]) -> AgentState:
        """From one row `(n, CHANNELS)` of a trajectory."""
        assert row.shape[-1] == CHANNELS
        turn, push, turning = row[:, ANGULAR_VELOCITY], row[:, _ACCELERATION], row[:, _ANGULAR_ACCELERATION]
        return cls(row[:, POSITION], row[:, ATTITUDE], row[:, VELOCITY], turn, push, turning, actuators)

    def part(self, rows: slice) -> AgentState:
        """That of some rows."""
        return AgentState(*(getattr(self, f.name)[rows] for f in fields(self)))

    @classmethod
    def together(cls, states: Sequence[AgentState]) -> AgentState:
        """Several as one, `(n, members, ...)`."""
        return cls(*(np.stack([getattr(s, f.name) for s in states], axis=1) for f in fields(cls)))

    @property
    def depth(self) -> NDArray[np.float64]:
        """`(n,)` depth of the body's origin below the mean surface [m]."""
        return np.asarray(-self.position[..., 2])

    @property
    def euler(self) -> NDArray[np.float64]:
        """`(n, 3)` roll, pitch, yaw [rad] of FLU in NWU (yaw counter-clockwise from north, pitch positive down)."""
        return euler_np(self.attitude)


class States(Mapping[str, AgentState]):
    """The true state of every agent by name; a group's name gives its members' together, `(n, members, ...)`.

    Iteration goes over single agents.
    """

    def __init__(self, model: Model, runs: Mapping[str, BatchRun]) -> None:
        self._model, self._rows = model, {name: (run.row, run.vehicle) for name, run in runs.items()}
        self._found: dict[str, AgentState] = {}

    @cached_property
    def motion(self) -> NDArray[np.float64]:
        """`(agents * n, CHANNELS)` motion of all, agent by agent in the scenario's order, and copy by copy within."""
        n, agents = self._model.n, self._model.agents
        if len(self._rows) == 1:
            return next(iter(self._rows.values()))[0]
        found = np.empty((len(agents) * n, CHANNELS))
        places = {name: i for i, name in enumerate(agents)}
        for name, (row, _) in self._rows.items():
            first = np.array([places[member] for member in self._model.batches[name].members]) * n
            found[(first[:, None] + np.arange(n)).ravel()] = row
        return found

    def batch(self, name: str) -> AgentState:
        """That of all rows of a batch."""
        if name not in self._found:
            row, vehicle = self._rows[name]
            self._found[name] = AgentState.of(row, self._model.batches[name].driver.actuators(vehicle))
        return self._found[name]

    def __getitem__(self, name: str) -> AgentState:
        agent = self._model.agents.get(name)
        if agent is not None:
            return self.batch(agent.batch.name).part(agent.rows)
        members = self._model.group(name)
        if members is None:
            raise UnknownKey("agent", name, [*self, *self._model.groups])
        return AgentState.together([self[member] for member in members])

    def __iter__(self) -> Iterator[str]:
        return iter(self._model.agents)

    def __len__(self) -> int:
        return len(self._model.agents)


def mixed(one: Array, other: Array, where: NDArray[np.bool_]) -> Array:
    """Packed states, of `other` `where` a copy `(n,)` is chosen; the bits of the rest are those of `one`."""
    n = len(where)
    lane = dr.arange(jit.UInt32, dr.width(one)) % n
    chosen = dr.gather(jit.Bool, jit.Bool(where), lane)
    made = dr.select(chosen, other, one)
    dr.eval(made)
    return made


def chosen(where: object, n: int) -> NDArray[np.bool_]:
    """Copies by a mask `(n,)` or by their indices, as a mask.

    Raises:
        CommandError: another shape, none at all, or an index beyond the fleet.
    """
    given = np.asarray(where)
    if given.dtype == bool and given.shape == (n,):
        mask = given.copy()
    elif given.ndim == 1 and given.dtype.kind in "iu" and ((given >= -n) & (given < n)).all():
        mask = np.zeros(n, dtype=bool)
        mask[given] = True
    else:
        raise CommandError(f"where is bool of shape ({n},), or indices of copies below {n}; given {where!r}")
    if not mask.any():
        raise CommandError("where chooses no copy")
    return mask


def checked_command(values: object, *, n: int, names: tuple[str, ...], agent: str) -> NDArray[np.float64]:
    """A command as `(n, k)`; `(k,)` goes to every copy. NumPy, or whatever speaks DLPack from the CPU's memory.

    Raises:
        CommandError: another shape, or a value that is not finite.
    """
    try:
        given = np.from_dlpack(values) if hasattr(values, "__dlpack__") and not hasattr(values, "__array__") else values
        array = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError, RuntimeError, BufferError) as error:
        raise CommandError(
            f"{agent}: a command is numbers of shape ({len(names)},) or ({n}, {len(names)}): {error}"
        ) from None
    if array.shape not in ((len(names),), (n, len(names))):
        raise CommandError(
            f"{agent}: a command has shape ({len(names)},) or ({n}, {len(names)}) for {', '.join(names)}; "
            f"given {array.shape}"
        )
    full = np.array(np.broadcast_to(array, (n, len(names))))
    if not np.isfinite(full).all():
        copy, channel = (int(i) for i in np.argwhere(~np.isfinite(full))[0])
        raise CommandError(
            f"{agent}: command {names[channel]!r} of copy {copy} is {full[copy, channel]}, not a finite number"
        )
    return full


def named_command(
    values: Mapping[str, object], held: NDArray[np.float64], *, names: tuple[str, ...], agent: str
) -> NDArray[np.float64]:
    """The command `(n, k)` that is held, with other set-points, one number or `(n,)` each, by name.

    Raises:
        CommandError: a name that is none of the mode's, or what is no number a copy.
    """
    whole = held.copy()
    for name, value in values.items():
        if name not in names:
            raise CommandError(str(LookupFailed("set-point", name, names, where=agent)))
        try:
            whole[:, names.index(name)] = np.broadcast_to(np.asarray(value, dtype=np.float64), len(whole))
        except (TypeError, ValueError):
            raise CommandError(f"{agent}: {name} is one number or ({len(whole)},); given {value!r}") from None
    return whole
