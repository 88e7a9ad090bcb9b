"""The page of checks: every numeric comparison of the tests, with its source, tolerance and measured deviation."""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path
from typing import Any, Final

TABLE: Final = Path(__file__).parents[2] / "docs" / "checks.json"
FOLDERS: Final = {
    "verification": "Closed forms and published numbers",
    "cross_code": "Other codes' numbers",
}
HEAD: Final = """\
# Checks

Every numeric comparison of Pelagos with something that nobody here wrote: closed forms, published tables, other
programs' results. `make checks` runs the tests and writes this list; nothing on it is typed by hand. Deviation is the
largest that any comparison of the test found, in parts of what was allowed there: 0 is exact, above 1 fails.

{count} tests with {comparisons} comparisons; median deviation {median:.2g} of what is allowed.
"""


def write(source: Path) -> None:
    """Write `checks.md` from the table that the tests made."""
    rows = json.loads(TABLE.read_text(encoding="utf-8"))["checks"] if TABLE.exists() else []
    worst = sorted(r["worst"] for r in rows) or [0.0]
    lines = [
        HEAD.format(count=len(rows), comparisons=sum(r["comparisons"] for r in rows), median=worst[len(worst) // 2])
    ]
    groups: dict[tuple[str, str], list[dict[str, Any]]] = defaultdict(list)
    for row in rows:
        folder, file = row["file"].split("/")[1:3]
        groups[folder, file].append(row)
    for folder, title in FOLDERS.items():
        lines += [f"## {title}", ""]
        for (kind, file), members in sorted(groups.items()):
            if kind != folder:
                continue
            lines += [
                f"### {_topic(file)}",
                "",
                members[0].get("about", ""),
                "",
                "| check | source, equation | compared | deviation |",
                "|---|---|---|---|",
            ]
            lines += [
                f"| {_cell(r['check'])} | {_cell(r['source'])} | {r['comparisons']} "
                f"| {r['worst']:.2g} of {_cell(r['allowed'])} |"
                for r in members
            ]
            lines.append("")
    (source / "checks.md").write_text("\n".join(lines), encoding="utf-8")


def _topic(file: str) -> str:
    return file.removesuffix(".py").removeprefix("test_").replace("_", " ")


def _cell(text: str) -> str:
    for mark in "*_<>[]{}$|":
        text = text.replace(mark, f"\\{mark}")
    return " ".join(text.split())
