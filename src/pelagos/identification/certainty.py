"""Certainty of the parameters: Fisher information, resampled shots, what cannot be told apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from pelagos.identification.problem import Normal, Problem
from pelagos.identification.search import Found

NORMAL_95: Final = 1.959964
"""Half width of a normal law's 95 % interval."""
UNTOLD: Final = 0.5
"""A parameter whose interval is narrower than its prior's by less than this factor is not identified."""
UNFELT: Final = 1e-3
"""Influence below which nothing that was recorded depends on a parameter: alone, it would narrow the prior by 5e-7."""
ALIKE: Final = 0.98
"""Correlation from which two parameters cannot be told apart."""


@dataclass(frozen=True)
class Certainty:
    """Spread of the parameters in the coordinates of the search.

    Attributes:
        fisher: standard deviations `(p,)` from the information, widened for residuals that go on for a while.
        bootstrap: 2.5 and 97.5 % points of resampled shots' changes `(p, 2)`; None with fewer than five shots.
        correlation: `(p, p)`.
        told: share of the prior's spread that the data took away, 0 to 1 `(p,)`.
        alike: pairs that cannot be told apart: names and correlation.
        memory: number of rows after which residuals are new.
        influence: change of what is fitted by one standard deviation of each prior, in standard deviations of the
            noise, summed as squares `(p,)`.
    """

    fisher: NDArray[np.float64]
    bootstrap: NDArray[np.float64] | None
    correlation: NDArray[np.float64]
    told: NDArray[np.float64]
    alike: tuple[tuple[str, str, float], ...]
    memory: float
    influence: NDArray[np.float64]


def certainty(problem: Problem, found: Found, *, resamplings: int, seed: int = 0) -> Certainty:
    """Of a search's end.

    Initial states are eliminated (Schur complement). Bootstrap: scores of whole shots are resampled and taken one
    Newton step (P. Kline, A. Santos, "A score based approach to wild bootstrap inference", J. Econometric Methods 1,
    2012), which needs no independence within a shot.
    """
    p = len(found.at)
    scores, whole = _scores(found.normal, p)
    matrix = found.normal.matrix - _spent(found.normal)
    across, inside = matrix[:p, p:], matrix[p:, p:]
    carried = np.linalg.solve(inside, across.T) if inside.size else np.zeros((0, p))
    reduced = matrix[:p, :p] - across @ carried
    memory = _memory(found.differences)
    data = reduced - np.diag(problem.precision)
    covariance = np.linalg.inv(data / memory + np.diag(problem.precision))
    spread = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(spread, spread)
    told = 1 - spread * np.sqrt(problem.precision)
    names = [q.name for q in problem.family.parameters]
    alike = tuple(
        (names[i], names[j], float(correlation[i, j]))
        for i in range(p) for j in range(i) if abs(correlation[i, j]) > ALIKE
    )  # fmt: skip
    influence = np.sqrt(np.diag(found.normal.own.sum(axis=0)) / problem.precision)
    return Certainty(spread, _resampled(whole, scores, resamplings, seed), correlation, told, alike, memory, influence)


def _scores(normal: Normal, p: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Scores of the parameters by shot `(s, p)`, as if each shot had not been fitted, and their information `(p, p)`.

    A fit follows its own shots, so that their scores are too small; each is multiplied by (I - A_k / A)^-1, A_k being
    its share of the information (R. M. Bell, D. F. McCaffrey, "Bias reduction in standard errors for linear regression
    with multi-stage samples", Survey Methodology 28, 2002).
    """
    across, inside = normal.matrix[:p, p:], normal.matrix[p:, p:]
    carried = np.linalg.solve(inside, across.T) if inside.size else np.zeros((0, p))
    reduced = normal.matrix[:p, :p] - across @ carried
    scores = normal.by_shot[:, :p] - normal.by_shot[:, p:] @ carried
    f = across.shape[1] // len(scores)
    found = []
    for k, score in enumerate(scores):
        part = normal.own[k] - across[:, k * f : (k + 1) * f] @ carried[k * f : (k + 1) * f]
        found.append(reduced @ np.linalg.solve(reduced - part, score))
    return np.array(found), reduced


def _spent(normal: Normal) -> NDArray[np.float64]:
    """Information that residuals only seem to hold, since the fit made them smaller than the noise `(m, m)`.

    Each channel's variance is the sum of squares over its count less the degrees of freedom that the fit took from it,
    the trace of the hat matrix (T. Hastie, R. Tibshirani, J. Friedman, "The Elements of Statistical Learning", 2nd ed.,
    Springer 2009, Section 7.6). At most nine tenths are taken away.
    """
    turned = np.linalg.inv(normal.matrix)
    taken = np.array([float((turned * part).sum()) for part in normal.by_channel])
    share = np.minimum(taken / np.maximum(normal.counts, 1), 0.9)
    return np.asarray(np.einsum("c,cij->ij", share, normal.by_channel))


def _resampled(
    reduced: NDArray[np.float64], scores: NDArray[np.float64], count: int, seed: int
) -> NDArray[np.float64] | None:
    shots = len(scores)
    if shots < 5 or count == 0:
        return None
    random = np.random.default_rng(seed)
    weights = random.multinomial(shots, np.full(shots, 1 / shots), size=count) - 1.0
    steps = -np.linalg.solve(reduced, (weights @ scores).T).T
    # a spread from few shots is itself uncertain: Student's law for as many less one
    steps *= np.sqrt(shots / (shots - 1)) * float(stdtrit(shots - 1, 0.975)) / NORMAL_95
    return np.stack(np.percentile(steps, [2.5, 97.5], axis=0), axis=-1)


def _memory(off: NDArray[np.float64]) -> float:
    """Integrated correlation time of the residuals in rows: 1 + 2 sum of correlations, up to the first that white noise
    may have too: below two of its standard deviations 1 / sqrt(rows).
    """
    n = len(off)
    found = []
    for c in range(off.shape[1]):
        x = np.where(np.isfinite(off[:, c]), off[:, c], 0.0)
        power = (x * x).mean()
        total = 1.0
        for lag in range(1, n // 2):
            rho = float((x[lag:] * x[:-lag]).mean() / power) if power > 0 else 0.0
            if rho < 2 / np.sqrt(x.size):
                break
            total += 2 * rho
        found.append(total)
    return float(np.mean(found))
