"""A manoeuvre as a picture."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pelagos.manoeuvres.measures import Measure, half_cycles
from pelagos.manoeuvres.trial import Trial
from pelagos.report import theme

_LEAST: Final = 0.1  # deg, deg/s: axes show at least as much either side
_BOW: Final = np.array([0.35, 0.5])  # shoulder and stem, in lengths before the middle
_BEFORE: Final = 0.25  # of the time after an order, shown before it
_OUTLINES: Final = 9  # along a track that is not a circle
_KILO: Final = 1e4  # pull from which it is drawn in kN [N]
_BEYOND: Final = 1.5  # times the span of the half cycles that count
_EVERY_DEG: Final = 45.0  # of heading, along a circle
_ARROW: Final[dict[str, Any]] = {"arrowstyle": "<->", "color": theme.SECOND, "lw": 1.1, "shrinkA": 0, "shrinkB": 0}


def draw(trial: Trial) -> bytes:
    """PNG: the track or the diagram of the manoeuvre, its time series, and its numbers beside their limits."""
    with theme.style():
        figure = theme.figure(10.5, 6.2)
        _DRAWN[trial.name](figure, trial)
        figure.suptitle(trial.title, fontweight="bold", x=0.01, ha="left")
        return theme.as_png(figure)


def _told(measure: Measure) -> str:
    words = "" if measure.kept is not False else ", not kept"
    limit = "" if measure.limit is None else f" (IMO: at most {measure.limit:.3g}{words})"
    return f"{measure.name} {measure.value:.2f} {measure.unit}{limit}"


def _turning(figure: Figure, trial: Trial) -> None:
    axes = figure.subplot_mosaic([["track", "angle"], ["track", "rate"], ["track", "speed"]], width_ratios=[1.25, 1.0])
    _track(axes["track"], trial)
    _turn_marks(axes["track"], trial)
    _series(axes, trial)


def _along(figure: Figure, trial: Trial) -> None:
    axes = figure.subplot_mosaic([["track", "angle"], ["track", "rate"], ["track", "speed"]], width_ratios=[1.0, 1.25])
    _track(axes["track"], trial)
    _series(axes, trial)
    lines = [_told(m) for m in trial.measures if m.unit in ("L", "s")]
    axes["track"].set_title("\n".join(lines), fontsize=8.5, fontweight="normal")
    order, end = float(trial.switched_s[0]), float(trial.track.time[-1])
    for side in ("angle", "rate", "speed"):
        axes[side].set_xlim(order - _BEFORE * (end - order), end)
        axes[side].axvline(trial.switched_s[0], color=theme.MUTED, lw=0.8, ls=":")
    axes["angle"].annotate(
        "order", (trial.switched_s[0], 1), xycoords=("data", "axes fraction"), fontsize=8, va="bottom", ha="center"
    )


def _zigzag(figure: Figure, trial: Trial) -> None:
    axes = figure.subplot_mosaic(
        [["angle", "angle"], ["rate", "speed"], ["track", "track"]], height_ratios=[2.0, 1.0, 1.0]
    )
    _series(axes, trial)
    _overshoots(axes["angle"], trial)
    for side in ("rate", "speed"):
        axes[side].set_xlabel("time [s]")
    _track(axes["track"], trial, ahead_right=True)


def _spiral(figure: Figure, trial: Trial) -> None:
    axes = figure.subplot_mosaic([["loop", "angle"], ["loop", "rate"], ["loop", "speed"]], width_ratios=[1.25, 1.0])
    helm, rate = trial.steady.T
    half, it = len(helm) // 2, axes["loop"]
    it.axhline(0, color=theme.MUTED, lw=0.8)
    it.axvline(0, color=theme.MUTED, lw=0.8)
    it.plot(helm[:half], rate[:half], "o-", color=theme.TRUTH, label="starboard to port")
    it.plot(helm[half:], rate[half:], "s--", color=theme.SENSOR, mfc="white", label="port to starboard")
    it.set_xlabel("helm [deg], positive to starboard")
    it.set_ylabel("steady yaw rate [deg/s], positive to starboard")
    it.legend(loc="upper left")
    height = next(m for m in trial.measures if m.name.startswith("height"))
    it.text(0.98, 0.03, f"{height.name}: {height.value:.3f} deg/s", transform=it.transAxes, ha="right")
    _series(axes, trial)


def _decay(figure: Figure, trial: Trial) -> None:
    axes = figure.subplot_mosaic([["roll", "damping"]], width_ratios=[1.6, 1.0])
    t, roll = trial.track.time, trial.track.attitude[:, 0]
    cycles = half_cycles(t, roll)
    axes["roll"].plot(t, np.degrees(roll), color=theme.TRUTH)
    axes["roll"].plot(cycles.time, np.degrees(cycles.angle), "o", color=theme.SENSOR, ms=4, label="extremes")
    axes["roll"].axhline(0, color=theme.MUTED, lw=0.8)
    axes["roll"].set_xlim(t[0], min(t[-1], t[0] + _BEYOND * (cycles.time[-1] - t[0])))  # what follows is rest
    axes["roll"].set_xlabel("time [s]")
    axes["roll"].set_ylabel("roll [deg], positive to starboard")
    axes["roll"].legend(loc="upper right")
    number = {m.name: m.value for m in trial.measures}
    line = np.array([0.0, cycles.amplitude.max()])
    small, growth = cycles.growth or (number["damping ratio, mean"], 0.0)
    fitted = small + growth * line
    axes["damping"].plot(np.degrees(cycles.amplitude), cycles.ratio, "o", color=theme.SENSOR, ms=4, label="half cycles")
    axes["damping"].plot(np.degrees(line), fitted, color=theme.TRUTH, label="mean" if cycles.growth is None else "fit")
    axes["damping"].set_xlabel("amplitude [deg]")
    axes["damping"].set_ylabel("damping ratio [-]")
    shown = np.concatenate([cycles.ratio, fitted])
    axes["damping"].axhline(0, color=theme.MUTED, lw=0.8)
    axes["damping"].set_ylim(1.25 * min(shown.min(), 0.0), 1.25 * max(shown.max(), 0.0))
    axes["damping"].legend(loc="lower right")
    axes["roll"].set_title(
        f"period {number['period']:.2f} s, damping ratio {number['damping ratio, mean']:.4f}", fontweight="normal"
    )


def _bollard(figure: Figure, trial: Trial) -> None:
    pulls = [m for m in trial.measures if m.unit == "N"]
    lost = [m for m in trial.measures if m.unit == "%"]
    panels = figure.subplots(1 + bool(lost), 1, squeeze=False, height_ratios=[len(pulls), len(lost)][: 1 + bool(lost)])
    said = {m.name.rpartition(", ")[2]: None for m in pulls if m.value > 0}  # in the order of the thrusters
    unit, newtons = ("kN", 1e3) if max((abs(m.value) for m in pulls), default=0.0) >= _KILO else ("N", 1.0)
    labels = (f"pull [{unit}], positive {', '.join(said)}", "thrust lost [%]")
    for axes, bars, label, one in zip(panels[:, 0], (pulls, lost), labels, (newtons, 1.0), strict=False):
        values = [m.value / one for m in bars]
        colours = [theme.SECOND if m.unit == "%" else theme.TRUTH if m.value > 0 else theme.SENSOR for m in bars]
        drawn = axes.barh([m.name for m in bars], values, color=colours, height=0.6)
        axes.bar_label(drawn, fmt="%.4g", padding=3, fontsize=8)
        axes.margins(x=0.12)
        axes.invert_yaxis()
        axes.axvline(0, color=theme.MUTED, lw=0.8)
        axes.set_xlabel(label)
        axes.grid(axis="y", visible=False)


def _series(axes: dict[str, Axes], trial: Trial) -> None:
    t = trial.track
    if trial.name != "spiral":  # where the ship turns round and round
        axes["angle"].plot(t.time, np.degrees(t.attitude[:, 2]), color=theme.TRUTH, label="heading")
    if trial.name != "stop":
        helm = np.degrees(t.commands[:, trial.rudder])
        axes["angle"].step(t.time, helm, color=theme.SENSOR, where="pre", label="helm ordered")
    if trial.name not in ("stop", "spiral"):
        axes["angle"].legend(loc="best", ncols=2)
    axes["angle"].set_ylabel({"stop": "heading [deg]", "spiral": "helm [deg]"}.get(trial.name, "angle [deg]"))
    axes["rate"].plot(t.time, np.degrees(t.rates[:, 2]), color=theme.SECOND)
    axes["rate"].set_ylabel("yaw rate [deg/s]")
    axes["speed"].plot(t.time, np.hypot(t.velocity[:, 0], t.velocity[:, 1]), color=theme.TRUTH)
    axes["speed"].set_ylabel("speed [m/s]")
    axes["speed"].set_ylim(0, 1.1 * float(np.hypot(t.velocity[:, 0], t.velocity[:, 1]).max()))
    for name in ("angle", "rate"):  # rounding is no motion
        low, high = axes[name].get_ylim()
        axes[name].set_ylim(min(low, -_LEAST), max(high, _LEAST))
    for name in ("angle", "rate", "speed"):
        axes[name].margins(x=0.01)
    axes["speed"].set_xlabel("time [s]")
    if trial.name != "zigzag":
        axes["angle"].tick_params(labelbottom=False)
        axes["rate"].tick_params(labelbottom=False)


def in_lengths(trial: Trial) -> NDArray[np.float64]:
    """Way ahead and to starboard `(n, 2)` in lengths, from the place and course at the first order."""
    t = trial.track
    start = trial.switched_s[0]
    north = (t.position[:, 0] - np.interp(start, t.time, t.position[:, 0])) / trial.length_m
    east = (t.position[:, 1] - np.interp(start, t.time, t.position[:, 1])) / trial.length_m
    course = float(np.interp(start, t.time, t.attitude[:, 2]))
    c, s = np.cos(course), np.sin(course)
    return np.stack([north * c + east * s, -north * s + east * c], axis=1)


def _shown(trial: Trial) -> NDArray[np.intp]:
    """Samples at which an outline is drawn: equal in heading along a circle, in time along a zig-zag; a stop's ends."""
    t = trial.track
    if trial.name == "zigzag":
        return np.linspace(0, len(t.time) - 1, _OUTLINES).astype(np.intp)
    if trial.name == "stop":
        return np.array([int(np.searchsorted(t.time, trial.switched_s[0])), len(t.time) - 1])
    turned = np.abs(np.degrees(t.attitude[:, 2] - np.interp(trial.switched_s[0], t.time, t.attitude[:, 2])))
    first = int(np.searchsorted(t.time, trial.switched_s[0]))
    steps = np.arange(0.0, min(360.0, turned[-1]), _EVERY_DEG)
    return first + np.searchsorted(np.maximum.accumulate(turned[first:]), steps)


