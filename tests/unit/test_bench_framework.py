"""Benchmarks are declared as data, and what they print can be relied on. Nothing here is timed."""

from __future__ import annotations

import datetime
import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from pelagos.bench import runner, timing
from pelagos.bench.case import Case, Measured, Reference, Result
from pelagos.bench.check import BenchError, must
from pelagos.bench.results import as_markdown
from pelagos.bench.runner import all_cases, as_data, as_line, choose, run_case
from pelagos.bench.timing import seconds
from pelagos.errors import LookupFailed

ISSUE = {  # name: goal on two cores
    "nav_rtf": 150.0, "harbour_rtf": 1.5, "cast_256_ms": 0.2, "cast_mrays": 10.0, "harbour_cold_s": 15.0,
    "harbour_warm_s": 5.0, "harbour_memory_mb": 1500.0,
}  # fmt: skip


def case(measure: object, better: str = "higher", goal: float = 10.0) -> Case:
    return Case("thing_ms", "a thing", measure, "ms", goal, better, Reference("a paper", 5.0))  # type: ignore[arg-type]


def test_the_declared_cases_have_their_goals() -> None:
    found = all_cases()
    assert {name: found[name].goal for name in ISSUE} == ISSUE


def test_every_case_says_what_it_is_compared_with() -> None:
    for name, found in all_cases().items():
        assert found.name == name
        assert found.title
        assert found.unit
        assert found.reference.text
        assert found.measure.__doc__


def test_an_unknown_case_names_the_nearest() -> None:
    with pytest.raises(LookupFailed, match="did you mean 'cast_mrays'"):
        choose(["cast_mray"])


@pytest.mark.parametrize(
    ("better", "value", "met"),
    [("higher", 10, True), ("higher", 9, False), ("lower", 10, True), ("lower", 11, False)],
)
def test_goals_and_ratios(better: str, value: float, met: bool) -> None:
    result = run_case(case(lambda: Measured(value, detail="checked"), better))
    assert result.met is met
    assert result.ratio == value / 5.0
    assert as_data(result)["met"] is met
    json.dumps(as_data(result))
    assert ("met" if met else "MISSED") in as_line(result)


def test_a_limit_of_the_same_run_replaces_the_declared_reference() -> None:
    result = run_case(case(lambda: Measured(20.0, Reference("raw", 40.0))))
    assert result.ratio == 0.5


def test_wrong_output_gives_no_value() -> None:
    def blank() -> Measured:
        must(False, "the picture is blank")
        return Measured(1.0)

    result = run_case(case(blank))
    assert result.value is None
    assert not result.met
    assert "blank" in result.detail
    assert "no value" in as_line(result)
    with pytest.raises(BenchError, match="wrong output: x"):
        must(False, "x")


def test_results_are_given_as_they_come(monkeypatch: pytest.MonkeyPatch) -> None:
    known = {"a": case(lambda: Measured(1.0)), "b": case(lambda: Measured(2.0))}
    monkeypatch.setattr(runner, "all_cases", lambda: known)
    seen: list[Result] = []
    results = runner.run_cases(["b", "a"], each=seen.append)
    assert [r.value for r in results] == [2.0, 1.0] == [r.value for r in seen]


def test_the_page_names_hardware_date_and_versions() -> None:
    text = as_markdown([run_case(case(lambda: Measured(12.0)))], today=datetime.date(2026, 11, 21))
    for part in ("2026-11-21", "cores", "drjit", "mitsuba", "| `thing_ms` | 12 | ms | >= 10 | yes | 2.4 | a paper (5)"):
        assert part in text


def test_timing_counts_calls() -> None:
    calls = []
    assert seconds(lambda: calls.append(1), at_least_s=0.0, warm_up=2) >= 0.0
    assert len(calls) == 7


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="only Linux inherits the peak")
def test_a_process_of_its_own_does_not_inherit_this_ones_peak() -> None:
    ballast = np.ones(40_000_000)  # 320 MB, far above a bare interpreter
    code = "from pelagos.sim.memory import peak_memory_mb; print(peak_memory_mb())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert float(done.stdout) < 250 < ballast.nbytes / 2**20


def test_calls_take_turns_and_the_median_of_each_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    """By a clock of the test's own: at least five calls of each, and as many more as fill the time of the shorter."""
    now, calls = [40.0], list[str]()
    lengths = {
        "a": iter([9.0, 0.1, 0.5, 0.2, 0.4, 0.3, 0.25, 0.45, 0.1]),
        "b": iter([9.0, 2.0, 3.0, 1.0, 5.0, 4.0, 2.5, 3.5, 6.0]),
    }

    def call(name: str) -> None:
        calls.append(name)
        now[0] += next(lengths[name])

    monkeypatch.setattr(timing, "time", SimpleNamespace(perf_counter=lambda: now[0]))
    found = timing.seconds_in_turns(lambda: call("a"), lambda: call("b"), at_least_s=1.7, warm_up=1)
    assert calls == ["a", "b"] * 7  # the sixth of a fills the time; the first of each warms up
    assert found == pytest.approx([0.3, 3.0])
