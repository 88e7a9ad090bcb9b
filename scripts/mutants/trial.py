"""A trial: the tests of one mutant in a process of their own."""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import importlib.util
import os
import resource
import signal
import sys
import time
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import CodeType, ModuleType
from typing import Literal

from mutant import ROOT, SOURCES, Mutant

Verdict = Literal["noticed", "survived", "slow", "broken"]
CPU_SECONDS = 400
"""Processor time of one trial. Tests that need more are no answer: name quicker ones in the list."""
ADDRESS_BYTES = 12 << 30
"""Of one trial: a mistake may lift the limit of what a scenario may take."""

PRELOADED = (
    "numpy", "scipy.signal", "pydantic", "yaml", "trimesh", "matplotlib", "pytest", "mcap", "rosbags", "hypothesis",
    "hypothesis.extra.numpy", "gsw", "pyais", "pymavlink.mavutil",
)  # fmt: skip
"""Packages that a trial finds loaded already. Nothing of Pelagos, and nothing that starts threads."""


@dataclass(frozen=True)
class Outcome:
    """What became of one mutant."""

    mutant: Mutant
    verdict: Verdict
    seconds: float
    by: str
    """The test that failed first; the end of pytest's output where nothing did."""


class MutantLoader(importlib.machinery.SourceFileLoader):
    """Loads one module from a changed text and leaves no byte code behind."""

    def __init__(self, name: str, path: str, text: str) -> None:
        super().__init__(name, path)
        self.text = text

    def get_code(self, fullname: str) -> CodeType | None:
        """The changed source, compiled."""
        return compile(self.text, self.path, "exec", dont_inherit=True)


class MutantFinder(importlib.abc.MetaPathFinder):
    """Answers for the mutated module alone."""

    def __init__(self, mutant: Mutant) -> None:
        name = "pelagos." + mutant.file.removesuffix(".py").replace("/", ".")
        self.package = name.endswith(".__init__")
        self.name = name.removesuffix(".__init__")
        self.path = str(SOURCES / mutant.file)
        self.text = mutant.mutated()

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """The specification of the mutated module, None for every other."""
        if fullname != self.name:
            return None
        loader = MutantLoader(fullname, self.path, self.text)
        places = [str(Path(self.path).parent)] if self.package else None
        return importlib.util.spec_from_file_location(
            fullname, self.path, loader=loader, submodule_search_locations=places
        )


class FirstFailure:
    """A pytest plugin that remembers the first test that failed."""

    def __init__(self) -> None:
        self.node = ""

    def pytest_runtest_logreport(self, report: object) -> None:
        """Keep the node's name once."""
        if getattr(report, "failed", False) and not self.node:
            self.node = report.nodeid  # type: ignore[attr-defined]


def preload() -> None:
    """Import the packages that every trial needs, once, before the first fork."""
    for name in PRELOADED:
        importlib.import_module(name)


def overlay(mutant: Mutant, folder: Path) -> Path:
    """A new folder with the package as the mutant has it: links, and the one file. For processes that a test starts."""
    here, there = folder / SOURCES.name, SOURCES
    if here.exists():  # of the trial of a single test, which was silent
        return folder
    for part in Path(mutant.file).parts:
        here.mkdir(parents=True)
        for entry in there.iterdir():
            if entry.name not in (part, "__pycache__"):
                (here / entry.name).symlink_to(entry)
        here, there = here / part, there / part
    here.write_text(mutant.mutated())
    return folder


def start(mutant: Mutant | None, tests: Sequence[str], log: Path) -> int:
    """Fork a process that runs `tests` with the mutant in place; returns its pid. The log's last line is the test."""
    pid = os.fork()
    if pid:
        return pid
    code = 70
    try:
        os.setsid()
        resource.setrlimit(resource.RLIMIT_CPU, (CPU_SECONDS, CPU_SECONDS + 5))
        resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_BYTES, ADDRESS_BYTES))
        out = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(out, 1)
        os.dup2(out, 2)
        os.environ["PELAGOS_THREADS"] = "1"
        sys.path[:0] = [str(ROOT / "src"), str(ROOT)]  # contracts import one another by their full names
        if mutant is not None:
            sys.meta_path.insert(0, MutantFinder(mutant))
            os.environ["PYTHONPATH"] = str(overlay(mutant, log.with_suffix("")))
        import pytest

        os.chdir(ROOT)
        first = FirstFailure()
        options = ["-x", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", "--tb=line", "-m", "not slow"]
        options += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]  # hypothesis is loaded before
        code = int(pytest.main([*options, *tests], plugins=[first]))
        print(f"\n{first.node}")
    except BaseException:  # the child may not return into the parent's loop, whatever happens
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def finish(pid: int, status: int, mutant: Mutant, began: float, log: Path) -> Outcome:
    """The outcome of a process that ended: exit code 1 is a failed test, 0 a survivor, anything else a broken trial."""
    code = os.waitstatus_to_exitcode(status)
    lines = [line for line in log.read_text(errors="replace").splitlines() if line.strip()]
    last = lines[-1] if lines else ""
    seconds = time.monotonic() - began
    if code in (-signal.SIGXCPU, -signal.SIGKILL):
        return Outcome(mutant, "slow", seconds, f"not done after {CPU_SECONDS} s of processor time")
    if code == 1 and "::" in last:
        return Outcome(mutant, "noticed", seconds, last.strip())
    if code < 0 or (code == 1 and "::" not in last):
        return Outcome(mutant, "noticed", seconds, f"the process ended with {code}")
    return Outcome(mutant, "survived" if code == 0 else "broken", seconds, "\n".join(lines[-6:]))
