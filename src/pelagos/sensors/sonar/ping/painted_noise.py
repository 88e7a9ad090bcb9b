"""Noise painted onto a finished image, for comparison with simulators that have no other.

Source: E. Potokar et al., "HoloOcean: An Underwater Robotics Simulator", ICRA 2022,
doi 10.1109/ICRA46639.2022.9812353, Section IV, and HoloOcean's documentation of its imaging sonar.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.philox import normal_pair32, uniform32
from pelagos.sensors.sonar.ping.ping_spec import Painting

_SQUARE: Final = math.cos(math.radians(8.0))  # sine of the grazing angle within 8 deg of normal incidence
_SHARE: Final = 0.08  # of a beam's rays


def paint(
    noise: Painting, intensity: Array, words: tuple[Array, Array, Array, Array], *, bin_: Array, bin_width: float
) -> Array:
    """Intensity at an exponential error of range and, where noise goes onto it, speckled (see `speckled`).

    Args:
        intensity: of all cells, in memory; bins fastest.
        words: four random `UInt32` a cell.
        bin_: `Int32` of each cell.
        bin_width: [m].
    """
    if noise.range_m > 0.0:
        late = -noise.range_m * dr.log(uniform32(words[3]))
        bins = jit.Int32(dr.round(late / bin_width))
        cell = dr.arange(jit.Int32, dr.width(intensity)) - bins
        shifted = dr.gather(jit.Float, intensity, jit.UInt32(cell), bin_ >= bins)
        intensity = shifted * dr.exp(-late / noise.range_m)
    if noise.onto == "level":
        return intensity
    return speckled(noise, intensity, words, noise.additive * 10.0 ** (noise.additive_reference_db / 10.0))


def speckled(
    noise: Painting, image: Array, words: tuple[Array, Array, Array, Array], additive: float
) -> Array:  # fmt: skip
    """An image times 1 + N(0, multiplicative), plus Rayleigh noise of a scale; nowhere negative."""
    factor, _ = normal_pair32(words[0], words[1])
    rayleigh = dr.sqrt(-2.0 * dr.log(uniform32(words[2])))
    return dr.maximum(image * (1.0 + noise.multiplicative * factor) + additive * rayleigh, 0.0)


def streak_rows(sine: Array, heard: Array, row: Array, rows: int) -> Array:
    """Mask of rows (pings by beams) that have streaks, `Bool`: where enough of their rays meet something squarely.

    Args:
        sine: of the grazing angle, by ray.
        heard: `Bool`, rays that meet something.
        row: `UInt32`, of each ray.
        rows: how many there are; all have as many rays.
    """
    square = dr.zeros(jit.UInt32, rows)
    dr.scatter_add(square, jit.UInt32(1), row, heard & (sine > _SQUARE))
    return square > int(_SHARE * dr.width(row) / rows)


def paint_streaks(noise: Painting, level: Array, streak: Array) -> Array:
    """Levels between 0 and 1, squared (dark) or that of what they lack (bright) where there is a streak."""
    curves: dict[str, Callable[[Array], Array]] = {
        "dark": lambda x: x * x,
        "bright": lambda x: 1.0 - (1.0 - x) * (1.0 - x),
    }
    return dr.select(streak, curves[noise.azimuth_streaks](level), level)
