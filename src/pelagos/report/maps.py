"""Maps: the track on the ground, and the ground as the multibeam saw it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LightSource, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pelagos.report import theme
from pelagos.report.mission import Mission
from pelagos.report.navigation import DeadReckoning, fixes
from pelagos.report.soundings import Accuracy, Grid, Soundings

_PIXELS: Final = 520  # of a map's longer side
_STRUCTURE_M: Final = 0.4  # what stands this far above the ground is drawn as a structure


@dataclass(frozen=True)
class Relief:
    """The ground in a rectangle.

    Attributes:
        east, north: `(w,)`, `(h,)` [m].
        height: `(h, w)` [m]; NaN where there is no ground.
        structure: `(h, w)` bool: something stands on or above the ground there.
    """

    east: NDArray[np.float64]
    north: NDArray[np.float64]
    height: NDArray[np.float64]
    structure: NDArray[np.bool_]

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """For `imshow`."""
        return float(self.east[0]), float(self.east[-1]), float(self.north[0]), float(self.north[-1])


def relief(world: Any, low: NDArray[np.float64], high: NDArray[np.float64]) -> Relief:
    """The ground between two corners (x, y) NWU [m], and what stands on it, looked at from above."""
    step = float((high - low).max()) / _PIXELS
    north = np.arange(low[0], high[0] + step / 2, step)
    east = np.arange(-high[1], -low[1] + step / 2, step)
    x, y = np.meshgrid(north, -east, indexing="ij")
    height = np.asarray(world.height(x, y))
    smooth = np.asarray(world.terrain.height(x, y)) if getattr(world, "terrain", None) is not None else height
    structure = np.zeros(height.shape, dtype=bool)
    if np.isfinite(height).any():
        above = float(np.asarray(world.bounds)[1, 2]) + 10.0
        origins = np.stack([x.ravel(), y.ravel(), np.full(x.size, above)], axis=-1)
        hits = world.cast(origins, np.array([0.0, 0.0, -1.0]), max_range=above - float(np.nanmin(height)) + 10.0)
        top = np.where(np.isfinite(hits.t), hits.position[:, 2], np.nan).reshape(height.shape)
        structure = np.nan_to_num(top - height) > _STRUCTURE_M
    return Relief(east, north, smooth, structure)


def draw_ground(axes: Axes, ground: Relief, norm: Normalize, *, contours: bool = True) -> Any:
    """Shaded, coloured depths, contours, and structures in dark grey."""
    dx = abs(float(ground.east[1] - ground.east[0]))
    shade = LightSource(azdeg=315, altdeg=45)
    filled = np.where(np.isfinite(ground.height), ground.height, np.nanmean(ground.height))
    span = max(float(np.nanmax(filled) - np.nanmin(filled)), 1e-3)
    exaggeration = 0.12 * (ground.east[-1] - ground.east[0]) / span
    colours = theme.DEPTHS(norm(filled))[..., :3]
    picture = shade.shade_rgb(colours, filled, blend_mode="soft", vert_exag=max(exaggeration, 1.0), dx=dx, dy=dx)
    picture = np.clip(0.15 + 0.85 * picture, 0, 1)
    picture[~np.isfinite(ground.height)] = 1.0
    picture[ground.structure] = (0.30, 0.33, 0.36)
    axes.imshow(picture, origin="lower", extent=ground.extent, interpolation="bilinear")
    if contours and span > 0.5:
        levels = _levels(float(np.nanmin(ground.height)), float(np.nanmax(ground.height)))
        drawn = axes.contour(
            ground.east, ground.north, ground.height, levels=levels, colors="#0c2238", linewidths=0.45, alpha=0.45,
            linestyles="solid",
        )  # fmt: skip
        axes.clabel(drawn, fmt=lambda z: f"{-z:g}", fontsize=6.5, inline_spacing=2)
    axes.grid(visible=False)
    axes.set_xlabel("east [m]")
    axes.set_ylabel("north [m]")
    axes.set_aspect("equal")


def depth_bar(drawn: Figure, axes: Any, norm: Normalize, label: str = "depth [m]") -> None:
    """A colour bar that counts downwards."""
    from matplotlib.cm import ScalarMappable

    owner = axes[0].figure if isinstance(axes, list) else drawn
    bar = owner.colorbar(ScalarMappable(norm, theme.DEPTHS), ax=axes, shrink=0.85, aspect=28, pad=0.015)
    bar.set_label(label)
    bar.formatter = lambda z, _: f"{-z:g}"
    bar.outline.set_visible(False)
    bar.update_ticks()


def track_map(mission: Mission, world: Any, reckoned: DeadReckoning | None) -> tuple[Figure, str]:
    """True and dead-reckoned track on the ground, with profile and error beside; the figure and its caption."""
    motion = mission.motion
    points = [motion.position[:, :2]] + ([reckoned.motion.position[:, :2]] if reckoned is not None else [])
    low, high = _around(np.concatenate(points), np.asarray(world.bounds)[:, :2], margin=0.12)
    ground = relief(world, low, high)
    with theme.style():
        drawn, axes, profile, error = _sheet(float((high - low)[1] / (high - low)[0]))
        norm = _norm(ground.height)
        if np.isfinite(ground.height).any():
            draw_ground(axes, ground, norm)
            depth_bar(drawn, axes, norm)
        _draw_tracks(axes, mission, reckoned)
        axes.set_xlim(ground.extent[:2])
        axes.set_ylim(ground.extent[2:])
        drawn.legend(*axes.get_legend_handles_labels(), loc="outside lower left", ncols=5, handlelength=2.2)
        _profile(profile, mission, world)
        _reckoning_error(error, reckoned)
    caption = "Depth below the mean sea surface; what stands on the seabed is dark grey."
    if reckoned is not None and reckoned.distance[-1] > 1.0:
        drift, way = float(reckoned.drift[-1]), float(reckoned.distance[-1])
        caption += (
            f" Dead reckoning (DVL, gyroscopes, magnetometer, depth) starts from {_source(reckoned)} and drifts by "
            f"{drift:.1f} m on a way of {way:.0f} m ({100 * drift / way:.2g} %)."
        )
    return drawn, caption


def _sheet(wide: float) -> tuple[Figure, Axes, Axes, Axes]:
    """A figure for a map `wide` times as wide as high, with two panels beside it, or below a landscape one."""
    if wide > 1.2:
        height = 10.3 / wide
        drawn = theme.figure(11.4, height + 2.9)
        cells = drawn.add_gridspec(2, 2, height_ratios=[height, 2.2])
        return (
            drawn, drawn.add_subplot(cells[0, :]), drawn.add_subplot(cells[1, 0]), drawn.add_subplot(cells[1, 1])
        )  # fmt: skip
    width = min(7.2 * wide + 1.4, 7.4)
    drawn = theme.figure(11.4, (width - 1.4) / wide + 0.7)
    cells = drawn.add_gridspec(2, 2, width_ratios=[width, 11.4 - width])
    return drawn, drawn.add_subplot(cells[:, 0]), drawn.add_subplot(cells[0, 1]), drawn.add_subplot(cells[1, 1])


def _profile(axes: Axes, mission: Mission, world: Any) -> None:
    """The way in the vertical: surface, vehicle, seabed."""
    motion = mission.motion
    scale, label = theme.time_axis(float(motion.t[-1]))
    t, depth = motion.t / scale, -motion.position[:, 2]
    bed = -np.asarray(world.height(motion.position[:, 0], motion.position[:, 1]))
    axes.set_title("profile")
    bottom = float(np.nanmax(np.append(bed[np.isfinite(bed)], depth.max()))) * 1.08 + 0.5
    axes.axhspan(0, bottom, color="#e3eff5", zorder=0)
    axes.fill_between(t, bed, bottom, color="#c9b79c", linewidth=0, label="seabed")
    axes.plot(t, bed, color="#8f7a5a", linewidth=0.8)
    axes.plot(t, depth, color=theme.TRUTH, linewidth=1.5, label="vehicle")
    axes.axhline(0, color="#1f78a8", linewidth=1.0)
    axes.set_ylim(bottom, -0.06 * bottom)
    axes.set_xlim(0, t[-1])
    axes.set_xlabel(label)
    axes.set_ylabel("depth [m]")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.99), ncols=2, borderaxespad=0.1)


def _reckoning_error(axes: Axes, reckoned: DeadReckoning | None) -> None:
    """Horizontal error of dead reckoning over time."""
    axes.set_title("error of dead reckoning")
    if reckoned is None:
        axes.set_axis_off()
        axes.text(0.0, 0.9, "needs an IMU and a DVL", transform=axes.transAxes, color=theme.MUTED)
        return
    scale, label = theme.time_axis(float(reckoned.motion.t[-1]))
    t = reckoned.motion.t / scale
    way = np.interp(reckoned.motion.t, np.linspace(0, reckoned.motion.t[-1], len(reckoned.distance)), reckoned.distance)
    axes.fill_between(t, 0.01 * way, color=theme.GRID, linewidth=0, label="1 % of the way")
    axes.plot(t, reckoned.error, color="#f2542d", linewidth=1.5, label="horizontal error")
    axes.plot(t, reckoned.drift, color=theme.SECOND, linewidth=1.2, label="less that of the start")
    axes.set_ylim(0, 1.35 * max(float(reckoned.error.max()), 0.01 * float(way[-1]), 0.1))
    axes.set_xlim(0, t[-1])
    axes.set_xlabel(label)
    axes.set_ylabel("[m]")
    axes.legend(loc="upper left", ncols=3, columnspacing=1.2)


def _source(reckoned: DeadReckoning) -> str:
    return f"the first GPS fix, {reckoned.error[0]:.1f} m off," if reckoned.start == "gps" else "the true position"


def _draw_tracks(axes: Axes, mission: Mission, reckoned: DeadReckoning | None) -> None:
    east, north = -mission.motion.position[:, 1], mission.motion.position[:, 0]
    axes.plot(east, north, color="white", linewidth=3.2, solid_capstyle="round")
    axes.plot(east, north, color=theme.TRUTH, linewidth=1.7, label="true track", solid_capstyle="round")
    if reckoned is not None:
        p = reckoned.motion.position
        axes.plot(-p[:, 1], p[:, 0], color="#f2542d", linewidth=1.3, linestyle=(0, (4, 2)), label="dead reckoning")
    _, fixed = fixes(mission)
    if len(fixed):
        axes.plot(
            -fixed[:, 1], fixed[:, 0], ".", color="#ffd23f", markersize=5, markeredgecolor=theme.INK,
            markeredgewidth=0.4, label="GPS fixes",
        )  # fmt: skip
    for k, marker, name in ((0, "o", "start"), (-1, "s", "end")):
        axes.plot(
            east[k], north[k], marker, color="white", markeredgecolor=theme.INK, markeredgewidth=1.4, markersize=7,
            label=name, zorder=5, linestyle="none",
        )  # fmt: skip


def survey_maps(
    sounded: Soundings, cells: Grid, found: Accuracy | None, world: Any, mission: Mission
) -> tuple[Figure, str]:
    """The soundings' map, the true ground, their difference, and the histogram of errors."""
    x, y = np.meshgrid(cells.x, cells.y, indexing="ij")
    true = np.asarray(world.height(x, y))
    covered = np.where(cells.count > 0, true, np.nan)
    norm = _norm(cells.mean if not np.isfinite(covered).any() else covered)
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


def _norm(height: NDArray[np.float64]) -> Normalize:
    finite = height[np.isfinite(height)]
    if len(finite) == 0:
        return Normalize(-1.0, 0.0)
    low, high = (float(v) for v in np.percentile(finite, [0.5, 99.5]))
    return Normalize(low, min(max(high, low + 0.5), max(0.0, low + 0.5)))


def _around(
    points: NDArray[np.float64], bounds: NDArray[np.float64], *, margin: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners of a rectangle about points, not narrower than half of its length, cut at the world's edge."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, np.maximum((high - low) / 2, 5.0)
    half = np.maximum(half, 0.5 * half.max()) + margin * half.max()
    room = 0.02 * half.max()
    inside = np.minimum(bounds[0] - room, low - room), np.maximum(bounds[1] + room, high + room)
    return np.maximum(middle - half, inside[0]), np.minimum(middle + half, inside[1])


def _levels(low: float, high: float) -> NDArray[np.float64]:
    span = high - low
    step = next(s for s in (0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000) if span / s <= 12 or s == 1000)
    return np.arange(np.ceil(low / step) * step, high, step)
