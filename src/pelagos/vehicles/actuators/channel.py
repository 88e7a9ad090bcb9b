"""A command that makes no force by itself: your own dynamics read it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Self

from pydantic import model_validator

from pelagos.hydro.algebra import Vector
from pelagos.jit import Array
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, Number, PartConfig, check_limits
from pelagos.vehicles.wetness import ALWAYS, Place


class ChannelConfig(PartConfig):
    """A state that lags behind its command, for terms of the type `function` (`flow.actuators`)."""

    type: Literal["channel"]
    low: Number
    """Least state."""
    high: Number
    """Largest state."""
    unit: str = ""
    """Of state and command."""
    time_constant_s: NonNegative = 0.0
    """[s]"""

    @model_validator(mode="after")
    def _possible(self) -> Self:
        check_limits(self, "low", "high")
        return self

    def build(self, body: Body) -> Channel:
        """The actuator."""
        return Channel(Lag(self.time_constant_s, self.low, self.high), self.unit)


@dataclass(frozen=True)
class Channel:
    """lag: how the state follows; unit: of the state."""

    lag: Lag
    unit: str
    site: Place = ALWAYS

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """None (6)."""
        return [0.0] * 6
