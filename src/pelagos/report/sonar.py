"""Imaging-sonar frames in their fan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pelagos.messages.fan import copper
from pelagos.report import theme
from pelagos.report.mission import Mission
from pelagos.sensors.sonar.ping.fan_picture import fan_image

FRAMES: Final = 6
_LOOKED_AT: Final = 90  # frames that are rated, to choose those that are shown
_PALE: Final = "#c9d3dc"


@dataclass(frozen=True)
class SonarFrame:
    """One ping.

    Attributes:
        t: [s].
        polar: `(beams, bins)` levels 0 .. 255.
        azimuth: `(beams,)` [rad], positive to port.
        ranges: `(bins,)` [m].
    """

    t: float
    polar: NDArray[np.uint8]
    azimuth: NDArray[np.float64]
    ranges: NDArray[np.float64]


def chosen_frames(mission: Mission, topic: str, *, count: int = FRAMES) -> list[SonarFrame]:
    """The frames with the most to see, one from each of `count` equal parts of the mission."""
    total = mission.recording.count(topic)
    step = max(1, total // _LOOKED_AT)
    rated = []
    for index in range(step // 2, total, step):
        message = mission.recording.message(topic, index).message
        beams = message.image.beam_count
        picture = np.asarray(message.image.data).reshape(-1, beams)
        rated.append((index, _interest(picture)))
    best = []
    for part in np.array_split(np.arange(len(rated)), min(count, len(rated))):
        best.append(max((rated[i] for i in part), key=lambda r: r[1])[0])
    return [_frame(mission, topic, index) for index in best]


def _interest(picture: NDArray[np.uint8]) -> float:
    """Conspicuousness: contrast between coarse cells, which speckle does not have."""
    height, width = (s // 8 * 8 for s in picture.shape)
    cells = picture[:height, :width].reshape(height // 8, 8, width // 8, 8).mean(axis=(1, 3))
    smooth = cells.mean(axis=1, keepdims=True)  # a bottom without objects changes with range only
    return float(np.std(cells - smooth))


def _frame(mission: Mission, topic: str, index: int) -> SonarFrame:
    recorded = mission.recording.message(topic, index)
    message = recorded.message
    azimuth = np.array([np.arctan2(-d.y, d.z) for d in message.beam_directions])
    polar = np.asarray(message.image.data).reshape(-1, message.image.beam_count).T
    return SonarFrame(recorded.t_ns * 1e-9, polar, azimuth, np.asarray(message.ranges, dtype=np.float64))


def frames_figure(mission: Mission, sensor: str, frames: Sequence[SonarFrame]) -> Figure:
    """The frames side by side, range rings and azimuths labelled."""
    columns = min(3, len(frames))
    lines = -(-len(frames) // columns)
    with theme.style(
        **{"text.color": _PALE, "axes.labelcolor": _PALE, "xtick.labelcolor": _PALE, "ytick.labelcolor": _PALE}
    ):
        drawn = theme.figure(11.4, 2.4 * lines + 0.1)
        drawn.patch.set_facecolor(theme.NIGHT)
        panels = np.atleast_1d(drawn.subplots(lines, columns, squeeze=False)).ravel()
        shown: Any = None
        for axes in panels[len(frames) :]:
            axes.set_axis_off()
        for axes, frame in zip(panels, frames, strict=False):
            shown = _draw(axes, frame, mission)
        _bar(drawn, shown, panels, mission.config(sensor))
    return drawn


def _draw(axes: Axes, frame: SonarFrame, mission: Mission) -> Any:
    far = float(frame.ranges[-1] + 0.5 * (frame.ranges[1] - frame.ranges[0]))
    picture = fan_image(frame.polar.astype(np.float32), frame.azimuth, frame.ranges, height=420)
    half = picture.shape[1] / 2 * far / picture.shape[0]
    colours = ListedColormap(copper() / 255.0).with_extremes(bad=theme.NIGHT)
    shown = axes.imshow(picture, extent=(-half, half, 0, far), cmap=colours, vmin=0, vmax=255, interpolation="bilinear")
    edge = float(np.abs(frame.azimuth).max() + 0.5 * abs(frame.azimuth[1] - frame.azimuth[0]))
    angle = np.linspace(-edge, edge, 121)
    ring = _ring_step(far)
    for r in np.arange(ring, far + 1e-6, ring):
        axes.plot(r * np.sin(angle), r * np.cos(angle), color="white", linewidth=0.45, alpha=0.35)
        axes.text(
            r * np.sin(edge) + 0.02 * far, r * np.cos(edge) - 0.035 * far, f"{r:g} m", fontsize=6.5, color=_PALE,
            ha="left", va="center",
        )  # fmt: skip
    for degrees in _spokes(edge):
        a = np.radians(degrees)
        axes.plot([0, far * np.sin(a)], [0, far * np.cos(a)], color="white", linewidth=0.45, alpha=0.3)
        axes.text(
            1.035 * far * np.sin(a), 1.035 * far * np.cos(a), f"{degrees:+.0f}°" if degrees else "0°", fontsize=6.5,
            color=_PALE, ha="center", va="bottom" if abs(degrees) < 45 else "center",
        )  # fmt: skip
    pose = mission.motion.at(np.array([frame.t]))
    heading = np.degrees(-pose.euler[0, 2]) % 360
    axes.set_title(
        f"t = {frame.t:.1f} s   depth {-pose.position[0, 2]:.1f} m   heading {heading:03.0f}°", fontsize=8.5,
        fontweight="normal", color=_PALE, loc="center", pad=10,
    )  # fmt: skip
    axes.set_xlim(-half * 1.12, half * 1.12)
    axes.set_ylim(-0.02 * far, 1.1 * far)
    axes.set_aspect("equal")
    axes.set_axis_off()
    return shown


def _bar(drawn: Figure, shown: Any, panels: Any, config: dict[str, Any]) -> None:
    bar = drawn.colorbar(shown, ax=list(panels), shrink=0.6, aspect=30, pad=0.012)
    bar.outline.set_visible(False)
    floor, span = float(config.get("floor_db", 0.0)), float(config.get("dynamic_range_db", 0.0))
    if span > 0:
        levels = np.arange(np.ceil(floor / 10) * 10, floor + span + 1e-6, 10)
        bar.set_ticks(list((levels - floor) / span * 255), labels=[f"{level:g}" for level in levels])
        bar.set_label("echo level after gain [dB]")
    else:
        bar.set_label("echo level (8 bit)")


def _ring_step(far: float) -> float:
    return next((s for s in (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0) if far / s <= 6), 200.0)


def _spokes(edge: float) -> list[float]:
    """Azimuths to label [deg], starboard positive."""
    widest = np.degrees(edge)
    step = 30.0 if widest > 40 else 10.0 if widest > 12 else 5.0
    inner = np.arange(0, widest - 0.3 * step, step)
    return sorted({*(-inner), *inner, -widest, widest})
