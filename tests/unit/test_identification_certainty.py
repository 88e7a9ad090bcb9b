"""Certainty of a fit against what straight lines through points give in closed form."""

from __future__ import annotations

import numpy as np

from pelagos.identification.certainty import _scores, _spent
from pelagos.identification.problem import Normal, Target


def regression(initial: int = 0) -> tuple[Normal, np.ndarray, np.ndarray]:
    """Least squares of two parameters, and `initial` numbers of each shot's own, by 5 shots of 7 points."""
    random = np.random.default_rng(4)
    p, s, rows = 2, 5, 7
    m = p + s * initial
    x = np.zeros((s, rows, m))
    x[..., :p] = random.normal(loc=[0.3, -0.8], size=(s, rows, p))
    for k in range(s):
        x[k, :, p + k * initial : p + (k + 1) * initial] = random.normal(size=(rows, initial)) + 1.0
    y = random.normal(size=(s, rows))
    flat, wanted = x.reshape(-1, m), y.ravel()
    best = np.linalg.lstsq(flat, wanted, rcond=None)[0]
    off = x @ best - y
    by_shot = np.einsum("krm,kr->km", x, off)
    own = np.einsum("krp,krq->kpq", x[..., :p], x[..., :p])
    matrix = flat.T @ flat
    normal = Normal(matrix, by_shot.sum(axis=0), by_shot, 0.5 * (off**2).sum(), matrix[None], np.array([s * rows]), own)
    return normal, x, y


def test_scores_are_those_of_fits_without_a_shot():
    """A Newton step by one shot's score is what leaving that shot out changes, exactly where all is linear."""
    for initial in (0, 1):
        normal, x, y = regression(initial)
        scores, whole = _scores(normal, 2)
        best = np.linalg.lstsq(x.reshape(-1, x.shape[2]), y.ravel(), rcond=None)[0][:2]
        for k in range(len(x)):
            rest = [i for i in range(len(x)) if i != k]
            without = np.linalg.lstsq(x[rest].reshape(-1, x.shape[2]), y[rest].ravel(), rcond=None)[0][:2]
            np.testing.assert_allclose(np.linalg.solve(whole, scores[k]), without - best, atol=1e-12)


def test_the_noise_is_estimated_with_the_degrees_of_freedom_left():
    """One channel: the variance is the residuals' over n - m, so that of n points m carry no information."""
    for initial in (0, 1):
        normal, x, _ = regression(initial)
        n, m = x.shape[0] * x.shape[1], x.shape[2]
        np.testing.assert_allclose(normal.matrix - _spent(normal), normal.matrix * (1 - m / n), rtol=1e-9)


def test_a_row_that_two_shots_share_counts_once():
    target = Target(("north",), np.arange(12.0).reshape(4, 1, 3))
    once = target.once([False, True, False]).wanted
    assert np.isnan(once[3, 0, 0])
    assert np.isfinite(once).sum() == 11
    assert np.isfinite(target.wanted).all()
