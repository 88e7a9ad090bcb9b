"""From hits to a sonar's signal: a ray is a patch of surface, a patch an echo spread over the bins that it spans.

A ray stands for a stratum of directions (`Strata`). The stratum cuts a strip out of the surface that was hit; its echo
energy is spread over the strip's span of ranges, so that neighbouring strata tile a smooth surface without gaps or
rings whatever the number of rays. Each range bin of a strip is a facet of its own, with its own roughness
(`speckle`) and its own two-way phase.

Each beam is summed by lanes of its own (`Walk`), ray after ray and bin after bin. Nothing is added by two threads at
once: sums need no atomic operations, and do not depend on the number of threads or of pings in a call.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.speckle import facet_amplitude, facet_hash, facet_place
from pelagos.acoustics.target_tag import tag
from pelagos.jit import Array

_WALKERS: Final = 16  # lanes that share the rays of sonars of few beams: the width of a vector
_COARSE: Final = 5e-3  # [rad], stratum whose span a strip may be moved by half of, however thin its own is
_BLEND: Final = 0.15  # half width of a strip's edges, in parts of its length


@jit.struct
class Patches:
    """Strips of surface seen by rays, one lane a ray (pings by fans): a Dr.Jit struct.

    Attributes:
        valid: `Bool`.
        distance: `Float`, to the ray's hit [m].
        near, far: `Float`, the span of ranges of the strip [m].
        energy: `Float`, echo intensity of the whole strip before range losses' gain, in the sonar's unit.
        slide: `Array3f`, way along the surface per metre of range, in the world frame [1].
        direction: `Array3f`, ray direction, world frame.
        label, instance: `UInt32`.
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


@dataclass(frozen=True)
class Walk:
    """Who sums which rays: walkers, `beams` times `parts` of them with parts fastest, take a ray each in every step.

    Attributes:
        order: `(steps * walkers,)`, row of the fan's ray by step and walker; `fan` where there is none.
        beams, parts, steps, fan: their numbers, and that of the rays of a fan.
    """

    order: NDArray[np.uint32]
    beams: int
    parts: int
    steps: int
    fan: int


