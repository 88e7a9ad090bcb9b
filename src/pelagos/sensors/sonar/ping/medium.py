"""Water at a sonar: sound speed and absorption, and how they change above and below it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import drjit as dr

from pelagos import jit
from pelagos.acoustics.absorption import LossColumn, absorption, check_frequency, loss_column
from pelagos.acoustics.refraction import LEVELS, Profile, profile_from
from pelagos.jit import Array

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean


@jit.struct
class Medium:
    """Water at the sonar, one lane a copy and tick, `Float` each: a Dr.Jit struct.

    Attributes:
        sound_speed: c [m/s].
        absorption: [dB/m].
        column: absorption above and below; None: the same everywhere.
    """

    sound_speed: Array
    absorption: Array
    column: LossColumn | None = None

    def mean_loss(self, row: Array, start: Array, end: Array) -> Array:
        """Mean absorption [dB/m] along straight ways from a height `start` to `end`, relative to the sonar's [m]."""
        return spread(self.absorption, row) if self.column is None else self.column.mean(row, start, end)


def medium_of(
    frequency_hz: float, ph: float, where: str = "", *, reach: float = 0.0, bottom: float = 0.0
) -> Callable[[Ocean, Array, Array], Medium]:
    """A function (ocean, position, t) -> `Medium` for a sonar of that frequency, to be frozen; `where` names it.

    Args:
        frequency_hz: [Hz].
        ph: acidity.
        where: path of the sonar.
        reach: how far its rays go [m]; 0: only the water at the sonar counts.
        bottom: height of the deepest ground [m].
    """
    check_frequency(frequency_hz, where)

    def medium(ocean: Ocean, position: Array, t: Array) -> Medium:
        def loss(place: Array, when: Array) -> Array:
            temperature, salinity = ocean.temperature(place, when), ocean.salinity(place, when)
            return absorption(jit.Float64(frequency_hz), temperature, salinity, dr.maximum(-place[2], 0.0), ph)

        speed = jit.Float(ocean.sound_speed(position, t))
        if reach <= 0.0:
            return Medium(speed, jit.Float(loss(position, t)))
        dr.eval(position)
        ends = (partial(lowest, reach=reach, bottom=bottom), partial(highest, reach=reach))
        column = loss_column(loss, position, t, *ends)
        return Medium(speed, column.here, column)

    return medium


def profile_of(ocean: Ocean, position: Array, t: Array, *, reach: float, bottom: float) -> Profile:
    """Sound speed above and below each place, from the surface or `reach` [m] above it down to as far below.

    `bottom` is the height of the deepest ground [m]: there is no water below it.
    """
    top, low = highest(position[2], reach), lowest(position[2], reach, bottom)
    step = (top - low) * (1.0 / (LEVELS - 1))
    dr.eval(low, step)
    level = dr.arange(jit.UInt32, dr.width(position) * LEVELS)
    row = level // LEVELS
    height = dr.gather(jit.Float64, low, row) + dr.gather(jit.Float64, step, row) * jit.Float64(level % LEVELS)
    x, y, z = (dr.gather(jit.Float64, p, row) for p in position)
    when = dr.gather(jit.Float64, t, row) if dr.width(t) > 1 else t
    here = ocean.sound_speed(position, t)
    excess = ocean.sound_speed(jit.Array3f64(x, y, z + height), when) - dr.gather(jit.Float64, here, row)
    made = jit.Float(excess)
    dr.eval(made)
    return profile_from(made, jit.Float(here), jit.Float(low), jit.Float(step))


def highest(z: Array, reach: float) -> Array:
    """Top of the water over a height, or how far up rays reach [m]."""
    return dr.minimum(jit.Float64(reach), dr.maximum(-z, 0.0) + 1.0)


def lowest(z: Array, reach: float, bottom: float) -> Array:
    """The deepest ground under a height, or how far down rays reach [m], negative."""
    return -dr.minimum(jit.Float64(reach), dr.maximum(z - bottom, 0.0) + 1.0)


def spread(values: Array, row: Array) -> Array:
    """Values of rows; of the only one without looking it up, which is what a single sonar's rays would spend their
    time on."""
    return values if dr.width(values) == 1 else dr.gather(type(values), values, row)
