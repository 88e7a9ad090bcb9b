"""Bottom detection in the time series of a narrow beam: by amplitude, and by the phase between its two halves.

Near nadir the bottom fills a beam at once, and its echo is a short pulse, whose centre of gravity is the range
(weighted mean time). Obliquely the echo sweeps through the beam; the phase between the left and the right half of the
array passes through zero where it crosses the beam's axis, and a straight line fitted to the phase finds that moment.
Sounders do both, and report the one whose own error is smaller.

Sources: C. de Moustier, State of the art in swath bathymetry survey systems, Int. Hydrogr. Rev. 65(2), 25-54 (1988):
weighted mean time, zero crossing of the phase; X. Lurton, An Introduction to Underwater Acoustics (2nd ed., 2010),
Sections 8.3.3-8.3.4; X. Lurton and J.-M. Augustin, A measurement quality factor for swath bathymetry sounders, IEEE J.
Ocean. Eng. 35(4), 852-862 (2010): errors estimated from the series itself.
"""

from __future__ import annotations

import math
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array

NOT_FOUND: Final = 0
BY_AMPLITUDE: Final = 1
BY_PHASE: Final = 2

_GATE: Final = 0.1  # of the strongest sample: samples of the echo, -10 dB
_WIDE: Final = 2.0  # [rad], phase within which samples make the first fit: 0.7 half-power widths off the axis
_NARROW: Final = 1.2  # [rad], and the second
_FEWEST: Final = 4.0  # samples that a line is fitted to


@jit.struct
class Series:
    """Echoes of the two halves of each beam in its window of ranges: a Dr.Jit struct, beams by samples.

    Attributes:
        halves: `Float`, four for each sample (samples fastest): complex amplitude of the left and of the right half.
        start: `Float`, near edge of each beam's first sample [m].
        spacing: `Float`, of each beam's samples [m].
        resolution: `Float`, range resolution of the pulse in each beam [m].
    """

    halves: Array
    start: Array
    spacing: Array
    resolution: Array


@jit.struct
class Detections:
    """Detections in each beam: a Dr.Jit struct.

    Attributes:
        kind: `UInt32`: `NOT_FOUND`, `BY_AMPLITUDE` or `BY_PHASE`.
        distance: `Float`, range [m].
        error: `Float`, standard deviation of the range as estimated from the series itself [m].
        by_amplitude, by_phase: `Float`, what either way found [m]; not a number where it found nothing.
        amplitude_error, phase_error: `Float`, their estimated errors [m].
        level: `Float`, mean intensity of the samples of the echo.
        power: `Float`, sum of the intensities of all samples.
    """

    kind: Array
    distance: Array
    error: Array
    by_amplitude: Array
    by_phase: Array
    amplitude_error: Array
    phase_error: Array
    level: Array
    power: Array


def half_apertures(offset: Array, length: Array) -> tuple[Array, Array]:
    """Amplitude and phase [rad] at which each half of a uniform line hears a source; the other half's is negative.

    Two halves, each L/2 long and with centres L/2 apart, have the pattern sinc(L u/2)/2 and the phases +- pi L u/2;
    their sum is the whole line's sinc(L u).

    Args:
        offset: u, sine of the direction less that of the beam's axis.
        length: L, of the whole line [wavelengths].
    """
    phase = (0.5 * math.pi) * length * offset
    small = dr.abs(phase) < 1e-3
    safe = dr.select(small, 1.0, phase)
    return 0.5 * dr.select(small, 1.0 - phase * phase / 6.0, dr.sin(safe) / safe), phase


def find_bottom(series: Series, samples: int, *, noise: Array) -> Detections:
    """Detect the bottom in every beam, both ways.

    Args:
        series: see `Series`.
        samples: of each beam.
        noise: mean intensity of noise in a sample of the whole beam.
    """
    beams = dr.width(series.start)
    row = dr.arange(jit.UInt32, beams) * samples
    whole, strongest = _all(series, row, samples)
    gate = dr.maximum(_GATE * strongest, 3.0 * noise)
    middle, spread, level, count = _weighted_mean_time(series, row, samples, gate)
    amplitude = amplitude_error(spread, series.resolution, level / noise)
    found = count > 0.0
    crossing, phase = _zero_crossing(series, row, samples, gate, middle)
    phase_found = found & (phase < dr.inf) & (dr.abs(crossing - middle) < 2.0 * spread + series.resolution)
    by_phase = phase_found & (phase < amplitude)
    kind = dr.select(found, dr.select(by_phase, jit.UInt32(BY_PHASE), BY_AMPLITUDE), NOT_FOUND)
    return Detections(
        kind=kind,
        distance=dr.select(by_phase, crossing, middle),
        error=dr.select(by_phase, phase, amplitude),
        by_amplitude=dr.select(found, middle, dr.nan),
        by_phase=dr.select(phase_found, crossing, dr.nan),
        amplitude_error=amplitude,
        phase_error=phase,
        level=level,
        power=whole,
    )


def amplitude_error(spread: Array, resolution: Array, snr: Array) -> Array:
    """Standard deviation [m] of the range at the centre of gravity of a speckled echo envelope.

    An envelope of rms width w made of N = 1 + 2 sqrt(3) w/dr independent samples has its centre known to w/sqrt(N);
    noise spreads it further.

    Args:
        spread: rms range spread of the echo in the beam's footprint [m].
        resolution: dr, range resolution of the pulse [m].
        snr: power ratio.
    """
    width2 = spread * spread + resolution * resolution / 12.0
    count = 1.0 + 2.0 * math.sqrt(3.0) * spread / resolution
    return dr.sqrt(width2 / count * (1.0 + 1.0 / dr.maximum(snr, 1e-6)))


