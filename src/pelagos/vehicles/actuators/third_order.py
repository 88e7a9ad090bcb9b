"""A thruster that follows its command as a linear system of third order with one real pole and a complex pair."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Final

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.jit import Array

# M. von Benzon et al., J. Mar. Sci. Eng. 10:1898, 2022, doi 10.3390/jmse10121898: the T200
VON_BENZON: Final = ((6136.0, 108700.0), (1.0, 89.0, 9258.0, 108700.0))


@dataclass(frozen=True)
class Modes:
    """H(s) = r/(s - p) + c/(s - q) + conj(c)/(s - conj(q)); p, q [1/s]."""

    real: tuple[float, float]  # p, r
    pair: tuple[complex, complex]  # q, c

    @classmethod
    def of(cls, numerator: tuple[float, ...], denominator: tuple[float, ...]) -> Modes:
        """Partial fractions of a strictly proper H(s), coefficients from the highest power of s."""
        poles = np.roots(denominator)
        residues = np.polyval(numerator, poles) / np.polyval(np.polyder(denominator), poles)
        p, q = int(np.argmin(np.abs(poles.imag))), int(np.argmax(poles.imag))
        return cls(
            (float(poles[p].real), float(residues[p].real)),
            (complex(poles[q]), complex(residues[q])),
        )


@dataclass(frozen=True)
class ThirdOrder:
    """The throttle after its motor and propeller; beside it two more numbers are kept, the complex mode's z.

    y = a + 2 Re z with a' = p a + r u, z' = q z + c u, u the command between its limits. A command that is constant
    over a step is followed exactly, whatever the step: a <- e^(p h) a + (e^(p h) - 1) (r/p) u, and z likewise.

    Attributes:
        modes: of H(s).
        low, high: limits of the command, and of the state as forces see it.
    """

    modes: Modes
    low: float
    high: float
    memory: ClassVar[int] = 2

    @property
    def time_constant(self) -> float:
        """Of the slowest mode [s]."""
        return -1.0 / max(self.modes.real[0], self.modes.pair[0].real)

    def limited(self, state: Array) -> Array:
        """The state as forces see it."""
        return dr.clip(state, self.low, self.high)

    def rates(self, state: Array, kept: list[Array], command: Array) -> list[Array]:
        """Time derivatives of the state and of what is kept beside it."""
        (p, r), (q, c) = self.modes.real, self.modes.pair
        x, y = kept
        u = self.limited(command)
        dx, dy = q.real * x - q.imag * y + c.real * u, q.imag * x + q.real * y + c.imag * u
        return [p * (state - 2 * x) + r * u + 2 * dx, dx, dy]

    def after(self, state: Array, kept: list[Array], command: Array, h: Array) -> list[Array]:
        """State and what is kept after h [s] of a constant command, exactly."""
        (p, r), (q, c) = self.modes.real, self.modes.pair
        h = jit.Float64(h)
        x, y = kept
        u = self.limited(command)
        slow = dr.exp(p * h)
        fade, (sin, cos) = dr.exp(q.real * h), dr.sincos(q.imag * h)
        re, im = fade * cos, fade * sin
        end = c / q  # (e^(q h) - 1) end u is what the command adds
        new_x = re * x - im * y + ((re - 1) * end.real - im * end.imag) * u
        new_y = im * x + re * y + (im * end.real + (re - 1) * end.imag) * u
        a = slow * (state - 2 * x) + (slow - 1) * (r / p) * u
        return [a + 2 * new_x, new_x, new_y]
