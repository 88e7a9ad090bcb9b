"""Random numbers of an episode, inside a kernel."""

from __future__ import annotations

import math

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.philox import philox

_WORD = 2.0**-32


class Draws:
    """A stream of random numbers, one a lane and call, named by (seed, environment, episode, moment).

    The same name gives the same numbers on any device, in any number of lanes, whatever other copies do. Numbers follow
    from the order of the calls, so a task calls in the same order every time.
    """

    def __init__(self, seed: Array, environment: Array, episode: Array, moment: Array) -> None:
        self._key = (seed, environment)
        self._episode, self._moment = episode, moment
        self._block = 0
        self._left: list[Array] = []

    def _word(self) -> Array:
        if not self._left:
            counter = (jit.UInt32(self._block), self._episode, self._moment, jit.UInt32(0))
            self._left = list(philox(counter, self._key))
            self._block += 1
        return self._left.pop()

    def uniform(self, low: Array = 0.0, high: Array = 1.0) -> Array:
        """`Float64`, even between `low` and `high`, neither of them itself."""
        return low + (high - low) * ((jit.Float64(self._word()) + 0.5) * _WORD)

    def normal(self, mean: Array = 0.0, deviation: Array = 1.0) -> Array:
        """`Float64`, normal (Box and Muller 1958, doi 10.1214/aoms/1177706645); |value - mean| <= 6.8 deviations."""
        r = dr.sqrt(-2.0 * dr.log(self.uniform()))
        return mean + deviation * (r * dr.cos(2.0 * math.pi * self.uniform()))

    def box(self, low: tuple[float, ...], high: tuple[float, ...]) -> list[Array]:
        """One `uniform` number for each pair of limits."""
        return [self.uniform(a, b) for a, b in zip(low, high, strict=True)]

    def direction(self) -> list[Array]:
        """A unit vector (3), even on the sphere."""
        z, turn = self.uniform(-1.0, 1.0), self.uniform(-math.pi, math.pi)
        r = dr.sqrt(1.0 - z * z)
        return [r * dr.cos(turn), r * dr.sin(turn), z]
