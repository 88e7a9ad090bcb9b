"""Roughness that belongs to a place: the same facet answers with the same complex amplitude whenever it is seen.

A resolution cell holds many unresolved scatterers, so that each facet's amplitude is complex Gaussian (J. W. Goodman,
Speckle Phenomena in Optics, 2nd ed. 2020, Section 3.1). Facets are cells of a world-fixed lattice; their amplitude is
a hash of the cell, of the object that they belong to and of a seed. Speckle therefore stands still while the sonar
does, and changes when it moves to see other facets, or the same ones at other distances.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.philox import uniform32
from pelagos.math.quick import larger

_NARROWEST: Final = 1e-4  # [facets], of a ray's cell
_PRIME_X: Final = 0x8DA6B343
_PRIME_Y: Final = 0xD8163841
_PRIME_Z: Final = 0xCB1AB31F
_PRIME_O: Final = 0x9E3779B1


def lattice_word(point: Sequence[Array], seed: Array) -> Array:
    """A `UInt32` for the lattice point `point`; `facet_word` goes on from it, by way of `on_instance`."""
    return _mixed(point) + scramble(seed)


def on_instance(word: Array, instance: Array) -> Array:
    """The word of a lattice point for the surface of an object."""
    return word + instance * _PRIME_O


def facet_word(base: Array, cell: Array) -> Array:
    """A random `UInt32` for a lattice cell: `cell`, `Array3f` of whole numbers, is counted from the point of `base`.

    `complex_normal32` makes the facet's amplitude of it.
    """
    return scramble(base + _mixed(cell))


def _mixed(point: Sequence[Array]) -> Array:
    """Lattice point -> word; that of a sum of points is the sum of theirs."""
    x, y, z = (jit.UInt32(jit.Int32(p)) for p in point)
    return x * _PRIME_X + y * _PRIME_Y + z * _PRIME_Z


def scramble(h: Array) -> Array:
    """A bijection of `UInt32` in which every input bit flips half of the output bits.

    Source: the finaliser of MurmurHash3 (A. Appleby, public domain).
    """
    h = (h ^ (h >> 16)) * 0x85EBCA6B
    h = (h ^ (h >> 13)) * 0xC2B2AE35
    return h ^ (h >> 16)


def rays_per_facet(width: Array, length: Array, *, single_file: bool = False) -> Array:
    """Number of rays that meet the facet that a ray meets, itself included: c, by which they amplify each other.

    Rays denser than the lattice meet one facet, whose amplitude they add in phase: of n with the energy e each, the
    intensity is n^2 e, not n e. Amplitudes made of e/c leave the mean of the intensity that of the energy if

        c = E[n^2] / E[n]

    over where the lattice lies. Rays stand at random places of cells that tile the surface, w facets wide and l long. A
    window of one facet's width sees w < 1 in whole cells, of one ray each, and cuts one at either end at an evenly
    distributed place, of which it has the part u with the variance u(1-u): E[u(1-u)] = 1/6, from both ends 1/3. Hence
    E[n] = 1/w and E[n^2] = 1/w^2 + 1/3. Where w > 1 a border of cells lies in the window with the probability 1/w,
    and only there it can see two rays: E[n^2] = 1/w + 1/(3 w^3). For one row of cells therefore

        c1 = 1/w + w/3 where w < 1, and 1 + 1/(3 w^2) where w >= 1.

    A facet sees max(1/l, 1) rows, those besides the ray's own with 1/w rays each, independent of it:

        c = c1(w) + (max(1/l, 1) - 1)/w.

    With `single_file` a row has one ray, anywhere in w. The next row's is in the same window with the probability
    E[max(1 - |d|, 0)] for two even places d apart, p = 1 - w/3 where w < 1, else 1/w - 1/(3 w^2):

        c = 1 + (max(1/l, 1) - 1) p.

    Args:
        width, length: w and l [facets], `Float`.
        single_file: see above; w is then the width in which the rays of a beam lie.
    """
    width, length = larger(width, _NARROWEST), larger(length, _NARROWEST)
    other_rows = larger(1.0 / length, 1.0) - 1.0
    others = 1.0 / width
    if single_file:
        pair = dr.select(width < 1.0, dr.fma(width, -1.0 / 3.0, 1.0), others * dr.fma(others, -1.0 / 3.0, 1.0))
        return dr.fma(other_rows, pair, 1.0)
    row = dr.select(width < 1.0, dr.fma(width, 1.0 / 3.0, others), dr.fma(others, others * (1.0 / 3.0), 1.0))
    return dr.fma(other_rows, others, row)


def facet_place(word: Array) -> Array:
    """Place of a facet's scatterer in its lattice cell, `Array3f`, each in (0, 1)."""
    return jit.Array3f(*(uniform32(scramble(word ^ k)) for k in (_PRIME_X, _PRIME_Y, _PRIME_Z)))


def patchiness(x: Array, y: Array, *, seed: Array, scale: float) -> Array:
    """Smooth random field of the horizontal place, mean 0, about -1 to 1: two octaves of value noise.

    Args:
        x, y: world [m], `Float`.
        seed: `UInt32`.
        scale: length of the coarser octave [m]; the finer one has a quarter of it.
    """
    return 0.65 * _value_noise(x / scale, y / scale, seed) + 0.35 * _value_noise(4 * x / scale, 4 * y / scale, seed + 1)


def _value_noise(x: Array, y: Array, seed: Array) -> Array:
    """Bilinear interpolation, smoothed at the nodes, of uniform random values in (-1, 1) on the integers."""
    floor_x, floor_y = dr.floor(x), dr.floor(y)
    fx, fy = x - floor_x, y - floor_y
    fx, fy = fx * fx * (3 - 2 * fx), fy * fy * (3 - 2 * fy)
    ix, iy = jit.Int32(floor_x), jit.Int32(floor_y)

    def node(dx: int, dy: int) -> Array:
        h = jit.UInt32(ix + dx) * _PRIME_X ^ jit.UInt32(iy + dy) * _PRIME_Y ^ seed
        return 2.0 * uniform32(scramble(h)) - 1.0

    low = dr.lerp(node(0, 0), node(1, 0), fx)
    return dr.lerp(low, dr.lerp(node(0, 1), node(1, 1), fx), fy)