def _track(axes: Axes, trial: Trial, *, ahead_right: bool = False) -> None:
    t = trial.track
    place = in_lengths(trial)[:, ::-1]  # (n, 2): to the right and up, ahead is up
    course = float(np.interp(trial.switched_s[0], t.time, t.attitude[:, 2]))
    half = 0.5 * trial.beam_m / trial.length_m
    outline = np.array([[-0.5, -half], [_BOW[0], -half], [_BOW[1], 0], [_BOW[0], half], [-0.5, half], [-0.5, -half]])
    flip = slice(None, None, -1) if ahead_right else slice(None)
    begin = int(np.searchsorted(t.time, trial.switched_s[0])) if trial.name == "stop" else 0
    axes.plot(*place[begin:, flip].T, color=theme.TRUTH)
    for k in _shown(trial):
        c, s = np.cos(t.attitude[k, 2] - course), np.sin(t.attitude[k, 2] - course)
        corners = place[k] + np.stack([outline @ [s, c], outline @ [c, -s]], axis=1)
        axes.fill(*corners[:, flip].T, color=theme.SENSOR, alpha=0.55, lw=0)
    labels = ["to starboard / L [-]", "ahead / L [-]"]
    axes.set_xlabel(labels[flip][0])
    axes.set_ylabel(labels[flip][1])
    axes.set_aspect("equal", adjustable="datalim")
    if ahead_right:
        axes.invert_yaxis()  # starboard is below for who looks along the track
    axes.plot(0, 0, "+", color=theme.ALARM, ms=10, mew=1.5, zorder=4)
    for switched in trial.switched_s[1:]:
        at = [np.interp(switched, t.time, place[:, j]) for j in (0, 1)][flip]
        axes.plot(*at, "o", color=theme.ALARM, ms=3.5)


