"""A pytest plug-in that writes docs/checks.json: the largest deviation of every numeric comparison, by test.

    python -m pytest -p proof_plugin -o enable_assertion_pass_hook=true tests/verification tests/cross_code

(with scripts/site on the path). It watches `numpy.testing.assert_allclose`, `numpy.allclose` and `pytest.approx`, and
assertions that bound a deviation by a number (`abs(a - b) < 1e-3`, `0.98 < ratio < 1.02`); of each it keeps how far
apart the two sides were in parts of what was allowed. Rows of tests that did not run stay: parts can be renewed.
"""

from __future__ import annotations

import ast
import inspect
import json
import re
import sys
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest

Approximate: Any = type(pytest.approx(1.0))
ROOT: Final = Path(__file__).parents[2]
TABLE: Final = ROOT / "docs" / "checks.json"
_NUMBER: Final = re.compile(r"(?:np\.float\d+\(|np\.int\d+\(|array\()?([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)\b", re.I)
_DEVIATION: Final = re.compile(r"\babs\(|\bnorm\(|\bhypot\(|error|worst|deviation|residual|apart|gap\b|_off\b")
_found: dict[str, dict[str, Any]] = {}
_ran: set[str] = set()
_current: dict[str, Any] = {}


def _note(actual: Any, expected: Any, relative: float, absolute: float) -> None:
    """Keep how far two sides of a comparison lie apart, in parts of what is allowed."""
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
    parts = ([f"{relative:.2g} relative"] if relative > 0 else []) + ([f"{absolute:.2g}"] if absolute > 0 else [])
    _keep(float(share.max()), " + ".join(parts))


def _keep(share: float, allowed: str) -> None:
    if not 0 <= share <= 1:  # the test holds that these two differ
        return
    _current["comparisons"] += 1
    if share >= _current["worst"]:
        _current["worst"], _current["allowed"] = share, allowed


def _from_tests() -> bool:
    """Whether the call that is watched stands in a test, and not in a package that the test uses."""
    return sys._getframe(2).f_code.co_filename.startswith(str(ROOT / "tests"))


def pytest_configure(config: pytest.Config) -> None:
    allclose, assert_allclose, equal = np.allclose, np.testing.assert_allclose, Approximate.__eq__

    def watched_allclose(a: Any, b: Any, rtol: float = 1e-5, atol: float = 1e-8, **more: Any) -> bool:
        if _from_tests():
            _note(a, b, rtol, atol)
        return bool(allclose(a, b, rtol=rtol, atol=atol, **more))

    def watched_assert(actual: Any, desired: Any, rtol: float = 1e-7, atol: float = 0, *rest: Any, **more: Any) -> None:
        if _from_tests():
            _note(actual, desired, rtol, atol)
        assert_allclose(actual, desired, rtol, atol, *rest, **more)

    def watched_equal(self: Any, actual: Any) -> bool:
        if isinstance(self.expected, (int, float, complex)) and not isinstance(self.expected, bool):
            relative = self.rel if self.rel is not None else (1e-6 if self.abs is None else 0.0)
            whole = relative * abs(self.expected) >= self.tolerance * (1 - 1e-9) > 0
            _note(actual, self.expected, *((relative, 0.0) if whole else (0.0, float(self.tolerance))))
        return bool(equal(self, actual))

    np.allclose, np.testing.assert_allclose = watched_allclose, watched_assert  # type: ignore[assignment]
    Approximate.__eq__ = watched_equal


def pytest_assertion_pass(item: pytest.Item, lineno: int, orig: str, expl: str) -> None:
    """Keep `deviation < number` and `number < value < number`."""
    if not _current:
        return
    tree = ast.parse(orig.strip(), mode="eval").body
    if not isinstance(tree, ast.Compare) or not all(isinstance(o, (ast.Lt, ast.LtE)) for o in tree.ops):
        return
    value = _NUMBER.match(expl.strip().removeprefix("assert ").lstrip("("))
    bounds = [_constant(side) for side in (tree.left, *tree.comparators)]
    if value is None:
        return
    if len(bounds) == 3 and bounds[1] is None and bounds[0] is not None and bounds[2] is not None:
        middle, half = (bounds[2] + bounds[0]) / 2, (bounds[2] - bounds[0]) / 2
        _keep(abs(float(value[1]) - middle) / half, f"{middle:.4g} +- {half:.2g}")
    elif len(bounds) == 2 and bounds[0] is None and bounds[1] and _DEVIATION.search(ast.unparse(tree.left)):
        _keep(float(value[1]) / bounds[1], f"{bounds[1]:.2g}")


def _constant(side: ast.expr) -> float | None:
    """The number that an expression of numbers alone stands for."""
    if any(
        not isinstance(n, (ast.Constant, ast.UnaryOp, ast.BinOp, ast.operator, ast.unaryop)) for n in ast.walk(side)
    ):
        return None
    found = eval(compile(ast.Expression(side), "bound", "eval"))  # numbers and signs only
    return float(found) if isinstance(found, (int, float)) else None


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Any:
    _current.clear()
    function = getattr(item, "function", None)
    words = words_of(function) if function else ""
    about = (inspect.getmodule(function).__doc__ or "").strip() if function else ""
    _current.update(worst=0.0, comparisons=0, allowed="")
    outcome = yield
    file, *_, name = item.nodeid.split("[")[0].split("::")  # a class may stand between
    test = f"{file}::{name}"
    _ran.add(test)
    if _current["comparisons"] and outcome.excinfo is None:
        row = _found.setdefault(
            test,
            {"file": file, "check": name.removeprefix("test_").replace("_", " "), "source": words,
             "about": " ".join(about.split("\n\n")[0].split()), "comparisons": 0, "worst": 0.0, "allowed": ""},
        )  # fmt: skip
        row["comparisons"] += _current["comparisons"]
        if _current["worst"] >= row["worst"]:
            row["worst"], row["allowed"] = float(f"{_current['worst']:.2g}"), _current["allowed"]
    _current.clear()


def words_of(function: Any) -> str:
    """The docstring of a test; without one the comments in it."""
    found = inspect.getdoc(function) or " ".join(re.findall(r"#\s+(?!fmt:|noqa)(.+)", inspect.getsource(function)))
    return " ".join(found.split())


def test_of(row: dict[str, Any]) -> str:
    """ "file::function" of a row."""
    return f"{row['file']}::test_{row['check'].replace(' ', '_')}"


def exists(test: str) -> bool:
    """Whether a test is still in its file."""
    file, _, function = test.rpartition("::")
    return (ROOT / file).exists() and f"def {function}(" in (ROOT / file).read_text(encoding="utf-8")


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    if hasattr(session.config, "workerinput") or not _found:
        return
    before = json.loads(TABLE.read_text(encoding="utf-8"))["checks"] if TABLE.exists() else []
    kept = [r for r in before if (test := test_of(r)) not in _ran and exists(test)]
    rows = sorted([*kept, *_found.values()], key=lambda r: (r["file"], r["check"]))
    TABLE.write_text(json.dumps({"checks": rows}, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
