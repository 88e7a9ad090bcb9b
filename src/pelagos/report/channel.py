"""A picture of a channel: where its rays run and how much is lost, when they arrive, and the water they run through."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from pelagos.acoustics.transmission_loss import Field, ray_paths
from pelagos.report.theme import ALARM, INK, MUTED, SECOND, SENSOR, THIRD, as_png, figure, style
from pelagos.sim.channel import Channel, ChannelArrivals

_RAYS: Final = 12
_SHOWN_DB: Final = 80.0  # below the loudest arrival
_COLOURS: Final = (INK, SECOND, SENSOR, THIRD)  # by bounces: none, surface only, bottom only, both


def draw_channel(channel: Channel, *, title: str = "") -> bytes:
    """PNG bytes."""
    made, a = channel.field(), channel.arrivals()
    with style():
        drawn = figure(11.0, 6.6)
        grid = drawn.add_gridspec(2, 2, width_ratios=[5, 1], height_ratios=[3, 2])
        section, profile = drawn.add_subplot(grid[0, 0]), drawn.add_subplot(grid[0, 1])
        arrivals = drawn.add_subplot(grid[1, :])
        _draw_section(drawn, section, channel, made, a)
        section.set_title(title or "Sound between two places")
        _draw_profile(profile, channel, made.depth[-1])
        _draw_arrivals(arrivals, channel, a)
        return as_png(drawn, dpi=130)


def _draw_section(drawn: Any, section: Any, channel: Channel, made: Field, a: ChannelArrivals) -> None:
    """Loss by distance and depth, the bottom, and the loudest rays."""
    from matplotlib.patheffects import withStroke

    distance = float(np.hypot(*(channel.receiver - channel.source)[:2]))
    loss = made.incoherent_loss_db.T
    x_unit, x_name = (1e-3, "km") if distance > 3000 else (1.0, "m")
    low = float(np.percentile(loss[np.isfinite(loss)], 5))
    shown = section.pcolormesh(
        made.x * x_unit, made.depth, loss, cmap="viridis_r", vmin=low, vmax=low + 50.0, shading="auto",
        rasterized=True,
    )  # fmt: skip
    drawn.colorbar(shown, ax=section, label=f"loss at {channel.frequency_hz / 1e3:g} kHz [dB re 1 m]", pad=0.01)
    bottom = channel.section.bottom_at(made.x)
    section.fill_between(made.x * x_unit, bottom, made.depth[-1], color="#8a7a63", linewidth=0)
    loudest = np.argsort(a.loss_db, kind="stable")[:_RAYS]
    if len(loudest):
        paths = ray_paths(channel.section, channel.depths[0], -a.departure_angle[loudest], distance)
        for row, ray in zip(paths.depth, loudest.tolist(), strict=True):
            x = np.concatenate([[0.0], paths.x]) * x_unit
            z = np.concatenate([[channel.depths[0]], row])
            section.plot(x, z, color="white", linewidth=1.0, alpha=0.25 if a.blocked[ray] else 0.85)
    for at, deep, name in zip((0.0, distance), channel.depths, ("transmitter", "receiver"), strict=True):
        section.plot(at * x_unit, deep, "o", color=ALARM, markeredgecolor="white", clip_on=False, zorder=5)
        section.annotate(
            name, (at * x_unit, deep), xytext=(7, -12), textcoords="offset points", color="white", fontsize=8,
            path_effects=[withStroke(linewidth=2.0, foreground=INK)],
        )  # fmt: skip
    section.set(
        xlabel=f"distance [{x_name}]", ylabel="depth [m]", xlim=(0, made.x[-1] * x_unit),
        ylim=(made.depth[-1], 0),
    )  # fmt: skip
    section.grid(False)


def _draw_profile(profile: Any, channel: Channel, bottom: float) -> None:
    """Sound speed by depth."""
    depth = np.linspace(0.0, bottom, 200)
    profile.plot(channel.section.speed_at(depth), depth, color=SECOND)
    profile.set(xlabel="sound speed [m/s]", ylim=(bottom, 0), title="Water")
    profile.ticklabel_format(useOffset=False)
    if profile.get_xlim()[1] - profile.get_xlim()[0] < 1.0:
        middle = float(channel.section.speed_at(0.0))
        profile.set_xlim(middle - 1.0, middle + 1.0)
    profile.tick_params(axis="x", rotation=45)


def _draw_arrivals(arrivals: Any, channel: Channel, a: ChannelArrivals) -> None:
    """Level of each arrival by its delay."""
    from matplotlib.lines import Line2D

    if len(a):
        kind = 1 * (a.surface > 0) + 2 * (a.bottom > 0)
        level = -np.where(a.blocked, np.nan, a.loss_db)
        loudest_level = float(np.nanmax(level)) if np.isfinite(level).any() else -60.0
        floor = loudest_level - _SHOWN_DB
        first = a.delay.min()
        for k in np.flatnonzero(~(level < floor)):
            arrivals.vlines(
                1e3 * (a.delay[k] - first), floor, level[k] if np.isfinite(level[k]) else floor + 2.0,
                color=MUTED if a.blocked[k] else _COLOURS[kind[k]], linewidth=1.8,
            )  # fmt: skip
        arrivals.set_ylim(floor, loudest_level + 5.0)
        names = ("direct", "surface", "bottom", "both")
        arrivals.legend(
            handles=[Line2D([], [], color=c, label=n) for c, n in zip(_COLOURS, names, strict=True)],
            loc="upper right", ncols=4,
        )  # fmt: skip
        arrivals.set(
            xlabel=f"delay after the first at {1e3 * first:.3f} ms [ms]", ylabel="level [dB re 1 m]",
            title=f"Arrivals: {len(a)} paths, {channel.transmission_loss():.1f} dB lost in all",
        )  # fmt: skip
    else:
        arrivals.set(title="Arrivals: no ray leads there", xticks=[], yticks=[])
