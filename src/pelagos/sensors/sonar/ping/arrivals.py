"""Other sonars' pulses as they arrive: coherent, in all beams at once, shaped by this receiver's filter."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.acoustics.echo_walk import Bins
from pelagos.acoustics.spreading import from_db
from pelagos.jit import Array
from pelagos.sensors.sonar.ping.fan import Lanes
from pelagos.sensors.sonar.ping.interference import Heard

_MOST: Final = 16  # samples of a bin, of which it keeps the strongest
_FINEST: Final = 0.3  # of 1/bandwidth, between them


def arrivals(heard: Heard, lanes: Lanes, bins: Bins, *, beams: int, bandwidth_hz: float) -> Array:
    """Signals of other sonars in each bin of each beam, re this one's source level at 1 m: two `Float` a cell.

    One arrival has one phase, that of its way: beams and bins share it. Lanes are pings by beams, which no other lane
    writes to, so that sums do not depend on the number of threads.
    """
    pings = dr.width(lanes.position)
    lane = dr.arange(jit.UInt32, pings * beams)
    ping, beam = lane // beams, lane % beams
    field = dr.zeros(jit.Float, pings * beams * bins.count * 2)
    speed = dr.gather(jit.Float, lanes.medium.sound_speed, ping)
    loss = dr.gather(jit.Float, lanes.medium.absorption, ping)
    places = dr.width(heard.distance) // pings
    begin, width = 2.0 * bins.first_range / speed, 2.0 * bins.width / speed  # times since the ping
    samples = min(max(math.ceil(2.0 * bins.width / 1400.0 * bandwidth_hz / _FINEST), 1), _MOST)

    def source(k: Array) -> tuple[Array]:
        row = k * pings + ping
        way = dr.gather(jit.Float, heard.distance, row)
        there = way < dr.inf
        level = dr.gather(jit.Float, heard.level, row * beams + beam)
        size = dr.select(there, dr.sqrt(level * from_db(-loss * dr.select(there, way, 0.0))), 0.0)
        of = dr.gather(jit.UInt32, heard.source, row)
        turns = jit.Float64(dr.select(there, way, 0.0)) * jit.Float64(dr.gather(jit.Float, heard.frequency, of) / speed)
        s, c = dr.sincos(jit.Float(turns - dr.floor(turns)) * (-2.0 * math.pi))
        period, step = dr.gather(jit.Float, heard.period, of), dr.gather(jit.Float, heard.step, of)
        first, taps = dr.gather(jit.UInt32, heard.first, of), dr.gather(jit.UInt32, heard.taps, of)
        length = jit.Float(taps) * step
        travel = dr.select(there, way, 0.0) / speed - dr.gather(jit.Float, heard.since, row)
        start = travel + dr.gather(jit.Float, heard.lead, of)
        start += dr.ceil((begin - length - start) / period) * period  # the first that is heard in the window

        def pulse(at: Array) -> tuple[Array]:
            low = jit.Int32(dr.floor((at - begin) / width))
            high = jit.Int32(dr.floor((at + length - begin) / width))

            def put(bin_: Array) -> tuple[Array]:
                moments = (begin + (jit.Float(bin_) + (j + 0.5) / samples) * width for j in range(samples))
                taps_heard = (jit.Int32(dr.round((now - at) / step)) for now in moments)
                real, imaginary = _loudest(heard.signal, first, taps, taps_heard)
                value = jit.Array2f(real * c - imaginary * s, real * s + imaginary * c) * size
                inside = (bin_ >= 0) & (bin_ < bins.count)
                into = lane * bins.count + jit.UInt32(bin_)
                dr.scatter_add(field, value, into, inside, mode=dr.ReduceMode.NoConflicts)
                return (bin_ + 1,)

            from_bin = dr.maximum(low, 0)
            dr.while_loop((from_bin,), lambda b: (b <= high) & (b < bins.count), put, mode="symbolic")
            return (at + period,)

        end = begin + bins.count * width
        first_at = dr.select(size > 0.0, start, end + 1.0)
        dr.while_loop((first_at,), lambda at: at < end, pulse, mode="symbolic")
        return (k + 1,)

    dr.while_loop((dr.zeros(jit.UInt32, pings * beams),), lambda k: k < places, source, mode="symbolic")
    dr.eval(field)
    return field


def _loudest(signal: Array, first: Array, count: Array, taps: Iterable[Array]) -> tuple[Array, Array]:
    """The loudest of some samples of a pulse whose `count` samples begin at `first` in `signal`."""
    real, imaginary = jit.Float(0), jit.Float(0)
    for tap in taps:
        known = (tap >= 0) & (tap < jit.Int32(count))
        pair = dr.gather(jit.Array2f, signal, first + jit.UInt32(tap), known)
        louder = dr.squared_norm(pair) > real * real + imaginary * imaginary
        real, imaginary = dr.select(louder, pair.x, real), dr.select(louder, pair.y, imaginary)
    return real, imaginary
