"""Rows and chapters of the page that compares Pelagos with recordings, and the page itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

TABLES: Final = Path(__file__).parent / "tables"
HEAD: Final = """\
# Predicted, and measured

Vehicles, devices and seas of Pelagos beside recordings of real ones. `make proof DATA=FOLDER` writes this page from the
recordings; nothing in the tables is typed by hand. Small tables are kept in `scripts/proof/tables`; the rest is read
from the folder named, and a chapter without its recordings says so. No number of a model was tuned on a record that it
is tested on: each chapter says what was calibrated, and on which part. *Bar* is what we ask of ourselves. Where it is
missed, the chapter says by how much and the most likely cause.

{kept} of {judged} comparisons keep their bar.
"""


@dataclass(frozen=True)
class Row:
    """One comparison.

    Attributes:
        quantity: in words; measured, simulated: with unit, as text.
        deviation: what is judged; unit: of it; bar: its limit, or None where nothing is judged.
        at_least: whether the bar is a lower limit; others: accuracy that others published.
    """

    quantity: str
    measured: str
    simulated: str
    deviation: float
    unit: str
    bar: float | None
    at_least: bool = False
    others: str = ""

    @property
    def kept(self) -> bool | None:
        """Whether the bar is kept; None without one."""
        if self.bar is None:
            return None
        return self.deviation >= self.bar if self.at_least else abs(self.deviation) <= self.bar


@dataclass(frozen=True)
class Chapter:
    """A vehicle, device or sea: what was compared, how, with which outcome."""

    title: str
    about: str
    source: str
    rows: Sequence[Row]
    missed: str = ""
    picture: bytes | None = None
    name: str = ""


def relative(
    quantity: str, unit: str, measured: float, simulated: float, percent: float | None, others: str = ""
) -> Row:
    """A row whose deviation is in per cent of the measured value."""
    off = 100 * (simulated - measured) / measured
    return Row(quantity, _text(measured, unit), _text(simulated, unit), off, "%", percent, others=others)


def absolute(quantity: str, unit: str, measured: float, simulated: float, bar: float | None, others: str = "") -> Row:
    """A row whose deviation is in the quantity's own unit."""
    return Row(quantity, _text(measured, unit), _text(simulated, unit), simulated - measured, unit, bar, others=others)


def at_least(quantity: str, value: float, bar: float, others: str = "") -> Row:
    """A score such as R2 that should be large."""
    return Row(quantity, "", "", value, "", bar, at_least=True, others=others)


def at_most(quantity: str, value: float, unit: str, bar: float, others: str = "") -> Row:
    """A deviation over a whole record, such as a root mean square, that should be small."""
    return Row(quantity, "", "", value, unit, bar, others=others)


def _text(value: float, unit: str) -> str:
    return f"{value:.4g} {unit}".strip()


def table(name: str) -> dict[str, np.ndarray]:
    """Columns of a small table by name; lines with # are its source."""
    lines = [x for x in (TABLES / name).read_text(encoding="utf-8").splitlines() if x and not x.startswith("#")]
    names = lines[0].split(",")
    values = np.array([[float(c) if c else np.nan for c in line.split(",")] for line in lines[1:]])
    return dict(zip(names, values.T, strict=True))


def keep(name: str, source: str, columns: dict[str, np.ndarray], digits: int = 5) -> None:
    """Write a small table with its source."""
    rows = np.column_stack(list(columns.values()))
    lines = [f"# {line}" for line in source.splitlines()] + [",".join(columns)]
    lines += [",".join("" if np.isnan(x) else f"{x:.{digits}g}" for x in row) for row in rows]
    (TABLES / name).write_text("\n".join(lines) + "\n", encoding="utf-8")


def section(c: Chapter, pictures: Path) -> str:
    """A chapter in Markdown; its picture is written."""
    parts = [f"## {c.title}\n", c.about.strip() + "\n"]
    parts.append("| quantity | measured | simulated | deviation | bar | | published by others |\n" + 7 * "|---" + "|")
    for r in c.rows:
        bar = "" if r.bar is None else f"{'>=' if r.at_least else '<='} {r.bar:g} {r.unit}".strip()
        verdict = {True: "kept", False: "**missed**", None: ""}[r.kept]
        off = f"{r.deviation:.3g} {r.unit}" if r.at_least or not r.measured else f"{r.deviation:+.2g} {r.unit}"
        parts.append(
            f"| {r.quantity} | {r.measured} | {r.simulated} | {off.strip()} | {bar} | {verdict} | {r.others} |"
        )
    parts.append("")
    if c.missed:
        parts.append(c.missed.strip() + "\n")
    if c.picture is not None:
        (pictures / f"proof_{c.name}.png").write_bytes(c.picture)
        parts.append(f"![{c.title}](images/proof_{c.name}.png)\n")
    parts.append(f"Recordings: {c.source.strip()}\n")
    return "\n".join(parts)


def sections(page: str) -> dict[str, str]:
    """Chapters of a page by title, as they stand there."""
    parts = ["## " + part for part in page.split("\n## ")[1:]]
    return {part.splitlines()[0].removeprefix("## "): part.rstrip("\n") + "\n" for part in parts}


def joined(parts: Sequence[str], absent: Sequence[str]) -> str:
    """The page of these chapters."""
    text = "\n".join(parts)
    kept, missed = text.count("| kept |"), text.count("| **missed** |")
    found = [HEAD.format(kept=kept, judged=kept + missed), *parts]
    if absent:
        found += ["## Not made\n", *[f"* {line}" for line in absent], ""]
    return "\n".join(found)
