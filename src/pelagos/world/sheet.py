"""One picture that shows a world: its map, its views, and the numbers that matter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pelagos.files import whole

_KINDS = 12  # kinds of object that are counted on the sheet
_CHART_IN, _TEXT_IN, _VIEW_IN = 8.4, 3.6, 4.9  # width of the map, heights of the text and of a view [inch]


def draw_sheet(
    path: Path, *, title: str, map_png: Path, views: Sequence[tuple[str, Path]], lines: Sequence[str]
) -> Path:
    """Write a sheet: the map at the left and lines of text below it, views at the right, and below the text what would
    make the right side much longer than the left.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.image import imread

    chart = imread(map_png)
    above = _CHART_IN * chart.shape[0] / chart.shape[1] + _TEXT_IN
    below = min(range(len(views) + 1), key=lambda k: max(above + _VIEW_IN * k, _VIEW_IN * (len(views) - k)))
    aside = list(views[: len(views) - below])
    high = max(above + _VIEW_IN * below, _VIEW_IN * len(aside))
    figure = Figure(figsize=(16, high), facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subfigures(1, 2, width_ratios=(1.1, 1.0))
    rest = high - above - _VIEW_IN * below  # empty space at the foot of the left side
    cells = left.add_gridspec(
        3 + below, 1, height_ratios=(above - _TEXT_IN, _TEXT_IN, *[_VIEW_IN] * below, rest + 0.01)
    )
    _picture(left.add_subplot(cells[0]), chart, "")
    text = left.add_subplot(cells[1])
    text.axis("off")
    text.text(0.04, 1.0, "\n".join(lines), va="top", fontsize=11, linespacing=1.5, wrap=True)
    for k, (caption, picture) in enumerate(views[len(aside) :]):
        _picture(left.add_subplot(cells[2 + k]), imread(picture), caption)
    for row, (caption, picture) in enumerate(aside):
        _picture(right.add_subplot(max(len(aside), 1), 1, row + 1), imread(picture), caption)
    figure.suptitle(title, fontsize=15)
    with whole(path) as fresh:
        figure.savefig(fresh, dpi=100)
    return path


def _picture(axes: Any, image: Any, caption: str) -> None:
    axes.imshow(image)
    axes.set_anchor("N")
    axes.set_title(caption, fontsize=11, loc="left")
    axes.axis("off")


def summary(stats: Mapping[str, Any]) -> list[tuple[str, str]]:
    """`(what, value)` for people, from `preview.statistics` and what the caller measured."""
    extent, ground = stats["extent_m"], stats["ground_z_m"]
    ha = stats["area_m2"] / 1e4
    counted = sum(stats["objects"].values())
    kinds = [f"{count} {name}" for name, count in list(stats["objects"].items())[:_KINDS]]
    if len(stats["objects"]) > _KINDS:
        kinds.append("...")
    rows = [
        ("extent", " x ".join(_length(e) for e in extent[:2])),
        ("area", f"{ha:,.4g} ha" if ha < 1e4 else f"{ha / 100:,.0f} km^2"),
        ("depth", f"{-ground[2]:.2f} .. {-ground[0]:.2f} m, median {-ground[1]:.2f} m"),
        ("objects", f"{counted}: {', '.join(kinds)}" if counted else "none"),
        ("movers", "; ".join(f"{name} ({what})" for name, what in stats["movers"].items())),
        ("materials", ", ".join(stats["materials"])),
        ("triangles", f"{stats['triangles']:,}"),
        ("meshes", f"{stats['mesh_mb']:.1f} MB"),
        ("origin", f"latitude {stats['latitude_deg']:.6f} deg, longitude {stats['longitude_deg']:.6f} deg"),
    ]
    if "generation_s" in stats:
        rows.append(("generated in", f"{stats['generation_s']:.1f} s"))
    if "peak_memory_mb" in stats:
        rows.append(("peak memory", f"{stats['peak_memory_mb']:.0f} MB, the program and its libraries included"))
    return [row for row in rows if row[1]]


def _length(metres: float) -> str:
    return f"{metres:.4g} m" if metres < 10_000 else f"{metres / 1e3:.4g} km"
