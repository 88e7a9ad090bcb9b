"""What every actuator offers."""

from __future__ import annotations

from typing import Protocol

from pelagos.hydro.algebra import Vector
from pelagos.jit import Array
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.flow import Flow


class Actuator(Protocol):
    """One command, one state that lags behind it, one wrench."""

    @property
    def lag(self) -> Lag:
        """How the state follows the command."""
        ...

    @property
    def unit(self) -> str:
        """Unit of state and command."""
        ...

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Force and moment on the body about its origin (6), FRD [N], [N m]."""
        ...
