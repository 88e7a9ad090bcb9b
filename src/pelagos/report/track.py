"""The track on the ground, the way in the vertical, and how dead reckoning fared."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pelagos.report import theme
from pelagos.report.ground import depth_bar, depth_norm, draw_ground, relief
from pelagos.report.mission import Mission
from pelagos.report.movers import draw_movers, mover_tracks, near_parts
from pelagos.report.navigation import DeadReckoning, Known, fixes

SOLVED: Final = "#7b2cbf"
NAVIGATION: Final = {"ekf": "navigation (EKF)", "external": "navigation from outside"}


def track_map(
    mission: Mission, world: Any, reckoned: DeadReckoning | None, solved: Known | None = None
) -> tuple[Figure, str]:
    """True and dead-reckoned track on the ground, with profile and error beside; the figure and its caption.

    solved: what the mission itself went by, where that was not the truth.
    """
    motion = mission.motion
    points = [motion.position[:, :2]] + ([reckoned.motion.position[:, :2]] if reckoned is not None else [])
    points += [] if solved is None else [solved.motion.position[:, :2]]
    movers = mover_tracks(mission.recording)
    points += near_parts(movers, motion.position[:, :2])
    low, high = around(np.concatenate(points), np.asarray(world.bounds)[:, :2], margin=0.12)
    ground = relief(world, low, high)
    with theme.style():
        drawn, axes, profile, error = _sheet(float((high - low)[1] / (high - low)[0]))
        norm = depth_norm(ground.height)
        if np.isfinite(ground.height).any():
            draw_ground(axes, ground, norm)
            depth_bar(drawn, axes, norm)
        draw_movers(axes, movers, low, high)
        _draw_tracks(axes, mission, reckoned, solved)
        axes.set_xlim(ground.extent[:2])
        axes.set_ylim(ground.extent[2:])
        drawn.legend(*axes.get_legend_handles_labels(), loc="outside lower left", ncols=5, handlelength=2.2)
        _profile(profile, mission, world)
        _errors(error, reckoned, solved)
    caption = "Depth below the mean sea surface; what stands on the seabed is dark grey."
    if reckoned is not None and reckoned.distance[-1] > 1.0:
        drift, way = float(reckoned.drift[-1]), float(reckoned.distance[-1])
        caption += (
            f" Dead reckoning (DVL, gyroscopes, magnetometer, depth) starts from {_source(reckoned)} and drifts by "
            f"{drift:.1f} m on a way of {way:.0f} m ({100 * drift / way:.2g} %)."
        )
    if solved is not None:
        caption += (
            f" The mission went by its own navigation ({NAVIGATION[solved.kind]}), whose horizontal error was "
            f"{np.sqrt((solved.error**2).mean()):.2f} m (root mean square) and {solved.error[-1]:.2f} m at the end."
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


def _errors(axes: Axes, reckoned: DeadReckoning | None, solved: Known | None) -> None:
    """Horizontal error of navigation and of dead reckoning over time."""
    if solved is not None:
        axes.set_title("error of navigation")
        scale, label = theme.time_axis(float(solved.motion.t[-1]))
        axes.plot(solved.motion.t / scale, solved.error, color=SOLVED, linewidth=1.5, label=NAVIGATION[solved.kind])
        most = float(solved.error.max())
        if reckoned is not None:
            axes.plot(reckoned.motion.t / scale, reckoned.error, color="#f2542d", linewidth=1.2, label="dead reckoning")
            most = max(most, float(reckoned.error.max()))
        axes.set_ylim(0, 1.35 * max(most, 0.1))
        axes.set_xlim(0, solved.motion.t[-1] / scale)
        axes.set_xlabel(label)
        axes.set_ylabel("[m]")
        axes.legend(loc="upper left", ncols=2)
        return
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


def _draw_tracks(axes: Axes, mission: Mission, reckoned: DeadReckoning | None, solved: Known | None) -> None:
    east, north = -mission.motion.position[:, 1], mission.motion.position[:, 0]
    axes.plot(east, north, color="white", linewidth=3.2, solid_capstyle="round")
    axes.plot(east, north, color=theme.TRUTH, linewidth=1.7, label="true track", solid_capstyle="round")
    if reckoned is not None:
        p = reckoned.motion.position
        axes.plot(-p[:, 1], p[:, 0], color="#f2542d", linewidth=1.3, linestyle=(0, (4, 2)), label="dead reckoning")
    if solved is not None:
        p = solved.motion.position
        axes.plot(-p[:, 1], p[:, 0], color=SOLVED, linewidth=1.3, linestyle=(0, (2, 1)), label=NAVIGATION[solved.kind])
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


def around(
    points: NDArray[np.float64], bounds: NDArray[np.float64], *, margin: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners of a rectangle about points, not narrower than half of its length, cut at the world's edge."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, np.maximum((high - low) / 2, 5.0)
    half = np.maximum(half, 0.5 * half.max()) + margin * half.max()
    room = 0.02 * half.max()
    inside = np.minimum(bounds[0] - room, low - room), np.maximum(bounds[1] + room, high + room)
    return np.maximum(middle - half, inside[0]), np.minimum(middle + half, inside[1])
