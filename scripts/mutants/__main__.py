"""Put plausible mistakes into the source, one at a time, and see that a test notices each.

usage: python scripts/mutants [LIST ...] [--some COUNT | --changed REF | --fresh COUNT | --list FILE | --check]
"""

from __future__ import annotations

import argparse
import json
import os
import random
import subprocess
import sys
import tempfile
import time
from collections import Counter, deque
from itertools import zip_longest
from pathlib import Path

from by_line import tests_by_line
from fresh import draw, with_tests
from mutant import LISTS, ROOT, BadMutant, Mutant, read_mutants
from trial import Outcome, finish, preload, start

NOTICED = LISTS.parent / "noticed.json"
"""The test that noticed each mutant last time: it is tried first."""


def main() -> int:
    """Run the trials, print a line each and a table by package; 1 if one survived or does not fit its file."""
    parser = argparse.ArgumentParser(prog="mutants", description=__doc__.splitlines()[0])
    parser.add_argument("lists", nargs="*", help="lists to run, all by default")
    parser.add_argument(
        "--some", metavar="COUNT", type=int, help="about so many of them, from as many files as there can be"
    )
    parser.add_argument("--changed", metavar="REF", help="only files that differ from this commit")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="trials at a time")
    parser.add_argument("--fresh", metavar="COUNT", type=int, help="about so many that are in no list, drawn at random")
    parser.add_argument("--decisions", action="store_true", help="of --fresh: conditions and branches, not formulas")
    parser.add_argument("--seed", type=int, default=0, help="of --some and --fresh")
    parser.add_argument("--list", metavar="FILE", type=Path, help="those of somebody else's list, which names no tests")
    parser.add_argument("--only", metavar="KEY", help="the mutant of this key alone")
    parser.add_argument("--check", action="store_true", help="only check that each list fits the source")
    options = parser.parse_args()
    if options.list:
        mutants = with_tests(options.list)
    else:
        mutants = (
            draw(options.seed, options.fresh, of_decisions=options.decisions)
            if options.fresh
            else list(read_mutants(tuple(options.lists)))
        )
    if options.changed:
        touched = changed_files(options.changed)
        mutants = [m for m in mutants if f"src/pelagos/{m.file}" in touched]
    if options.only:
        mutants = [m for m in mutants if m.key == options.only]
    if options.some:
        mutants = spread(mutants, options.some, options.seed)
    misfits = [text for m in mutants if (text := misfit(m))]
    for text in misfits:
        print(text)
    if options.check or misfits:
        print(f"{len(mutants)} mutants, {len(misfits)} do not fit the source")
        return bool(misfits)
    preload()
    outcomes = run(mutants, options.jobs, keep=not (options.fresh or options.list))
    return report(outcomes)


def changed_files(ref: str) -> set[str]:
    """Paths that differ between the working tree and the commit."""
    answer = subprocess.run(["git", "diff", "--name-only", ref], cwd=ROOT, capture_output=True, text=True, check=True)
    return set(answer.stdout.split())


def spread(mutants: list[Mutant], count: int, seed: int) -> list[Mutant]:
    """So many of them: one of each file before a second of any."""
    by_file: dict[str, list[Mutant]] = {}
    for mutant in random.Random(seed).sample(mutants, len(mutants)):
        by_file.setdefault(mutant.file, []).append(mutant)
    rounds = zip_longest(*by_file.values())
    return [mutant for one_each in rounds for mutant in one_each if mutant][:count]


def misfit(mutant: Mutant) -> str:
    """Why the mutant cannot be put in; empty if it can."""
    try:
        mutant.mutated()
    except (BadMutant, OSError, SyntaxError) as error:
        return str(error)
    missing = [test for test in mutant.tests if not (ROOT / test.split("::")[0]).exists()]
    return f"{mutant.layer}: {mutant.file}: no tests {missing}" if missing else ""


def run(mutants: list[Mutant], jobs: int, *, keep: bool = True) -> list[Outcome]:
    """All trials, `jobs` at a time: the test that noticed last time, then, if it is silent, all; `keep` its name.

    Where none is known, tests that run the line come first, if `make mutants-map` has written down which.
    """
    known = json.loads(NOTICED.read_text()) if NOTICED.exists() else {}
    near = tests_by_line() if keep else None
    first = {m.key: (known[m.key],) if m.key in known else (near and near.of(m.file, m.text)) for m in mutants}
    waiting = deque((m, first[m.key] or m.tests) for m in mutants)
    running: dict[int, tuple[Mutant, tuple[str, ...], float, Path]] = {}
    outcomes: list[Outcome] = []
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        while waiting or running:
            while waiting and len(running) < jobs:
                mutant, tests = waiting.popleft()
                log = Path(folder) / f"{mutant.key}.log"
                running[start(mutant, tests, log)] = (mutant, tests, time.monotonic(), log)
            pid, status = os.wait()
            mutant, tests, started, log = running.pop(pid)
            outcome = finish(pid, status, mutant, started, log)
            if outcome.verdict != "noticed" and tests != mutant.tests:
                waiting.appendleft((mutant, mutant.tests))
                continue
            outcomes.append(outcome)
            if keep:
                remember(outcome)
            elapsed = time.monotonic() - began
            print(f"{len(outcomes):4d}/{len(mutants)} {elapsed:6.0f} s  {line(outcome)}", flush=True)
    return outcomes


def line(outcome: Outcome) -> str:
    """One trial in one line, survivors in full."""
    m = outcome.mutant
    change = f"{m.text.strip()!r} -> {m.mutation.strip()!r}"
    head = f"{outcome.verdict:8s} {outcome.seconds:5.1f} s  {m.key}  {m.file}: {change}"
    return head if outcome.verdict == "noticed" else f"{head}\n{outcome.by}"


def remember(outcome: Outcome) -> None:
    """Write down which test noticed the mutant."""
    if outcome.verdict == "noticed" and "::" in outcome.by:
        known = json.loads(NOTICED.read_text()) if NOTICED.exists() else {}
        known[outcome.mutant.key] = outcome.by
        NOTICED.write_text(json.dumps(dict(sorted(known.items())), indent=0) + "\n")


def report(outcomes: list[Outcome]) -> int:
    """A table by package and the survivors; 1 if there are any."""
    every = Counter(o.mutant.package for o in outcomes)
    seen = Counter(o.mutant.package for o in outcomes if o.verdict == "noticed")
    print(f"\n{'package':14s} noticed")
    for package, count in sorted(every.items()):
        print(f"{package:14s} {seen[package]:4d} of {count}")
    print(f"{'all':14s} {seen.total():4d} of {every.total()}")
    missed = [o for o in outcomes if o.verdict != "noticed"]
    for outcome in missed:
        print(line(outcome))
    return bool(missed)


if __name__ == "__main__":
    sys.exit(main())
