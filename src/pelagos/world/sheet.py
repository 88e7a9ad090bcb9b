"""One picture that shows a world: its map, its views, and the numbers that matter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

_KINDS = 12  # kinds of object that are counted on the sheet


def draw_sheet(
    path: Path, *, title: str, map_png: Path, views: Sequence[tuple[str, Path]], lines: Sequence[str]
) -> Path:
    """Write a sheet: the map at the left, views at the right, lines of text below the map."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.image import imread

    rows = max(len(views), 1)
    chart = imread(map_png)
    high = max(4.6 * rows, 8.4 * chart.shape[0] / chart.shape[1] + 3.6)  # of the sheet: room for the text below the map
    figure = Figure(figsize=(16, high), facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subfigures(1, 2, width_ratios=(1.1, 1.0))
    share = 8.4 * chart.shape[0] / chart.shape[1] / high
    top = left.add_gridspec(2, 1, height_ratios=(share, 1.0 - share))
    axes = left.add_subplot(top[0])
    axes.imshow(chart)
    axes.set_anchor("N")
    axes.axis("off")
    text = left.add_subplot(top[1])
    text.axis("off")
    text.text(0.04, 1.0, "\n".join(lines), va="top", fontsize=11, linespacing=1.5, wrap=True)
    for row, (caption, picture) in enumerate(views):
        panel = right.add_subplot(rows, 1, row + 1)
        panel.imshow(imread(picture))
        panel.set_title(caption, fontsize=11, loc="left")
        panel.axis("off")
    figure.suptitle(title, fontsize=15)
    figure.savefig(path, dpi=100)
    return path


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
