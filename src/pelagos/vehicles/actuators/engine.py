"""A ship's main engine: revolutions of the propeller that follow an order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, Self

import drjit as dr
from pydantic import model_validator

from pelagos.hydro.algebra import Vector
from pelagos.jit import Array
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, PartConfig, Positive
from pelagos.vehicles.wetness import ALWAYS, Place


class ShipEngineConfig(PartConfig):
    """Revolutions of a ship's propeller, ahead. Command and state: [1/s].

    Its thrust is worked out with the hull and the rudder, by the actuator that names this one as its `engine`.
    """

    type: Literal["ship_engine"]
    service_hz: Positive
    """At the service speed; trials begin with them [1/s]."""
    limit_hz: Positive
    """Largest [1/s]."""
    time_constant_s: Positive
    """[s]"""
    quickened_above_hz: Positive | None = None
    """Revolutions beyond which the time constant falls with them [1/s]; left out: it is the same at all."""
    quickened_constant: Positive | None = None
    """There, the time constant times the revolutions [-]."""

    @model_validator(mode="after")
    def _possible(self) -> Self:
        if self.service_hz > self.limit_hz:
            raise ValueError(f"service_hz {self.service_hz:g} must not be above limit_hz {self.limit_hz:g}")
        if (self.quickened_above_hz is None) != (self.quickened_constant is None):
            raise ValueError("give both quickened_above_hz and quickened_constant, or neither")
        return self

    def build(self, body: Body) -> ShipEngine:
        """The actuator."""
        lag: Lag | ShaftLag = Lag(self.time_constant_s, 0.0, self.limit_hz)
        if self.quickened_above_hz is not None and self.quickened_constant is not None:
            lag = ShaftLag(self.time_constant_s, 0.0, self.limit_hz, self.quickened_above_hz, self.quickened_constant)
        return ShipEngine(lag, self.service_hz)


@dataclass(frozen=True)
class ShaftLag:
    """state' = (command - state)/T, T = time_constant [s] up to `above` [1/s], and `constant`/state beyond."""

    time_constant: Array
    low: Array
    high: Array
    above: Array
    constant: Array
    memory: ClassVar[int] = 0

    def limited(self, state: Array) -> Array:
        """The state as forces see it."""
        return dr.clip(state, self.low, self.high)

    def rates(self, state: Array, kept: list[Array], command: Array) -> list[Array]:
        """Time derivative; a state beyond its limits is back after 1 s."""
        start = self.limited(state)
        return [(start - state) + (self.limited(command) - start) / self._slowness(start)]

    def after(self, state: Array, kept: list[Array], command: Array, h: Array) -> list[Array]:
        """The state after h [s] of a constant command, with the time constant of the step's beginning."""
        start = self.limited(state)
        left = dr.exp(-h / self._slowness(start))
        return [start + (self.limited(command) - start) * (1 - left)]

    def _slowness(self, state: Array) -> Array:
        return dr.select(state > self.above, self.constant / dr.maximum(state, self.above), self.time_constant)


@dataclass(frozen=True)
class ShipEngine:
    """lag: how revolutions follow; service: those of the service speed [1/s]."""

    lag: Lag | ShaftLag
    service: float
    unit: str = "1/s"
    site: Place = ALWAYS

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """None (6): the thrust comes with the hull and the rudder."""
        return [0.0] * 6
