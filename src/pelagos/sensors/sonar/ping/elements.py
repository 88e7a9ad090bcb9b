"""A ping by the single elements of the receive array: the echoes that the beams are made of, and one noise for both.

Echoes of a beam's sector come from the sector's middle, coherent ones from their own direction. The noise of elements
is as much louder than that of a beam as their weights say, so that delay and sum gives the device's own beams; those
of the picture hear the same noise, by the same sum.
"""

from __future__ import annotations

from dataclasses import replace

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.beamforming import spread_pulse
from pelagos.acoustics.complex_pair import times
from pelagos.acoustics.echo_walk import pitch
from pelagos.acoustics.element_array import Bearings, ElementLine, at_elements, by_delay_and_sum
from pelagos.acoustics.reverberation import volume_intensity
from pelagos.acoustics.spreading import time_varied_gain
from pelagos.jit import Array
from pelagos.math.constants import NOMINAL_SOUND_SPEED
from pelagos.math.philox import complex_normal32
from pelagos.math.quick import cosine_sine
from pelagos.sensors.noise import words32
from pelagos.sensors.sonar.ping.cells import Cells, Constants, middle
from pelagos.sensors.sonar.ping.clumps import clumped
from pelagos.sensors.sonar.ping.layout import Layout
from pelagos.sensors.sonar.ping.levels import Din, Moment, quantise, ringing
from pelagos.sensors.sonar.ping.medium import Medium
from pelagos.sensors.sonar.ping.ping_spec import PingSpec
from pelagos.sensors.sonar.ping.target_echoes import Grid, echoes_at_elements
from pelagos.sensors.sonar.ping.target_sighting import Sighting
from pelagos.sensors.sonar.ping.volume_echo import Haze, haze_at

_WATER, _NOISE = 0x60000000, 0x80000000  # where the counts of random numbers of the water and of elements begin


@jit.struct
class ElementTables:
    """Constants of an array: a Dr.Jit struct.

    Attributes:
        weights: see `ElementLine`.
        sine, cosine: `Float`, of the beams' directions.
        channels: `Array2f`, see `ElementLine`; None: they have no errors.
    """

    weights: Array
    sine: Array
    cosine: Array
    channels: Array | None = None


def element_tables(layout: Layout) -> ElementTables | None:
    """Tables of a sonar's array; None where it gives no elements."""
    if layout.elements is None:
        return None
    weights, sine, cosine = layout.elements.weights, np.sin(layout.azimuths), np.cos(layout.azimuths)
    tables = ElementTables(*(jit.Float(values.astype(np.float32)) for values in (weights, sine, cosine)))
    factors = layout.elements.channels
    if factors is not None:
        tables.channels = jit.Array2f(*(np.ascontiguousarray(p, np.float32) for p in (factors.real, factors.imag)))
    return tables


def line_tables(line: ElementLine, frequency_hz: float) -> dict[str, NDArray[np.float32]]:
    """Geometry of an array along y, as readings have it: places `(elements, 3)` [m], and its beamformer's weights."""
    along = line.places * (NOMINAL_SOUND_SPEED / frequency_hz)
    position = np.stack([0.0 * along, along, 0.0 * along], axis=-1)
    return {"element_position": position.astype(np.float32), "element_weights": line.weights.astype(np.float32)}


def steering_speed(spec: PingSpec, medium: Medium) -> Array:
    """Sound speed by which a device turns phases into angles, by ping [m/s]."""
    if spec.sound_speed_mps is None:
        return jit.Float(medium.sound_speed)
    return dr.full(jit.Float, spec.sound_speed_mps, dr.width(medium.sound_speed))


