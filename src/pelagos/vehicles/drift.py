"""Mean wave drift of a floating hull: forces of second order that push it along, slowly varying with groups.

A regular wave of amplitude a pushes with a^2 D, D from a panel method's far field; waves of several frequencies push
with D at each pair's mean, J. N. Newman, "Second-order, slowly-varying forces on vessels in irregular waves", Proc.
Int. Symp. on the Dynamics of Marine Vehicles, London 1974, p. 182. Zero speed: what the hull's own speed changes in D
(wave drift damping) is not part of it. The pressure on the hull as it moves (`seakeeping.py`) is itself a part of what
pushes it, so the coefficients may say which (`DriftConfig.own`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Self

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.hydro.wave_load import newman_drift
from pelagos.jit import Array
from pelagos.math.turns import sincos_turns
from pelagos.ocean.waves import Waves
from pelagos.vehicles.part import PartConfig, Positive

_FREQUENCIES: Final = 384  # of the table, evenly from zero; the nearest is taken


class DriftConfig(PartConfig):
    """Mean force of regular waves of amplitude 1 m over the water's density, zero speed, hulls the same on both sides.

    FRD, about the origin. Newtons over the square of the amplitude and over the density: m^2/s^2.
    """

    omega_radps: tuple[Positive, ...] = Field(min_length=2)
    """Frequencies, increasing [rad/s]; beyond the last the force is that of the last."""
    heading_deg: tuple[float, ...] = Field(min_length=2)
    """Where the wave travels to, from the bow over starboard, evenly from 0 to 180 [deg]: 180 is a head sea."""
    force: tuple[tuple[tuple[float, float, float], ...], ...]
    """`(frequencies, headings, 3)`: surge and sway [m^2/s^2], yaw [m^3/s^2]."""
    own: tuple[tuple[tuple[float, float, float], ...], ...] = ()
    """What the pressure on the moving hull, as this simulator has it, pushes by itself; the same shape. It is taken
    off, so that both together are `force` (`scripts/drift.py` measures it)."""

    @model_validator(mode="after")
    def _shapes(self) -> Self:
        shape = (len(self.omega_radps), len(self.heading_deg), 3)
        if np.shape(self.force) != shape:
            raise ValueError(f"force must be {shape[0]} x {shape[1]} x 3: by frequency and heading surge, sway and yaw")
        if self.own and np.shape(self.own) != shape:
            raise ValueError(f"own must be {shape[0]} x {shape[1]} x 3, as force is")
        if (np.diff(self.omega_radps) <= 0).any():
            raise ValueError("omega_radps must increase")
        if not np.allclose(self.heading_deg, np.linspace(0, 180, shape[1])):
            raise ValueError("heading_deg must go evenly from 0 to 180")
        return self


@dataclass(frozen=True)
class Drift:
    """Coefficients on an even grid, compiled.

    Attributes:
        rows: `(frequencies, headings, 3)`: surge, sway and yaw over the density.
        step: between frequencies [rad/s].
    """

    rows: NDArray[np.float64]
    step: float

    def table(self) -> Array:
        """The rows on the device, `Float64`."""
        return jit.Float64(np.ascontiguousarray(self.rows.ravel()))

    def push(
        self, waves: Waves, table: Array, x: Array, y: Array, heading: tuple[Array, Array], t: Array
    ) -> list[Array]:
        """Surge, sway and yaw along the heading, over the density.

        Args:
            waves: the sea.
            table: see `table`.
            x, y: of the hull's origin, world NWU [m].
            heading: cosine and sine of the compass heading.
            t: time [s].
        """
        cos, sin = heading
        last, turns = len(self.rows) - 1, self.rows.shape[1] - 1
        nothing = 0 * (x + y + t + cos)

        def add(i: Array, *sums: Array) -> tuple[Array, ...]:
            first, second = waves._rows(i)
            ahead, aside = first[0] * cos - first[1] * sin, -(first[0] * sin + first[1] * cos)
            force = self._at(table, 2 * math.pi * first[2], dr.atan2(dr.abs(aside), ahead), last, turns)
            side = dr.select(aside < 0, -1.0 + 0 * ahead, 1.0 + 0 * ahead)
            s, c = sincos_turns(dr.fma(first[0], x, dr.fma(first[1], y, dr.fma(-first[2], t, first[3]))))
            s, c = second[0] * s, second[0] * c
            each = (force[0], side * force[1], side * force[2])
            terms = [c, s, *(v for d in each for v in (d * c, d * s))]
            return i + 1, *(a + b for a, b in zip(sums, terms, strict=True))

        c, s, *weighted = waves._loop(add, *([nothing] * 8))
        return [newman_drift((c, s), (weighted[2 * k], weighted[2 * k + 1])) for k in range(3)]

    def _at(self, table: Array, omega: Array, angle: Array, last: int, turns: int) -> Array:
        """Of the nearest frequency, linear in heading; the last frequency's beyond it."""
        v = angle * (turns / math.pi)
        i = dr.minimum(jit.UInt32(dr.minimum(dr.fma(omega, 1 / self.step, 0.5), float(last))), last)
        j = dr.minimum(jit.UInt32(v), turns - 1)
        q = v - jit.Float64(j)
        row = i * (turns + 1) + j
        low, high = (dr.gather(jit.Array3f64, table, r) for r in (row, row + 1))
        return (1 - q) * low + q * high


def compile_drift(config: DriftConfig) -> Drift:
    """On an even grid of frequencies that starts with nothing at zero."""
    omega = np.concatenate([[0.0], config.omega_radps])
    rest = np.array(config.force) - (np.array(config.own) if config.own else 0.0)
    force = np.concatenate([np.zeros((1, len(config.heading_deg), 3)), rest])
    even = np.linspace(0.0, omega[-1], _FREQUENCIES)
    rows = np.zeros((_FREQUENCIES, len(config.heading_deg), 3))
    for j in range(rows.shape[1]):
        for k in range(3):
            rows[:, j, k] = np.interp(even, omega, force[:, j, k])
    return Drift(rows, float(even[1]))
