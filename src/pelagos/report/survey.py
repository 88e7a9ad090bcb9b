"""The ground as the multibeam saw it, beside what it is."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LightSource, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pelagos.report import theme
from pelagos.report.ground import depth_bar, depth_norm
from pelagos.report.mission import Mission
from pelagos.report.soundings import Accuracy, Grid, Soundings


def survey_maps(
    sounded: Soundings, cells: Grid, found: Accuracy | None, world: Any, mission: Mission
) -> tuple[Figure, str]:
    """The soundings' map, the true ground, their difference, and the histogram of errors."""
    x, y = np.meshgrid(cells.x, cells.y, indexing="ij")
    true = np.asarray(world.height(x, y))
    covered = np.where(cells.count > 0, true, np.nan)
    norm = depth_norm(cells.mean if not np.isfinite(covered).any() else covered)
    with theme.style():
        drawn, axes = _four(len(cells.y) / len(cells.x))
        _draw_cells(axes[0], cells, cells.mean, norm)
        axes[0].set_title(f"{len(sounded.points):,} soundings, {cells.cell:g} m cells")
        _draw_cells(axes[1], cells, true, norm)
        axes[1].set_title("true terrain")
        axes[1].set_ylabel("")
        depth_bar(drawn, axes[:2], norm)
        for a in axes[:2]:
            a.plot(
                -mission.motion.position[:, 1], mission.motion.position[:, 0], color="white", linewidth=0.6, alpha=0.8
            )
            a.set_xlim(_extent(cells)[:2])
            a.set_ylim(_extent(cells)[2:])
        _difference(axes[2], cells, true, found)
        _histogram(axes[3], found)
    caption = (
        f"{sounded.pings:,} pings of {sounded.beams} beams, {100 * sounded.share:.1f} % of them with a bottom. "
        "Soundings are placed with the true pose of the vehicle, so the errors are the sonar's own."
    )
    if found is not None:
        caption += (
            f" {100 * found.elsewhere:.1f} % of the soundings lie more than {found.limit:g} m from the ground: they "
            "are on structures (or wrong), and part neither of the difference nor of the histogram."
        )
    return drawn, caption


def _four(wide: float) -> tuple[Figure, list[Axes]]:
    """Three maps `wide` times as wide as high, and a chart: two by two, or the chart below three high maps."""
    if wide > 0.7:
        height = 4.6 / wide
        drawn = theme.figure(11.4, min(2 * height + 1.2, 11.5))
        return drawn, list(drawn.subplots(2, 2).ravel())
    height = min(2.6 / wide, 6.2)
    drawn = theme.figure(11.4, height + 3.2)
    top, bottom = drawn.subfigures(2, 1, height_ratios=[height + 0.5, 2.6])
    return drawn, [*top.subplots(1, 3, width_ratios=[1, 1, 1]), bottom.subplots()]


def _draw_cells(axes: Axes, cells: Grid, height: NDArray[np.float64], norm: Normalize) -> None:
    """A gridded surface with shading, empty cells pale."""
    picture = height[:, ::-1]  # columns run west; maps run east
    finite = np.isfinite(picture)
    filled = np.where(finite, picture, np.nanmedian(picture) if finite.any() else 0.0)
    shade = LightSource(azdeg=315, altdeg=45)
    colours = theme.DEPTHS(norm(filled))[..., :3]
    span = max(float(norm.vmax or 0) - float(norm.vmin or 0), 0.1)
    factor = min(max(0.05 * cells.cell * len(cells.x) / span, 1.0), 8.0)
    out = colours
    if min(filled.shape) > 1:  # a single row has no slope to shade
        out = shade.shade_rgb(colours, filled, blend_mode="soft", vert_exag=factor, dx=cells.cell, dy=cells.cell)
    out = np.clip(0.12 + 0.88 * out, 0, 1)
    out[~finite] = (0.933, 0.945, 0.957)
    axes.imshow(out, origin="lower", extent=_extent(cells), interpolation="nearest")
    _dress(axes)


def _difference(axes: Axes, cells: Grid, true: NDArray[np.float64], found: Accuracy | None) -> None:
    difference = (cells.mean if found is None else found.cells) - true
    limit = max(3.0 * found.std, 0.02) if found is not None else 0.5
    axes.set_facecolor(theme.EMPTY)
    shown = axes.imshow(
        difference[:, ::-1], origin="lower", extent=_extent(cells), cmap=theme.DIFFERENCE, vmin=-limit, vmax=limit,
        interpolation="nearest",
    )  # fmt: skip
    bar = axes.figure.colorbar(shown, ax=axes, shrink=0.85, aspect=28, pad=0.015, extend="both")
    bar.set_label("map less terrain [m]")
    bar.outline.set_visible(False)
    axes.set_title("difference")
    _dress(axes)


def _histogram(axes: Axes, found: Accuracy | None) -> None:
    axes.set_title("error of single soundings")
    if found is None:
        axes.set_axis_off()
        axes.text(0.5, 0.5, "no terrain to compare with", ha="center", transform=axes.transAxes, color=theme.MUTED)
        return
    width = 4.5 * found.std
    axes.hist(100 * found.error, bins=np.linspace(-100 * width, 100 * width, 91), color=theme.SECOND, alpha=0.85)
    axes.axvline(100 * found.bias, color=theme.ALARM, linewidth=1.4)
    axes.set_xlabel("sounding less terrain [cm]")
    axes.set_ylabel("soundings")
    axes.yaxis.set_major_formatter(lambda v, _: f"{v / 1000:g} k" if v >= 1000 else f"{v:g}")
    inside = np.percentile(np.abs(found.error), 95)
    axes.text(
        0.98, 0.95, f"bias {100 * found.bias:+.1f} cm\nstd {100 * found.std:.1f} cm\n95 % within {100 * inside:.1f} cm",
        transform=axes.transAxes, ha="right", va="top", linespacing=1.5,
    )  # fmt: skip


def _dress(axes: Axes) -> None:
    axes.grid(visible=False)
    axes.set_aspect("equal")
    axes.set_xlabel("east [m]")
    axes.set_ylabel("north [m]")


def _extent(cells: Grid) -> tuple[float, float, float, float]:
    half = cells.cell / 2
    return (
        float(-cells.y[-1] - half), float(-cells.y[0] + half), float(cells.x[0] - half), float(cells.x[-1] + half)
    )  # fmt: skip
