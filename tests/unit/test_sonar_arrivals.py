"""Other sonars' pulses as they arrive in bins and beams, against a sum written out."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos import jit
from pelagos.acoustics.echo_walk import Bins
from pelagos.acoustics.interference import Sent, through_filter
from pelagos.sensors.sonar.ping.arrivals import arrivals
from pelagos.sensors.sonar.ping.interference import Heard, Pulses

SPEED, LOSS = np.array([1475.0, 1520.0]), np.array([0.03, 0.06])
BINS, BEAMS, BANDWIDTH = Bins(80, 2.0, 0.25), 3, 1.5e3
DISTANCE = np.array([[19.0, 41.5], [33.3, np.inf]])  # two places by two lanes
SINCE = np.array([[0.0037, 0.031], [0.0022, 0.0]])
SOURCE = np.array([[1, 0], [0, 0]])
PERIOD, FREQUENCY = np.array([0.0113, 0.0071]), np.array([61e3, 66e3])
FIRST, TAPS, LEAD, STEP = np.array([5, 0]), np.array([9, 4]), np.array([-0.0003, 0.0001]), np.array([1.3e-4, 2.1e-4])


def heard() -> tuple[Heard, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(4)
    signal = rng.normal(size=14) + 1j * rng.normal(size=14)
    level = rng.uniform(0.1, 2.0, (2, 2, BEAMS))
    pairs = np.stack([signal.real, signal.imag], axis=-1)
    made = Heard(
        jit.Float(DISTANCE.ravel()), jit.Array3f(1.0, 0.0, 0.0), jit.Float(SINCE.ravel()), jit.Float(level.ravel()),
        jit.UInt32(SOURCE.ravel()), jit.Float(PERIOD), jit.Float(FREQUENCY), jit.Float(pairs.ravel()),
        jit.UInt32(FIRST), jit.UInt32(TAPS), jit.Float(LEAD), jit.Float(STEP),
    )  # fmt: skip
    return made, signal, level


def test_each_bin_keeps_the_loudest_sample_of_each_pulse_with_the_phase_of_its_way() -> None:
    """All pulses of a period, from before the window to behind it; two samples a bin."""
    made, signal, level = heard()
    medium = SimpleNamespace(sound_speed=jit.Float(SPEED), absorption=jit.Float(LOSS))
    lanes: Any = SimpleNamespace(position=jit.Array3f64(np.zeros((3, 2))), medium=medium)
    found = np.array(arrivals(made, lanes, BINS, beams=BEAMS, bandwidth_hz=BANDWIDTH)).reshape(2, BEAMS, BINS.count, 2)
    samples = int(np.ceil(2 * BINS.width / 1400.0 * BANDWIDTH / 0.3))
    assert samples == 2
    unsure = np.zeros((2, BINS.count), bool)
    by_beam = np.zeros((2, BEAMS, BINS.count), complex)
    pulses = 0
    for lane in range(2):
        c = SPEED[lane]
        for place in range(2):
            d, s = DISTANCE[place, lane], SOURCE[place, lane]
            if not np.isfinite(d):
                continue
            turn = np.exp(-2j * np.pi * (d * FREQUENCY[s] / c % 1.0)) * 10 ** (-LOSS[lane] * d / 20)
            for n in range(-9, 9):
                at = d / c - SINCE[place, lane] + LEAD[s] + n * PERIOD[s]
                shape = np.zeros(BINS.count, complex)
                for b in range(BINS.count):
                    now = 2 * (BINS.first_range + (b + (np.arange(samples) + 0.5) / samples) * BINS.width) / c
                    place_of = (now - at) / STEP[s]
                    tap = np.round(place_of).astype(int)
                    ok = (tap >= 0) & (tap < TAPS[s])
                    near = (place_of > -1) & (place_of < TAPS[s])
                    unsure[lane, b] |= bool((np.abs(place_of % 1 - 0.5)[near] < 3e-3).any())
                    if ok.any():
                        values = signal[FIRST[s] + tap[ok]]
                        shape[b] = values[np.abs(values).argmax()]
                pulses += bool(shape.any())
                by_beam[lane] += shape * turn * np.sqrt(level[place, lane])[:, None]
    assert pulses > 5
    assert unsure.mean() < 0.2
    got = found[..., 0] + 1j * found[..., 1]
    for lane in range(2):
        sure = ~unsure[lane]
        assert got[lane][:, sure] == pytest.approx(by_beam[lane][:, sure], abs=2e-2)
    assert np.abs(by_beam).max() > 1.0


def test_pulses_are_kept_once_each_in_one_row_of_samples() -> None:
    own, others = Sent(100e3, 20e3, 1e-3), [Sent(104e3, 10e3, 2e-3), Sent(100e3, 20e3, 1e-3), Sent(104e3, 10e3, 2e-3)]
    made = Pulses.of(own, others)
    assert list(made.rows) == others[:2]
    signal = np.array(made.signal).view(np.complex64)
    for other in others:
        first, taps, lead, step = made.rows[other]
        alone = through_filter(own, other)
        assert signal[first : first + taps] == pytest.approx(alone.signal)
        assert (lead, step) == (alone.lead_s, alone.step_s)
    assert len(signal) == sum(made.rows[o][1] for o in others[:2])


@pytest.mark.parametrize(("own_s", "other_s"), [(2e-3, 3e-3), (1e-3, 0.3e-3), (0.4e-3, 1e-3), (2e-3, 0.25e-3)])
def test_a_burst_comes_out_of_a_bursts_filter_as_the_correlation_of_two_rectangles(
    own_s: float, other_s: float
) -> None:
    """In the same band: a trapezium, flat for as long as one is longer. 64 samples of the shorter: 1.6 % of the top."""
    found = through_filter(Sent(50e3, 1 / own_s, own_s, "cw"), Sent(50e3, 1 / other_s, other_s, "cw"))
    time = found.lead_s + found.step_s * np.arange(len(found.signal))
    short = min(own_s, other_s)
    expected = short / own_s * np.clip((0.5 * (own_s + other_s) - np.abs(time)) / short, 0.0, 1.0)
    assert found.signal.real == pytest.approx(expected, abs=0.02 * short / own_s)
    assert np.abs(found.signal.imag).max() < 1e-6


def test_a_burst_off_the_filters_centre_comes_out_as_the_integral_of_its_beat() -> None:
    """310 Hz off, 2 ms within 3 ms: |sin(pi f T)/(pi f T)| by the time T of overlap; it turns with the beat."""
    off, short = 310.0, 2e-3
    found = through_filter(Sent(50e3, 1 / short, short, "cw"), Sent(50e3 + off, 1 / 3e-3, 3e-3, "cw"))
    time = found.lead_s + found.step_s * np.arange(len(found.signal))
    overlap = np.clip(2.5e-3 - np.abs(time), 0.0, short)
    expected = np.abs(np.sinc(off * overlap)) * overlap / short
    assert np.abs(found.signal) == pytest.approx(expected, abs=0.02)
    flat = np.abs(time) < 0.5e-3
    assert flat.sum() >= 2
    turned = found.signal[flat] * np.exp(-2j * np.pi * off * time[flat])
    assert np.abs(np.angle(turned)).max() < 0.05
