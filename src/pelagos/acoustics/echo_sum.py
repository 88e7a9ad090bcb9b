"""The sum of all echoes of a ping: each patch's facets, bin by bin, with their amplitude and phase; and their energy.

The amplitudes are what a sonar hears. The energies, which nothing interferes with, are computed from the same strips
when somebody wants to know them.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import drjit as dr

from pelagos import jit
from pelagos.acoustics.echo import Patches
from pelagos.acoustics.echo_strips import Strips, strips_of
from pelagos.acoustics.echo_walk import Walkers, joined
from pelagos.acoustics.speckle import facet_place, facet_word, lattice_word, on_instance, rays_per_facet
from pelagos.acoustics.target_tag import tag
from pelagos.jit import Array
from pelagos.math.philox import complex_normal32
from pelagos.math.quick import cosine_sine, larger


@dataclass(frozen=True)
class Roughness:
    """Roughness of surfaces, which turns a strip's energy into echoes that interfere.

    Attributes:
        wave_cycles: 2 f/c, cycles of phase per metre of range by ping [1/m].
        origin: `Array3f64` sensor position by ping, world [m].
        facet: edge of the lattice of facets [m].
        seed: `UInt32`.
        scattered: put each facet's scatterer at a random place of its lattice cell instead of the middle, for sonars
            that resolve the lattice.
        single_file: see `rays_per_facet`.
    """

    wave_cycles: Array
    origin: Array
    facet: float
    seed: Array
    scattered: bool = False
    single_file: bool = False


@jit.struct
class _Facets:
    """Facets of each ray's strip, for its phases; lengths in facets: a Dr.Jit struct.

    Attributes:
        start: `Array3f`, where the strip's line would be at no range, from the sonar [facets].
        slide: `Array3f`, way along the surface [facets per metre].
        base: `UInt32`, word of the lattice point below the sonar, of the instance and the seed.
        single: a strip's share over the number of rays that meet one facet of it, see `rays_per_facet`; None where
            that is one.
    """

    start: Array
    slide: Array
    base: Array
    single: Array | None = None


@dataclass(frozen=True)
class _Sonar:
    """Of each lane's sonar.

    Attributes:
        middle: `Array3f`, from the sonar to the middle of the lattice cell that it is in [facets].
        turns: cycles of phase per facet of range.
        scattered: see `Roughness`.
    """

    middle: Array
    turns: Array
    scattered: bool


def sum_amplitudes(
    patches: Patches, walkers: Walkers, roughness: Roughness, *, tags: bool = False
) -> tuple[Array, Array | None, Strips]:
    """Sum the echoes of all patches into range bins.

    Args:
        patches: see `Patches`.
        walkers: who sums, and into which bins.
        roughness: of the surfaces.
        tags: also find the strongest echo of each cell.

    Returns:
        for each cell of pings x beams x `pitch(bins)` two `Float`: real and imaginary amplitude; with `tags` the
        largest `tag` of each cell; and the strips, for `sum_energies`.
    """
    lattice = roughness.origin * (1.0 / roughness.facet)
    whole = dr.floor(lattice)
    part = jit.Array3f(lattice - whole)
    bins = walkers.bins
    strips = strips_of(patches, bins=bins.count, first_range=bins.first_range, bin_width=bins.width)
    facets = _facets_of(patches, strips, walkers, roughness, lattice_word(whole, roughness.seed))
    names = (patches.label, patches.instance) if tags else ()
    dr.eval(strips, facets, names)

    ping, row = walkers.ping, walkers.row
    part = dr.gather(jit.Array3f, part, ping)
    sonar = _Sonar(
        middle=0.5 - part,
        turns=dr.gather(jit.Float, roughness.wave_cycles, ping) * roughness.facet,
        scattered=roughness.scattered,
    )
    strongest = dr.zeros(jit.UInt64, walkers.size * walkers.walk.parts) if tags else None

    def visit(ray: Array, exists: Array, strip: Strips) -> Any:
        fields = {name: value for name, value in vars(facets).items() if value is not None}
        facet = _Facets(**{name: dr.gather(type(v), v, ray, exists) for name, v in fields.items()})
        facet.start += part
        named = [dr.gather(jit.UInt32, name, ray, exists) for name in names]

        def values_of(first: Array, ranges: list[Array], parts: list[Array]) -> list[Array]:
            values: list[Array] = []
            for k, (real, imaginary, energy) in enumerate(_echoes(sonar, strip, facet, ranges, parts)):
                values += [real, imaginary]
                if tags:
                    dr.scatter_reduce(
                        dr.ReduceOp.Max, strongest, tag(energy, *named), row + first + k, energy > 0.0,
                        mode=dr.ReduceMode.NoConflicts,
                    )  # fmt: skip
            return values

        return values_of

    field = joined(walkers.sum(strips, visit, 2), 2 * walkers.size, walkers.walk.parts)
    if tags and walkers.walk.parts > 1:
        cell = dr.arange(jit.UInt32, walkers.size)
        each = [dr.gather(jit.UInt64, strongest, cell + k * walkers.size) for k in range(walkers.walk.parts)]
        strongest = functools.reduce(dr.maximum, each)
    return field, strongest, strips


def sum_energies(strips: Strips, walkers: Walkers) -> Array:
    """The energy of all echoes without interference, a `Float` for each cell; `strips` in memory."""

    def visit(_: Array, __: Array, strip: Strips) -> Any:
        return lambda ___, ranges, parts: _energies(strip.share, ranges, parts)

    return joined(walkers.sum(strips, visit, 1), walkers.size, walkers.walk.parts)


def _energies(share: Array, ranges: list[Array], parts: list[Array]) -> list[Array]:
    """Energies of facets, from a strip's share, their ranges [m] and what part of their bins the strip covers."""
    return [share * (larger(part, 0.0) / dr.square(reach)) for part, reach in zip(parts, ranges, strict=True)]


