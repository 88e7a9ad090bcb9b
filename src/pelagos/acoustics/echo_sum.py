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
from pelagos.acoustics.speckle import facet_place, facet_word, lattice_word, on_instance, rays_per_facet
from pelagos.acoustics.target_tag import tag
from pelagos.jit import Array
from pelagos.math.philox import complex_normal32
from pelagos.math.quick import cosine_sine, larger, smaller

_WALKERS: Final = 16  # lanes that share the rays of sonars of few beams: the width of a vector
_BLEND: Final = 0.04  # half width of a strip's edges, in parts of its length
_LENGTH: Final = 0.5 / _BLEND  # of a strip, in widths of its edges
_TOGETHER: Final = 2  # bins of a strip that are summed side by side
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
    """What the sum needs of each ray's patch, lengths in bins or in facets: a Dr.Jit struct.

    Attributes:
        begin: near end of the ramp at the near edge [bins].
        length: between the middles of the ramps [bins]; 0 where nothing is heard.
        share: energy per ramp's length at 1 m, before the fall with range.
        distance: of the hit [m].
        hit: `Array3f`, from the sonar [facets].
        slide: `Array3f`, way along the surface [facets per metre].
        base: `UInt32`, word of the lattice point below the sonar, of the instance and the seed.
        single: `share` over the number of rays that meet one facet of it, see `rays_per_facet`; None where that is one.
    """

    begin: Array
    length: Array
    share: Array
    distance: Array
    hit: Array
    slide: Array
    base: Array
    single: Array | None = None

    @property
    def end(self) -> Array:
        """Far end of the ramp at the far edge [bins]."""
        return dr.fma(1.0 + 2.0 * _BLEND, self.length, self.begin)

    def packets(self, bins: int) -> tuple[Array, Array]:
        """The first and last packet of `_TOGETHER` bins that it touches, `Int32`; last < first where there is none."""
        last = jit.Int32(smaller(self.end, bins - 0.5)) // _TOGETHER
        return jit.Int32(larger(self.begin, 0.0)) // _TOGETHER, dr.select(self.length > 0.0, last, -1)


