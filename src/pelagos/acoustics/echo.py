"""From hits to a sonar's signal: a ray is a patch of surface, a patch an echo spread over the bins that it spans.

A ray stands for a stratum of directions (`Strata`). The stratum cuts a strip out of the surface that was hit; its echo
energy is spread over the strip's span of ranges, so that neighbouring strata tile a smooth surface without gaps or
rings whatever the number of rays. Each range bin of a strip is a facet of its own, with its own roughness
(`speckle`) and its own two-way phase.

Sums are fixed-point 64-bit integers: independent of the order of threads.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.acoustics.speckle import facet_amplitude, facet_hash
from pelagos.jit import Array

FIXED_POINT: Final = 2.0**30  # steps per unit amplitude; units are chosen so that echoes are around 1
_LARGEST: Final = 2.0**30  # |amplitude| of one contribution: 2^33 of them would be needed to overflow


@dataclass
class Patches:
    """Strips of surface seen by rays, one lane each: a Dr.Jit struct.

    Attributes:
        valid: `Bool`.
        distance: `Float`, to the ray's hit [m].
        near, far: `Float`, the span of ranges of the strip [m].
        energy: `Float`, echo intensity of the whole strip before range losses' gain, in the sonar's unit.
        slide: `Array3f`, way along the surface per metre of range, in the world frame [1].
        direction: `Array3f`, ray direction, world frame.
        instance: `UInt32`.
        row: `UInt32`, first bin of the (lane, beam) that the patch belongs to.
    """

    valid: Array
    distance: Array
    near: Array
    far: Array
    energy: Array
    slide: Array
    direction: Array
    instance: Array
    row: Array


def strip_span(
    distance: Array, direction: Array, normal: Array, along: Array, lower: Array, upper: Array, longest: Array
) -> tuple[Array, Array, Array]:
    """Range span [m] of the strip that a stratum cuts out of a plane, and how a point moves along it.

    The stratum reaches from angle `lower` (negative) to `upper` [rad] about the ray, towards the unit vector `along`.
    On a plane with unit normal n the range at angle a is t (n.d)/(n.(d cos a + u sin a)).

    Returns:
        near [m], far [m], and `Array3f` slide [1]: displacement on the plane per metre of range.
    """
    facing = -dr.dot(normal, direction)
    tilt = -dr.dot(normal, along)
    flat = dr.maximum(facing, 1e-4)
    reach_low = flat / dr.maximum(flat * dr.cos(lower) + tilt * dr.sin(lower), 1e-4 * flat)
    reach_up = flat / dr.maximum(flat * dr.cos(upper) + tilt * dr.sin(upper), 1e-4 * flat)
    near = dr.minimum(reach_low, reach_up) * distance
    far = dr.maximum(reach_low, reach_up) * distance
    near, far = dr.maximum(near, distance - longest), dr.minimum(far, distance + longest)
    slope = dr.select(dr.abs(tilt) > 0.02, facing / dr.select(tilt == 0.0, 1.0, tilt), 0.0)
    return near, far, direction - along * slope


def accumulate(
    patches: Patches,
    *,
    bins: int,
    cells: int,
    first_range: Array,
    bin_width: Array,
    wave_cycles: Array,
    origin: Array,
    facet: Array,
    seed: Array,
    decay: Array,
) -> tuple[Array, Array, Array]:
    """Sum the echoes of all patches into range bins.

    Args:
        patches: see `Patches`.
        bins: range bins of a beam.
        cells: size of the result, lanes x beams x bins.
        first_range, bin_width: near edge of the first bin [m], width of a bin [m].
        wave_cycles: 2 f/c, cycles of phase per metre of range [1/m].
        origin: `Array3f64` sensor position by patch, world [m].
        facet: edge of the lattice of facets [m].
        seed: `UInt32` of the roughness.
        decay: `Float`: exponent p of the strip's energy density, r^-p.

    Returns:
        real and imaginary amplitude, and energy without interference, `Float` `(cells,)` each.
    """
    lattice = origin * (1.0 / jit.Float64(facet))
    whole = dr.floor(lattice)
    part = jit.Array3f(lattice - whole)
    base = [jit.Int32(w) for w in whole]
    to_lattice = 1.0 / facet
    hit = part + patches.direction * (patches.distance * to_lattice)

    inverse = 1.0 / bin_width
    start = (patches.near - first_range) * inverse
    stop = dr.maximum((patches.far - first_range) * inverse, start + 1e-3)
    first = jit.Int32(dr.floor(dr.maximum(start, 0.0)))
    last = jit.Int32(dr.floor(dr.minimum(stop, bins - 0.5)))
    share = patches.energy / (stop - start)
    inside = patches.valid & (start < bins) & (stop > 0.0)

    real = dr.zeros(jit.UInt64, cells)
    imaginary = dr.zeros(jit.UInt64, cells)
    energy = dr.zeros(jit.UInt64, cells)

    def more(b: Array) -> Array:
        return inside & (b <= last)

    def add(b: Array) -> tuple[Array]:
        low = dr.maximum(start, jit.Float(b))
        high = dr.minimum(stop, jit.Float(b) + 1.0)
        reach = first_range + 0.5 * (low + high) * bin_width
        moved = hit + patches.slide * ((reach - patches.distance) * to_lattice)
        cell = dr.floor(moved)
        x, y, z = (base[i] + jit.Int32(cell[i]) for i in range(3))
        word = facet_hash(x, y, z, patches.instance, seed)
        a, b_ = facet_amplitude(word)
        path = dr.norm(cell + 0.5 - part) * facet * wave_cycles
        s, c = dr.sincos(2.0 * dr.pi * (path - dr.floor(path)))
        power = share * dr.maximum(high - low, 0.0) * (patches.distance / reach) ** decay
        size = dr.minimum(dr.sqrt(power), _LARGEST) * FIXED_POINT
        index = patches.row + jit.UInt32(b)
        dr.scatter_add(real, jit.UInt64(jit.Int64(size * (a * c + b_ * s))), index, inside)
        dr.scatter_add(imaginary, jit.UInt64(jit.Int64(size * (b_ * c - a * s))), index, inside)
        dr.scatter_add(energy, jit.UInt64(dr.minimum(power, _LARGEST) * FIXED_POINT), index, inside)
        return (b + 1,)

    dr.while_loop((first,), more, add, mode="symbolic", labels=("bin",))
    scale = 1.0 / FIXED_POINT
    return (
        jit.Float(jit.Int64(real)) * scale,
        jit.Float(jit.Int64(imaginary)) * scale,
        jit.Float(energy) * scale,
    )
