"""Order of summation: the lanes that add the strips of a ping to its bins, and their sequence.

Each beam is summed by lanes of its own (`Walk`), ray after ray and bin after bin. Nothing is added by two threads at
once: sums need no atomic operations, and do not depend on the number of threads or of pings in a call. Lanes that run
side by side wait for the one with most bins; each takes its short strips first and its long ones last, so that they
are alike.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.echo_strips import Strips, covered
from pelagos.jit import Array
from pelagos.math.quick import larger, smaller

TOGETHER: Final = 4  # bins of a strip that are summed side by side
_WALKERS: Final = 16  # lanes that share the rays of sonars of few beams: the width of a vector
_CLASSES: Final = 36  # of strips by the number of their bins, four an octave
_SORTED_FROM: Final = 32  # rays of a lane from which sorting them is worth it

Visit = Callable[[Array, Array, Strips], Callable[[Array, list[Array], list[Array]], list[Array]]]
"""(ray, whether there is one, its strip) -> (first bin, ranges [m], parts of the bins covered) -> values to add."""


@dataclass(frozen=True)
class Walk:
    """Distribution of rays over walkers: `beams` times `parts` of them with parts fastest, each a ray in every step.

    Attributes:
        order: `(steps * walkers,)`, row of the fan's ray by step and walker; `fan` where there is none.
        beams, parts, steps, fan: their numbers, and that of the rays of a fan.
    """

    order: NDArray[np.uint32]
    beams: int
    parts: int
    steps: int
    fan: int


@dataclass(frozen=True)
class Bins:
    """Range bins of a beam: their number, the near edge of the first and their width [m]."""

    count: int
    first_range: float
    width: float


def pitch(bins: int) -> int:
    """Cells from a beam's row to the next: an odd number of fours, so that rows read together share no cache set."""
    return (-(-bins // TOGETHER) | 1) * TOGETHER


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


class Walkers:
    """The lanes that sum, `beams` times `parts` for each of `pings`.

    Args:
        walk: see `Walk`.
        order: its table on the device.
        pings: how many fans there are.
        bins: what strips are summed into.

    Attributes:
        lanes: their number.
        size: cells of a sum: pings x beams x `pitch`.
        ping: that of each lane, `UInt32`.
        row: first cell of each lane, `UInt32`; parts of a beam have sums of their own, `size` cells apart.
    """

    def __init__(self, walk: Walk, order: Array, pings: int, bins: Bins) -> None:
        self.walk, self.pings, self.bins = walk, pings, bins
        self._order = order
        each = walk.beams * walk.parts
        self.lanes, self.size = pings * each, pings * walk.beams * pitch(bins.count)
        self._number = dr.arange(jit.UInt32, self.lanes)
        self.ping, self._walker = self._number // each, self._number % each
        beam = self.ping * walk.beams + self._walker // walk.parts
        self.row = (self._walker % walk.parts) * self.size + beam * pitch(bins.count)

    def listed(self, step: Array) -> tuple[Array, Array]:
        """Each lane's ray of a step, and whether there is one."""
        each = self.walk.beams * self.walk.parts
        ray = dr.gather(jit.UInt32, self._order, step * each + self._walker)
        return ray + self.ping * self.walk.fan, ray < self.walk.fan

    def sum(self, strips: Strips, visit: Visit, channels: int) -> Array:
        """Sum of `visit`'s values: `channels` `Float` a cell, for each of `walk.parts` times `size` cells.

        `strips` must be in memory.
        """
        rays, last_step = self._rays(strips), self.walk.steps
        field = dr.empty(jit.Float, channels * self.size * self.walk.parts)  # each lane clears its own row
        silence = dr.zeros(jit.ArrayXf, (channels * TOGETHER, self.lanes))
        own, packets = self.row // TOGETHER, pitch(self.bins.count) // TOGETHER

        def clear(packet: Array) -> tuple[Array]:
            dr.scatter(field, silence, own + packet, mode=dr.ReduceMode.Permute)
            return (packet + 1,)

        def take(step: Array) -> tuple[Array]:
            unclean = dr.select(step == 0, jit.UInt32(0), packets)
            dr.while_loop((unclean,), lambda k: k < packets, clear, mode="symbolic")
            ray, exists = rays(step)
            strip = Strips(*(dr.gather(jit.Float, v, ray, exists) for v in (strips.begin, strips.length, strips.share)))
            end, steepness = strip.end, strip.steepness
            values_of = visit(ray, exists, strip)
            first, last = packets_of(strip, self.bins.count)

            def add(packet: Array, below: Array) -> tuple[Array, Array]:
                floors = [jit.Float(packet * TOGETHER + k) for k in range(TOGETHER)]
                upto = [covered(floor + 1.0, strip.begin, steepness) for floor in floors]
                parts = [high - low for low, high in zip([below, *upto], upto, strict=False)]
                middles = [larger(strip.begin, floor) + smaller(end, floor + 1.0) for floor in floors]
                ranges = [dr.fma(0.5 * self.bins.width, middle, self.bins.first_range) for middle in middles]
                values = values_of(jit.UInt32(packet * TOGETHER), ranges, parts)
                dr.scatter_add(field, jit.ArrayXf(values), own + jit.UInt32(packet), mode=dr.ReduceMode.NoConflicts)
                return packet + 1, upto[-1]

            state = (first, covered(jit.Float(first * TOGETHER), strip.begin, steepness))
            dr.while_loop(state, lambda packet, _: packet <= last, add, mode="symbolic", labels=("packet", "covered"))
            return (step + 1,)

        start = dr.zeros(jit.UInt32, self.lanes)
        dr.while_loop((start,), lambda step: step < last_step, take, mode="symbolic")
        return field

    def _rays(self, strips: Strips) -> Callable[[Array], tuple[Array, Array]]:
        """A function step -> each lane's ray, and whether there is one; the longest strips last."""
        if self.walk.steps < _SORTED_FROM:
            return self.listed
        order = _by_length(strips.length, self.bins.count, self.listed, self.walk.steps, self.lanes)

        def taken(step: Array) -> tuple[Array, Array]:
            ray = dr.gather(jit.UInt32, order, step * self.lanes + self._number)
            return ray, ray < self.pings * self.walk.fan

        return taken


def packets_of(strip: Strips, bins: int) -> tuple[Array, Array]:
    """The first and last packet of `TOGETHER` bins that it touches, `Int32`; last < first where there is none."""
    last = jit.Int32(smaller(strip.end, bins - 0.5)) // TOGETHER
    return jit.Int32(larger(strip.begin, 0.0)) // TOGETHER, dr.select(strip.length > 0.0, last, -1)


def joined(values: Array, size: int, parts: int) -> Array:
    """The sum of the walkers' parts of `size` values each, in their order."""
    if parts == 1:
        return values
    cell = dr.arange(jit.UInt32, size)
    total = dr.zeros(jit.Float, size)
    for k in range(parts):
        total += dr.gather(jit.Float, values, cell + k * size)
    return total


def _by_length(
    lengths: Array, bins: int, rays: Callable[[Array], tuple[Array, Array]], steps: int, lanes: int
) -> Array:
    """Rays by step and lane as `rays` gives them by step, each lane's sorted by the class of their strips' lengths.

    Rays of the same class keep their order.
    """
    lane = dr.arange(jit.UInt32, lanes)
    place = dr.alloc_local(jit.UInt32, _CLASSES, value=jit.UInt32(0))

    def length_class(ray: Array, exists: Array) -> Array:
        length = dr.gather(jit.Float, lengths, ray, exists)
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
