"""The strips of a ping's patches: where each begins and ends in range bins, and how much of it lies in a bin."""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.acoustics.echo import Patches
from pelagos.jit import Array
from pelagos.math.quick import larger, smaller

BLEND: Final = 0.04  # half width of a strip's edges, in parts of its length
_LENGTH: Final = 0.5 / BLEND  # of a strip, in widths of its edges


@jit.struct
class Strips:
    """Spans of range with their energies, one lane a ray: a Dr.Jit struct.

    Attributes:
        begin: near end of the ramp at the near edge [bins].
        length: between the middles of the ramps [bins]; 0 where nothing is heard.
        share: energy per ramp's length at 1 m, before the fall with range.
    """

    begin: Array
    length: Array
    share: Array

    @property
    def end(self) -> Array:
        """Far end of the ramp at the far edge [bins]."""
        return dr.fma(1.0 + 2.0 * BLEND, self.length, self.begin)

    @property
    def steepness(self) -> Array:
        """Of the ramps at its edges [1/bin], see `covered`."""
        return _LENGTH / self.length


def strips_of(patches: Patches, *, bins: int, first_range: float, bin_width: float) -> Strips:
    """Patches in bins from `first_range` on, of `bin_width` [m] each."""
    low = (patches.near - first_range) * (1.0 / bin_width)
    length = larger((patches.far - first_range) * (1.0 / bin_width) - low, 1e-2)
    fall = larger(patches.near * patches.far, 1e-6)  # 1 / mean of r^-2 over the strip
    share = dr.select(patches.valid, patches.energy, 0.0) * fall * (1.0 / _LENGTH)
    begin = low - BLEND * length
    heard = (share > 0.0) & (begin < bins) & (low + (1.0 + BLEND) * length > 0.0)
    return Strips(begin=begin, length=dr.select(heard, length, 0.0), share=share)


def covered(x: Array, begin: Array, steepness: Array) -> Array:
    """Length of a strip below x, in widths of the ramps at its edges, 1 / `steepness` bins each, where neighbours
    blend."""
    t = (x - begin) * steepness
    return _ramp(t) - _ramp(t - _LENGTH)


def _ramp(t: Array) -> Array:
    """Integral up to t of a step that rises linearly from 0 to 1."""
    s = larger(smaller(t, 1.0), 0.0)
    return s * dr.fma(-0.5, s, t)
