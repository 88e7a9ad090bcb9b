"""Bottom detection in time series whose answers are known."""

from __future__ import annotations

import math

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.acoustics.beam_pattern import line
from pelagos.acoustics.bottom_detection import BY_AMPLITUDE, BY_PHASE, NOT_FOUND, Series, find_bottom, half_apertures

SAMPLES = 64


def series(left, right, *, start=10.0, spacing=0.01):
    halves = np.stack([left.real, left.imag, right.real, right.imag], axis=-1).astype(np.float32)
    beams = len(left)
    return Series(
        jit.Float(halves.ravel()), *(jit.Float(np.full(beams, v, np.float32)) for v in (start, spacing, 2 * spacing))
    )


def detect(*args, noise=1e-6, **options):
    found = find_bottom(series(*args, **options), SAMPLES, noise=jit.Float(noise))
    dr.eval(found)
    return found


def test_two_halves_are_the_whole_line():
    """sinc(L u/2)/2 (e^{i psi} + e^{-i psi}) = sinc(L u), psi = pi L u/2."""
    u = jit.Float(np.linspace(-0.05, 0.05, 401, dtype=np.float32))
    pattern, phase = half_apertures(u, 50.0)
    assert np.array(2.0 * pattern * dr.cos(phase)) == pytest.approx(np.array(line(u, 50.0)), abs=1e-6)


def test_phase_crosses_zero_where_the_ramp_says():
    """A line through zero at sample 30.3, no noise: found to single precision."""
    k = np.arange(SAMPLES) + 0.5
    phase = 0.09 * (k - 30.3)
    found = detect(np.exp(0.5j * phase)[None], np.exp(-0.5j * phase)[None])
    assert np.array(found.by_phase) == pytest.approx([10.0 + 0.303], abs=2e-5)
    assert np.array(found.kind) == [BY_PHASE]


def test_a_short_pulse_is_found_by_its_centre_of_gravity():
    k = np.arange(SAMPLES) + 0.5
    pulse = np.exp(-(((k - 40.7) / 1.2) ** 2))
    found = detect(0.5 * pulse[None] + 0j, 0.5 * pulse[None] + 0j)
    # samples below -10 dB are cut off: at 1.29 samples from the middle, which moves the centre by less than a tenth
    assert np.array(found.distance) == pytest.approx([10.407], abs=1e-3)
    assert np.array(found.kind) == [BY_AMPLITUDE]


def test_silence_holds_no_bottom():
    silent = np.zeros((3, SAMPLES), complex)
    assert (np.array(detect(silent, silent).kind) == NOT_FOUND).all()


def test_spread_of_the_crossing_is_that_of_the_fit():
    """Phase noise s on N samples of a ramp m: the crossing at their middle has s/(m sqrt(N)) (least squares)."""
    rng = np.random.default_rng(1)
    k = np.arange(SAMPLES) + 0.5
    ramp, noise, beams = 0.06, 0.15, 2000
    phase = ramp * (k - 32.0) + noise * rng.standard_normal((beams, SAMPLES))
    found = detect(np.exp(0.5j * phase), np.exp(-0.5j * phase), spacing=1.0)
    inside = (np.abs(ramp * (k - 32.0)) < 1.2).sum()
    expected = noise / (ramp * math.sqrt(inside))
    assert np.array(found.by_phase).std() == pytest.approx(expected, rel=0.1)
    # two samples make one resolution cell: the estimate counts half as many
    assert np.median(np.array(found.phase_error)) == pytest.approx(math.sqrt(2) * expected, rel=0.1)
    assert np.array(found.by_phase).mean() == pytest.approx(42.0, abs=4 * expected / math.sqrt(beams))
