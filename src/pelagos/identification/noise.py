"""Noise of a sensor from its own record: the terms of its Allan deviation, and of a velocity log's beams.

Sources: IEEE Std 952-1997, Annex C (terms of the Allan variance); D. A. Howe, D. W. Allan, J. A. Barnes, "Properties of
signal sources and measurement methods", Proc. 35th Annual Symposium on Frequency Control (1981) (overlapping samples).
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from pelagos.errors import InputError, PelagosWarning
from pelagos.identification.coordinates import PLAUSIBLE
from pelagos.sensors.noise import FLOOR

Floats = NDArray[np.float64]
_FEWEST: Final = 200  # samples
_LONGEST: Final = 9  # clusters that the longest averaging time must leave
_PER_DECADE: Final = 6
_VISIBLE: Final = 0.25
"""Share of the variance that a term must have at some averaging time to be seen by eye in the curve."""
_SURE: Final = 2.0  # standard deviations of the curve, which a term must exceed besides
_UNLIKE: Final = 0.5
"""Logarithm of measured over modelled deviation from which the three terms are not what the record shows, where the
curve is known to a tenth."""
_KNOWN: Final = 50  # clusters that know the curve to a tenth (IEEE Std 952-1997, equation C.20)
_OUTLIER: Final = 30.0  # of the median change from sample to sample: normal noise changes by 7 of it once in 1e6
_LONG_S: Final = 5.0  # between samples: of a slow sensor, or of a clock in another unit
_ZEROS: Final = 0.005  # share of pings
_STRAY: Final = 10.0  # standard deviations
_UNEVEN: Final = 0.02
_REWEIGHTED: Final = 6
_AROUND: Final = np.array([1.0, -1.0, 1.0, -1.0])
"""Signs of beams in order around the vertical that leave nothing of a velocity."""
_SHOWN: Final = 3


@dataclass(frozen=True)
class Term:
    """value: found; visible: whether the record shows it, or only bounds it from above."""

    value: float
    visible: bool


@dataclass(frozen=True)
class SensorNoise:
    """Terms of a sensor's noise, with the unit x of its reading.

    Attributes:
        white: density [x/sqrt(Hz)]; bias_instability: B, the curve's floor is 0.664 B [x]; random_walk: [x/sqrt(s)];
            resolution: step of the output [x], 0 where none is seen; mean, deviation of all samples [x].
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
        noise_mps: at rest [m/s]; noise_relative: in parts of the speed along the beam; lost: share of pings without it,
            by beam `(4,)`; pings: with all four.
    """

    noise_mps: float
    noise_relative: float
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
    weight = np.sqrt(len(values) / counts) / deviation**2  # an Allan variance is known to sqrt(m/n) of itself
    squares = nnls(terms * weight[:, None], deviation**2 * weight)[0]
    unsure = np.sqrt(2 / (len(values) / counts - 1))  # of an Allan variance, relative: IEEE Std 952-1997, equation C.20
    seen = (terms * squares / deviation[:, None] ** 2 > np.maximum(_VISIBLE, _SURE * unsure)[:, None]).any(axis=0)
    white, floor, walk = (Term(float(np.sqrt(s)), bool(v)) for s, v in zip(squares, seen, strict=True))
    off = np.log(deviation / np.sqrt(np.maximum(terms @ squares, 1e-300)))
    for text in _doubts(values, rate_hz, tau, np.where(counts <= len(values) / _KNOWN, off, 0.0)):
        warnings.warn(label + text, PelagosWarning, stacklevel=2)
    return SensorNoise(
        white,
        floor,
        walk,
        _step_of(values),
        float(values.mean()),
        float(values.std()),
        tau,
        deviation,
        rate_hz,
        len(values),
    )


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
    k = int(np.argmax(np.abs(off)))
    if abs(off[k]) > _UNLIKE:
        yield (
            f"the Allan deviation at {tau[k]:.3g} s is {np.exp(off[k]):.2g} times what white noise, bias instability "
            "and random walk make together: was the sensor at rest, and warm?"
        )


def _step_of(values: Floats) -> float:
    """Step of a digital output: the smallest difference between levels, if all are multiples of it."""
    levels = np.unique(values)
    if len(levels) > len(values) // 4:
        return 0.0
    step = float(np.diff(levels).min())
    multiples = np.diff(levels) / step
    return step if np.abs(multiples - np.round(multiples)).max() < _UNEVEN * max(1.0, float(multiples.max())) else 0.0


def fit_beams(beams: Sequence[Floats]) -> BeamNoise:
    """Noise of a Janus log's beams while it moves as it likes.

    Of four beams in order around the vertical, b1 - b2 + b3 - b4 = 0 for any velocity: what is left is noise, with the
    variance 4 noise^2 + relative^2 (b1^2 + b2^2 + b3^2 + b4^2).

    Args:
        beams: speeds along each `(n,)` [m/s]; NaN where it was lost.

    Raises:
        InputError: not four, of unequal length, or fewer than 200 pings with all four; or their sum says that they are
            not in order around.
    """
    if len(beams) != 4 or len({len(b) for b in beams}) != 1:
        raise InputError(f"give four beams with as many pings each, not {[len(b) for b in beams]}")
    table = np.stack([np.asarray(b, dtype=np.float64) for b in beams], axis=-1)
    heard = np.isfinite(table)
    whole = table[heard.all(axis=1)]
    if len(whole) < _FEWEST:
        raise InputError(f"{len(whole)} pings have all four beams: give {_FEWEST} or more")
    fastest = float(np.abs(whole).max())
    if fastest > PLAUSIBLE["u"]:
        raise InputError(f"a beam reads {fastest:.4g} m/s, more than any vehicle has; in mm/s? Give m/s")
    left = whole @ _AROUND
    if np.ptp(left) == 0:
        raise InputError("b1 - b2 + b3 - b4 never changes: there is no noise in this record")
    _refuse_zeros(whole, left)
    size = (whole**2).sum(axis=1)
    others = [whole @ s for s in ([1.0, 1.0, -1.0, -1.0], [1.0, -1.0, -1.0, 1.0])]
    if min(float(x.std()) for x in others) < 0.5 * float(left.std()):
        raise InputError(
            "the beams are not in order around the vertical, another order leaves less: opposite ones are 1, 3 and 2, 4"
        )
    off = left - left.mean()
    basis = np.stack([np.full(len(whole), 4.0), size], axis=-1)
    model = np.full(len(whole), float(np.mean(off**2)))
    for _ in range(_REWEIGHTED):  # the square of normal noise scatters as its own expectation
        squares = nnls(basis / model[:, None], off**2 / model)[0]
        model = np.maximum(basis @ squares, 1e-3 * float(np.mean(off**2)))
    lost = tuple(float(x) for x in 1 - heard.mean(axis=0))
    return BeamNoise(float(np.sqrt(squares[0])), float(np.sqrt(squares[1])), lost, len(whole))


def _refuse_zeros(whole: Floats, left: Floats) -> None:
    """Refuse beams `(n, 4)` that write 0 where they are lost, by the other three."""
    noise = 1.4826 * float(np.median(np.abs(left - np.median(left))))
    for k in range(4):
        stray = (whole[:, k] == 0) & (np.abs(left) > _STRAY * noise)
        if stray.mean() > _ZEROS:
            raise InputError(
                f"beam {k + 1} reads exactly 0 in {int(stray.sum())} pings in which the other three say otherwise, "
                f"the first in row {int(np.argmax(stray)) + 1} of those with four beams: leave lost cells empty"
            )


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
