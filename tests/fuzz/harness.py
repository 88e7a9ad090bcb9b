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


def end_well(work: Callable[[], object], longest_s: float = LONGEST_S) -> str:
    """It works, or it ends in one error of ours, soon: in this many seconds of the processor."""
    started = time.process_time()
    ended = end_of(work)
    assert time.process_time() - started < longest_s
    return ended


def end_of(work: Callable[[], object]) -> str:
    """How work ended: "accepted", or in an error of ours: for "one fault", or for "many faults"."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            work()
        except PelagosError as error:
            assert str(error).strip()  # noqa: PT017
            return "many faults" if "things are wrong:" in str(error) else "one fault"
    return "accepted"


def run_cases(
    strategy: st.SearchStrategy[Any],
    check: Callable[[Any], None],
    kind: str,
    *,
    cases: int = 40,
    longest_s: float = LONGEST_S,
) -> Counter[str]:
    """The same few cases in every run; where `PELAGOS_FUZZ_SECONDS` is set, new ones until the time is over.

    Returns:
        How many ended how.
    """
    ends, batch, counts = time.monotonic() + SECONDS, 0, Counter[str]()
    while True:

        def case(value: Any) -> None:
            ended = end_well(lambda: check(value), longest_s)
            counts[ended] += 1
            COUNTS[f"{kind}: {ended}"] += 1

        settled = settings(
            max_examples=5 * cases if SECONDS else cases, deadline=None, suppress_health_check=list(HealthCheck),
            derandomize=not SECONDS, database=None,
        )(given(strategy)(case))  # fmt: skip
        (seed(int(time.time()) + batch)(settled) if SECONDS else settled)()
        batch += 1
        if time.monotonic() >= ends:
            return counts
