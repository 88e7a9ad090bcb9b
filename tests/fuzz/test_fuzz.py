"""Fuzzing: scenarios changed, drawn from the schema or broken, and damaged recordings end well or in one error of ours.

`make fuzz` goes on by time.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import pytest
from harness import COUNTS, SECONDS, end_well, run_cases
from hypothesis import strategies as st
from scenario_checks import check, short_run
from scenarios import allowed, broken, near

from pelagos.config.loader import load_scenario
from pelagos.sim.record import Recorder
from pelagos.sim.replay import Recording

CORPUS = sorted((Path(__file__).parent / "corpus").glob("*.yaml"))


def drawn(make: Callable[[Random], Any]) -> st.SearchStrategy[Any]:
    """By a number each: `st.randoms()` draws subnormal numbers, which Dr.Jit's processor mode does not have."""
    return st.integers(0, 2**32).map(lambda number: make(Random(number)))


@pytest.mark.parametrize(
    ("make", "least"), [(near, 0.5), (allowed, 0.25), (broken, 0.0)], ids=["near", "allowed", "broken"]
)
def test_scenarios(make: Callable[[Random], Any], least: float) -> None:
    """Enough of them is accepted: what is refused at the door never meets what lies behind it."""
    ends = run_cases(drawn(make), check, make.__name__, cases=30)
    assert ends["accepted"] >= least * ends.total(), ends


@pytest.mark.skipif(not SECONDS, reason="builds simulations; `make fuzz` runs it by time")
def test_short_runs() -> None:
    """What passes the check runs five ticks, or ends in one error of ours; memory of two gigabytes at most."""
    run_cases(drawn(near) | drawn(allowed), short_run, "runs", cases=4, longest_s=120.0)


def test_texts(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"

    def read(text: str) -> None:
        path.write_text(text, encoding="utf-8")
        load_scenario(path)

    letters = st.sampled_from("abc: -[]{}&*<>|\n\t#!'0123456789.eE\x00\u2028")
    run_cases(st.text(alphabet=letters, max_size=200), read, "texts")


@pytest.mark.parametrize("path", CORPUS, ids=lambda p: p.stem)
def test_past_failures(path: Path) -> None:
    end_well(lambda: check(path))


def test_damaged_recordings(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with Recorder(path, "name: a\n", 1, {}, None, (0.0, 0.0), 1_000_000) as recorder:
        recorder.flush()
    whole = path.read_bytes()
    flips = st.lists(st.tuples(st.integers(0, len(whole) - 1), st.integers(0, 255)), max_size=6)

    def read(damage: tuple[int, list[tuple[int, int]]]) -> None:
        raw = bytearray(whole)
        for at, value in damage[1]:
            raw[at] = value
        path.write_bytes(raw[: damage[0]])
        Recording(path)

    run_cases(st.tuples(st.integers(0, len(whole)), flips), read, "recordings")


def test_figures() -> None:
    """How many cases there were (`make fuzz` shows it)."""
    print(COUNTS)
