"""A manoeuvre as a picture."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from pelagos.manoeuvres.trial import Trial
from pelagos.report import theme


def draw(trial: Trial) -> bytes:
    """PNG: the track, headings and helm, speed, and the numbers."""
    with theme.style():
        figure = theme.figure(10.5, 5.6)
        axes = figure.subplot_mosaic([["track", "angle"], ["track", "speed"]], width_ratios=[1.0, 1.15])
        if trial.name == "spiral":
            _spiral(axes["track"], trial)
        else:
            _track(axes["track"], trial)
        t = trial.track
        shown = t.attitude[:, 0] if trial.name == "decay" else t.attitude[:, 2]
        axes["angle"].plot(
            t.time, np.degrees(shown), color=theme.TRUTH, label="roll" if trial.name == "decay" else "heading"
        )
        if trial.name in ("turning", "zigzag", "spiral"):
            axes["angle"].step(t.time, np.degrees(t.commands[:, 0]), color=theme.SENSOR, where="post", label="helm")
        axes["angle"].set_ylabel("[deg]")
        axes["angle"].legend(loc="best")
        axes["speed"].plot(t.time, np.hypot(t.velocity[:, 0], t.velocity[:, 1]), color=theme.TRUTH, label="speed [m/s]")
        axes["speed"].plot(t.time, np.degrees(t.rates[:, 2]), color=theme.SECOND, label="yaw rate [deg/s]")
        axes["speed"].legend(loc="best")
        axes["speed"].set_xlabel("time [s]")
        figure.suptitle(f"{trial.vehicle}: {trial.name}, {trial.ordered}", fontweight="bold", x=0.01, ha="left")
        return theme.as_png(figure)


def _track(axes: Axes, trial: Trial) -> None:
    t, length = trial.track, trial.length_m
    start = trial.switched_s[0] if len(trial.switched_s) else t.time[0]
    north = (t.position[:, 0] - np.interp(start, t.time, t.position[:, 0])) / length
    east = (t.position[:, 1] - np.interp(start, t.time, t.position[:, 1])) / length
    axes.plot(east, north, color=theme.TRUTH)
    every = np.linspace(0, len(t.time) - 1, 16).astype(int)
    for k in every:
        c, s = np.cos(t.attitude[k, 2]), np.sin(t.attitude[k, 2])
        outline = np.array([[-0.5, -0.07], [0.35, -0.07], [0.5, 0], [0.35, 0.07], [-0.5, 0.07], [-0.5, -0.07]])
        axes.fill(east[k] + outline @ [s, c], north[k] + outline @ [c, -s], color=theme.SENSOR, alpha=0.55, lw=0)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("east / L")
    axes.set_ylabel("north / L")
    lines = [
        f"{m.name} {m.value:.2f} L" + ("" if m.limit is None else f" (limit {m.limit:g})")
        for m in trial.measures if m.unit == "L"
    ]  # fmt: skip
    middle = trial.name == "turning"
    axes.text(
        0.5 if middle else 0.02, 0.5 if middle else 0.98, "\n".join(lines), transform=axes.transAxes, fontsize=8,
        va="center" if middle else "top", ha="center" if middle else "left",
    )  # fmt: skip


def _spiral(axes: Axes, trial: Trial) -> None:
    points = [(float(m.name.split()[3]), m.value) for m in trial.measures if m.name.startswith("yaw rate")]
    axes.plot(*zip(*points, strict=True), "o-", color=theme.TRUTH)
    axes.set_xlabel("helm [deg]")
    axes.set_ylabel("yaw rate [deg/s]")