def ping_by_elements(
    spec: PingSpec, layout: Layout, constants: Constants, field: Array, moment: Moment, haze: Haze | None,
    heard: tuple[Sighting, Grid] | None,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """All that the elements hear, re the source level at 1 m.

    Args:
        field: see `sum_amplitudes`.
        haze: of the water; None: it is clear.
        heard: things with coherent echoes; None: none.

    Returns:
        two `Float` for each of pings x elements x bins; for each of pings x beams x bins of what is no echo of
        surfaces, for the picture; and the field with the echo of the water. Where channels have errors the picture is
        of all that they hear, and the field is empty.
    """
    assert layout.elements is not None
    assert constants.elements is not None
    lanes, bins = moment.lanes, spec.bins
    pings, line = dr.width(lanes.position), layout.elements
    scale = NOMINAL_SOUND_SPEED / steering_speed(spec, lanes.medium)
    if haze is not None:
        field = field + _water(spec, layout, constants, moment, haze)
    shaped = spread_pulse(field, constants.pulse, channels=2, bins=bins)
    turn = None
    if spec.doppler:
        turn = jit.Float(moment.spin.z) * (2.0 / lanes.medium.sound_speed) * spec.bin_width_m
    tables = constants.elements
    bearings = Bearings(tables.sine, tables.cosine, scale, turn)
    first = spec.range_min_m / spec.bin_width_m + 0.5
    signals = at_elements(shaped, line, bearings, pings=pings, sectors=layout.beams, bins=bins, first_delay=first)
    cell = dr.arange(jit.UInt32, pings * line.count * bins)
    ping, bin_ = cell // (line.count * bins), cell % bins
    distance = middle(spec, bin_)
    loss = dr.gather(jit.Float, lanes.medium.absorption, ping)
    raised = time_varied_gain(distance, loss, spreading=30.0)
    size = dr.sqrt(constants.cell * (spec.equivalent_m / spec.bin_width_m) / raised)
    total = dr.gather(jit.Array2f, signals, cell) * size
    if heard is not None:
        coherent = echoes_at_elements(*heard, line, scale, pings)
        total += dr.gather(jit.Array2f, coherent, cell)
    noise = _noise(spec, layout, constants, moment, cell)
    total += noise
    if tables.channels is not None:
        factor = dr.gather(jit.Array2f, tables.channels, cell // bins % line.count)
        total = jit.Array2f(*times((total.x, total.y), (factor.x, factor.y)))
    if spec.converter is not None:
        total = jit.Array2f(*(quantise(spec, part, jit.Float(1)) for part in total))
    flat = dr.ravel(noise if tables.channels is None else total)
    dr.eval(flat)
    still = Bearings(tables.sine, tables.cosine, scale)
    beams = by_delay_and_sum(flat, line, tables.weights, still, pings=pings, beams=layout.beams, bins=bins)
    if tables.channels is not None:
        field = dr.zeros(jit.Float, dr.width(field))
    return dr.ravel(total), beams, field


def _noise(spec: PingSpec, layout: Layout, constants: Constants, moment: Moment, cell: Array) -> Array:
    """Noise of the elements' own: what a beam hears, over the sum of squared weights."""
    assert layout.elements is not None
    bins, each = spec.bins, layout.elements.count * spec.bins
    ping = cell // each
    power = constants.noise
    if spec.ringing is not None:
        distance = middle(spec, cell % bins)
        at = Cells(ping, cell, cell, distance, distance, distance)
        power = power + ringing(spec, at, moment.lanes.medium)
    counter = [dr.gather(jit.UInt32, v, ping) for v in (moment.lanes.environment, moment.lanes.tick)]
    strength, turn = complex_normal32(words32(moment.key, cell % each + _NOISE, *counter)[0])
    size = dr.sqrt(power * (1.0 / layout.elements.noise_gain) * strength)
    return jit.Array2f(*cosine_sine(turn)) * size


def _water(spec: PingSpec, layout: Layout, constants: Constants, moment: Moment, haze: Haze) -> Array:
    """The echo of the water in each sector, as a field: of many scatterers, new in each ping."""
    beams, row, medium = layout.beams, pitch(spec.bins), moment.lanes.medium
    cell = dr.arange(jit.Int32, dr.width(moment.lanes.position) * beams * row)
    bin_, beam, ping = cell % row, cell // row % beams, cell // (row * beams)
    distance, inside = middle(spec, bin_), bin_ < spec.bins
    loss = dr.gather(jit.Float, medium.absorption, jit.UInt32(ping))
    open_water = haze_at(haze, ping, beam, distance, beams)
    power = volume_intensity(open_water, distance, loss, spec.bin_width_m)
    power *= time_varied_gain(distance, loss, spreading=30.0) / constants.cell
    if haze.clumps is not None:
        power *= clumped(haze.clumps, ping, beam, distance, beams)
    counter = [dr.gather(jit.UInt32, v, jit.UInt32(ping)) for v in (moment.lanes.environment, moment.lanes.tick)]
    word = words32(moment.key, jit.UInt32(beam * spec.bins + bin_) + _WATER, *counter)[0]
    strength, turn = complex_normal32(word)
    pair = jit.Array2f(*cosine_sine(turn)) * dr.select(inside, dr.sqrt(power * strength), 0.0)
    return dr.ravel(pair)


def without_noise(spec: PingSpec, constants: Constants, din: Din, beams: Array) -> tuple[PingSpec, Constants, Din]:
    """Keys, constants and din of a picture whose noise has been formed from that of elements, `beams`."""
    silent = replace(constants, noise=dr.zeros(jit.Float, 1))
    if constants.elements.channels is not None:
        return replace(spec, ringing=None, converter=None), silent, Din(beams, None, din.streaks)
    coherent = beams if din.coherent is None else din.coherent + beams
    return replace(spec, ringing=None), silent, Din(coherent, None, din.streaks)
