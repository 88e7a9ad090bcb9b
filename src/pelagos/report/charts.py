"""Charts of the navigation sensors against the truth, over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pelagos.math.so3 import rotate_np
from pelagos.messages.navigation import DEPTH_FIELDS, POSE_COVARIANCE
from pelagos.messages.ranging import DVL, DVL_FIELDS, RANGE, RANGE_FIELDS, TWIST_COVARIANCE, TWIST_FIELDS
from pelagos.report import theme
from pelagos.report.mission import Mission
from pelagos.report.navigation import DeadReckoning

_MOST_POINTS: Final = 3000  # drawn of one series


@dataclass(frozen=True)
class Series:
    """Something measured, with what it should have been.

    Attributes:
        name: for the legend.
        colour: of its points.
        t: `(k,)` [s].
        value, truth: `(k,)`; truth may be NaN where it is not known.
    """

    name: str
    colour: str
    t: NDArray[np.float64]
    value: NDArray[np.float64]
    truth: NDArray[np.float64]


@dataclass(frozen=True)
class Row:
    """One quantity over time.

    Attributes:
        title: what it is.
        unit: of the axis.
        t, truth: `(k,)`, the line of the truth.
        series: what sensors say about it.
        downwards: the axis points down.
        error_unit, error_scale: of the histogram.
        wraps: an angle that goes round [deg].
    """

    title: str
    unit: str
    t: NDArray[np.float64]
    truth: NDArray[np.float64]
    series: list[Series]
    downwards: bool = False
    error_unit: str = ""
    error_scale: float = 1.0
    wraps: bool = False


def rows(mission: Mission, world: Any, reckoned: DeadReckoning | None) -> list[Row]:
    """Depth, altitude, speed, heading, pitch and roll, as far as there are sensors for them."""
    motion = mission.motion
    found = [_depth(mission), _altitude(mission, world), _speed(mission)]
    angles = np.degrees(motion.euler)
    heading = np.mod(-angles[:, 2], 360.0)
    for title, values, column, sign in (
        ("heading", heading, 2, -1.0),
        ("pitch, nose up", -angles[:, 1], 1, -1.0),
        ("roll, to starboard", angles[:, 0], 0, 1.0),
    ):  # fmt: skip
        series = []
        if reckoned is not None:
            own = sign * np.degrees(reckoned.motion.euler[:, column])
            true = sign * np.degrees(motion.at(reckoned.motion.t).euler[:, column])
            if column == 2:
                own, true = np.mod(own, 360.0), np.mod(true, 360.0)
            series.append(
                Series("gyroscopes, accelerometers, magnetometer", theme.SENSOR, reckoned.motion.t, own, true)
            )
        found.append(Row(title, "deg", motion.t, values, series, error_unit="deg", wraps=column == 2))
    return [row for row in found if row is not None]


def _depth(mission: Mission) -> Row:
    motion = mission.motion
    series = []
    table = mission.table("depth", POSE_COVARIANCE, DEPTH_FIELDS)
    if table is not None:
        t, values = table
        pose = motion.at(t)
        lever = rotate_np(pose.attitude, np.broadcast_to(mission.mount("depth")[0], (len(t), 3)))
        series.append(Series("depth sensor", theme.SENSOR, t, -values[:, 0], -(pose.position + lever)[:, 2]))
    return Row(
        "depth", "m", motion.t, -motion.position[:, 2], series, downwards=True, error_unit="cm", error_scale=100.0
    )


def _altitude(mission: Mission, world: Any) -> Row | None:
    motion = mission.motion
    ground = np.asarray(world.height(motion.position[:, 0], motion.position[:, 1]))
    if not np.isfinite(ground).any():
        return None
    truth = motion.position[:, 2] - ground
    series = []
    table = mission.table("altimeter", RANGE, RANGE_FIELDS)
    if table is not None:
        t, values = table
        series.append(_above_ground("altimeter", theme.SENSOR, mission, world, "altimeter", t, values[:, 0]))
    table = mission.table("dvl", DVL, DVL_FIELDS)
    if table is not None:
        t, values = table
        series.append(_above_ground("DVL", theme.SECOND, mission, world, "dvl", t, values[:, 6]))
    return Row("altitude above the seabed", "m", motion.t, truth, series, error_unit="m")


def _above_ground(
    name: str, colour: str, mission: Mission, world: Any, sensor: str, t: NDArray[np.float64],
    value: NDArray[np.float64],
) -> Series:  # fmt: skip
    pose = mission.motion.at(t)
    place = pose.position + rotate_np(pose.attitude, np.broadcast_to(mission.mount(sensor)[0], (len(t), 3)))
    ground = np.asarray(world.height(place[:, 0], place[:, 1]))
    return Series(name, colour, t, value, place[:, 2] - ground)


def _speed(mission: Mission) -> Row:
    motion = mission.motion
    series = []
    table = mission.table("dvl", TWIST_COVARIANCE, TWIST_FIELDS)
    if table is not None:
        t, values = table
        body = rotate_np(mission.mount("dvl")[1], values[:, :3])
        series.append(Series("DVL, forward", theme.SENSOR, t, body[:, 0], motion.at(t).velocity[:, 0]))
    return Row(
        "forward speed over ground",
        "m/s",
        motion.t,
        motion.velocity[:, 0],
        series,
        error_unit="cm/s",
        error_scale=100.0,
    )


def against_truth(shown: list[Row], *, duration_s: float) -> Figure:
    """One line of panels a quantity: over time, and the errors as a histogram."""
    scale, label = theme.time_axis(duration_s)
    with theme.style():
        drawn = theme.figure(11.4, 1.62 * len(shown) + 0.4)
        panels = drawn.subplots(len(shown), 2, width_ratios=[4.3, 1.0], squeeze=False)
        for row, (left, right) in zip(shown, panels, strict=True):
            _over_time(left, row, scale)
            _errors(right, row)
            left.set_xlim(0, duration_s / scale)
            left.label_outer()
        panels[-1, 0].set_xlabel(label)
    return drawn


def _over_time(axes: Axes, row: Row, scale: float) -> None:
    axes.set_title(row.title)
    axes.set_ylabel(row.unit)
    for series in row.series:
        step = max(1, len(series.t) // _MOST_POINTS)
        axes.plot(
            series.t[::step] / scale, series.value[::step], ".", markersize=2.6, markeredgewidth=0, color=series.colour,
            label=series.name,
        )  # fmt: skip
    truth = row.truth.copy()
    if row.wraps:
        truth[1:][np.abs(np.diff(row.truth)) > 180] = np.nan
        axes.set_ylim(0, 360)
        axes.set_yticks([0, 90, 180, 270, 360])
    axes.plot(row.t / scale, truth, color=theme.TRUTH, linewidth=1.0, label="truth")
    if row.downwards:
        axes.invert_yaxis()
    handles, names = axes.get_legend_handles_labels()
    order = [len(names) - 1, *range(len(names) - 1)]
    axes.legend(
        [handles[i] for i in order], [names[i] for i in order], loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=4,
        markerscale=4, handlelength=1.4, columnspacing=1.4, borderaxespad=0.1,
    )  # fmt: skip


def _errors(axes: Axes, row: Row) -> None:
    lines = []
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.grid(visible=False)
    ranges = []
    for series in row.series:
        error = row.error_scale * (series.value - series.truth)
        if row.wraps:
            error = (error + 180.0) % 360.0 - 180.0
        error = error[np.isfinite(error)]
        if len(error) < 5:
            continue
        spread = float(np.percentile(np.abs(error - np.median(error)), 98)) or 1e-6
        ranges.append((float(np.median(error)) - 1.4 * spread, float(np.median(error)) + 1.4 * spread))
        lines.append((error, series.colour))
    if not lines:
        axes.set_axis_off()
        return
    low, high = min(r[0] for r in ranges), max(r[1] for r in ranges)
    for error, colour in lines:
        axes.hist(error, bins=np.linspace(low, high, 46), color=colour, alpha=0.75, density=True)
    for k, (error, colour) in enumerate(reversed(lines)):
        axes.text(
            0.5, 1.03 + 0.17 * k, f"{error.mean():+.2g} ± {error.std():.2g} {row.error_unit}", color=colour, fontsize=8,
            fontweight="bold", transform=axes.transAxes, va="bottom", ha="center",
        )  # fmt: skip
    axes.axvline(0.0, color=theme.INK, linewidth=0.8)
    axes.set_xlabel(f"error [{row.error_unit}]", labelpad=1)
