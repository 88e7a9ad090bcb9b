"""The sum of all echoes of a ping: each patch's facets, bin by bin, with their amplitude and phase.

Each beam is summed by lanes of its own (`Walk`), ray after ray and bin after bin. Nothing is added by two threads at
once: sums need no atomic operations, and do not depend on the number of threads or of pings in a call. Lanes that run
side by side wait for the one with most bins; each takes its short strips first and its long ones last, so that they
are alike.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.echo import Patches
from pelagos.acoustics.speckle import facet_amplitude, facet_place, facet_word, lattice_word
from pelagos.acoustics.target_tag import tag
from pelagos.jit import Array
from pelagos.math.quick import cosine_sine

_WALKERS: Final = 16  # lanes that share the rays of sonars of few beams: the width of a vector
_BLEND: Final = 0.04  # half width of a strip's edges, in parts of its length
_CLASSES: Final = 36  # of strips by the number of their bins, four an octave
_SORTED_FROM: Final = 32  # rays of a lane from which sorting them is worth it


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


def pitch(bins: int) -> int:
    """Cells from a beam's row to the next: an odd number of fours, so that rows read together share no cache set."""
    return (-(-bins // 4) | 1) * 4


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


@jit.struct
class _Strips:
    """What the sum needs of each ray's patch, lengths in parts of a bin or of a facet: a Dr.Jit struct.

    Attributes:
        low, high: edges [bins]; they blend with their neighbours' over +- `_BLEND` of the length.
        first, last: `Int32`, bins that it touches; last < first: none.
        share: energy per bin at 1 m, before the fall with range.
        distance: of the hit [m].
        hit: `Array3f`, from the lattice point below the sonar [facets].
        slide: `Array3f`, way along the surface [facets per metre].
        base: `UInt32`, word of the lattice point below the sonar, of the instance and the seed.
    """

    low: Array
    high: Array
    first: Array
    last: Array
    share: Array
    distance: Array
    hit: Array
    slide: Array
    base: Array


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
        for each cell of pings x beams x `pitch(bins)` four `Float`: real and imaginary amplitude, energy without
        interference, and nothing; with `tags` the largest `tag` of each cell.
    """
    lattice = origin * (1.0 / facet)
    whole = dr.floor(lattice)
    part = jit.Array3f(lattice - whole)
    strips = _strips(patches, walk, part, whole, pings, bins, first_range, bin_width, facet, seed, decay)
    dr.eval(strips, patches.label, patches.instance)

    walkers = walk.beams * walk.parts
    lane = dr.arange(jit.UInt32, pings * walkers)
    ping, walker = lane // walkers, lane % walkers
    part = dr.gather(jit.Array3f, part, ping)
    turns = dr.gather(jit.Float, wave_cycles, ping) * facet
    size = pings * walk.beams * pitch(bins)
    row = (walker % walk.parts) * size + (ping * walk.beams + walker // walk.parts) * pitch(bins)

    def listed(step: Array) -> tuple[Array, Array]:
        ray = dr.gather(jit.UInt32, order, step * walkers + walker)
        return ray + ping * walk.fan, ray < walk.fan

    sorted_rays = _by_length(strips, listed, walk.steps, pings * walkers) if walk.steps >= _SORTED_FROM else None

    def taken(step: Array) -> tuple[Array, Array]:
        if sorted_rays is None:
            return listed(step)
        ray = dr.gather(jit.UInt32, sorted_rays, step * (pings * walkers) + lane)
        return ray, ray < pings * walk.fan

    field = dr.zeros(jit.Float, 4 * size * walk.parts)
    strongest = dr.zeros(jit.UInt64, size * walk.parts) if tags else None
    owned = dr.ReduceMode.NoConflicts

    def visit(step: Array) -> tuple[Array]:
        ray, exists = taken(step)
        strip = _Strips(**{name: dr.gather(type(v), v, ray, exists) for name, v in vars(strips).items()})
        label, instance = (dr.gather(jit.UInt32, v, ray, exists) for v in (patches.label, patches.instance))
        edge = _BLEND * (strip.high - strip.low)
        inverse = 0.5 / edge
        begin, end = strip.low - edge, strip.high + edge
        below = dr.maximum(_covered(jit.Float(strip.first), strip.low, strip.high, edge, inverse), 0.0)
        last = dr.select(exists, strip.last, -1)

        def add(b: Array, below: Array) -> tuple[Array, Array]:
            floor = jit.Float(b)
            near, far = dr.maximum(begin, floor), dr.minimum(end, floor + 1.0)
            reach = dr.fma(0.5 * bin_width, near + far, first_range)
            moved = dr.fma(strip.slide, reach - strip.distance, strip.hit)
            cell = dr.floor(moved)
            word = facet_word(strip.base, cell)
            strength, turn = facet_amplitude(word)
            middle = cell - part + (facet_place(word) if scattered else 0.5)
            cosine, sine = cosine_sine(dr.fma(-turns, dr.norm(middle), turn))
            upto = _covered(floor + 1.0, strip.low, strip.high, edge, inverse)
            power = strip.share * dr.maximum(upto - below, 0.0)
            fallen = power * (1.0 / reach) ** decay if decay else power
            amplitude = dr.sqrt(fallen * strength)
            index = row + jit.UInt32(b)
            value = jit.Array4f(amplitude * cosine, amplitude * sine, fallen, 0.0)
            dr.scatter_add(field, value, index, mode=owned)
            if tags:
                found = tag(fallen, label, instance)
                dr.scatter_reduce(dr.ReduceOp.Max, strongest, found, index, fallen > 0.0, mode=owned)
            return b + 1, upto

        state = (strip.first, below)
        dr.while_loop(state, lambda b, _: b <= last, add, mode="symbolic", labels=("bin", "covered"))
        return (step + 1,)

    dr.while_loop((dr.zeros(jit.UInt32, pings * walkers),), lambda step: step < walk.steps, visit, mode="symbolic")
    if walk.parts > 1:
        field = _joined(field, 4 * size, walk.parts)
        if tags:
            cell = dr.arange(jit.UInt32, size)
            parts = [dr.gather(jit.UInt64, strongest, cell + k * size) for k in range(walk.parts)]
            strongest = functools.reduce(dr.maximum, parts)
    return field, strongest


def _strips(
    patches: Patches, walk: Walk, part: Array, whole: Array, pings: int, bins: int, first_range: float,
    bin_width: float, facet: float, seed: Array, decay: int,
) -> _Strips:  # fmt: skip
    """Patches in units of bins and facets; `part` and `whole` of the sonar's place by ping [facets]."""
    low = (patches.near - first_range) * (1.0 / bin_width)
    high = dr.maximum((patches.far - first_range) * (1.0 / bin_width), low + 1e-2)
    ping = dr.arange(jit.UInt32, pings * walk.fan) // walk.fan
    base = lattice_word(dr.gather(jit.Array3f64, whole, ping), patches.instance, seed)
    middle = dr.sqrt(dr.maximum(patches.near * patches.far, 1e-6))  # of which r^-2 has the mean over the strip
    share = dr.select(patches.valid, patches.energy / (high - low), 0.0) * middle**decay
    edge = _BLEND * (high - low)
    heard = (share > 0.0) & (low - edge < bins) & (high + edge > 0.0)
    return _Strips(
        low=low,
        high=high,
        first=jit.Int32(dr.maximum(low - edge, 0.0)),
        last=dr.select(heard, jit.Int32(dr.minimum(high + edge, bins - 0.5)), -1),
        share=share,
        distance=patches.distance,
        hit=dr.gather(jit.Array3f, part, ping) + patches.direction * (patches.distance * (1.0 / facet)),
        slide=patches.slide * (1.0 / facet),
        base=base,
    )


def _by_length(strips: _Strips, rays: Callable[[Array], tuple[Array, Array]], steps: int, lanes: int) -> Array:
    """Rays by step and lane as `rays` gives them by step, each lane's sorted by the class of their strips' lengths.

    Rays of the same class keep their order.
    """
    lane = dr.arange(jit.UInt32, lanes)
    place = dr.alloc_local(jit.UInt32, _CLASSES, value=jit.UInt32(0))

    def length_class(ray: Array, exists: Array) -> Array:
        first, last = dr.gather(jit.Int32, strips.first, ray, exists), dr.gather(jit.Int32, strips.last, ray, exists)
        count = jit.Float(dr.maximum(last - first + 1, 1))
        return dr.minimum((dr.reinterpret_array(jit.UInt32, count) >> 21) - 4 * 127, _CLASSES - 1)

    def tally(step: Array, place: Array) -> tuple[Array, Array]:
        which = length_class(*rays(step))
        place[which] = place[which] + 1
        return step + 1, place

    def put(step: Array, place: Array) -> tuple[Array, Array]:
        ray, exists = rays(step)
        which = length_class(ray, exists)
        at = place[which]
        dr.scatter(order, ray, at * lanes + lane, mode=dr.ReduceMode.Permute)
        place[which] = at + 1
        return step + 1, place

    start = dr.zeros(jit.UInt32, lanes)
    _, place = dr.while_loop((start, place), lambda step, _: step < steps, tally, mode="symbolic")
    below = jit.UInt32(0)
    for which in range(_CLASSES):
        here = place[which]
        place[which] = below
        below = below + here
    order = dr.zeros(jit.UInt32, steps * lanes)
    dr.while_loop((start, place), lambda step, _: step < steps, put, mode="symbolic")
    return order


def _covered(x: Array, near: Array, far: Array, ramp: Array, inverse: Array) -> Array:
    """Length of `[near, far]` below x; its edges are ramps of half width `ramp`, so that neighbours blend.

    `inverse` is 1/(2 ramp).
    """
    return _ramp(x - near, ramp, inverse) - _ramp(x - far, ramp, inverse)


def _ramp(x: Array, ramp: Array, inverse: Array) -> Array:
    """Integral up to x of a step at 0 that rises linearly over +- `ramp`."""
    s = dr.clip((x + ramp) * inverse, 0.0, 1.0)
    return ramp * s * s + dr.maximum(x - ramp, 0.0)


def _joined(values: Array, size: int, parts: int) -> Array:
    """The sum of the walkers' parts, in their order."""
    cell = dr.arange(jit.UInt32, size)
    total = jit.Float(0)
    for k in range(parts):
        total += dr.gather(jit.Float, values, cell + k * size)
    return total
