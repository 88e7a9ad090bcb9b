"""Noise of a sensor from its own record: the terms of its Allan deviation, and of a velocity log's beams.

Sources: IEEE Std 952-1997, Annex C (terms of the Allan variance); D. A. Howe, D. W. Allan, J. A. Barnes, "Properties of
signal sources and measurement methods", Proc. 35th Annual Symposium on Frequency Control (1981) (overlapping samples);
W. R. Bennett, "Spectra of quantized signals", Bell System Technical Journal 27 (1948) (rounding to steps of q adds
white noise of the variance q^2/12).
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.special import chdtri

from pelagos.errors import InputError, PelagosWarning
from pelagos.identification.allan_terms import LEAST, REWEIGHTED, terms_of
from pelagos.identification.beam_faults import (
    AROUND,
    OTHERS,
    STRAY,
    refuse_constant,
    refuse_contradicted,
    refuse_zeros,
    standing_out,
    warn_of_noise,
    warn_of_wandering,
)
from pelagos.identification.coordinates import PLAUSIBLE, normal_size
from pelagos.sensors.noise import FLOOR

Floats = NDArray[np.float64]
_FEWEST: Final = 200  # samples
_LONGEST: Final = 9  # clusters that the longest averaging time must leave
_PER_DECADE: Final = 6
_UNLIKE: Final = 0.5
"""Logarithm of measured over modelled deviation from which the three terms are not what the record shows, where the
curve is known to a tenth."""
_KNOWN: Final = 50  # clusters that know the curve to a tenth (IEEE Std 952-1997, equation C.20)
_PARTS: Final = 64  # of a record, whose means show its drift
_STRAIGHT: Final = 0.985
"""Share of a straight line in the variance of those means from which it is a drift: one random walk in 10 000 has it,
the steadiest of all noise (of 200 000, drawn)."""
_OUTLIER: Final = 30.0  # of the median change from sample to sample: normal noise changes by 7 of it once in 1e6
_COARSE: Final = 0.5
"""Standard deviation of normal noise, in steps of the output, from which rounding adds a twelfth of the step's square
to its variance, to 3 %, wherever its mean lies."""
_LONG_S: Final = 5.0  # between samples: of a slow sensor, or of a clock in another unit
_ALONE: Final = 0.5  # of the range of all other readings
_FLAGS: Final = re.compile(r"0*(3276[78]|9{3,})0*")
"""Digits of the ends of 16 bits, and of nines."""
_UNEVEN: Final = 0.02
_BOUNDED: Final = 0.99  # probability
_CERTAIN: Final = 3.0  # standard deviations
_MOVING: Final = 2.0  # times the squares of a log at rest, which are noise
_SHOWN: Final = 3


@dataclass(frozen=True)
class Term:
    """value: found; visible: whether the record shows it, or only bounds it from above; most: that bound, at 99 %."""

    value: float
    visible: bool
    most: float


@dataclass(frozen=True)
class SensorNoise:
    """Terms of a sensor's noise, with the unit x of its reading.

    Attributes:
        white: density without that of rounding [x/sqrt(Hz)]; bias_instability: B, the curve's floor is 0.664 B [x];
            random_walk: [x/sqrt(s)]; resolution: step of the output [x], 0 where none is seen; mean, deviation of all
            samples [x].
        tau, allan: averaging times [s] and Allan deviations [x], `(n,)`; rate: [Hz]; samples.
    """

    white: Term
    bias_instability: Term
    random_walk: Term
    resolution: float
    mean: float
    deviation: float
    tau: Floats
    allan: Floats
    rate: float
    samples: int


@dataclass(frozen=True)
class BeamNoise:
    """Noise of one beam of a four-beam velocity log.

    Attributes:
        noise_mps: at rest [m/s]; noise_relative: in parts of the speed along the beam; 0 where the record shows none.
        most_mps, most_relative: the largest that the joint fit allows, its variances plus 3 standard deviations.
        speed_mps: root mean square along the beams [m/s].
        lost: share of pings without it, by beam `(4,)`; pings: with all four.
    """

    noise_mps: float
    noise_relative: float
    most_mps: float
    most_relative: float
    speed_mps: float
    lost: tuple[float, ...]
    pings: int


def allan_deviation(values: Floats, m: int) -> float:
    """Overlapping Allan deviation of samples that are averaged m at a time."""
    total = np.concatenate([[0.0], np.cumsum(values - values.mean())]) / m
    second = total[2 * m :] - 2 * total[m:-m] + total[: -2 * m]
    return float(np.sqrt(0.5 * np.mean(second**2)))


def even_rate(time: Floats) -> float:
    """Samples per second of a record.

    Raises:
        InputError: times are not finite, out of order, twice, or not even.
    """
    step = np.diff(time)
    faults = ((~np.isfinite(step), "are not numbers"), (step < 0, "are not in order"), (step == 0, "occur twice"))
    for wrong, words in faults:
        if wrong.any():
            rows = ", ".join(str(k + 2) for k in np.flatnonzero(wrong)[:_SHOWN])
            raise InputError(f"times {words}: row {rows} ({int(wrong.sum())} such)")
    middle = float(np.median(step))
    if middle > _LONG_S:
        text = f"samples are {middle:.4g} s apart: if the time is in ms, us or ns, give seconds, or --time-unit"
        warnings.warn(text, PelagosWarning, stacklevel=2)
    off = np.abs(step - middle) > max(0.5 * middle, 1e-9)
    if off.any() or abs(float(step.mean()) / middle - 1) > _UNEVEN:
        k = int(np.argmax(np.abs(step - middle)))
        raise InputError(
            f"an Allan deviation needs even times: steps are {middle:.4g} s, but {step[k]:.4g} s at {time[k]:.6g} s "
            f"({int(off.sum())} such); give a stretch without holes"
        )
    return 1 / float(step.mean())


def fit_noise(values: Floats, rate_hz: float, *, label: str = "") -> SensorNoise:
    """Noise terms of a sensor that was at rest.

    Args:
        values: samples `(n,)`, evenly in time, of a quantity that did not change.
        rate_hz: samples per second.
        label: for warnings, such as "gyro_x: ".

    Raises:
        InputError: fewer than 200 samples, or some not finite, or all the same.

    Warns:
        PelagosWarning: samples stand out, or the curve is not that of the three terms.
    """
    values = np.asarray(values, dtype=np.float64)
    if len(values) < _FEWEST:
        raise InputError(f"{len(values)} samples are too few for an Allan deviation: give {_FEWEST} or more")
    if not np.isfinite(values).all():
        rows = ", ".join(str(k + 1) for k in np.flatnonzero(~np.isfinite(values))[:_SHOWN])
        raise InputError(f"samples that are no numbers: {rows} ({int((~np.isfinite(values)).sum())} such)")
    if np.ptp(values) == 0:
        raise InputError("all samples are the same: there is no noise in this record")
    longest = len(values) // _LONGEST
    counts = np.unique(np.geomspace(1, longest, max(4, round(_PER_DECADE * np.log10(longest)))).astype(int))
    deviation = np.array([allan_deviation(values, int(m)) for m in counts])
    tau = counts / rate_hz
    # samples of a walk (not its means): the second difference of means of m has the variance K^2 (2 m^2 + 1)/(3 m) step
    terms = np.stack([1 / tau, np.full(len(tau), FLOOR**2), tau / 3 * (1 + 0.5 / counts**2)], axis=-1)
    squares, seen = terms_of(terms, deviation, len(values) / counts)
    step = _step_of(values)
    rounding = step**2 / 12 / rate_hz  # white as well, and the sensor adds it by itself where it has this resolution
    own = np.maximum(squares - [rounding, 0.0, 0.0], 0.0)
    most = _most(terms, deviation, len(values) / counts - 1)
    white, floor, walk = (
        Term(float(np.sqrt(s)), bool(v and s > 0), float(m)) for s, v, m in zip(own, seen, most, strict=True)
    )
    off = np.log(deviation / np.sqrt(np.maximum(terms @ squares, 1e-300)))
    doubts = [*_doubts(values, rate_hz, tau, np.where(counts <= len(values) / _KNOWN, off, 0.0))]
    if seen[0] and own[0] * rate_hz < (_COARSE * step) ** 2:
        doubts.append(
            f"white noise of {np.sqrt(own[0] * rate_hz):.2g} a sample is less than half of the output's step "
            f"{step:.3g}, which hides its size: take it for a guess"
        )
    for text in doubts:
        warnings.warn(label + text, PelagosWarning, stacklevel=2)
    return SensorNoise(
        white,
        floor,
        walk,
        step,
        float(values.mean()),
        float(values.std()),
        tau,
        deviation,
        rate_hz,
        len(values),
    )


def _most(terms: Floats, deviation: Floats, freedoms: Floats) -> Floats:
    """Largest size of each of `terms` `(n, 3)` that stands nowhere above the measured curve, as far as it is known.

    An Allan variance s^2 of nu degrees of freedom is below nu s^2/chi^2(nu) with the probability of chi^2 (W. J. Riley,
    NIST Special Publication 1065, 2008, Section 5.3).
    """
    highest = deviation**2 * freedoms / chdtri(freedoms, _BOUNDED)
    return np.asarray(np.sqrt((highest[:, None] / terms).min(axis=0)))


def _doubts(values: Floats, rate_hz: float, tau: Floats, off: Floats) -> Iterator[str]:
    """Faults of a record in words: samples that stand out, and a curve that is `off` (logarithm) at `tau` [s]."""
    change = np.abs(np.diff(values))
    usual = float(np.median(change[change > 0]))
    far = np.flatnonzero(change > _OUTLIER * usual)
    if len(far):
        k = int(far[0])
        yield (
            f"{len(far)} changes from sample to sample are more than {_OUTLIER:g} times the usual {usual:.2g}, the "
            f"first after sample {k + 1} ({k / rate_hz:.6g} s): leave faults out, or give a stretch without them"
        )
    slope, share = _drift(values)
    if share > _STRAIGHT:
        yield (
            f"the mean drifts by {slope * rate_hz:.2g} a second, straight as no noise goes, and counts as random walk: "
            "was the sensor warm? Give a later stretch, or take the drift away"
        )
        return
    k = int(np.argmax(np.abs(off)))
    if abs(off[k]) > _UNLIKE:
        yield (
            f"the Allan deviation at {tau[k]:.3g} s is {np.exp(off[k]):.2g} times what white noise, bias instability "
            "and random walk make together: was the sensor at rest, and warm?"
        )


def _drift(values: Floats) -> tuple[float, float]:
    """Slope of a straight line through means of a record, a sample, and its share in their variance."""
    length = len(values) // _PARTS
    means = values[: _PARTS * length].reshape(_PARTS, length).mean(axis=1)
    means -= means.mean()
    place = np.arange(_PARTS) - (_PARTS - 1) / 2
    slope = place @ means / (place @ place)
    return float(slope / length), float(slope**2 * (place @ place) / max(means @ means, 1e-300))


def _step_of(values: Floats) -> float:
    """Step of a digital output: the smallest difference between levels, if all are multiples of it."""
    levels = np.unique(values)
    if len(levels) > len(values) // 4:
        return 0.0
    step = float(np.diff(levels).min())
    multiples = np.diff(levels) / step
    uneven = np.abs(multiples - np.round(multiples)) > _UNEVEN * multiples
    return 0.0 if uneven.any() else step


def fit_beams(beams: Sequence[Floats]) -> BeamNoise:
    """Noise of a Janus log's beams while it moves as it likes.

    Of four beams in order around the vertical, b1 - b2 + b3 - b4 = 0 for any velocity: what is left is noise, with the
    variance 4 noise^2 + relative^2 (v1^2 + v2^2 + v3^2 + v4^2). The squares of the true speeds v are taken from the
    three other sums, whose noise is independent of what is left: by squares of the beams themselves, the noise of a
    log at rest would be in proportion to its own size.

    Args:
        beams: speeds along each `(n,)` [m/s]; NaN where it was lost.

    Raises:
        InputError: not four, of unequal length, or fewer than 200 pings with all four; a beam that never changes, or is
            0 where it was lost; or their sum says that they are not in order around, or one of another sign or unit.

    Warns:
        PelagosWarning: beams hold a number that an instrument writes where it lost them, or pings stand out: both are
            left out; a beam has another scale than the others, or an offset that changes; a noise that no log has.
    """
    if len(beams) != 4 or len({len(b) for b in beams}) != 1:
        raise InputError(f"give four beams with as many pings each, not {[len(b) for b in beams]}")
    table = np.stack([np.asarray(b, dtype=np.float64) for b in beams], axis=-1)
    refuse_constant(table)
    table = _without_lost_marks(table)
    heard = np.isfinite(table)
    whole = table[heard.all(axis=1)]
    if len(whole) < _FEWEST:
        raise InputError(f"{len(whole)} pings have all four beams: give {_FEWEST} or more")
    fastest = float(np.abs(whole).max())
    if fastest > PLAUSIBLE["u"]:
        raise InputError(f"a beam reads {fastest:.4g} m/s, more than any vehicle has; in mm/s? Give m/s")
    left = whole @ AROUND
    if np.ptp(left) == 0:
        raise InputError("b1 - b2 + b3 - b4 never changes: there is no noise in this record")
    refuse_zeros(whole, left)
    if (whole @ OTHERS.T).std(axis=0).min() < 0.5 * float(left.std()):
        raise InputError(
            "the beams are not in order around the vertical, another order leaves less: opposite ones are 1, 3 and 2, 4"
        )
    far = standing_out(whole, left)
    if far.any():
        first = int(np.flatnonzero(heard.all(axis=1))[far][0]) + 1
        text = f"{int(far.sum())} pings stand out, the first in row {first}: left out"
        warnings.warn(f"b1 - b2 + b3 - b4: {text}", PelagosWarning, stacklevel=2)
        whole, left = whole[~far], left[~far]
    told = refuse_contradicted(whole, left)
    squares, most = _variances(whole, left)
    lost = tuple(float(x) for x in 1 - heard.mean(axis=0))
    noise, relative = (float(x) for x in np.sqrt(squares))
    if not told:
        warn_of_wandering(left)
    warn_of_noise(noise)
    speed = float(np.sqrt(np.mean(whole**2)))
    return BeamNoise(noise, relative, float(most[0]), float(most[1]), speed, lost, len(whole))


def _variances(whole: Floats, left: Floats) -> tuple[Floats, Floats]:
    """Squares of the noise at rest and of the relative one `(2,)`, and the most of both `(2,)`."""
    off = (left - left.mean()) ** 2
    basis = np.stack([np.full(len(whole), 4.0), ((whole @ OTHERS.T) ** 2).sum(axis=1) / 4], axis=-1)
    squares, unsure = _reweighted(basis, off)
    most = np.sqrt(squares + _CERTAIN * unsure)
    at_rest = float(basis[:, 1].mean()) < _MOVING * 0.75 * float(off.mean())  # of three sums with the noise of this
    for k in (1, 0):  # hardly changing its speed a log does not tell them apart: the relative one goes first
        if squares[k] < _CERTAIN * unsure[k] or (k == 1 and at_rest):
            squares = np.zeros(2)
            squares[1 - k] = _reweighted(basis[:, [1 - k]], off)[0][0]
            break
    return squares, most


def _reweighted(basis: Floats, off: Floats) -> tuple[Floats, Floats]:
    """Coefficients of `basis` `(n, c)`, not negative, in expectations of squares `off` `(n,)`; standard deviations.

    The square of normal noise scatters as its own expectation, with sqrt(2) of it.
    """
    mean, size = float(off.mean()), basis.mean(axis=0)
    basis = basis / size
    model = np.full(len(off), mean)
    for _ in range(REWEIGHTED):
        squares = nnls(basis / model[:, None], off / model)[0]
        model = np.maximum(basis @ squares, LEAST * mean)
    weighted = basis / model[:, None]
    return squares / size, np.sqrt(2 * np.diag(np.linalg.pinv(weighted.T @ weighted))) / size


def _without_lost_marks(table: Floats) -> Floats:
    """Beams `(n, 4)`; NaN where they hold a number that means that they were lost.

    It is the largest or the least of all, far from all others, and there more than once or of the digits that
    instruments are known to write: -32.768, 9.999 and the like.
    """
    table = table.copy()
    while np.isfinite(table).any():
        known = np.unique(table[np.isfinite(table)])
        for value, rest in ((known[-1], known[:-1]), (known[0], known[1:])):
            at = table == value
            usual = table[~at.any(axis=1)]
            if len(rest) < 2 or not (at.sum() > 1 or _FLAGS.fullmatch(f"{abs(value):g}".replace(".", ""))):
                continue
            left = usual[np.isfinite(usual).all(axis=1)] @ AROUND
            noise = max(_size(left) if len(left) else 0.0, float(np.diff(rest).min()))
            if np.abs(rest - value).min() > max(_ALONE * float(np.ptp(rest)), STRAY * noise):
                places = ", ".join(f"beam {k + 1} in {n} pings" for k, n in enumerate(at.sum(axis=0)) if n)
                text = f"{value:g} is taken for the mark of a lost beam: {places}; leave lost cells empty"
                warnings.warn(text, PelagosWarning, stacklevel=3)
                table[at] = np.nan
                break
        else:
            break
    return table


def _size(left: Floats) -> float:
    """Standard deviation of most of what is left."""
    return normal_size(left - np.median(left))


def keys_of(found: Mapping[str, SensorNoise], prefix: str) -> dict[str, float]:
    """Keys of a simulated sensor: root mean squares over its axes, 0 for terms that no axis shows.

    Args:
        found: by axis; prefix: such as "gyroscope_", "accelerometer_" of the `imu`.
    """
    made = {}
    names = {"noise_density": "white", "bias_instability": "bias_instability", "random_walk": "random_walk"}
    for key, name in names.items():
        terms = [getattr(n, name) for n in found.values()]
        seen = [t.value for t in terms if t.visible]
        made[prefix + key] = float(np.sqrt(np.mean(np.square(seen)))) if seen else 0.0
    made[prefix + "resolution"] = max(n.resolution for n in found.values())
    return made
