"""The page of checks: every numeric comparison of the tests, with its source, tolerance and measured deviation."""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path
from typing import Any, Final

TABLE: Final = Path(__file__).parents[2] / "docs" / "checks.json"
FOLDERS: Final = {
    "verification": "Closed forms, published numbers, conservation",
    "cross_code": "Other codes' numbers",
}
HEAD: Final = """\
# Checks

The numeric comparisons of Pelagos' tests with what nobody here wrote: closed forms, published tables, conservation
laws, other programs' results. `make checks` runs the tests and writes this list; nothing on it is typed by hand.

**{count} checks, {comparisons} numbers compared.** *Allowed* is the tolerance, relative where it says so, else in the
unit of the number. The bar is the largest deviation that any comparison of the check found, in parts of what is allowed
there: 0 is exact, above 1 the test fails. Half of the checks stay below {median:.2g}.
"""


def write(source: Path) -> None:
    """Write `checks.md` from the table that the tests made."""
    rows = json.loads(TABLE.read_text(encoding="utf-8"))["checks"] if TABLE.exists() else []
    worst = sorted(r["worst"] for r in rows) or [0.0]
    total = sum(r["comparisons"] for r in rows)
    groups: dict[tuple[str, str], list[dict[str, Any]]] = defaultdict(list)
    for row in rows:
        folder, file = row["file"].split("/")[1:3]
        groups[folder, file].append(row)
    lines = [HEAD.format(count=len(rows), comparisons=f"{total:,}".replace(",", " "), median=worst[len(worst) // 2])]
    for folder, title in FOLDERS.items():
        lines += [f"## {title}", ""]
        for (kind, file), members in sorted(groups.items()):
            if kind == folder:
                lines += [f"### {_topic(file)}", "", members[0].get("about", ""), "", *_table(members)]
                lines += [f"`tests/{folder}/{file}`", ""]
    (source / "checks.md").write_text("\n".join(lines), encoding="utf-8")


def _table(members: list[dict[str, Any]]) -> list[str]:
    head = ["| check | source, equation | compared | allowed | deviation |", "|---|---|---|---|---|"]
    rows = [
        f"| {_cell(r['check'])} | {_cell(r['source'])} | {r['comparisons']} | {_cell(r['allowed'])} "
        f"| {_bar(r['worst'])} |"
        for r in members
    ]
    return [*head, *rows, ""]


def _bar(part: float) -> str:
    """A deviation in parts of what is allowed, as a bar with its number."""
    return f'<span class="part"><span style="width:{100 * min(part, 1):.0f}%"></span></span> {part:.2g}'


def _topic(file: str) -> str:
    words = file.removesuffix(".py").removeprefix("test_").replace("_", " ").replace("nav ", "navigation: ")
    return words[0].upper() + words[1:]


def _cell(text: str) -> str:
    for mark in "*_<>[]{}$|":
        text = text.replace(mark, f"\\{mark}")
    return " ".join(text.split())
