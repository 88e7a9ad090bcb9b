"""`pelagos bench`: measure, print, and write the page of results."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from pelagos.cli.console import err, out, shown


def run_bench(names: Sequence[str], *, as_json: bool, write: Path | None) -> int:
    """Run cases.

    Returns:
        The exit code: 0 where every case could be measured, goal met or not; else 1.

    Raises:
        LookupFailed: no case has this name.
    """
    with err.status("loading the simulator"):
        from pelagos.bench.results import as_markdown
        from pelagos.bench.runner import as_data, as_line, run_cases
    results = run_cases(names, each=None if as_json else lambda result: out.print(as_line(result), markup=False))
    if as_json:
        out.print(json.dumps([as_data(result) for result in results], indent=2), markup=False)
    if write is not None:
        write.parent.mkdir(parents=True, exist_ok=True)
        write.write_text(as_markdown(results), encoding="utf-8")
        err.print(f"written: {shown(write)}")
    return 0 if all(result.value is not None for result in results) else 1
