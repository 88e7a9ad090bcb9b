"""Taps, samples between samples, and noise of a channel, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos.acoustics.channel import (
    ambient_density,
    delay_spread,
    impulse_response,
    interpolated,
    noise_of,
    received,
    spectral_level,
)

DELAY, AMPLITUDE = np.array([0.0412, 0.0437, 0.0531]), np.array([0.02 - 0.01j, -0.015j, 0.004 + 0.011j])
CARRIER, RATE = 11_300.0, 4_000.0


def test_delays_are_spread_by_their_power() -> None:
    """Powers 4 and 1 at 0.10 and 0.25 s: 0.06 s about 0.13 s; silence is not spread."""
    assert delay_spread(np.array([0.1, 0.25]), np.array([1.2 - 1.6j, 1j])) == pytest.approx(0.06, rel=1e-12)
    assert delay_spread(np.array([0.1, 0.2]), np.zeros(2, complex)) == 0.0
    assert delay_spread(np.zeros(0), np.zeros(0, complex)) == 0.0


def test_taps_begin_and_end_half_a_filter_beside_the_paths_or_where_they_are_asked_for() -> None:
    first, taps = impulse_response(DELAY, AMPLITUDE, carrier=CARRIER, sample_rate=RATE)
    assert first == pytest.approx(DELAY[0] - 16 / RATE)
    assert first + (len(taps) - 1) / RATE == pytest.approx(DELAY[-1] + 16 / RATE, abs=1 / RATE)
    late = first + 20 / RATE  # amid the first pulse
    start, cut = impulse_response(DELAY, AMPLITUDE, carrier=CARRIER, sample_rate=RATE, start=late, taps=9)
    assert start == late
    np.testing.assert_allclose(cut, taps[20:29], atol=1e-12)
    assert np.abs(cut).max() > 1e-3
    early, wide = impulse_response(
        DELAY, AMPLITUDE, carrier=CARRIER, sample_rate=RATE, start=first - 3 / RATE, taps=400
    )
    assert early == first - 3 / RATE
    np.testing.assert_allclose(wide[: len(taps) + 3], np.concatenate([np.zeros(3), taps]), atol=1e-7)
    assert not wide[len(taps) + 4 :].any()
    whole = DELAY[:1].round(3)  # on a sample: one tap
    _, alone = impulse_response(whole, AMPLITUDE[:1], carrier=CARRIER, sample_rate=RATE)
    assert alone[16] == pytest.approx(AMPLITUDE[0] * np.exp(-2j * np.pi * CARRIER * whole[0]), rel=1e-9)
    assert np.abs(np.delete(alone, 16)).max() < 1e-12


@pytest.mark.parametrize("start", [None, 0.3])
@pytest.mark.parametrize("taps", [None, 7])
def test_without_paths_there_is_silence_of_the_length_that_is_asked_for(start: float | None, taps: int | None) -> None:
    at, made = impulse_response(
        np.zeros(0), np.zeros(0, complex), carrier=CARRIER, sample_rate=RATE, start=start, taps=taps
    )
    assert (at, made.tolist()) == (start or 0.0, [0.0] * (taps or 0))


def test_values_between_samples_are_those_of_the_tone() -> None:
    """To 60 dB at 0.36 of the rate; a pulse rings for half a filter to both sides, and no farther."""
    n = np.arange(120)
    place = np.array([30.0, 47.25, 60.5, 71.9])
    found = interpolated(np.exp(2j * np.pi * 0.36 * n), place)
    np.testing.assert_allclose(found, np.exp(2j * np.pi * 0.36 * place), atol=1e-3)
    pulse = interpolated(np.ones(1, complex), np.array([-16.5, -15.5, -0.5, 0.0, 0.5, 15.5, 16.5]))
    np.testing.assert_allclose(pulse, pulse[::-1], atol=1e-15)
    assert pulse[3] == pytest.approx(1.0)
    assert 0.6 < pulse[2].real < 2 / np.pi
    assert 0.0 < abs(pulse[1]) < 1e-3
    assert pulse[0] == 0.0


def test_a_path_that_grows_stretches_time_and_turns_the_carrier() -> None:
    """A tone of 300 Hz about the carrier, D 1.002: all of it is shifted, from D t - tau on."""
    count, ratio, tau = 400, 1.002, 0.0137
    sent = np.exp(2j * np.pi * 300.0 * np.arange(900) / RATE)
    got = received(
        sent, np.array([tau]), np.array([0.5 + 0j]), np.array([ratio]), carrier=CARRIER, sample_rate=RATE, start=0.05,
        count=count,
    )  # fmt: skip
    t = 0.05 + np.arange(count) / RATE
    expected = 0.5 * np.exp(2j * np.pi * ((CARRIER + 300.0) * (ratio * t - tau) - CARRIER * t))
    np.testing.assert_allclose(got, expected, atol=1e-4)


def test_noise_has_no_mean_and_is_held_below_a_hertz() -> None:
    """Variance of a flat density: its level times half the rate."""
    density = ambient_density(400, 100.0, wind_speed=7.0, shipping=0.3)  # every quarter of a hertz
    np.testing.assert_array_equal(density[:4], density[4])
    expected = 10.0 ** (spectral_level([1.0, 2.0], wind_speed=7.0, shipping=0.3) / 10.0)
    np.testing.assert_allclose(density[[4, 8]], expected)
    noise = noise_of(np.full(2001, 3.0), 4000, 500.0, rng=np.random.default_rng(2), elements=3)
    assert noise.shape == (3, 4000)
    assert np.abs(noise.mean(axis=1)).max() < 1e-12
    assert noise.var(axis=1) == pytest.approx(np.full(3, 3.0 * 250.0), rel=5 * np.sqrt(2 / 4000))
