"""Uniform and normal numbers made of random words."""

import drjit as dr
import numpy as np
from scipy import stats

from pelagos import jit
from pelagos.math.philox import normal_pair32, normal_pair64, philox, uniform32, uniform64

COUNT = 200_000
ALPHA = 1e-4  # chance that a test of a right generator fails; the numbers never change, so it fails always or never


def words(key: int = 7):
    index = dr.arange(jit.UInt32, COUNT)
    return philox((index, jit.UInt32(0), jit.UInt32(0), jit.UInt32(0)), (jit.UInt32(key), jit.UInt32(1)))


def test_uniforms_are_uniform_and_open_at_both_ends() -> None:
    w = words()
    for u in (np.array(uniform64(w[0], w[1])), np.array(uniform32(w[2]), dtype=np.float64)):
        assert u.min() > 0
        assert u.max() < 1
        assert stats.kstest(u, "uniform").pvalue > ALPHA


def test_extreme_words_stay_inside_the_interval() -> None:
    for word in (0, 0xFFFFFFFF):
        x = jit.UInt32(word)
        assert 0 < np.array(uniform64(x, x))[0] < 1
        assert 0 < np.array(uniform32(x))[0] < 1


def test_normals_are_normal_and_independent() -> None:
    w = words()
    a, b = (np.array(x) for x in normal_pair64(w))
    c, d = (np.array(x, dtype=np.float64) for x in normal_pair32(w[0], w[1]))
    for x in (a, b, c, d):
        assert stats.kstest(x, "norm").pvalue > ALPHA
    limit = stats.norm.isf(ALPHA / 2) / np.sqrt(COUNT)
    assert abs(np.corrcoef(a, b)[0, 1]) < limit
    assert abs(np.corrcoef(a[:-1], a[1:])[0, 1]) < limit
    assert abs(np.corrcoef(c, d)[0, 1]) < limit


def test_other_keys_give_independent_numbers() -> None:
    a, b = (np.array(normal_pair64(words(key))[0]) for key in (7, 8))
    assert abs(np.corrcoef(a, b)[0, 1]) < stats.norm.isf(ALPHA / 2) / np.sqrt(COUNT)