@dataclass(frozen=True)
class _Sonar:
    """Of each lane's sonar.

    Attributes:
        middle: `Array3f`, from the sonar to the middle of the lattice cell that it is in [facets].
        turns: cycles of phase per facet of range.
        scattered: see `accumulate`.
    """

    middle: Array
    turns: Array
    scattered: bool


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
    tags: bool = False,
    scattered: bool = False,
    single_file: bool = False,
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
        tags: also find the strongest echo of each cell.
        scattered: put each facet's scatterer at a random place of its lattice cell instead of the middle, for sonars
            that resolve the lattice.
        single_file: see `rays_per_facet`.

    Returns:
        for each cell of pings x beams x `pitch(bins)` four `Float`: real and imaginary amplitude, energy without
        interference, and nothing; with `tags` the largest `tag` of each cell.
    """
    lattice = origin * (1.0 / facet)
    whole = dr.floor(lattice)
    part = jit.Array3f(lattice - whole)
    words = lattice_word(whole, seed)
    strips = _strips(patches, walk, words, pings, bins, first_range, bin_width, facet, single_file=single_file)
    names = (patches.label, patches.instance) if tags else ()
    dr.eval(strips, names)

    walkers = walk.beams * walk.parts
    lane = dr.arange(jit.UInt32, pings * walkers)
    ping, walker = lane // walkers, lane % walkers
    size = pings * walk.beams * pitch(bins)
    row = (walker % walk.parts) * size + (ping * walk.beams + walker // walk.parts) * pitch(bins)
    part = dr.gather(jit.Array3f, part, ping)
    sonar = _Sonar(
        middle=0.5 - part,
        turns=dr.gather(jit.Float, wave_cycles, ping) * facet,
        scattered=scattered,
    )

    def listed(step: Array) -> tuple[Array, Array]:
        ray = dr.gather(jit.UInt32, order, step * walkers + walker)
        return ray + ping * walk.fan, ray < walk.fan

    sorted_rays = _by_length(strips, bins, listed, walk.steps, pings * walkers) if walk.steps >= _SORTED_FROM else None

    def taken(step: Array) -> tuple[Array, Array]:
        if sorted_rays is None:
            return listed(step)
        ray = dr.gather(jit.UInt32, sorted_rays, step * (pings * walkers) + lane)
        return ray, ray < pings * walk.fan

    field = dr.empty(jit.Float, 4 * size * walk.parts)  # each lane clears its own row
    strongest = dr.zeros(jit.UInt64, size * walk.parts) if tags else None
    silence = dr.zeros(jit.ArrayXf, (4 * _TOGETHER, pings * walkers))
    own, packets = row // _TOGETHER, pitch(bins) // _TOGETHER

    def clear(packet: Array) -> tuple[Array]:
        dr.scatter(field, silence, own + packet, mode=dr.ReduceMode.Permute)
        return (packet + 1,)

    def visit(step: Array) -> tuple[Array]:
        dr.while_loop((dr.select(step == 0, jit.UInt32(0), packets),), lambda k: k < packets, clear, mode="symbolic")
        ray, exists = taken(step)
        fields = {name: value for name, value in vars(strips).items() if value is not None}
        strip = _Strips(**{name: dr.gather(type(v), v, ray, exists) for name, v in fields.items()})
        strip.hit += part
        end, steepness = strip.end, _LENGTH / strip.length
        named = [dr.gather(jit.UInt32, name, ray, exists) for name in names]
        first, last = strip.packets(bins)

        def add(packet: Array, below: Array) -> tuple[Array, Array]:
            floors = [jit.Float(packet * _TOGETHER + k) for k in range(_TOGETHER)]
            upto = [_covered(floor + 1.0, strip.begin, steepness) for floor in floors]
            covered = [high - low for low, high in zip([below, *upto], upto, strict=False)]
            middles = [larger(strip.begin, floor) + smaller(end, floor + 1.0) for floor in floors]
            ranges = [dr.fma(0.5 * bin_width, middle, first_range) for middle in middles]
            values: list[Array] = []
            for k, (real, imaginary, energy) in enumerate(_facets(sonar, strip, ranges, covered)):
                values += [real, imaginary, energy, jit.Float(0)]
                if tags:
                    found, cell = tag(energy, *named), row + jit.UInt32(packet * _TOGETHER + k)
                    dr.scatter_reduce(
                        dr.ReduceOp.Max, strongest, found, cell, energy > 0.0, mode=dr.ReduceMode.NoConflicts
                    )
            dr.scatter_add(field, jit.ArrayXf(values), own + jit.UInt32(packet), mode=dr.ReduceMode.NoConflicts)
            return packet + 1, upto[-1]

        state = (first, _covered(jit.Float(first * _TOGETHER), strip.begin, steepness))
        dr.while_loop(state, lambda packet, _: packet <= last, add, mode="symbolic", labels=("packet", "covered"))
        return (step + 1,)

    dr.while_loop((dr.zeros(jit.UInt32, pings * walkers),), lambda step: step < walk.steps, visit, mode="symbolic")
    if walk.parts > 1:
        field = _joined(field, 4 * size, walk.parts)
        if tags:
            cell = dr.arange(jit.UInt32, size)
            parts = [dr.gather(jit.UInt64, strongest, cell + k * size) for k in range(walk.parts)]
            strongest = functools.reduce(dr.maximum, parts)
    return field, strongest


def _facets(
    sonar: _Sonar, strip: _Strips, ranges: list[Array], covered: list[Array]
) -> list[tuple[Array, Array, Array]]:
    """Real and imaginary amplitude and energy of a strip's facets in neighbouring bins.

    Args:
        sonar, strip: by lane.
        ranges: of the facets [m].
        covered: part of their bins that the strip covers, see `_covered`.

    Each step is taken for all of them before the next: a facet alone is one long chain of operations, each of which
    waits for the one before.
    """
    jit.stage()
    cells = [dr.floor(dr.fma(strip.slide, reach - strip.distance, strip.hit)) for reach in ranges]
    jit.stage()
    words = [facet_word(strip.base, cell) for cell in cells]
    jit.stage()
    places = [cell + sonar.middle for cell in cells]
    if sonar.scattered:
        places = [place + (facet_place(word) - 0.5) for place, word in zip(places, words, strict=True)]
    ways = [dr.sqrt(dr.squared_norm(place)) for place in places]
    parts = [larger(part, 0.0) / dr.square(reach) for part, reach in zip(covered, ranges, strict=True)]
    energies = [strip.share * part for part in parts]
    own = energies if strip.single is None else [strip.single * part for part in parts]
    jit.stage()
    normals = [complex_normal32(word) for word in words]
    jit.stage()
    sizes = [dr.sqrt(energy * power) for energy, (power, _) in zip(own, normals, strict=True)]
    waves = [cosine_sine(dr.fma(-sonar.turns, way, turn)) for way, (_, turn) in zip(ways, normals, strict=True)]
    jit.stage()
    return [
        (size * cosine, size * sine, energy)
        for size, (cosine, sine), energy in zip(sizes, waves, energies, strict=True)
    ]


def _covered(x: Array, begin: Array, steepness: Array) -> Array:
    """Length of a strip below x, in widths of the ramps at its edges, 1 / `steepness` bins each, where neighbours
    blend."""
    t = (x - begin) * steepness
    return _ramp(t) - _ramp(t - _LENGTH)


def _ramp(t: Array) -> Array:
    """Integral up to t of a step that rises linearly from 0 to 1."""
    s = larger(smaller(t, 1.0), 0.0)
    return s * dr.fma(-0.5, s, t)


def _strips(
    patches: Patches, walk: Walk, words: Array, pings: int, bins: int, first_range: float, bin_width: float,
    facet: float, *, single_file: bool,
) -> _Strips:  # fmt: skip
    """Patches in units of bins and facets; `words` of the lattice points below the sonars by ping.

    Of a strip over several bins each bin has a piece.
    """
    low = (patches.near - first_range) * (1.0 / bin_width)
    length = larger((patches.far - first_range) * (1.0 / bin_width) - low, 1e-2)
    if pings > 1:
        words = dr.gather(jit.UInt32, words, dr.arange(jit.UInt32, pings * walk.fan) // walk.fan)
    fall = larger(patches.near * patches.far, 1e-6)  # 1 / mean of r^-2 over the strip
    share = dr.select(patches.valid, patches.energy, 0.0) * fall * (1.0 / _LENGTH)
    single = None
    if patches.width is not None and patches.length is not None:
        piece = patches.length * (1.0 / facet) / larger(length, 1.0)
        single = share / rays_per_facet(patches.width * (1.0 / facet), piece, single_file=single_file)
    begin = low - _BLEND * length
    heard = (share > 0.0) & (begin < bins) & (low + (1.0 + _BLEND) * length > 0.0)
    return _Strips(
        begin=begin,
        length=dr.select(heard, length, 0.0),
        share=share,
        distance=patches.distance,
        hit=patches.direction * (patches.distance * (1.0 / facet)),
        slide=patches.slide * (1.0 / facet),
        base=on_instance(words, patches.instance),
        single=single,
    )


def _by_length(
    strips: _Strips, bins: int, rays: Callable[[Array], tuple[Array, Array]], steps: int, lanes: int
) -> Array:
    """Rays by step and lane as `rays` gives them by step, each lane's sorted by the class of their strips' lengths.

    Rays of the same class keep their order.
    """
    lane = dr.arange(jit.UInt32, lanes)
    place = dr.alloc_local(jit.UInt32, _CLASSES, value=jit.UInt32(0))

    def length_class(ray: Array, exists: Array) -> Array:
        length = dr.gather(jit.Float, strips.length, ray, exists)
        length = smaller(length + 2.0, float(bins))  # about the bins it touches; most of the ends' strips lie inside
        return dr.minimum((dr.reinterpret_array(jit.UInt32, length) >> 21) - 4 * 127, _CLASSES - 1)

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
    order = dr.empty(jit.UInt32, steps * lanes)  # all are written
    dr.while_loop((start, place), lambda step, _: step < steps, put, mode="symbolic")
    return order


def _joined(values: Array, size: int, parts: int) -> Array:
    """The sum of the walkers' parts, in their order."""
    cell = dr.arange(jit.UInt32, size)
    total = jit.Float(0)
    for k in range(parts):
        total += dr.gather(jit.Float, values, cell + k * size)
    return total