def _turn_marks(axes: Axes, trial: Trial) -> None:
    """Advance, transfer and tactical diameter as a drawing has dimensions."""
    number = {m.name: m for m in trial.measures}
    t, place = trial.track, in_lengths(trial)
    side = 1.0 if t.attitude[-1, 2] > t.attitude[0, 2] else -1.0
    across = {name: side * number[name].value for name in ("transfer", "tactical diameter")}
    advance = number["advance"].value
    level = float(np.interp(trial.switched_s[0] + number["time to 180 deg"].value, t.time, place[:, 0]))
    top = place[:, 0].max() + 0.45
    left = -0.5 * side
    for end, begin in (
        ((left, advance), (left, 0.0)),
        ((across["transfer"], top), (0.0, top)),
        ((across["tactical diameter"], level), (0.0, level)),
    ):
        axes.annotate("", end, begin, arrowprops=_ARROW)
    thin = {"color": theme.MUTED, "lw": 0.8, "ls": "--"}
    axes.plot([0, 0], [0, top], **thin)
    axes.plot([left, across["transfer"]], [advance, advance], **thin)
    axes.plot([across["transfer"]] * 2, [advance, top], **thin)
    axes.plot([left, 0], [0, 0], **thin)
    axes.plot(across["transfer"], advance, "o", color=theme.ALARM, ms=5, zorder=4)
    axes.plot(across["tactical diameter"], level, "o", color=theme.ALARM, ms=5, zorder=4)
    small = {"fontsize": 8, "color": theme.SECOND}
    axes.text(1.25 * left, advance / 2, "advance", rotation=90, va="center", ha="center", **small)
    axes.text(across["transfer"] / 2, top + 0.05, "transfer", va="bottom", ha="center", **small)
    axes.text(across["tactical diameter"] / 2, level + 0.05, "tactical diameter", va="bottom", ha="center", **small)
    lines = [_told(m) for m in trial.measures if m.unit in ("L", "")]
    axes.set_title("\n".join(lines), fontsize=8.5, fontweight="normal")


