"""Arrays are near one another exactly where pytest's own comparison, number by number, finds them so."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from quick_approx import FEW, near

TOLERANCES: list[tuple[float | None, float | None]] = [
    (None, None), (1e-3, None), (None, 2e-3), (1e-3, 2e-3), (0.0, None), (1, 0.0),
]  # fmt: skip


@pytest.mark.parametrize(("rel", "absolute"), TOLERANCES)
@pytest.mark.parametrize("kind", [np.float64, np.float32, np.complex128, np.int32])
@pytest.mark.parametrize("scalar", [False, True])
def test_tolerances_are_those_of_pytest(rel: float | None, absolute: float | None, kind: Any, scalar: bool) -> None:
    """Of unequal numbers of both signs, each as far off as the tolerance, a hundredth more and a hundredth less."""
    expected = np.linspace(-3.0, 4.0, 40).astype(kind)
    of_one = [pytest.approx(x, rel=rel, abs=absolute) for x in expected.tolist()]
    for part in (0.0, 0.99, 1.01):
        for i in (3, 36):
            found = np.full(40, expected[i], kind) if scalar else expected.copy()
            size = of_one[i].tolerance
            found = found.astype(np.result_type(kind, np.float64))
            found[i] += part * size * (1j if kind is np.complex128 else 1.0)
            whole = expected[i].item() if scalar else expected
            wanted = all(a == of_one[i if scalar else k] for k, a in enumerate(found.tolist()))
            assert near(found, whole, rel, absolute) == wanted
            assert (found == pytest.approx(whole, rel=rel, abs=absolute)) == wanted


def test_what_is_no_plain_number_is_left_to_pytest() -> None:
    """NaN, infinity, booleans, other shapes, tolerances that are refused."""
    x = np.arange(2.0 * FEW)
    gap, endless = x.copy(), x.copy()
    gap[3], endless[4] = np.nan, np.inf
    assert gap != pytest.approx(gap)
    assert gap == pytest.approx(gap, nan_ok=True)
    assert endless == pytest.approx(endless)
    assert x != pytest.approx(endless)
    assert endless != pytest.approx(x)
    assert x != pytest.approx(x[:-1])
    assert x[:, None] != pytest.approx(x)
    assert (x > 3) != pytest.approx(x > 4)
    with pytest.raises(ValueError, match="negative"):
        assert x == pytest.approx(x + 1, abs=-1.0)
