"""No test drops out unseen: a skip that nobody expected fails the run."""

from __future__ import annotations

import gc
import os
import re

import pytest

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy: its threads wait for one another busily

from quick_approx import quicken_approx
from quick_kernels import quicken

quicken()
quicken_approx()
gc.set_threshold(50_000, 20, 50)  # thousands of collected tests are looked through again and again otherwise

EXPECTED_SKIPS = (
    "the real surveys are not on this machine",
    "builds simulations; `make fuzz` runs it by time",
    "this GDAL is built without BAG",
    "kernels are counted by their LLVM code",
    "POSIX",
    "only Linux inherits the peak",
    "forks",
    "Ray is not installed",
    "pelagos[learn] is not installed",
    "regressions of tank trials, about one speed",
    "not installed: sh scripts/peers.sh",
    "zenoh-ros2-sdk 0.1.8 takes a fixed array of messages for something else",
)
"""Parts of the reasons that a complete installation may give. PELAGOS_ALLOW_SKIPS=1 allows every other reason too."""


def unexpected_skips(config: pytest.Config) -> list[str]:
    """The reasons, with their places, of skips that no entry of `EXPECTED_SKIPS` explains."""
    reporter = config.pluginmanager.get_plugin("terminalreporter")
    if reporter is None or os.environ.get("PELAGOS_ALLOW_SKIPS"):
        return []
    expected = re.compile("|".join(map(re.escape, EXPECTED_SKIPS)))
    reasons = [r.longrepr for r in reporter.stats.get("skipped", ()) if isinstance(r.longrepr, tuple)]
    return [f"{path}:{line}: {reason}" for path, line, reason in reasons if not expected.search(reason)]


def pytest_collection_finish(session: pytest.Session) -> None:
    gc.freeze()


@pytest.hookimpl(tryfirst=True)
def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    if exitstatus == pytest.ExitCode.OK and unexpected_skips(session.config):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    reasons = unexpected_skips(config)
    if reasons:
        terminalreporter.section("unexpected skips fail the run", red=True)
        for reason in reasons:
            terminalreporter.line(reason)
        terminalreporter.line("install the missing package with `make venv`, or set PELAGOS_ALLOW_SKIPS=1")
