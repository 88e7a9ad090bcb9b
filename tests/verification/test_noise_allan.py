"""Noise against the Allan deviations that IEEE Std 952-1997, Annex C, gives for each of its terms.

The Allan deviation used here is itself checked against the 1000-point set of the National Bureau of Standards (W. J.
Riley, NIST Special Publication 1065, 2008, page 108).
"""

import numpy as np
import pytest
from numpy.typing import NDArray

from pelagos import jit
from pelagos.sensors import noise
from pelagos.sensors.example_motion import lanes


def allan_deviation(rate: NDArray[np.float64], m: int) -> float:
    """Overlapping, from frequency-like data and an averaging factor."""
    x = np.concatenate([[0.0], np.cumsum(rate)]) / m
    second = x[2 * m :] - 2 * x[m:-m] + x[: -2 * m]
    return float(np.sqrt(0.5 * np.mean(second**2)))


def series(make, seconds: float, step_s: float, runs: int) -> NDArray[np.float64]:
    """(runs, samples) of a noise: one environment a run."""
    count = round(seconds / step_s)
    key = noise.opaque_key(noise.stream_key(3, "auv0.imu", "noise"))
    frozen = jit.freeze(make)
    rows = [
        np.array(frozen(key, lanes(range(count), dt_ns=round(step_s * 1e9), environments=(run,))))
        for run in range(runs)
    ]
    return np.array(rows)


def mean_deviation(rows: NDArray[np.float64], m: int) -> float:
    return float(np.sqrt(np.mean([allan_deviation(row, m) ** 2 for row in rows])))


def test_the_measure_itself_on_the_nbs_set() -> None:
    x, values = 1234567890, []
    for _ in range(1000):
        values.append(x / 2147483647)
        x = 16807 * x % 2147483647
    data = np.array(values)
    assert allan_deviation(data, 1) == pytest.approx(2.922319e-1, rel=1e-6)
    assert allan_deviation(data, 10) == pytest.approx(9.159953e-2, rel=1e-6)
    assert allan_deviation(data, 100) == pytest.approx(3.241343e-2, rel=1e-6)


@pytest.mark.parametrize("rate", [50.0, 200.0])
def test_white_noise_has_its_density_at_any_rate(rate: float) -> None:
    """N / sqrt(tau). 60 000 samples: the deviation at m = 10 is known to 1 %, at 100 to 3 % (one standard
    deviation).
    """
    n = 0.02
    rows = (
        series(lambda key, motion: noise.normals64(key, motion, 1)[0], 60_000 / rate, 1 / rate, 1) * n * np.sqrt(rate)
    )
    for m, tolerance in ((10, 0.03), (100, 0.1)):
        assert allan_deviation(rows[0], m) == pytest.approx(n / np.sqrt(m / rate), rel=tolerance)


def test_random_walk() -> None:
    """K sqrt(tau / 3) above the 4 s between which the walk is linear; 20 runs of 20 000 s."""
    rows = series(lambda key, motion: noise.random_walk(key, motion, 1)[0], 20_000, 2.0, 20)
    assert (rows[:, 0] == 0).all()
    for m, tolerance in ((20, 0.03), (100, 0.05), (500, 0.1)):
        assert mean_deviation(rows, m) == pytest.approx(np.sqrt(m * 2.0 / 3), rel=tolerance)


def test_random_walk_goes_on_beyond_its_longest_span() -> None:
    """The variance stays t: 400 walks at 18.2 h, 40 h, 100 h, and the increments between are independent."""
    dt_ns = 1_000_000_000
    ticks = (65_000, 144_000, 360_000)
    key = noise.opaque_key(noise.stream_key(3, "auv0.imu", "noise"))
    walk = jit.freeze(lambda key, motion: noise.random_walk(key, motion, 1)[0])
    values = np.array(walk(key, lanes(ticks, dt_ns=dt_ns, environments=range(400)))).reshape(3, 400)
    for row, t in zip(values, ticks, strict=True):
        assert np.var(row) / t == pytest.approx(1.0, abs=4 * np.sqrt(2 / 400))
    assert abs(np.corrcoef(values[0], values[1] - values[0])[0, 1]) < 4 / 20
    across = np.array(walk(key, lanes(range(65_530, 65_542), dt_ns=dt_ns)))
    assert np.abs(np.diff(across)).max() < 5 * np.sqrt(4)  # no jump where two spans meet


def test_gauss_markov() -> None:
    """(T/a)(2 - (T/a)(3 - 4 e^{-a/T} + e^{-2a/T})) for variance 1, and the autocorrelation e^{-t/T}; 40 runs of 100
    T.
    """
    big_t = 50.0
    rows = series(lambda key, motion: noise.gauss_markov(key, motion, 1, correlation_time=big_t)[0], 5_000, 5.0, 40)
    loss = 1 - 1 / 48  # of variance, by linear interpolation between values T/16 apart: 2/3 + rho/3, rho = 1 - 1/16
    assert np.mean(rows**2) == pytest.approx(loss, abs=4 * np.sqrt(2 / (40 * 50)))
    for lag in (5, 10, 30):
        assert np.mean(rows[:, lag:] * rows[:, :-lag]) == pytest.approx(np.exp(-lag * 5 / big_t), abs=0.1)
    for m in (10, 20, 60):
        a = m * 5.0 / big_t
        expected = np.sqrt((2 - (3 - 4 * np.exp(-a) + np.exp(-2 * a)) / a) / a)
        assert mean_deviation(rows, m) == pytest.approx(expected, rel=0.06)


def test_bias_instability_peaks_at_the_floor() -> None:
    """0.664 B at 1.89 T."""
    big_t = 50.0
    rows = series(lambda key, motion: noise.bias_instability(key, motion, 1, correlation_time=big_t)[0], 5_000, 5.0, 40)
    assert mean_deviation(rows, 19) == pytest.approx(0.664, rel=0.05)
    assert mean_deviation(rows, 2) < 0.4
    assert mean_deviation(rows, 100) < 0.6
