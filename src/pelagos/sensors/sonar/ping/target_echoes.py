"""Echoes of things that few rays would meet, and of smooth ones: where and how strongly each is heard.

A thing's own rays go to places spread evenly over its disc, as the sonar sees it. They tell what stands before it, and
what its surface scatters; the coherent part of a smooth sphere, box or cylinder is computed from its shape. Coherent
echoes are heard by each beam through the array's pattern in their own direction, and by each bin through the pulse at
their own range: neither sectors nor bins round them.

Source: X. Lurton, An Introduction to Underwater Acoustics (2nd ed., 2010), Chapters 3 and 5; see also `specular`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.acoustics.echo_walk import Bins, pitch
from pelagos.acoustics.element_array import ElementLine
from pelagos.acoustics.pulse import response
from pelagos.acoustics.spreading import time_varied_gain
from pelagos.acoustics.target_tag import tag
from pelagos.jit import Array
from pelagos.math.quick import cosine_sine
from pelagos.sensors.sonar.ping.aperture import Aperture, Facing
from pelagos.sensors.sonar.ping.fan import Lanes
from pelagos.sensors.sonar.ping.target_sighting import Sighting
from pelagos.sensors.sonar.ping.targets import Targets

_SAMPLED: Final = 0.3  # of a resolution between samples, of which a wide bin keeps the strongest


@dataclass(frozen=True)
class Grid:
    """Cells of a ping.

    Attributes:
        beams: their number.
        bins: see `Bins`.
        resolution: c/(2B) [m].
        pulse: "chirp" or "cw".
        cell: that levels of the field are calibrated to [rad m].
    """

    beams: int
    bins: Bins
    resolution: float
    pulse: str
    cell: float


def with_small_things(
    sighting: Sighting, grid: Grid, lanes: Lanes, boost: Array, field: Array, tags: Array | None, instances: Array
) -> None:
    """Add the small things' own rays to the amplitudes of a ping's cells, and to its tags; in place.

    One lane a ping takes them one after the other, so that sums do not depend on the number of threads.
    """
    k = dr.width(sighting.energy) // dr.width(sighting.size)

    def put(index: Array, at: Array, heard: Array, level: Array) -> None:
        factor = dr.sqrt(level)
        pair = jit.Array2f(*(dr.gather(jit.Float, v, index) * factor for v in (sighting.real, sighting.imaginary)))
        dr.scatter_add(field, pair, at, heard, mode=dr.ReduceMode.NoConflicts)
        if tags is not None:
            energy = dr.gather(jit.Float, sighting.energy, index) * level
            things = dr.width(instances)
            word = tag(energy, dr.gather(jit.UInt32, sighting.label, index),
                       dr.gather(jit.UInt32, instances, index // k % things))  # fmt: skip
            dr.scatter_reduce(dr.ReduceOp.Max, tags, word, at, heard, mode=dr.ReduceMode.NoConflicts)

    _each_ray(sighting, grid, lanes.medium.absorption, boost, put)


def with_small_energies(sighting: Sighting, grid: Grid, absorption: Array, boost: Array, energies: Array) -> None:
    """The same for energies without interference."""

    def put(index: Array, at: Array, heard: Array, level: Array) -> None:
        energy = dr.gather(jit.Float, sighting.energy, index) * level
        dr.scatter_add(energies, energy, at, heard, mode=dr.ReduceMode.NoConflicts)

    _each_ray(sighting, grid, absorption, boost, put)


def _each_ray(
    sighting: Sighting, grid: Grid, absorption: Array, boost: Array, put: Callable[[Array, Array, Array, Array], None]
) -> None:
    """Call `put` with (row of the ray, cell, whether it is heard, level re the source level to that of the field)."""
    pings, rows = dr.width(absorption), dr.width(sighting.size)
    ping, loss = dr.arange(jit.UInt32, pings), jit.Float(absorption)
    things, k = rows // pings, dr.width(sighting.energy) // rows

    def take_ray(index: Array, end: Array) -> tuple[Array, Array]:
        distance, beam = dr.gather(jit.Float, sighting.distance, index), dr.gather(jit.UInt32, sighting.beam, index)
        bin_ = jit.Int32(dr.floor((distance - grid.bins.first_range) * (1.0 / grid.bins.width)))
        heard = (dr.gather(jit.Float, sighting.energy, index) > 0.0) & (beam < grid.beams)
        heard &= (bin_ >= 0) & (bin_ < grid.bins.count)
        row = dr.minimum(beam, grid.beams - 1)
        whole = dr.select(dr.gather(jit.Bool, sighting.point, index // k), dr.gather(jit.Float, boost, row), 1.0)
        level = time_varied_gain(distance, loss, spreading=30.0) * (1.0 / grid.cell) * whole
        put(index, (ping * grid.beams + row) * pitch(grid.bins.count) + jit.UInt32(bin_), heard, level)
        return index + 1, end

    def take_thing(m: Array) -> tuple[Array]:
        row = ping * things + m
        own = dr.select(dr.gather(jit.Bool, sighting.small, row), jit.UInt32(k), 0)  # no others' rays have energy
        dr.while_loop((row * k, row * k + own), lambda index, end: index < end, take_ray, mode="symbolic")
        return (m + 1,)

    dr.while_loop((dr.zeros(jit.UInt32, pings),), lambda m: m < things, take_thing, mode="symbolic")


def coherent_echoes(
    sighting: Sighting, grid: Grid, aperture: Aperture, facing: Facing, pings: int, *, energies: bool
) -> Array:
    """Coherent echoes in each bin of each beam, re the source level at 1 m: two `Float` a cell, or with
    `energies` its intensity, one."""
    beams = grid.beams
    beam = dr.arange(jit.UInt32, pings * beams) % beams

    def received(index: Array) -> Array:
        if not aperture.steered:
            return dr.select(dr.gather(jit.UInt32, sighting.nearest, index) == beam, 1.0, 0.0)
        return aperture.side_amplitude(facing, beam, dr.gather(jit.Array3f, sighting.direction, index))

    return _spread(sighting, grid, beams, pings, received, energies=energies)


def echoes_at_elements(sighting: Sighting, grid: Grid, line: ElementLine, scale: Array, pings: int) -> Array:
    """The same at each element of a line along y, by its phase: two `Float` a bin; `scale` see `Bearings`."""
    lane = dr.arange(jit.UInt32, pings * line.count)
    place = jit.Float(lane % line.count) * line.spacing + float(line.places[0])
    cycles = place * dr.gather(jit.Float, scale, lane // line.count)

    def received(index: Array) -> Array:
        return jit.Array2f(*cosine_sine(cycles * dr.gather(jit.Array3f, sighting.direction, index).y))

    return _spread(sighting, grid, line.count, pings, received, energies=False)


def _spread(
    sighting: Sighting, grid: Grid, receivers: int, pings: int, received: Callable[[Array], Array], *, energies: bool
) -> Array:
    """Coherent echoes in each bin of each receiver; `received` tells its factor, `Float` or a complex pair, of things.

    One lane a receiver takes all things one after another.
    """
    bins, channels = grid.bins, 1 if energies else 2
    field = dr.zeros(jit.Float, pings * receivers * bins.count * channels)
    lane = dr.arange(jit.UInt32, pings * receivers)
    ping = lane // receivers
    things = dr.width(sighting.size) // pings
    taps = math.ceil(2.5 * grid.resolution / bins.width)
    slack = max(0.5 * (bins.width - _SAMPLED * grid.resolution), 0.0)  # a wide bin keeps the strongest of its samples

    def take(m: Array) -> tuple[Array]:
        index = ping * things + m
        size, factor = dr.gather(jit.Float, sighting.size, index), received(index)
        distance = dr.gather(jit.Float, sighting.reach, index)
        middle = jit.Int32(dr.floor((distance - bins.first_range) * (1.0 / bins.width)))
        wave = jit.Array2f(*(dr.gather(jit.Float, v, index) for v in (sighting.cosine, sighting.sine)))
        if type(factor) is jit.Array2f:
            wave = jit.Array2f(wave.x * factor.x - wave.y * factor.y, wave.x * factor.y + wave.y * factor.x)
        else:
            size *= factor

        def spread(j: Array) -> tuple[Array]:
            bin_ = middle + j
            off = dr.abs(bins.first_range + (jit.Float(bin_) + 0.5) * bins.width - distance)
            part = size * response(dr.maximum(off - slack, 0.0) * (1.0 / grid.resolution), grid.pulse)
            at = lane * bins.count + jit.UInt32(bin_)
            inside = (bin_ >= 0) & (bin_ < bins.count)
            value = part * part if energies else wave * part
            dr.scatter_add(field, value, at, inside, mode=dr.ReduceMode.NoConflicts)
            return (j + 1,)

        first = dr.select(dr.abs(size) > 0.0, jit.Int32(-taps), taps + 1)
        dr.while_loop((first,), lambda j: j <= taps, spread, mode="symbolic")
        return (m + 1,)

    dr.while_loop((dr.zeros(jit.UInt32, pings * receivers),), lambda m: m < things, take, mode="symbolic")
    dr.eval(field)
    return field


def excluded_share(things: Targets, sighting: Sighting, instance: Array, lane: Array) -> tuple[Array, Array]:
    """Of rays that met `instance`: whether the thing has rays of its own, and what part of its scattering is left."""
    count = dr.width(things.kind)
    known = dr.width(things.of_instance)
    row = dr.gather(jit.UInt32, things.of_instance, dr.minimum(instance, known - 1), instance < known)
    is_thing = (instance < known) & (row < count)
    index = lane * count + dr.minimum(row, count - 1)
    small = dr.gather(jit.Bool, sighting.small, index, is_thing)
    return small, dr.select(is_thing, dr.gather(jit.Float, sighting.dulled, index, is_thing), 1.0)
