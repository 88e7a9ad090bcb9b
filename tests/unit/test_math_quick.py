"""Functions in half the time: their errors are those that they state."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos import jit
from pelagos.math import philox
from pelagos.math.quick import cosine_sine, larger, log2, smaller


@pytest.mark.parametrize("span", [0.5, 80.0])
def test_logarithm(span: float) -> None:
    x = np.exp(np.random.default_rng(0).uniform(-span, span, 100_000)).astype(np.float32)
    exact = np.log2(x.astype(np.float64))
    error = np.abs(np.array(log2(jit.Float(x))) - exact)
    assert (error <= 4e-7 + 0.51 * np.spacing(np.abs(exact).astype(np.float32))).all()


def test_powers_of_two_have_whole_logarithms() -> None:
    exponent = np.arange(-126, 128)
    found = np.array(log2(jit.Float((2.0**exponent).astype(np.float32))))
    np.testing.assert_array_equal(found, exponent)


def test_cosine_and_sine_of_turns() -> None:
    turns = np.random.default_rng(1).uniform(-4, 4, 100_000).astype(np.float32)
    cosine, sine = (np.array(v) for v in cosine_sine(jit.Float(turns)))
    assert np.abs(cosine - np.cos(2 * np.pi * turns.astype(np.float64))).max() < 3e-6
    assert np.abs(sine - np.sin(2 * np.pi * turns.astype(np.float64))).max() < 3e-6


def test_whole_turns_change_nothing() -> None:
    turns = np.float32([0.0, 0.125, 0.25, -0.375])
    for a, b in zip(cosine_sine(jit.Float(turns)), cosine_sine(jit.Float(turns + 1024)), strict=True):
        np.testing.assert_array_equal(np.array(a), np.array(b))


def test_larger_and_smaller_are_the_general_ones() -> None:
    a, b = np.random.default_rng(2).normal(size=(2, 1000)).astype(np.float32)
    np.testing.assert_array_equal(np.array(larger(jit.Float(a), jit.Float(b))), np.maximum(a, b))
    np.testing.assert_array_equal(np.array(smaller(jit.Float(a), 0.25)), np.minimum(a, np.float32(0.25)))


def test_complex_normals_have_unit_power_and_even_phases() -> None:
    """Of 10^6 words: mean power 1 and mean square 2 within four standard errors, phases' mean vector below them."""
    words = np.random.default_rng(4).integers(0, 2**32, 1_000_000, dtype=np.uint32)
    power, phase = (np.array(v, dtype=np.float64) for v in philox.complex_normal32(jit.UInt32(words)))
    assert power.min() >= 0
    assert power.mean() == pytest.approx(1, abs=4e-3)
    assert (power**2).mean() == pytest.approx(2, abs=4e-3 * 20**0.5)  # variance of an exponential's square: 24 - 4
    assert np.abs(phase).max() <= 0.5
    assert abs(np.exp(2j * np.pi * phase).mean()) < 4e-3


def test_power_and_phase_of_a_complex_normal_fill_the_plane_evenly() -> None:
    """Spectral test in two dimensions: the longest gap between lines of the lattice is near the least possible.

    No lattice of 2^32 points has lines closer together than (3/4)^(1/4) 2^-16 apart (Knuth, Section 3.3.4).
    """
    modulus, multiplier = 2**32, philox._PHASE
    u, v = np.array([modulus, 0], dtype=object), np.array([-multiplier, 1], dtype=object)  # dual lattice, reduced below
    while True:
        if u @ u < v @ v:
            u, v = v, u
        q = round((u @ v) / (v @ v))
        if q == 0:
            break
        u = u - q * v
    shortest = float(min(u @ u, v @ v)) ** 0.5
    assert shortest > 0.9 * 2**16 * (4 / 3) ** 0.25
