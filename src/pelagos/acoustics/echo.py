"""From hits to a sonar's signal: a ray is a patch of surface, a patch an echo spread over the bins that it spans.

A ray stands for a stratum of directions (`Strata`). The stratum cuts a strip out of the surface that was hit; its echo
energy is spread over the strip's span of ranges, so that neighbouring strata tile a smooth surface without gaps or
rings whatever the number of rays. Each range bin of a strip is a facet of its own, with its own roughness
(`speckle`) and its own two-way phase.

Sums are fixed-point integers, independent of the order of threads; real and imaginary part share one 64-bit word, 32
bits each, so that a contribution costs two atomic additions.
"""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.acoustics.speckle import facet_amplitude, facet_hash, facet_place
from pelagos.acoustics.target_tag import tag
from pelagos.jit import Array

AMPLITUDE_STEPS: Final = 2.0**20  # per unit amplitude; units are chosen so that a sea bed's echo is about 0.01 to 1
ENERGY_STEPS: Final = 2.0**42  # per unit energy
_LARGEST: Final = 2.0**9  # amplitude of one contribution; their sum stays exact up to 2^11 (+66 dB)
_LARGEST_ENERGY: Final = 2.0**16
_COARSE: Final = 5e-3  # [rad], stratum whose span a strip may be moved by half of, however thin its own is
_BLEND: Final = 0.15  # half width of a strip's edges, in parts of its length


@jit.struct
class Patches:
    """Strips of surface seen by rays, one lane each: a Dr.Jit struct.

    Attributes:
        valid: `Bool`.
        distance: `Float`, to the ray's hit [m].
        near, far: `Float`, the span of ranges of the strip [m].
        energy: `Float`, echo intensity of the whole strip before range losses' gain, in the sonar's unit.
        slide: `Array3f`, way along the surface per metre of range, in the world frame [1].
        direction: `Array3f`, ray direction, world frame.
        label, instance: `UInt32`.
        row: `UInt32`, first bin of the (lane, beam) that the patch belongs to.
    """

    valid: Array
    distance: Array
    near: Array
    far: Array
    energy: Array
    slide: Array
    direction: Array
    label: Array
    instance: Array
    row: Array