def _echoes(
    sonar: _Sonar, strip: Strips, facet: _Facets, ranges: list[Array], parts: list[Array]
) -> list[tuple[Array, Array, Array]]:
    """Real and imaginary amplitude and energy of a strip's facets in neighbouring bins; arguments as of `_energies`.

    Each step is taken for all of them before the next: a facet alone is one long chain of operations, each of which
    waits for the one before.
    """
    jit.new_scope()
    cells = [dr.floor(dr.fma(facet.slide, reach, facet.start)) for reach in ranges]
    jit.new_scope()
    words = [facet_word(facet.base, cell) for cell in cells]
    jit.new_scope()
    places = [cell + sonar.middle for cell in cells]
    if sonar.scattered:
        places = [place + (facet_place(word) - 0.5) for place, word in zip(places, words, strict=True)]
    ways = [dr.sqrt(dr.squared_norm(place)) for place in places]
    energies = _energies(strip.share, ranges, parts)
    own = energies if facet.single is None else _energies(facet.single, ranges, parts)
    jit.new_scope()
    normals = [complex_normal32(word) for word in words]
    jit.new_scope()
    sizes = [dr.sqrt(energy * power) for energy, (power, _) in zip(own, normals, strict=True)]
    waves = [cosine_sine(dr.fma(-sonar.turns, way, turn)) for way, (_, turn) in zip(ways, normals, strict=True)]
    jit.new_scope()
    return [
        (size * cosine, size * sine, energy)
        for size, (cosine, sine), energy in zip(sizes, waves, energies, strict=True)
    ]


def _facets_of(patches: Patches, strips: Strips, walkers: Walkers, roughness: Roughness, words: Array) -> _Facets:
    """Patches in units of facets; `words` of the lattice points below the sonars by ping.

    Of a strip over several bins each bin has a piece.
    """
    per_metre = 1.0 / roughness.facet
    if walkers.pings > 1:
        fan = walkers.walk.fan
        words = dr.gather(jit.UInt32, words, dr.arange(jit.UInt32, walkers.pings * fan) // fan)
    single = None
    if patches.width is not None and patches.length is not None:
        piece = patches.length * per_metre / larger(strips.length, 1.0)
        single = strips.share / rays_per_facet(patches.width * per_metre, piece, single_file=roughness.single_file)
    return _Facets(
        start=(patches.direction - patches.slide) * (patches.distance * per_metre),
        slide=patches.slide * per_metre,
        base=on_instance(words, patches.instance),
        single=single,
    )
