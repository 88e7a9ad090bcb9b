"""`python -m pelagos.bench [CASE ...] [--write FILE]`, which `make bench` calls."""

from __future__ import annotations

import sys
from pathlib import Path

from pelagos.bench.results import as_markdown
from pelagos.bench.runner import as_line, run_cases


def _main() -> None:
    arguments = sys.argv[1:]
    target = None
    if "--write" in arguments:
        place = arguments.index("--write")
        target = Path(arguments[place + 1])
        del arguments[place : place + 2]
    results = run_cases(arguments, each=lambda result: print(as_line(result), flush=True))
    if target is not None:
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(as_markdown(results), encoding="utf-8")


if __name__ == "__main__":
    _main()