def _overshoots(axes: Axes, trial: Trial) -> None:
    """Overshoots as arrows from the angle at which the helm is reversed to the peak."""
    t = trial.track
    heading = np.degrees(t.attitude[:, 2])
    named = [m for m in trial.measures if m.name.endswith("overshoot")]
    for (start, end), m in zip(pairwise(trial.switched_s[1:]), named, strict=True):
        within = (t.time >= start) & (t.time <= end)
        side = np.sign(np.interp(start, t.time, heading))
        k = int(np.argmax(np.where(within, side * heading, -np.inf)))
        base = side * (side * heading[k] - m.value)
        axes.plot([start, t.time[k]], [base, base], color=theme.MUTED, lw=0.8, ls="--")
        axes.plot(start, np.interp(start, t.time, heading), "o", color=theme.ALARM, ms=4, zorder=4)
        axes.annotate("", (t.time[k], heading[k]), (t.time[k], base), arrowprops=_ARROW)
        limit = "" if m.limit is None else f"\nIMO: at most {m.limit:.3g}°"
        axes.annotate(
            f"{m.value:.1f}°{limit}", (t.time[k], heading[k]), (0, 5 * side), textcoords="offset points", fontsize=8,
            ha="center", va="bottom" if side > 0 else "top", color=theme.SECOND,
        )  # fmt: skip
    axes.axhline(0, color=theme.MUTED, lw=0.8)
    low, high = float(heading.min()), float(heading.max())
    axes.set_ylim(low - 0.25 * (high - low), high + 0.25 * (high - low))
    way = trial.measures[0]
    rest = [m for m in trial.measures if m.name == "period"]
    axes.set_title(", ".join(_told(m) for m in (way, *rest)), fontsize=8.5, fontweight="normal")


_DRAWN: Final[dict[str, Callable[[Figure, Trial], None]]] = {
    "turning": _turning, "zigzag": _zigzag, "stop": _along, "spiral": _spiral, "decay": _decay, "bollard": _bollard,
}  # fmt: skip
