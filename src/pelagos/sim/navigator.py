"""Navigation of a mission where it is not the truth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from pelagos.config.navigation import EkfNavigation, ExternalNavigation
from pelagos.sim.guidance.aboard import Fix, Floats

if TYPE_CHECKING:
    from pelagos.sim.model import AgentModel, Model
    from pelagos.sim.sampled import Sampled
    from pelagos.sim.state import AgentState


T = TypeVar("T", float, Floats)


class Navigator(Protocol):
    """Keeps a solution for every copy.

    Attributes:
        listens: names of the sensors whose readings it takes.
    """

    listens: frozenset[str]

    @property
    def fix(self) -> Fix:
        """The newest solution."""
        ...

    @property
    def motion(self) -> tuple[Floats, Floats, Floats]:
        """Position `(n, 3)` NWU [m], attitude `(n, 4)`, velocity `(n, 3)` NWU [m/s] of the newest solution."""
        ...

    @property
    def rate(self) -> Floats:
        """Angular velocity `(n, 3)` body FLU [rad/s]."""
        ...

    def hear(self, sampled: Sampled) -> None:
        """Take readings of a sensor."""
        ...

    def advance(self, tick: int) -> None:
        """Bring the solution to a tick."""
        ...

    def memory(self) -> dict[str, Any]:
        """Memory: arrays."""
        ...

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Keep that instead."""
        ...

    def renewed(self, before: Mapping[str, Any], fresh: Mapping[str, Any], where: NDArray[np.bool_]) -> dict[str, Any]:
        """Memory in which some copies begin anew: of that before, all of which was taken in, and of a fresh one."""
        ...


class External:
    """The solution that somebody outside gave last; the start before the first."""

    listens: frozenset[str] = frozenset()

    def __init__(self, fix: Fix) -> None:
        self._fix = fix

    @property
    def fix(self) -> Fix:
        """The newest solution."""
        return self._fix

    def tell(self, position: NDArray[np.float64], heading: NDArray[np.float64], velocity: NDArray[np.float64]) -> None:
        """Take a solution."""
        self._fix = Fix(position, heading, velocity)

    def hear(self, sampled: Sampled) -> None:
        """Takes no readings."""

    def advance(self, tick: int) -> None:
        """The solution is as old as it is."""

    @property
    def rate(self) -> Floats:
        """Not told."""
        return np.zeros_like(self._fix.position)

    @property
    def motion(self) -> tuple[Floats, Floats, Floats]:
        """See `Navigator.motion`; level."""
        half = -0.5 * self._fix.heading
        zero = np.zeros_like(half)
        attitude = np.stack([np.cos(half), zero, zero, np.sin(half)], axis=-1)
        return self._fix.position, attitude, self._fix.velocity

    def memory(self) -> dict[str, Any]:
        """See `Navigator.memory`."""
        return dict(vars(self._fix))

    def recall(self, memory: Mapping[str, Any]) -> None:
        """See `Navigator.recall`."""
        self._fix = Fix(**memory)

    def renewed(self, before: Mapping[str, Any], fresh: Mapping[str, Any], where: NDArray[np.bool_]) -> dict[str, Any]:
        """See `Navigator.renewed`."""
        return dict(renewed(before, fresh, where))


def renewed(before: Any, fresh: Any, where: NDArray[np.bool_]) -> Any:
    """Arrays of memory `(n, ...)`, fresh in some copies and as before in the others.

    What is kept from the first command on, and has no rows yet, is not a number in copies that have had none.
    """
    if isinstance(before, Mapping):
        return {key: renewed(value, fresh[key], where) for key, value in before.items()}
    if len(before) and not len(fresh):
        fresh = np.full_like(before, np.nan)
    return np.where(where.reshape(-1, *[1] * (np.ndim(before) - 1)), fresh, before)


def fix_of(state: AgentState) -> Fix:
    """The true motion as guidance takes it."""
    q, velocity = state.attitude.T, state.velocity.T
    if len(state.position) == 1:  # Python's numbers: the same operations in a tenth of the time
        across, along, *turned = _turned(*q[:, 0].tolist(), *velocity[:, 0].tolist())
        return Fix(state.position, -np.arctan2([across], [along]), np.array([turned]))
    across, along, *turned = _turned(*q, *velocity)
    return Fix(state.position, -np.arctan2(across, along), np.stack(turned, axis=-1))


def _turned(w: T, x: T, y: T, z: T, u: T, v: T, s: T) -> tuple[T, T, T, T, T]:
    """Sine and cosine of the yaw, times one number, and a vector (u, v, s) turned by a quaternion (w, x, y, z)."""
    a, b, c = 2 * (y * s - z * v), 2 * (z * u - x * s), 2 * (x * v - y * u)
    u, v, s = u + w * a + y * c - z * b, v + w * b + z * a - x * c, s + w * c + x * b - y * a
    return 2 * (w * z + x * y), 1 - 2 * (y * y + z * z), u, v, s


def navigator_of(agent: AgentModel, model: Model, state: AgentState) -> Navigator | None:
    """The navigator of an agent; None where it knows the truth."""
    config = agent.config.navigation
    if isinstance(config, ExternalNavigation):
        return External(fix_of(state))
    if isinstance(config, EkfNavigation):
        from pelagos.sim.estimator import Estimator

        return Estimator(config, agent, model, state)
    return None
