"""The page: one file of HTML that needs nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Final

_CSS: Final = """
:root { --ink: #0c2238; --muted: #5d6f82; --line: #dde4ea; --pale: #f4f7f9; --sea: #11467f; --accent: #2a9d8f; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--pale); color: var(--ink); line-height: 1.5; font-size: 15px;
  font-family: system-ui, -apple-system, "Segoe UI", "DejaVu Sans", "Liberation Sans", sans-serif; }
header { background: linear-gradient(160deg, #0b1f3f 0%, #11467f 70%, #1f78a8 100%); color: white;
  padding: 38px 0 76px; }
header .inner, main { max-width: 1180px; margin: 0 auto; padding: 0 24px; }
header .kind { text-transform: uppercase; letter-spacing: .14em; font-size: 12px; opacity: .75; margin: 0 0 6px; }
h1 { font-size: 31px; line-height: 1.2; margin: 0 0 8px; font-weight: 650; }
header p { margin: 0; max-width: 75ch; opacity: .9; }
main { padding-bottom: 56px; margin-top: -52px; position: relative; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(138px, 1fr)); gap: 1px; background: var(--line);
  border-radius: 10px; overflow: hidden; box-shadow: 0 2px 14px rgba(12, 34, 56, .13); }
.tile { background: white; padding: 15px 18px 13px; }
.tile b { display: block; font-size: 23px; line-height: 1.25; font-weight: 650; font-variant-numeric: tabular-nums; }
.tile b small { font-size: 14px; font-weight: 500; color: var(--muted); }
.tile span { font-size: 12.5px; color: var(--muted); }
section { background: white; border-radius: 10px; padding: 24px 26px 20px; margin-top: 22px;
  box-shadow: 0 1px 5px rgba(12, 34, 56, .07); }
h2 { font-size: 19px; margin: 0 0 4px; font-weight: 650; }
section > p { margin: 0 0 14px; color: var(--muted); max-width: 105ch; }
img { max-width: 100%; height: auto; display: block; margin: 0 auto; }
.night { background: #080d12; border-radius: 8px; padding: 10px; }
.photos { display: grid; grid-template-columns: repeat(3, 1fr); gap: 12px; }
figure { margin: 0; } figure img { border-radius: 6px; width: 100%; }
figcaption { font-size: 12.5px; color: var(--muted); margin-top: 4px; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-size: 14px; }
th { text-align: left; font-size: 12px; font-weight: 600; color: var(--muted); border-bottom: 2px solid var(--line);
  padding: 6px 10px 6px 0; white-space: nowrap; }
td { border-bottom: 1px solid var(--line); padding: 6px 10px 6px 0; vertical-align: top; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
td.code { font-family: ui-monospace, "DejaVu Sans Mono", monospace; font-size: 12px; color: var(--muted); }
.two { display: grid; grid-template-columns: 1fr 1fr; gap: 0 40px; }
footer { max-width: 1180px; margin: 0 auto; padding: 0 24px 36px; color: var(--muted); font-size: 13px; }
@media (max-width: 760px) { .photos, .two { grid-template-columns: 1fr; } section { padding: 18px 14px; } }
@media print { body { background: white; } section, .tiles { box-shadow: none; break-inside: avoid; } }
"""


@dataclass(frozen=True)
class Tile:
    """One number of the header."""

    value: str
    unit: str
    label: str


@dataclass(frozen=True)
class Section:
    """One card of the page; `body` is HTML, `text` is not."""

    title: str
    text: str
    body: str


def page(*, title: str, kind: str, text: str, tiles: Sequence[Tile], sections: Sequence[Section], foot: str) -> str:
    """The whole document."""
    numbers = "".join(
        f'<div class="tile"><b>{escape(t.value)} <small>{escape(t.unit)}</small></b>'
        f"<span>{escape(t.label)}</span></div>"
        for t in tiles
    )
    cards = "".join(
        f"<section><h2>{escape(s.title)}</h2>{f'<p>{escape(s.text)}</p>' if s.text else ''}{s.body}</section>\n"
        for s in sections
    )
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><title>{escape(title)}</title>'
        f"<style>{_CSS}</style></head>\n<body><header><div class=inner><p class=kind>{escape(kind)}</p>"
        f"<h1>{escape(title)}</h1><p>{escape(text)}</p></div></header>\n<main>"
        f'<div class="tiles">{numbers}</div>\n{cards}</main><footer>{escape(foot)}</footer></body></html>\n'
    )


def image(source: str, alternative: str, *, night: bool = False) -> str:
    """A picture that is part of the page."""
    tag = f'<img src="{source}" alt="{escape(alternative)}">'
    return f'<div class="night">{tag}</div>' if night else tag


def photographs(pictures: Sequence[tuple[str, str]]) -> str:
    """`(source, caption)` in three columns."""
    cells = "".join(
        f'<figure><img src="{source}" alt="{escape(caption)}"><figcaption>{escape(caption)}</figcaption></figure>'
        for source, caption in pictures
    )
    return f'<div class="photos">{cells}</div>'


def table(
    head: Sequence[str], rows: Sequence[Sequence[str]], *, numbers: Sequence[int] = (), code: Sequence[int] = ()
) -> str:
    """A table; columns of `numbers` stand right, columns of `code` are set as code."""

    def kind(column: int) -> str:
        return ' class="n"' if column in numbers else ' class="code"' if column in code else ""

    top = "".join(f"<th{kind(i) if i in numbers else ''}>{escape(h)}</th>" for i, h in enumerate(head))
    body = "".join("<tr>" + "".join(f"<td{kind(i)}>{escape(c)}</td>" for i, c in enumerate(r)) + "</tr>" for r in rows)
    return f'<div class="scroll"><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'


def two_columns(left: str, right: str) -> str:
    """Two pieces side by side where there is room."""
    return f'<div class="two"><div>{left}</div><div>{right}</div></div>'
