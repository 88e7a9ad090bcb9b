"""Time series of the two halves of a multibeam's array in each beam, about the bottom's echo."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.acoustics.bottom_detection import Series, half_apertures
from pelagos.acoustics.echo import Patches
from pelagos.acoustics.speckle import lattice_word, on_instance, scramble
from pelagos.acoustics.spreading import patch_intensity, time_varied_gain
from pelagos.jit import Array
from pelagos.math.philox import complex_normal32, normal_pair32, uniform32
from pelagos.sensors.noise import Key, words32
from pelagos.sensors.sonar.ping.fan import Fan, FanHits, Lanes
from pelagos.sensors.sonar.ping.medium import spread

_GATE: Final = 0.06  # detection window about the strongest echo [of the range]
_FAINT: Final = 0.01  # of the strongest ray's level: rays that the window need not hold
_MARGIN: Final = 8  # samples of the window beyond the echo, on both sides together
_PULSE: Final = (0.5, 1.0, 0.5)  # amplitude at samples half a resolution apart
_PULSE_ENERGY: Final = 1.5  # sum of its squares
_WORD: Final = 0x9E3779B1


@dataclass(frozen=True)
class Beams:
    """Reception of a multibeam.

    Attributes:
        count: beams of a ping.
        samples: of a beam's series.
        finest: least time between samples, half of 1/bandwidth [s].
        length: of the receive array [wavelengths].
        receive: power pattern of the array at the place of each ray of a beam, with which the fan is weighted.
        facet: edge of the roughness lattice [m].
        longest: how far a ray's patch may reach in range [m].
        seed: of the roughness.
    """

    count: int
    samples: int
    finest: float
    length: float
    receive: tuple[float, ...]
    facet: float
    longest: float
    seed: int


@jit.struct
class Window:
    """Place of each beam's strongest echo, one lane a beam: a Dr.Jit struct.

    Attributes:
        found: `Bool`.
        where: `Float`, range of the strongest ray [m].
        near, far: `Float`, span of ranges of the rays that are heard with it [m].
        power: `Float`, mean of the sum of the intensities of all samples, re the source level at 1 m.
        section: `Float`, mean cross section per unit area of what was hit [1].
        axis: `Float`, range along the beam's axis [m], infinite without a hit.
        label, instance: `UInt32`, on the axis.
    """

    found: Array
    where: Array
    near: Array
    far: Array
    power: Array
    section: Array
    axis: Array
    label: Array
    instance: Array


def beam_series(
    beams: Beams, view: FanHits, patches: Patches, fan: Fan, lanes: Lanes, noise: Array, key: Key
) -> tuple[Window, Series]:
    """Window and time series of every beam; see `Window` and `Series`.

    A ray's strip of surface sweeps through directions as it does through ranges. Each sample of it is one facet with an
    amplitude of its own, heard by both halves of the array from the direction that the sample's range has in the strip.

    Args:
        beams, view, fan, lanes: of the ping.
        patches: what the rays met, at the ranges that their times mean.
        noise: mean intensity in a sample of the whole beam, one for all or one a beam of each ping.
        key: random stream of the noise.
    """
    dr.eval(patches, view)  # one cast: block reductions and gathers would each begin with their own
    window = _window(beams, view, patches, fan, lanes)
    dr.eval(window)
    lane = dr.arange(jit.UInt32, dr.width(window.where)) // beams.count
    finest = dr.gather(jit.Float, lanes.medium.sound_speed, lane) * (0.5 * beams.finest)
    spacing = dr.maximum(finest, (window.far - window.near) * (1.0 / (beams.samples - _MARGIN)))
    start = 0.5 * (window.near + window.far) - 0.5 * beams.samples * spacing
    dr.eval(start, spacing)
    raw = _raw(beams, view, patches, fan, lanes, start, spacing, noise, key)
    series = Series(_shaped(raw, beams.samples), start, spacing, 2.0 * spacing)
    dr.eval(series)
    window.power *= 2.0  # a sample hears two cells' energy
    return window, series


def _window(beams: Beams, view: FanHits, patches: Patches, fan: Fan, lanes: Lanes) -> Window:
    rays = len(beams.receive)
    loss = dr.gather(jit.Float, lanes.medium.absorption, view.lane)
    t, energy = patches.distance, patches.energy
    level = energy * time_varied_gain(t, loss, spreading=20.0)  # so that near things do not win by nearness alone
    level = dr.select(patches.valid, level, 0.0)
    density = energy / (dr.gather(jit.Float, fan.weight, view.ray) * patch_intensity(t, loss)) * view.sine
    dr.eval(level, density)
    first = dr.arange(jit.UInt32, dr.width(lanes.position) * beams.count) * rays
    strongest, where = jit.Float(0), jit.Float(0)
    for k in range(rays):
        loud = dr.gather(jit.Float, level, first + k)
        where = dr.select(loud > strongest, dr.gather(jit.Float, t, first + k), where)
        strongest = dr.maximum(strongest, loud)
    total, section = jit.Float(0), jit.Float(0)
    near, far = jit.Float(where), jit.Float(where)
    for k in range(rays):
        loud = dr.gather(jit.Float, level, first + k)
        offset = dr.gather(jit.Float, t, first + k) - where
        heard = (loud > _FAINT * strongest) & (dr.abs(offset) <= _GATE * where + 0.2)
        weight = dr.select(heard, dr.gather(jit.Float, energy, first + k), 0.0)
        near = dr.select(heard, dr.minimum(near, dr.gather(jit.Float, patches.near, first + k)), near)
        far = dr.select(heard, dr.maximum(far, dr.gather(jit.Float, patches.far, first + k)), far)
        total += weight
        section += weight * dr.gather(jit.Float, density, first + k)
    middle = first + rays // 2
    valid = dr.gather(jit.Bool, view.hits.valid, middle)
    return Window(
        found=total > 1e-36,
        where=where,
        near=near,
        far=far,
        power=total,
        section=section / dr.maximum(total, 1e-37),
        axis=dr.select(valid, dr.gather(jit.Float, view.hits.t, middle), dr.inf),
        label=dr.gather(jit.UInt32, view.hits.label, middle),
        instance=dr.gather(jit.UInt32, view.hits.instance, middle),
    )


def _raw(
    beams: Beams, view: FanHits, patches: Patches, fan: Fan, lanes: Lanes, start: Array, spacing: Array,
    noise: Array, key: Key,
) -> Array:  # fmt: skip
    """Echo and noise of both halves in cells one sample long, before the pulse: four `Float` a sample."""
    rays, samples = len(beams.receive), beams.samples
    ray = dr.arange(jit.UInt32, dr.width(view.ray))
    beam = ray // rays
    begin, scale = dr.gather(jit.Float, start, beam), 1.0 / dr.gather(jit.Float, spacing, beam)
    low = (patches.near - begin) * scale
    high = dr.maximum((patches.far - begin) * scale, low + 1e-2)
    share = dr.select(patches.valid, patches.energy / (high - low), 0.0)
    # direction across the track at both ends of the strip, less that of the beam's axis
    axis = dr.gather(jit.Float, fan.direction.y, beam % beams.count * rays + rays // 2)
    across = dr.gather(jit.Float, fan.direction.y, view.ray) - axis
    turn = dr.gather(jit.Float, fan.along.y, view.ray)
    lower, upper = dr.gather(jit.Float, fan.lower, view.ray), dr.gather(jit.Float, fan.upper, view.ray)
    approaching = dr.dot(view.hits.normal, view.along) < 0.0  # range falls towards `upper`
    at_near = across + turn * dr.select(approaching, upper, lower)
    at_far = across + turn * dr.select(approaching, lower, upper)
    x, y, z = (jit.UInt32(jit.Int32(dr.floor(p * (1.0 / beams.facet)))) for p in view.hits.position)
    surface = view.hits.instance + view.ray % rays
    word = scramble(on_instance(lattice_word((x, y, z), jit.UInt32(beams.seed)), surface))
    span = jit.Array4f(low, high, share, at_near)
    sweep = (at_far - at_near) / (high - low)
    dr.eval(span, sweep, word)
    spans = dr.ravel(span)
    dr.eval(spans)

    lane = dr.arange(jit.UInt32, dr.width(start) * samples)
    row, sample = lane // samples, lane % samples
    bottom, top = jit.Float(sample), jit.Float(sample) + 1.0
    left_re = left_im = right_re = right_im = jit.Float(0)
    for k in range(rays):
        index = row * rays + k
        near, far, amount, direction = dr.gather(jit.Array4f, spans, index)
        covered = dr.maximum(dr.minimum(far, top) - dr.maximum(near, bottom), 0.0)
        hashed = scramble(dr.gather(jit.UInt32, word, index) + sample * _WORD)
        strength, cycle = complex_normal32(hashed)
        place = dr.fma(covered, uniform32(scramble(hashed ^ _WORD)), dr.maximum(near, bottom)) - near
        offset = dr.fma(place, dr.gather(jit.Float, sweep, index), direction)
        pattern, phase = half_apertures(offset, beams.length)
        size = dr.sqrt(amount * covered * strength * (1.0 / beams.receive[k])) * pattern
        size = dr.select(covered > 0.0, size, 0.0)
        angle = 2.0 * math.pi * cycle
        s1, c1 = dr.sincos(angle + phase)
        s2, c2 = dr.sincos(angle - phase)
        left_re, left_im = dr.fma(size, c1, left_re), dr.fma(size, s1, left_im)
        right_re, right_im = dr.fma(size, c2, right_re), dr.fma(size, s2, right_im)
    ping = row // beams.count
    environment, tick = dr.gather(jit.UInt32, lanes.environment, ping), dr.gather(jit.UInt32, lanes.tick, ping)
    words = words32(key, row % beams.count * samples + sample, environment, tick)
    n1, n2 = normal_pair32(words[0], words[1])
    n3, n4 = normal_pair32(words[2], words[3])
    hiss = dr.sqrt(0.125 * spread(noise, row))  # two halves, two parts, and a pulse of energy 2
    return dr.ravel(jit.Array4f(left_re + hiss * n1, left_im + hiss * n2, right_re + hiss * n3, right_im + hiss * n4))


def _shaped(raw: Array, samples: int) -> Array:
    """The pulse over all cells: each sample hears its neighbours."""
    dr.eval(raw)
    lane = dr.arange(jit.UInt32, dr.width(raw) // 4)
    sample = jit.Int32(lane % samples)
    out = jit.Array4f(0)
    scale = math.sqrt(2.0 / _PULSE_ENERGY)
    for k, weight in enumerate(_PULSE):
        shift = k - len(_PULSE) // 2
        inside = (sample + shift >= 0) & (sample + shift < samples)
        out += (weight * scale) * dr.gather(jit.Array4f, raw, jit.UInt32(jit.Int32(lane) + shift), inside)
    return dr.ravel(out)
