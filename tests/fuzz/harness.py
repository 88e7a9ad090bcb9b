"""What fuzz tests share: cases by number or by time, counted; each works, or ends in one error of ours, soon."""

from __future__ import annotations

import os
import time
import warnings
from collections import Counter
from collections.abc import Callable
from typing import Any

from hypothesis import HealthCheck, given, seed, settings
from hypothesis import strategies as st

from pelagos.errors import PelagosError

SECONDS = float(os.environ.get("PELAGOS_FUZZ_SECONDS", "0"))
"""How long each test goes on; 0: the few cases of every test run."""
LONGEST_S = 10.0
COUNTS: Counter[str] = Counter()


def end_well(work: Callable[[], object], longest_s: float = LONGEST_S) -> None:
    """It works, or it ends in one error of ours, soon: in this many seconds of the processor."""
    started = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            work()
        except PelagosError as error:
            assert str(error).strip()  # noqa: PT017
    assert time.process_time() - started < longest_s


def run_cases(
    strategy: st.SearchStrategy[Any],
    check: Callable[[Any], None],
    kind: str,
    *,
    cases: int = 40,
    longest_s: float = LONGEST_S,
) -> None:
    """The same few cases in every run; where `PELAGOS_FUZZ_SECONDS` is set, new ones until the time is over."""
    ends, batch = time.monotonic() + SECONDS, 0
    while True:

        def case(value: Any) -> None:
            COUNTS[kind] += 1
            end_well(lambda: check(value), longest_s)

        settled = settings(
            max_examples=5 * cases if SECONDS else cases, deadline=None, suppress_health_check=list(HealthCheck),
            derandomize=not SECONDS, database=None,
        )(given(strategy)(case))  # fmt: skip
        (seed(int(time.time()) + batch)(settled) if SECONDS else settled)()
        batch += 1
        if time.monotonic() >= ends:
            return
