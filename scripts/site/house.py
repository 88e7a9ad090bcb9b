"""The house: the layers of `pyproject.toml` as a picture whose boxes lead to the packages' pages."""

from __future__ import annotations

import tomllib
from html import escape
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).parents[2]
WIDTH, HEIGHT, GAP, TOP = 960, 46, 8, 8
COLOURS: Final = ("#0b3954", "#125d78", "#1b7f94", "#2a9d8f", "#52b69a", "#76c893", "#99d98c", "#b5e48c", "#d9ed92")


def layers() -> list[list[str]]:
    """Packages of each layer, the highest first, as the import contract names them."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    named = next(c for c in contracts if c["type"] == "layers")["layers"]
    rows = [[part.strip(" ()") for part in row.replace(":", "|").split("|")] for row in named]
    exists = [[p for p in row if _path(p).exists()] for row in rows]
    return [row for row in exists if row]


def _path(package: str) -> Path:
    folder = ROOT / "src" / "pelagos" / package
    return folder if folder.is_dir() else folder.with_suffix(".py")


def purpose(package: str) -> str:
    """First sentence of a package's or module's docstring."""
    import ast

    path = _path(package)
    file = path / "__init__.py" if path.is_dir() else path
    text = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
    return text.strip().split("\n")[0]


def write(source: Path) -> None:
    """Write `house.svg` for the page of contents, which puts it in as it is."""
    rows = layers()
    height = TOP + len(rows) * (HEIGHT + GAP)
    drawn = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img" '
        'aria-label="Layers of Pelagos: each imports only from those below" style="max-width:100%;height:auto">'
    ]
    for number, row in enumerate(rows):
        y = TOP + number * (HEIGHT + GAP)
        size = (WIDTH - GAP * (len(row) - 1)) / len(row)
        fill = COLOURS[min(number, len(COLOURS) - 1)]
        ink = "#ffffff" if number < 5 else "#10202c"
        for place, package in enumerate(row):
            x = place * (size + GAP)
            drawn.append(
                f'<a href="api/{package}.html"><title>{escape(purpose(package) or package)}</title>'
                f'<rect x="{x:.1f}" y="{y}" width="{size:.1f}" height="{HEIGHT}" rx="6" fill="{fill}"/>'
                f'<text x="{x + size / 2:.1f}" y="{y + HEIGHT / 2 + 6}" text-anchor="middle" fill="{ink}" '
                f'font-family="sans-serif" font-size="17">{escape(package)}</text></a>'
            )
    drawn.append("</svg>")
    (source / "house.svg").write_text("\n".join(drawn), encoding="utf-8")
