"""Bodies on scripted paths in a report: their tracks on the map, and how near the vehicle came to them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from pelagos.math.frames import enu_to_nwu_np
from pelagos.messages.motion import ODOMETRY_FIELDS
from pelagos.report.mission import Mission
from pelagos.report.page import Section, table
from pelagos.sim.replay import Recording
from pelagos.world.label import label_color

_MOST_DRAWN = 12
_NEAR_M = 40.0  # what moves within this of a standing vehicle belongs on its map


@dataclass(frozen=True)
class MoverTrack:
    """One mover of a recording.

    Attributes:
        name, body, label: as the recorder noted them.
        color: of its label, "#rrggbb".
        t: `(k,)` [s].
        position: `(k, 3)` NWU [m].
    """

    name: str
    body: str
    label: str
    color: str
    t: NDArray[np.float64]
    position: NDArray[np.float64]


def mover_tracks(recording: Recording) -> list[MoverTrack]:
    """The movers of a recording, in the scenario's order."""
    found = []
    for channel in recording.channels.values():
        about = channel.about
        if "mover" in about and recording.count(channel.topic):
            t, values = recording.table(channel.topic, ODOMETRY_FIELDS)
            color = "#{:02x}{:02x}{:02x}".format(*label_color(int(about["label_number"])))
            place = enu_to_nwu_np(values[:, 2:5])
            found.append(MoverTrack(about["mover"], about["body"], about["label"], color, t, place))
    return found


def near_parts(tracks: list[MoverTrack], own: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """The parts `(k, 2)` of their ways that a map of the vehicle's own way `(m, 2)` should show."""
    low, high = own.min(axis=0), own.max(axis=0)
    room = max(_NEAR_M, float((high - low).max()))
    parts = [t.position[:, :2] for t in tracks]
    return [p[((p > low - room) & (p < high + room)).all(axis=1)] for p in parts]


def draw_movers(axes: Axes, tracks: list[MoverTrack], low: NDArray[np.float64], high: NDArray[np.float64]) -> None:
    """Their ways, a diamond where each was at the end, and their names, on the map between two corners (x, y) [m]."""
    inside = [t for t in tracks if ((t.position[:, :2] > low) & (t.position[:, :2] < high)).all(axis=1).any()]
    for index, track in enumerate(inside[:_MOST_DRAWN]):
        east, north = -track.position[:, 1], track.position[:, 0]
        axes.plot(east, north, color="white", linewidth=2.0, alpha=0.8)
        axes.plot(
            east, north, color=track.color, linewidth=1.2, linestyle=(0, (1.5, 1.5)),
            label="movers" if index == 0 else None,
        )  # fmt: skip
        axes.plot(
            east[-1], north[-1], "D", color=track.color, markeredgecolor="white", markersize=5, linestyle="none",
            clip_on=True,
        )  # fmt: skip
        axes.annotate(
            track.name, (east[-1], north[-1]), fontsize=7.5, xytext=(5, 4), textcoords="offset points", clip_on=True,
            annotation_clip=True, bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "alpha": 0.7, "lw": 0},
        )  # fmt: skip


def movers_section(mission: Mission, tracks: list[MoverTrack]) -> list[Section]:
    """A table: what moved, how far, and how near the vehicle came; empty where nothing did."""
    if not tracks:
        return []
    rows = []
    for track in tracks:
        own = mission.motion.at(track.t).position
        away = np.linalg.norm(own - track.position, axis=1)
        way = np.linalg.norm(np.diff(track.position, axis=0), axis=1).sum()
        nearest = int(np.argmin(away))
        rows.append(
            [track.name, track.body, track.label, f"{way:.1f}", f"{away[nearest]:.1f}", f"{track.t[nearest]:.1f}"]
        )
    heads = ["mover", "body", "label", "way [m]", f"nearest to {mission.name} [m]", "at [s]"]
    text = "Bodies on scripted paths; distances are between origins."
    return [Section("What moved", text, table(heads, rows, numbers=(3, 4, 5)))]