def _first(row: Array) -> Array:
    return dr.zeros(jit.UInt32, dr.width(row))


def _sample(series: Series, row: Array, k: Array) -> Array:
    return dr.gather(jit.Array4f, series.halves, row + k)


def _intensity(halves: Array) -> Array:
    real, imaginary = halves[0] + halves[2], halves[1] + halves[3]
    return real * real + imaginary * imaginary


def _all(series: Series, row: Array, samples: int) -> tuple[Array, Array]:
    """Sum and maximum of each beam's intensities."""
    start = [dr.zeros(jit.Float, dr.width(row)) for _ in range(2)]

    def add(k: Array, total: Array, strongest: Array) -> tuple[Array, Array, Array]:
        heard = _intensity(_sample(series, row, k))
        return k + 1, total + heard, dr.maximum(strongest, heard)

    _, total, strongest = dr.while_loop((_first(row), *start), lambda k, *_: k < samples, add, mode="symbolic")
    return total, strongest


def _weighted_mean_time(series: Series, row: Array, samples: int, gate: Array) -> tuple[Array, Array, Array, Array]:
    """Centre [m], rms width [m], mean intensity and number of the samples of each beam above its gate."""
    start = [dr.zeros(jit.Float, dr.width(row)) for _ in range(4)]

    def add(k: Array, total: Array, first: Array, second: Array, count: Array) -> tuple[Array, ...]:
        heard = _intensity(_sample(series, row, k))
        weight = dr.select(heard > gate, heard, 0.0)
        place = jit.Float(k) + 0.5 - 0.5 * samples  # from the window's middle: single precision keeps the square
        return (
            k + 1,
            total + weight,
            dr.fma(weight, place, first),
            dr.fma(weight, place * place, second),
            count + dr.select(heard > gate, jit.Float(1), 0.0),
        )

    _, total, first, second, count = dr.while_loop(
        (_first(row), *start), lambda k, *_: k < samples, add, mode="symbolic"
    )
    scale = dr.select(total > 0.0, 1.0 / total, 0.0)
    place = first * scale
    width = dr.sqrt(dr.maximum(second * scale - place * place, 0.0))
    centre = series.start + (place + 0.5 * samples) * series.spacing
    # an echo from one range has the width of the pulse's own envelope
    own = series.resolution * (1.0 / math.sqrt(12.0))
    spread = dr.sqrt(dr.maximum((width * series.spacing) ** 2 - own * own, 0.0))
    return centre, spread, total / dr.maximum(count, 1.0), count


def _zero_crossing(series: Series, row: Array, samples: int, gate: Array, middle: Array) -> tuple[Array, Array]:
    """Range [m] at which the phase between the halves is zero, and its estimated error [m], infinite where none is.

    The line is fitted twice, with the samples' amplitudes as weights: first to all samples whose phase is below
    `_WIDE`, then to those that the first line puts below `_NARROW`, where the ramp is straight.
    """
    origin = (middle - series.start) / series.spacing

    def fit(line: tuple[Array, Array] | None) -> tuple[Array, Array, Array, Array, Array]:
        def add(
            k: Array, w: Array, x: Array, y: Array, xx: Array, xy: Array, yy: Array, w2: Array
        ) -> tuple[Array, ...]:
            a = _sample(series, row, k)
            heard = _intensity(a)
            phase = dr.atan2(a[1] * a[2] - a[0] * a[3], a[0] * a[2] + a[1] * a[3])
            place = jit.Float(k) + 0.5 - origin
            if line is None:
                used = dr.abs(phase) < _WIDE
            else:
                expected = line[1] * (place - line[0])
                used = (dr.abs(expected) < _NARROW) & (dr.abs(phase - expected) < _WIDE)
            g = dr.select(used & (heard > gate), dr.sqrt(heard), 0.0)
            gx, gy = g * place, g * phase
            return (
                k + 1, w + g, x + gx, y + gy, dr.fma(gx, place, xx), dr.fma(gx, phase, xy), dr.fma(gy, phase, yy),
                dr.fma(g, g, w2),
            )  # fmt: skip

        _, w, x, y, xx, xy, yy, w2 = dr.while_loop(
            (_first(row), *(dr.zeros(jit.Float, dr.width(row)) for _ in range(7))),
            lambda k, *_: k < samples, add, mode="symbolic",
        )  # fmt: skip
        scale = dr.select(w > 0.0, 1.0 / w, 0.0)
        x, y, xx, xy, yy = x * scale, y * scale, xx * scale, xy * scale, yy * scale
        extent = dr.maximum(xx - x * x, 1e-6)
        slope = (xy - x * y) / extent
        steep = dr.abs(slope) > 1e-4
        crossing = x - y / dr.select(steep, slope, 1.0)
        residual = dr.maximum(yy - y * y - slope * slope * extent, 0.0)
        count = w * w / dr.maximum(w2, 1e-37)  # as many equal weights know as much
        ok = steep & (count >= _FEWEST)
        return crossing, slope, residual, dr.select(ok, count, 0.0), (crossing - x) ** 2 / extent

    crossing, slope, _, count, _ = fit(None)
    first = count > 0.0
    crossing, slope, residual, count, leverage = fit((crossing, dr.select(first, slope, dr.inf)))
    known = first & (count > 0.0)
    looks = dr.maximum(count * series.spacing / series.resolution, 1.0)
    safe = dr.select(known, dr.abs(slope), 1.0)
    error = dr.sqrt(residual * (1.0 + leverage) / looks) / safe * series.spacing
    distance = series.start + (crossing + origin) * series.spacing
    return dr.select(known, distance, 0.0), dr.select(known, error, dr.inf)
