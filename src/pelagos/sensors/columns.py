"""One array from a frozen call instead of many: each transfer to NumPy costs as much as a small kernel."""

from __future__ import annotations

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array


def pack(*columns: Array) -> Array:
    """Columns (`Float64` or `Bool`, one entry a lane) as one `Float64` of rows, lane after lane."""
    return dr.ravel(jit.ArrayXf64([jit.Float64(dr.select(c, 1.0, 0.0) if dr.is_mask_v(c) else c) for c in columns]))


def unpack(packed: Array, columns: int) -> NDArray[np.float64]:
    """`(m, columns)`, what `pack` packed."""
    rows: NDArray[np.float64] = packed.numpy().reshape(-1, columns)
    return rows