def walk(beam: NDArray[np.integer], beams: int) -> Walk:
    """The walk over a fan whose rays belong to the beams `beam` `(r,)`, as many rays to each.

    The parts of a beam take turns, so that rays read together lie together.
    """
    rays = len(beam) // beams
    parts = max(_WALKERS // beams, 1)
    steps = -(-rays // parts)
    table = np.full((beams, steps * parts), len(beam), dtype=np.uint32)
    table[:, :rays] = np.argsort(beam, kind="stable").reshape(beams, rays)
    order = np.ascontiguousarray(table.reshape(beams, steps, parts).transpose(1, 0, 2)).ravel()
    return Walk(order, beams, parts, steps, len(beam))


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
    walk: Walk,
    order: Array,
    *,
    pings: int,
    bins: int,
    first_range: float,
    bin_width: float,
    wave_cycles: Array,
    origin: Array,
    facet: float,
    seed: Array,
    decay: int,
    tags: bool = False,
    scattered: bool = False,
) -> tuple[Array, Array | None]:
    """Sum the echoes of all patches into range bins.

    Args:
        patches: see `Patches`.
        walk, order: see `Walk`; `order` is its table on the device.
        pings: how many fans the patches are of.
        bins: range bins of a beam.
        first_range, bin_width: near edge of the first bin [m], width of a bin [m].
        wave_cycles: 2 f/c, cycles of phase per metre of range by ping [1/m].
        origin: `Array3f64` sensor position by ping, world [m].
        facet: edge of the lattice of facets [m].
        seed: `UInt32` of the roughness.
        decay: exponent p of the strip's energy density, r^-p.
        tags: also find the strongest echo of each cell.
        scattered: put each facet's scatterer at a random place of its lattice cell instead of the middle, for sonars
            that resolve the lattice.

    Returns:
        for each cell of pings x beams x bins four `Float`: real and imaginary amplitude, energy without interference,
        and nothing; with `tags` the largest `tag` of each cell.
    """
    start = (patches.near - first_range) * (1.0 / bin_width)
    stop = dr.maximum((patches.far - first_range) * (1.0 / bin_width), start + 1e-2)
    share = dr.select(patches.valid, patches.energy / (stop - start), 0.0)
    towards = patches.direction * (patches.distance * (1.0 / facet))
    dr.eval(start, stop, share, towards, patches.distance, patches.slide, patches.instance)
    if tags:
        dr.eval(patches.label)

    walkers = walk.beams * walk.parts
    lane = dr.arange(jit.UInt32, pings * walkers)
    ping, walker = lane // walkers, lane % walkers
    lattice = dr.gather(jit.Array3f64, origin, ping) * (1.0 / facet)
    whole = dr.floor(lattice)
    part = jit.Array3f(lattice - whole)
    base = [jit.UInt32(jit.Int32(w)) for w in whole]
    turns = dr.gather(jit.Float, wave_cycles, ping) * facet
    size = pings * walk.beams * bins
    row = (walker % walk.parts) * size + (ping * walk.beams + walker // walk.parts) * bins

    field = dr.zeros(jit.Float, 4 * size * walk.parts)
    strongest = dr.zeros(jit.UInt64, size * walk.parts) if tags else None
    owned = dr.ReduceMode.NoConflicts

    def visit(step: Array) -> tuple[Array]:
        ray = dr.gather(jit.UInt32, order, step * walkers + walker)
        exists = ray < walk.fan
        ray = ray + ping * walk.fan
        low, high = dr.gather(jit.Float, start, ray, exists), dr.gather(jit.Float, stop, ray, exists)
        amount = dr.gather(jit.Float, share, ray, exists)
        away = dr.gather(jit.Float, patches.distance, ray, exists)
        hit = part + dr.gather(jit.Array3f, towards, ray, exists)
        slide = dr.gather(jit.Array3f, patches.slide, ray, exists) * (1.0 / facet)
        instance = dr.gather(jit.UInt32, patches.instance, ray, exists)
        label = dr.gather(jit.UInt32, patches.label, ray, exists) if tags else None
        edge = _BLEND * (high - low)
        inverse = 0.5 / edge
        first = jit.Int32(dr.maximum(low - edge, 0.0))
        last = jit.Int32(dr.minimum(high + edge, bins - 0.5))
        last = dr.select((amount > 0.0) & (low - edge < bins) & (high + edge > 0.0), last, -1)
        below = dr.maximum(_covered(jit.Float(first), low, high, edge, inverse), 0.0)

        def add(b: Array, below: Array) -> tuple[Array, Array]:
            near = dr.maximum(low - edge, jit.Float(b))
            far = dr.minimum(high + edge, jit.Float(b) + 1.0)
            reach = dr.fma(0.5 * bin_width, near + far, first_range)
            moved = dr.fma(slide, reach - away, hit)
            cell = dr.floor(moved)
            x, y, z = (base[i] + jit.UInt32(jit.Int32(cell[i])) for i in range(3))
            word = facet_hash(x, y, z, instance, seed)
            strength, turn = facet_amplitude(word)
            middle = cell - part + (facet_place(word) if scattered else 0.5)
            turn -= dr.norm(middle) * turns
            sine, cosine = dr.sincos(2.0 * dr.pi * (turn - dr.floor(turn)))
            upto = _covered(jit.Float(b) + 1.0, low, high, edge, inverse)
            power = amount * dr.maximum(upto - below, 0.0) * (away / reach) ** decay
            size = dr.sqrt(power * strength)
            index = row + jit.UInt32(b)
            dr.scatter_add(field, jit.Array4f(size * cosine, size * sine, power, 0.0), index, mode=owned)
            if tags:
                found = tag(power, label, instance)
                dr.scatter_reduce(dr.ReduceOp.Max, strongest, found, index, power > 0.0, mode=owned)
            return b + 1, upto

        dr.while_loop((first, below), lambda b, _: b <= last, add, mode="symbolic", labels=("bin", "covered"))
        return (step + 1,)

    dr.while_loop((dr.zeros(jit.UInt32, pings * walkers),), lambda step: step < walk.steps, visit, mode="symbolic")
    if walk.parts > 1:
        field = _joined(field, 4 * size, walk.parts)
        if tags:
            cell = dr.arange(jit.UInt32, size)
            parts = [dr.gather(jit.UInt64, strongest, cell + k * size) for k in range(walk.parts)]
            strongest = functools.reduce(dr.maximum, parts)
    return field, strongest


def _joined(values: Array, size: int, parts: int) -> Array:
    """The sum of the walkers' parts, in their order."""
    cell = dr.arange(jit.UInt32, size)
    total = jit.Float(0)
    for k in range(parts):
        total += dr.gather(jit.Float, values, cell + k * size)
    return total
