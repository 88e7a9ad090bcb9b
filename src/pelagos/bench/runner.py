"""Find the cases, run them, and say what came out."""

from __future__ import annotations

import pkgutil
from collections.abc import Callable, Iterable
from importlib import import_module
from typing import Any

from pelagos.bench.case import Case, Result
from pelagos.errors import LookupFailed, PelagosError


def all_cases() -> dict[str, Case]:
    """Every declared case by name: the tuples `CASES` of the modules in `bench/cases/`."""
    from pelagos.bench import cases

    found: dict[str, Case] = {}
    for module in sorted(m.name for m in pkgutil.iter_modules(cases.__path__)):
        for case in import_module(f"{cases.__name__}.{module}").CASES:
            assert case.name not in found, f"two cases are called {case.name}"
            found[case.name] = case
    return found


def choose(names: Iterable[str]) -> list[Case]:
    """The named cases; all if none is named.

    Raises:
        LookupFailed: no case has this name.
    """
    known = all_cases()
    asked = list(names)
    for name in asked:
        if name not in known:
            raise LookupFailed("benchmark", name, known)
    return [known[name] for name in asked] if asked else list(known.values())


def run_case(case: Case) -> Result:
    """Run one case; what goes wrong on purpose becomes its detail."""
    try:
        measured = case.measure()
    except PelagosError as error:
        return Result(case, None, case.reference, str(error).splitlines()[0])
    return Result(case, measured.value, measured.reference or case.reference, measured.detail)


def run_cases(names: Iterable[str] = (), *, each: Callable[[Result], None] | None = None) -> list[Result]:
    """Run cases one after the other.

    Args:
        names: which; all if none is named.
        each: called with every result as it comes.

    Raises:
        LookupFailed: no case has this name.
    """
    results = []
    for case in choose(names):
        result = run_case(case)
        if each is not None:
            each(result)
        results.append(result)
    return results


def as_data(result: Result) -> dict[str, Any]:
    """A result for JSON."""
    return {
        "name": result.case.name,
        "title": result.case.title,
        "value": result.value,
        "unit": result.case.unit,
        "goal": result.case.goal,
        "better": result.case.better,
        "met": result.met,
        "reference": {"text": result.reference.text, "value": result.reference.value},
        "ratio": result.ratio,
        "detail": result.detail,
    }


def as_line(result: Result) -> str:
    """A result for people: name, value, unit, goal, ratio to the reference."""
    sign = "at least" if result.case.better == "higher" else "at most"
    value = "no value" if result.value is None else f"{result.value:.4g} {result.case.unit}"
    ratio = "" if result.ratio is None else f"; {result.ratio:.3g} x {result.reference.text}"
    verdict = "met" if result.met else "MISSED"
    return f"{result.case.name:<18} {value:<18} goal {sign} {result.case.goal:g}: {verdict}{ratio} ({result.detail})"
