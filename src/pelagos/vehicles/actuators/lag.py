"""First-order lag with saturation, as servos and motors have it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal, TypeAlias

import drjit as dr

from pelagos.jit import Array

Clip: TypeAlias = Literal["before", "after", "force"]
"""What limits act on: the state before its use and its lag, the state that the lag returns, or the force alone."""


@dataclass(frozen=True)
class Lag:
    """state' = (command - state)/time_constant, between limits.

    Attributes:
        time_constant: [s]; 0: the state is the command.
        low, high: limits of the state.
        clip: see `Clip`; published models differ in it, `advanced` always returns a state between its limits.
        rate_limit: fastest change of the state [1/s]; None: none.
    """

    time_constant: Array
    low: Array
    high: Array
    clip: Clip = "before"
    rate_limit: float | None = None
    memory: ClassVar[int] = 0

    def rates(self, state: Array, kept: list[Array], command: Array) -> list[Array]:
        """`rate`, as `actuators.actuator.Follower` has it."""
        return [self.rate(state, command)]

    def after(self, state: Array, kept: list[Array], command: Array, h: Array) -> list[Array]:
        """`advanced`, as `actuators.actuator.Follower` has it."""
        return [self.advanced(state, command, h)]

    def limited(self, state: Array) -> Array:
        """The state as forces see it."""
        return state if self.clip == "after" else self._clipped(state)

    def rate(self, state: Array, command: Array) -> Array:
        """Time derivative; a time constant of 0 counts as 1 s.

        `before`: that of the published loop, whose limits act at a step's beginning: a state beyond them is back after
        1 s, one between them follows the command, within the limits or not. `after`: at a limit it does not go on.
        """
        start = self._clipped(state) if self.clip != "force" else state
        change = command - start
        if not (isinstance(self.time_constant, (int, float)) and self.time_constant == 0):
            change = change / self.time_constant
        change = self._slowed(change, 1.0)
        if self.clip == "after":
            stuck = ((state >= self.high) & (change > 0)) | ((state <= self.low) & (change < 0))
            change = dr.select(stuck, 0.0, change)
        return (start - state) + change

    def advanced(self, state: Array, command: Array, h: Array) -> Array:
        """The state after h [s] of a constant command, exactly, and between its limits."""
        if isinstance(self.time_constant, (int, float)) and self.time_constant == 0:
            return self._clipped(state + self._slowed(command - state, h))
        if isinstance(h, (int, float)) and isinstance(self.time_constant, (int, float)):
            left: Array = math.exp(-h / self.time_constant)
        else:
            left = dr.exp(-h / self.time_constant)
        start = self.limited(state)
        return self._clipped(start + self._slowed((command - start) * (1 - left), h))

    def _clipped(self, state: Array) -> Array:
        return dr.clip(state, self.low, self.high)

    def _slowed(self, change: Array, h: Array) -> Array:
        if self.rate_limit is None:
            return change
        most = self.rate_limit * h
        return dr.clip(change, -most, most)
