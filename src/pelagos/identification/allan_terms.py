"""Terms of an Allan variance by least squares, weighed as each of its points is known."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

Floats = NDArray[np.float64]
_VISIBLE: Final = 0.25
"""Share of the variance that a term must have at some averaging time to be seen by eye in the curve."""
_SURE: Final = 2.0  # standard deviations of the curve, which a term must exceed besides
REWEIGHTED: Final = 6  # times
LEAST: Final = 1e-3  # of what was measured, so that no weight is infinite


def terms_of(terms: Floats, deviation: Floats, clusters: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Squares of the sizes of `terms` `(n, 3)` in a curve `(n,)` of so many clusters, and which of them it shows.

    A variance that is known to sqrt(1/clusters) of itself weighs by what it should be: by what was measured, the low
    ones would count more than the high ones, and the slow terms come out low. A slow term that is not shown is 0, since
    it takes its part from the one that is; white noise takes none.
    """
    unsure = np.sqrt(2 / (clusters - 1))  # of an Allan variance, relative: IEEE Std 952-1997, equation C.20
    squares = _weighed(terms, deviation, clusters)
    part = terms * squares / np.maximum(terms @ squares, 1e-300)[:, None]
    seen = np.asarray((part > np.maximum(_VISIBLE, _SURE * unsure)[:, None]).any(axis=0))
    kept = seen | np.array([True, False, False])
    squares[~kept], squares[kept] = 0.0, _weighed(terms[:, kept], deviation, clusters)
    return squares, seen


def _weighed(terms: Floats, deviation: Floats, clusters: Floats) -> Floats:
    """Squares `(c,)`, not negative, of the sizes of `terms` `(n, c)`."""
    variance = deviation**2
    model = variance
    for _ in range(REWEIGHTED):
        weight = np.sqrt(clusters) / model
        squares = nnls(terms * weight[:, None], variance * weight)[0]
        model = np.maximum(terms @ squares, LEAST * variance)
    return np.asarray(squares)
