"""Absorption of sound in sea water, at a place and as a mean along straight ways through layers."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, Final

import drjit as dr

from pelagos import jit
from pelagos.errors import ValidityWarning
from pelagos.jit import Array

FREQUENCY_RANGE_HZ: Final = (200.0, 2.0e6)
"""Francois and Garrison state 200 Hz to 1 MHz; up to 2 MHz their pure water, all that counts there, goes on as f^2."""
LAYERS: Final = 32
_LEVEL: Final = 0.02  # [m], rise of a way below which the absorption of its layer counts


def francois_garrison(
    frequency: Array, temperature: Array, salinity: Array, depth: Array, ph: Array = 8.1
) -> tuple[Array, Array, Array]:
    """Absorption by boric acid, magnesium sulphate and pure water, each [dB/km]; their sum is the absorption.

    Args:
        frequency: [Hz], see `FREQUENCY_RANGE_HZ`.
        temperature: [deg C], -2 to 30.
        salinity: practical, 0 to 40.
        depth: [m], positive down, 0 to 7000.
        ph: NBS scale, 7.7 to 8.3.

    Source: R. E. Francois and G. R. Garrison, J. Acoust. Soc. Am. 72, 1879 (1982), Eqs. 10-17,
    doi 10.1121/1.388673. The sound speed inside is the paper's own, 1412 + 3.21 T + 1.19 S + 0.0167 D.
    """
    f = frequency * 1e-3  # [kHz], as in the paper
    T, S, D = temperature, salinity, depth
    c = 1412.0 + 3.21 * T + 1.19 * S + 0.0167 * D
    kelvin = 273.0 + T

    A1 = 8.86 / c * _power10(0.78 * ph - 5.0)
    f1 = 2.8 * dr.sqrt(S / 35.0) * _power10(4.0 - 1245.0 / kelvin)
    boric = A1 * f1 * f * f / (f1 * f1 + f * f)

    A2 = 21.44 * S / c * (1.0 + 0.025 * T)
    P2 = 1.0 - 1.37e-4 * D + 6.2e-9 * D * D
    f2 = 8.17 * _power10(8.0 - 1990.0 / kelvin) / (1.0 + 0.0018 * (S - 35.0))
    magnesium = A2 * P2 * f2 * f * f / (f2 * f2 + f * f)

    cold = 4.937e-4 + T * (-2.59e-5 + T * (9.11e-7 - 1.50e-8 * T))
    warm = 3.964e-4 + T * (-1.146e-5 + T * (1.45e-7 - 6.5e-10 * T))
    A3 = dr.select(T <= 20.0, cold, warm)
    P3 = 1.0 - 3.83e-5 * D + 4.9e-10 * D * D
    water = A3 * P3 * f * f
    return boric, magnesium, water


def absorption(frequency: Array, temperature: Array, salinity: Array, depth: Array, ph: Array = 8.1) -> Array:
    """Absorption [dB/m]: the sum of `francois_garrison`, same arguments."""
    check_frequency(frequency)
    boric, magnesium, water = francois_garrison(frequency, temperature, salinity, depth, ph)
    return (boric + magnesium + water) * 1e-3


def check_frequency(frequency: Any, where: str = "") -> None:
    """Warn (`ValidityWarning`) where a frequency known on the host lies outside the fit; `where` says whose it is."""
    low, high = FREQUENCY_RANGE_HZ
    if isinstance(frequency, int | float) and not low <= frequency <= high:
        subject = f"{where}: absorption" if where else "absorption"
        message = f"{subject} at {frequency:g} Hz: Francois and Garrison's fit covers {low:g} Hz to {high:g} Hz"
        warnings.warn(message, ValidityWarning, stacklevel=3)


def thorp(frequency: Array) -> Array:
    """Absorption [dB/km] at 4 deg C, pH 8 and 900 m, for 100 Hz to 50 kHz; `frequency` [Hz].

    Source: L. M. Brekhovskikh and Y. P. Lysanov, Fundamentals of Ocean Acoustics (3rd ed., 2003), Section 1.1, after
    W. H. Thorp, J. Acoust. Soc. Am. 42, 270 (1967), doi 10.1121/1.1910566.
    """
    f2 = (frequency * 1e-3) ** 2
    return 3.0e-3 + 0.11 * f2 / (1.0 + f2) + 44.0 * f2 / (4100.0 + f2) + 2.75e-4 * f2


def _power10(x: Array) -> Array:
    return dr.exp2(x * 3.321928094887362)


@jit.struct
class LossColumn:
    """Absorption by height in layers, one row a place: a Dr.Jit struct.

    Attributes:
        whole: `Float` rows by `LAYERS` + 1, integral of the absorption over that at the place itself, from the lowest
            layer up to each layer's lower edge [dB].
        lowest, step: `Float`, height of the lowest layer's lower edge over the place and thickness of layers [m].
        here: `Float`, absorption at the place [dB/m].
    """

    whole: Array
    lowest: Array
    step: Array
    here: Array

    @property
    def size_key(self) -> int:
        """Number of rows."""
        return len(self.here)

    def mean(self, row: Array, start: Array, end: Array) -> Array:
        """Mean absorption [dB/m] on straight ways between two heights over the place [m].

        Beyond the column's ends the water is as in its outermost layers.
        """
        rise = end - start
        level = dr.abs(rise) < _LEVEL
        low = dr.select(level, 0.5 * (start + end) - _LEVEL, start)
        high = dr.select(level, low + 2.0 * _LEVEL, end)
        excess = (self._up_to(row, high) - self._up_to(row, low)) / (high - low)
        return excess + self._of_row(self.here, row)

    def _up_to(self, row: Array, height: Array) -> Array:
        place = (height - self._of_row(self.lowest, row)) / self._of_row(self.step, row)
        layer = dr.clip(jit.Int32(dr.floor(place)), 0, LAYERS - 1)
        index = jit.UInt32(layer) + row * (LAYERS + 1)
        below = dr.gather(jit.Float, self.whole, index)
        return dr.fma(place - jit.Float(layer), dr.gather(jit.Float, self.whole, index + 1) - below, below)

    def _of_row(self, values: Array, row: Array) -> Array:
        return values if dr.width(values) == 1 else dr.gather(jit.Float, values, row)


def loss_column(
    loss: Callable[[Array, Array], Array], position: Array, t: Array, low: Array, high: Array
) -> LossColumn:
    """The column over each of some places.

    Args:
        loss: absorption [dB/m] at world places `Array3f64` and times [s].
        position: `Array3f64`, places in memory.
        t: times [s], one or one a place.
        low, high: functions of the height [m]: ends of the column over a place.
    """
    rows = dr.width(position)
    edge = dr.arange(jit.UInt32, rows * (LAYERS + 1))
    row, level = edge // (LAYERS + 1), edge % (LAYERS + 1)
    place = position if rows == 1 else dr.gather(jit.Array3f64, position, row)
    when = dr.gather(jit.Float64, t, row) if dr.width(t) > 1 else t
    bottom = low(place.z)
    step = (high(place.z) - bottom) * (1.0 / LAYERS)
    here = loss(place, when)

    def add(k: Array, total: Array) -> tuple[Array, Array]:
        height = bottom + (jit.Float64(k) + 0.5) * step
        return k + 1, total + (loss(jit.Array3f64(place.x, place.y, place.z + height), when) - here) * step

    start = (dr.zeros(jit.UInt32, dr.width(edge)), dr.zeros(jit.Float64, dr.width(edge)))
    _, whole = dr.while_loop(start, lambda k, _: k < level, add, mode="symbolic", labels=("layer", "whole"))
    lowest = low(position.z)
    return LossColumn(
        jit.Float(whole),
        jit.Float(lowest),
        jit.Float((high(position.z) - lowest) * (1.0 / LAYERS)),
        jit.Float(loss(position, t)),
    )
