"""A pytest plug-in that writes docs/checks.json: the largest deviation of every numeric comparison, by test.

    python -m pytest -p proof_plugin tests/verification tests/cross_code      (with scripts/site on the path)

It watches `numpy.testing.assert_allclose`, `numpy.allclose` and `pytest.approx`; of each it keeps how far apart the two
sides were in parts of what was allowed.
"""

from __future__ import annotations

import inspect
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

Approximate: Any = type(pytest.approx(1.0))
TABLE = Path(__file__).parents[2] / "docs" / "checks.json"
_found: dict[str, dict[str, Any]] = {}
_current: dict[str, Any] = {}


def _note(actual: Any, expected: Any, relative: float, absolute: float) -> None:
    if not _current:
        return
    try:
        a, b = np.broadcast_arrays(np.asarray(actual, dtype=complex), np.asarray(expected, dtype=complex))
    except (TypeError, ValueError):
        return
    usable = np.isfinite(a) & np.isfinite(b)
    allowed = absolute + relative * np.abs(b[usable])
    if not allowed.size or not (allowed > 0).any():
        return
    share = np.abs(a[usable] - b[usable])[allowed > 0] / allowed[allowed > 0]
    _current["comparisons"] += 1
    worst = float(share.max())
    if worst <= 1 and worst >= _current["worst"]:
        _current["worst"] = worst
        parts = ([f"{relative:.2g} relative"] if relative > 0 else []) + ([f"{absolute:.2g}"] if absolute > 0 else [])
        _current["allowed"] = " + ".join(parts)


def pytest_configure(config: pytest.Config) -> None:
    allclose, assert_allclose, equal = np.allclose, np.testing.assert_allclose, Approximate.__eq__

    def watched_allclose(a: Any, b: Any, rtol: float = 1e-5, atol: float = 1e-8, **more: Any) -> bool:
        _note(a, b, rtol, atol)
        return bool(allclose(a, b, rtol=rtol, atol=atol, **more))

    def watched_assert(actual: Any, desired: Any, rtol: float = 1e-7, atol: float = 0, *rest: Any, **more: Any) -> None:
        _note(actual, desired, rtol, atol)
        assert_allclose(actual, desired, rtol, atol, *rest, **more)

    def watched_equal(self: Any, actual: Any) -> bool:
        if isinstance(self.expected, (int, float, complex)) and not isinstance(self.expected, bool):
            _note(actual, self.expected, 0.0, float(self.tolerance))
        return bool(equal(self, actual))

    np.allclose, np.testing.assert_allclose = watched_allclose, watched_assert  # type: ignore[assignment]
    Approximate.__eq__ = watched_equal


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Any:
    _current.clear()
    function = getattr(item, "function", None)
    words = " ".join((inspect.getdoc(function) or "").split()) if function else ""
    about = (inspect.getmodule(function).__doc__ or "").strip() if function else ""
    _current.update(worst=0.0, comparisons=0, allowed="")
    yield
    name = item.nodeid.split("[")[0]
    if _current["comparisons"]:
        file, _, check = name.rpartition("::")
        row = _found.setdefault(
            name,
            {"file": file, "check": check.removeprefix("test_").replace("_", " "), "source": words,
             "about": " ".join(about.split("\n\n")[0].split()), "comparisons": 0, "worst": 0.0, "allowed": ""},
        )  # fmt: skip
        row["comparisons"] += _current["comparisons"]
        if _current["worst"] >= row["worst"]:
            row["worst"], row["allowed"] = float(f"{_current['worst']:.2g}"), _current["allowed"]
    _current.clear()


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    rows = sorted(_found.values(), key=lambda r: (r["file"], r["check"]))
    TABLE.write_text(json.dumps({"checks": rows}, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
