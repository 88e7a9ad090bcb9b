"""A long attack on scenarios: as many checks and short runs as asked for, each case by its number, counted by its end.

usage: python tests/fuzz/campaign.py CHECKS [--runs RUNS] [--first NUMBER] [--minutes M] [--folder FOLDER]

Works in a process of its own, which is started anew after a crash or a hang. FOLDER/counts.json has the figures; every
failure is FOLDER/KIND-NUMBER.yaml with its traceback beside it: mend it, and keep its scenario in tests/fuzz/corpus.
"""

from __future__ import annotations

import argparse
import copy
import json
import os
import select
import subprocess
import sys
import time
import traceback
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from random import Random
from typing import IO, Any

sys.path.insert(0, str(Path(__file__).parent))

KINDS = ("near", "allowed", "near", "allowed", "broken", "broken")
"""Checks take turns; runs take `near` and `allowed`."""
HANG_S = {"check": 60.0, "run": 400.0}  # of the clock, where a case may take 10 and 120 s of the processor
SLOW_S = {"check": 10.0, "run": 120.0}


def case(work: str, number: int) -> tuple[str, Any]:
    """The kind and the data of a case."""
    import scenarios

    kind = KINDS[number % (len(KINDS) if work == "check" else 4)]
    draw = Random(f"{work} {kind} {number}")
    make: dict[str, Callable[[Random], Any]] = {
        "near": scenarios.near, "allowed": scenarios.allowed, "broken": scenarios.broken
    }  # fmt: skip
    return kind, make[kind](draw)


def child(work: str, first: int, end: int) -> None:
    """One line of JSON for every case: its number, kind, end, seconds of the processor, and the traceback if any."""
    from harness import end_of
    from scenario_checks import DO

    report = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what is printed on the way
    for number in range(first, end):
        kind, data = case(work, number)
        began, trace = time.process_time(), ""
        try:
            ended = end_of(lambda data=data: DO[work](data))  # type: ignore[misc]
        except Exception as error:
            ended, trace = f"{type(error).__name__}", traceback.format_exc()
            data = smaller(data, partial(_fails, type(error), work))
        spent = time.process_time() - began
        if spent > SLOW_S[work]:
            ended, trace = "slow", trace or f"{spent:.1f} s"
        report.write(json.dumps([number, kind, ended, spent, trace, data if trace else None]) + "\n")


def _fails(kind: type[Exception], work: str, data: Any) -> bool:
    from harness import end_of
    from scenario_checks import DO

    try:
        end_of(lambda: DO[work](data))
    except kind:
        return True
    except Exception:
        return False
    return False


def smaller(data: Any, fails: Callable[[Any], bool], tries: int = 200) -> Any:
    """What is left of a failing case when every part is gone without which it fails as before."""
    from scenarios import at, places

    found = sorted(places(data), key=len)
    while found and tries:
        place, tries = found.pop(0), tries - 1
        less = copy.deepcopy(data)
        del at(less, place[:-1])[place[-1]]
        if fails(less):
            data, found = less, sorted(places(less), key=len)
    return data


class Campaign:
    """Cases from one number to another, and what became of them."""

    def __init__(self, folder: Path, ends: float) -> None:
        self.folder, self.ends, self.counts, self.seconds = folder, ends, Counter[str](), Counter[str]()
        folder.mkdir(parents=True, exist_ok=True)

    def go(self, work: str, first: int, end: int) -> int:
        """The first number that was not tried."""
        while first < end and time.monotonic() < self.ends:
            command = [sys.executable, __file__, "--child", work, str(first), str(end)]
            with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, bufsize=0) as process:
                assert process.stdout is not None
                first = self._listen(process, process.stdout, work, first)
            self._write()
        return first

    def _listen(self, process: subprocess.Popen[bytes], lines: IO[bytes], work: str, first: int) -> int:
        """Count until the child is done, dies, hangs, or the time is over."""
        rest = b""
        while True:
            ready, _, _ = select.select([lines], [], [], HANG_S[work])
            chunk = os.read(lines.fileno(), 1 << 16) if ready else b""
            if not chunk:  # the end, a crash or a hang
                if not ready:
                    process.kill()
                if code := process.wait():
                    kind, data = case(work, first)
                    ended = "hang" if not ready else f"exit {code}"
                    self._count(work, first, kind, ended, 0.0, f"exit code {code}", data)
                    return first + 1
                return first
            *whole, rest = (rest + chunk).split(b"\n")
            for line in whole:
                number, kind, ended, spent, trace, data = json.loads(line)
                self._count(work, number, kind, ended, spent, trace, data)
                first = number + 1
            if time.monotonic() > self.ends:
                process.kill()
                return first

    def _count(self, work: str, number: int, kind: str, ended: str, spent: float, trace: str, data: Any) -> None:
        self.counts[f"{work} {kind}: {ended}"] += 1
        self.seconds[f"{work} {kind}"] += spent  # type: ignore[assignment]
        if trace:
            import yaml

            path = self.folder / f"{work}-{number}.yaml"
            path.write_text(yaml.safe_dump(data, allow_unicode=True, sort_keys=False))
            path.with_suffix(".txt").write_text(trace)
        if not number % 100 or trace:
            self._write()

    def _write(self) -> None:
        text = json.dumps({"counts": dict(sorted(self.counts.items())), "cpu_s": dict(self.seconds)}, indent=1)
        (self.folder / "counts.json").write_text(text + "\n")


def main() -> int:
    """Attack; 1 if anything failed."""
    if sys.argv[1:2] == ["--child"]:
        child(sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
        return 0
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("checks", type=int)
    parser.add_argument("--runs", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--minutes", type=float, default=1e6)
    parser.add_argument("--folder", type=Path, default=Path("build/fuzz"))
    options = parser.parse_args()
    campaign = Campaign(options.folder, time.monotonic() + 60.0 * options.minutes)
    for work, count in (("check", options.checks), ("run", options.runs)):
        campaign.go(work, options.first, options.first + count)
    print(json.dumps(campaign.counts, indent=1, sort_keys=True))
    return int(any(options.folder.glob("*.txt")))


if __name__ == "__main__":
    sys.exit(main())
