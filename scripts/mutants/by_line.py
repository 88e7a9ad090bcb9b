"""Tests that run a line of the source, quickest first, from one run of the suite that wrote down which test ran what.

`make mutants-map` makes the two files; without them, and for sources that changed since, tests are chosen by imports.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

from mutant import ROOT, SOURCES

LINES = ROOT / "build" / "tests_by_line.coverage"
SECONDS = ROOT / "build" / "tests_by_line.txt"
"""pytest's list of durations."""
MOST_SECONDS = 600.0
"""Of one trial, by the tests' own time: a mistake that is seen at all is mostly seen by the quickest of its tests."""
LONGEST = 12  # lines of a statement
_DURATION = re.compile(r"^([\d.]+)s (?:call|setup) +(tests/\S.*)$", re.MULTILINE)


class TestsByLine:
    """Which tests ran a line, with the seconds that each takes."""

    def __init__(self) -> None:
        from coverage import CoverageData

        self.data = CoverageData(basename=str(LINES))
        self.data.read()
        self.seconds: dict[str, float] = defaultdict(float)
        for seconds, node in _DURATION.findall(SECONDS.read_text()):
            for name in {node.strip(), node.strip().partition("[")[0]}:
                self.seconds[name] += float(seconds)
        self.files = {Path(f).as_posix().rpartition("/src/pelagos/")[2]: f for f in self.data.measured_files()}

    def of(self, file: str, text: str) -> tuple[str, ...]:
        """Nodes that ran any line of a text within a file below `src/pelagos`; empty where none did but by import."""
        if (SOURCES / file).stat().st_mtime > LINES.stat().st_mtime:
            return ()  # its lines have moved since
        source = (SOURCES / file).read_text()
        first = source[: source.index(text)].count("\n") + 1
        lines = self.data.contexts_by_lineno(self.files[file]) if file in self.files else {}
        own = range(first, first + text.count("\n") + 1)
        if not any(lines.get(k) for k in own):  # within a statement that begins above
            own = next((range(k, k + 1) for k in range(first, max(first - LONGEST, 0), -1) if lines.get(k)), own)
        contexts = {c for k in own for c in lines.get(k, ())}
        nodes, shared = set(), set()
        for node, _, phase in (c.rpartition("|") for c in contexts if c):
            nodes.add(node)
            if phase == "setup":
                shared.add(node.split("::")[0])
        known = sorted({_today(n) for n in nodes if _there(n)})
        return (*self._quickest(known), *sorted(shared)) if known else ()

    def _quickest(self, nodes: Iterable[str]) -> list[str]:
        """File by file, so that what tests of a file share is made once."""
        by_file: dict[str, list[str]] = defaultdict(list)
        for node in sorted(nodes, key=lambda n: (self.seconds[n], n)):
            by_file[node.split("::")[0]].append(node)
        cost = {file: sum(self.seconds[n] for n in of) for file, of in by_file.items()}
        chosen, spent = [], 0.0
        for file in sorted(by_file, key=lambda f: (cost[f], f)):
            for node in by_file[file]:
                spent += self.seconds[node]
                if spent > MOST_SECONDS and chosen:
                    return chosen
                chosen.append(node)
        return chosen


def _there(node: str) -> bool:
    """True if the test still stands in its file: a map may be older than the tests."""
    file, _, name = node.partition("::")
    path = ROOT / file
    return path.exists() and f"def {name.partition('[')[0].rpartition('::')[2]}(" in path.read_text()


def _today(node: str) -> str:
    """The test, without the name of its case where its file has changed since: cases may be called otherwise."""
    file, _, name = node.partition("::")
    return f"{file}::{name.partition('[')[0]}" if (ROOT / file).stat().st_mtime > LINES.stat().st_mtime else node


def tests_by_line() -> TestsByLine | None:
    """The map, where `make mutants-map` has made it."""
    return TestsByLine() if LINES.exists() and SECONDS.exists() else None
