"""The contract of an actuator."""

from __future__ import annotations

from typing import Protocol

from pelagos.hydro.algebra import Vector
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.wetness import Place


class Follower(Protocol):
    """Law by which a state follows its command: `lag.Lag`, `third_order.ThirdOrder`."""

    @property
    def memory(self) -> int:
        """Number of values kept beside the state."""
        ...

    @property
    def time_constant(self) -> Array:
        """Of the slowest part [s]."""
        ...

    @property
    def low(self) -> Array:
        """Least state."""
        ...

    @property
    def high(self) -> Array:
        """Largest state."""
        ...

    def limited(self, state: Array) -> Array:
        """The state as forces see it."""
        ...

    def rates(self, state: Array, kept: list[Array], command: Array) -> list[Array]:
        """Time derivatives of the state, and of what is kept."""
        ...

    def after(self, state: Array, kept: list[Array], command: Array, h: Array) -> list[Array]:
        """The state, and what is kept, after h [s] of a constant command."""
        ...


class Actuator(Protocol):
    """One command, one state that follows it, one wrench."""

    @property
    def lag(self) -> Follower:
        """Law by which the state follows the command."""
        ...

    @property
    def site(self) -> Place:
        """Place at which it acts, and the share of its force left near the surface."""
        ...

    @property
    def unit(self) -> str:
        """Unit of state and command."""
        ...

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Force and moment on the body about its origin (6), FRD [N], [N m]."""
        ...