def strip_span(
    distance: Array, direction: Array, normal: Array, along: Array, aside: Array, lower: Array, upper: Array,
    longest: Array,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Range span [m] of the strip that a stratum cuts out of a plane, and how a point moves along it.

    The stratum reaches from angle `lower` (negative) to `upper` [rad] about the ray, towards the unit vector `along`.
    On a plane with unit normal n the range at angle a is t (n.d)/(n.(d cos a + u sin a)). Rays of one beam lie off its
    middle by `-aside`; strips longer than what this changes in range are moved to where they lie in the beam's middle,
    so that they tile.

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
    middle = flat / dr.maximum(flat - dr.dot(normal, aside), 1e-4 * flat) * distance - distance
    limit = 0.5 * (far - near) * dr.maximum(_COARSE / (upper - lower), 1.0)
    shift = dr.clip(middle, -limit, limit)
    slope = dr.select(dr.abs(tilt) > 0.02, facing / dr.select(tilt == 0.0, 1.0, tilt), 0.0)
    return near + shift, far + shift, direction - along * slope


def _covered(x: Array, near: Array, far: Array, ramp: Array, inverse: Array) -> Array:
    """Length of `[near, far]` below x; its edges are ramps of half width `ramp`, so that neighbours blend.

    `inverse` is 1/(2 ramp).
    """
    return _ramp(x - near, ramp, inverse) - _ramp(x - far, ramp, inverse)


def _ramp(x: Array, ramp: Array, inverse: Array) -> Array:
    """Integral up to x of a step at 0 that rises linearly over +- `ramp`."""
    s = dr.clip((x + ramp) * inverse, 0.0, 1.0)
    return ramp * s * s + dr.maximum(x - ramp, 0.0)


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
    decay: int,
    tags: bool = False,
    scattered: bool = False,
) -> tuple[Array, Array, Array, Array | None]:
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
        decay: exponent p of the strip's energy density, r^-p.
        tags: also find the strongest echo of each cell.
        scattered: put each facet's scatterer at a random place of its lattice cell instead of the middle, for sonars
            that resolve the lattice.

    Returns:
        real and imaginary amplitude, and energy without interference, `Float` `(cells,)` each; with `tags` the largest
        `tag` of each cell.
    """
    lattice = origin * (1.0 / jit.Float64(facet))
    whole = dr.floor(lattice)
    part = jit.Array3f(lattice - whole)
    base = [jit.Int32(w) for w in whole]
    to_lattice = 1.0 / facet
    hit = part + patches.direction * (patches.distance * to_lattice)

    inverse = 1.0 / bin_width
    start = (patches.near - first_range) * inverse
    stop = dr.maximum((patches.far - first_range) * inverse, start + 1e-2)
    share = patches.energy / (stop - start)
    ramp = _BLEND * (stop - start)
    first = jit.Int32(dr.floor(dr.maximum(start - ramp, 0.0)))
    last = jit.Int32(dr.floor(dr.minimum(stop + ramp, bins - 0.5)))
    inside = patches.valid & (start - ramp < bins) & (stop + ramp > 0.0)

    signal = dr.zeros(jit.UInt64, cells)
    energy = dr.zeros(jit.UInt64, cells)
    strongest = dr.zeros(jit.UInt64, cells) if tags else None

    inverse_ramp = 0.5 / ramp
    below = dr.maximum(_covered(jit.Float(first), start, stop, ramp, inverse_ramp), 0.0)

    def more(b: Array, below: Array) -> Array:
        return inside & (b <= last)

    def add(b: Array, below: Array) -> tuple[Array, Array]:
        low = dr.maximum(start - ramp, jit.Float(b))
        high = dr.minimum(stop + ramp, jit.Float(b) + 1.0)
        reach = first_range + 0.5 * (low + high) * bin_width
        moved = hit + patches.slide * ((reach - patches.distance) * to_lattice)
        cell = dr.floor(moved)
        x, y, z = (base[i] + jit.Int32(cell[i]) for i in range(3))
        word = facet_hash(x, y, z, patches.instance, seed)
        strength, turn = facet_amplitude(word)
        middle = cell - part + (facet_place(word) if scattered else 0.5)
        turn -= dr.norm(middle) * facet * wave_cycles
        sine, cosine = dr.sincos(2.0 * dr.pi * (turn - dr.floor(turn)))
        upto = _covered(jit.Float(b) + 1.0, start, stop, ramp, inverse_ramp)
        power = share * dr.maximum(upto - below, 0.0) * (patches.distance / reach) ** decay
        scaled = dr.minimum(dr.sqrt(power * strength), _LARGEST) * AMPLITUDE_STEPS
        real, imaginary = jit.Int32(scaled * cosine), jit.Int32(scaled * sine)
        word64 = (jit.UInt64(jit.Int64(real)) << 32) + jit.UInt64(jit.Int64(imaginary))
        index = patches.row + jit.UInt32(b)
        dr.scatter_add(signal, word64, index, inside, mode=dr.ReduceMode.Direct)
        dr.scatter_add(
            energy,
            jit.UInt64(dr.minimum(power, _LARGEST_ENERGY) * ENERGY_STEPS),
            index,
            inside,
            mode=dr.ReduceMode.Direct,
        )
        if tags:
            found = tag(power, patches.label, patches.instance)
            dr.scatter_reduce(dr.ReduceOp.Max, strongest, found, index, inside & (power > 0.0))
        return b + 1, upto

    dr.while_loop((first, below), more, add, mode="symbolic", labels=("bin", "covered"))
    low_half = jit.Int32(jit.UInt32(signal & 0xFFFFFFFF))
    high_half = jit.Int32(jit.UInt32((signal - jit.UInt64(jit.Int64(low_half))) >> 32))
    scale = 1.0 / AMPLITUDE_STEPS
    mean = jit.Float(energy) * (1.0 / ENERGY_STEPS)
    return jit.Float(high_half) * scale, jit.Float(low_half) * scale, mean, strongest
