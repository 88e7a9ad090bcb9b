"""Texture of reverberation that comes from few scatterers: a gamma-distributed factor on the mean of its intensity.

Speckle of many scatterers is exponential in intensity. Where a resolution cell holds only nu of them, their cross
sections exponentially distributed, the intensity is K-distributed: exponential about a mean that is itself
gamma-distributed with shape nu and mean one, and <I^2>/<I>^2 = 2 (1 + 1/nu).

Source: D. A. Abraham and A. P. Lyons, IEEE J. Ocean. Eng. 27(4), 800 (2002), doi 10.1109/JOE.2002.1040942: the shape
grows with the size of the resolution cell times the density of scatterers.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.quick import larger, log2, smaller

SHAPES: Final = (0.05, 200.0)  # beyond: as at the ends; 200 is Rayleigh's speckle within half a percent of its variance
_ROWS: Final = 49  # of the table, over the logarithm of the shape
_COLUMNS: Final = 129  # over the standard normal score
_SCORES: Final = (-5.0, 6.0)


@lru_cache(maxsize=1)
def gamma_table() -> NDArray[np.float32]:
    """Quantiles of gamma variates of mean one `(rows * columns,)`, by shape and by the score of a normal variate."""
    from scipy.special import gammainccinv, gammaincinv, ndtr

    shape = np.geomspace(*SHAPES, _ROWS)[:, None]
    score = np.linspace(*_SCORES, _COLUMNS)[None, :]
    below, above = gammaincinv(shape, ndtr(score)), gammainccinv(shape, ndtr(-score))
    table = np.where(score < 0.0, below, above) / shape
    table.flags.writeable = False
    return np.ascontiguousarray(table, dtype=np.float32).ravel()


def gamma_texture(table: Array, shape: Array, score: Array) -> Array:
    """Gamma variates of mean one and of a `shape`, from standard normal ones.

    Args:
        table: `Float`, see `gamma_table`.
        shape: nu.
        score: normal variates.
    """
    low, high = (math.log2(edge) for edge in SHAPES)
    row = (log2(larger(shape, SHAPES[0])) - low) * ((_ROWS - 1) / (high - low))
    column = (score - _SCORES[0]) * ((_COLUMNS - 1) / (_SCORES[1] - _SCORES[0]))
    row, column = larger(smaller(row, _ROWS - 1.001), 0.0), larger(smaller(column, _COLUMNS - 1.001), 0.0)
    i, j = jit.UInt32(row), jit.UInt32(column)
    across, along = row - jit.Float(i), column - jit.Float(j)
    at = i * _COLUMNS + j
    values = [dr.gather(jit.Float, table, at + step) for step in (0, 1, _COLUMNS, _COLUMNS + 1)]
    return dr.lerp(dr.lerp(values[0], values[1], along), dr.lerp(values[2], values[3], along), across)
