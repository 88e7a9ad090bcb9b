"""Arrays beside `pytest.approx` in one NumPy call: pytest takes some 20 microseconds for each of their numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
import pytest

FEW: Final = 16  # numbers for which pytest is as quick
EXACT: Final = 2**53  # whole numbers below it are floating-point numbers, too
ARRAY: Final = type(pytest.approx(np.zeros(1)))
SCALAR: Final = type(pytest.approx(1.0))
SMALLEST: Final[float] = SCALAR.DEFAULT_ABSOLUTE_TOLERANCE
RELATIVE: Final[float] = SCALAR.DEFAULT_RELATIVE_TOLERANCE


def quicken_approx() -> None:
    """Have arrays that are near be found so at once; all others are left to pytest, which says where they differ."""
    for kind in (ARRAY, SCALAR):
        kind.__eq__ = _quick(kind.__eq__)


def _quick(slow: Callable[[Any, Any], bool]) -> Callable[[Any, Any], bool]:
    def equal(self: Any, actual: Any) -> bool:
        array = isinstance(actual, np.ndarray) and actual.size > FEW
        return (array and near(actual, self.expected, self.rel, self.abs)) or slow(self, actual)

    return equal


def near(found: Any, expected: Any, rel: Any, absolute: Any) -> bool:
    """Whether all numbers of an array are within pytest's tolerances; False where pytest has to decide."""
    expected = np.asarray(expected)
    if not (_numbers(found) and _numbers(expected)) or (expected.ndim > 0 and expected.shape != found.shape):
        return False
    if any(t is not None and not (isinstance(t, int | float) and t >= 0) for t in (rel, absolute)):
        return False
    wide = np.result_type(found, expected, np.float64)
    found, expected = found.astype(wide), expected.astype(wide)
    with np.errstate(all="ignore"):
        allowed = SMALLEST if absolute is None else absolute
        if rel is not None or absolute is None:
            allowed = np.maximum((RELATIVE if rel is None else rel) * np.abs(expected), allowed)
        return bool(np.isfinite(expected).all() and (np.abs(found - expected) <= allowed).all())


def _numbers(values: np.ndarray) -> bool:
    whole = values.dtype.kind in "iu"
    return values.dtype.kind in "fc" or (whole and bool(((values > -EXACT) & (values < EXACT)).all()))
