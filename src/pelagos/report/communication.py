"""Packets between modems in a report: a matrix of who heard whom, and every packet on a time line with its fate."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from typing import Any, Final

from matplotlib.figure import Figure

from pelagos.messages.communication import PACKETS
from pelagos.report.page import Section, image, table
from pelagos.report.theme import ALARM, INK, MUTED, SECOND, SENSOR, THIRD, as_png, data_uri, figure, style, time_axis
from pelagos.sim.replay import Recording

_COLOURS: Final = {
    "received": SECOND, "collision": ALARM, "multipath": THIRD, "noise": SENSOR, "out of range": MUTED, "blocked": INK,
    "half duplex": "#c9a227", "no path": "#a9b4bf",
}  # fmt: skip
_MOST_ENDS: Final = 24


def packets_of(recording: Recording) -> list[dict[str, Any]]:
    """Fate of every packet at every receiver of the first copy, in order of time."""
    found: list[dict[str, Any]] = []
    for topic in recording.channels:
        if topic.endswith(f"/{PACKETS}") and recording.of_first(topic):
            for message in recording.messages(topic):
                found += json.loads(message.message.data)
    return sorted(found, key=lambda line: (line["time_ns"], line["receiver"]))


def communication_section(recording: Recording, numbers: dict[str, Any]) -> list[Section]:
    """A section where any modem heard of anything; its counts go into `numbers`."""
    lines = packets_of(recording)
    if not lines:
        return []
    fates = Counter(line["fate"] for line in lines if line["kind"] in ("data", "request", "response"))
    numbers["communication"] = {"packets": len(lines), "fates": dict(fates)}
    with style():
        drawn = _drawn(lines)
        picture = image(data_uri(as_png(drawn)), "packets between modems")
    text = (
        f"{fates.get('received', 0)} of {sum(fates.values())} receptions succeeded. Left: what each receiver got of "
        "each sender; right: each packet at its receiver, by what became of it."
    )
    rows = [[fate, str(count)] for fate, count in fates.most_common()]
    return [Section("Who heard whom", text, picture + table(["fate", "receptions"], rows))]


def _drawn(lines: Sequence[dict[str, Any]]) -> Figure:
    ends = sorted({line["receiver"] for line in lines} | {line["sender"] for line in lines})[:_MOST_ENDS]
    place = {end: k for k, end in enumerate(ends)}
    drawn = figure(10.0, 1.6 + 0.35 * max(len(ends), 4))
    matrix, times = drawn.subplots(1, 2, width_ratios=[1, 2])
    share = [[float("nan")] * len(ends) for _ in ends]
    for a in ends:
        for b in ends:
            pair = [line["fate"] for line in lines if line["sender"] == a and line["receiver"] == b]
            if pair:
                share[place[a]][place[b]] = pair.count("received") / len(pair)
                matrix.text(place[b], place[a], f"{pair.count('received')}/{len(pair)}", ha="center", va="center",
                            fontsize=7)  # fmt: skip
    matrix.imshow(share, vmin=0.0, vmax=1.0, cmap="RdYlGn", alpha=0.7, aspect="auto")
    names = [end.replace(".modem", "") for end in ends]
    matrix.set_xticks(range(len(ends)), names, rotation=60, ha="right")
    matrix.set_yticks(range(len(ends)), names)
    matrix.set(xlabel="receiver", ylabel="sender", title="Packets received")
    matrix.grid(False)
    scale, label = time_axis(max(line["time_ns"] for line in lines) * 1e-9)
    for fate in dict.fromkeys(line["fate"] for line in lines):
        some = [line for line in lines if line["fate"] == fate and line["receiver"] in place]
        times.plot(
            [line["time_ns"] * 1e-9 / scale for line in some], [place[line["receiver"]] for line in some], "|",
            color=_COLOURS.get(fate, MUTED), markersize=11, markeredgewidth=1.6, label=fate,
        )  # fmt: skip
    times.set_yticks(range(len(ends)), names)
    times.invert_yaxis()
    times.set(xlabel=label, title="Packets at their receivers")
    times.legend(loc="upper center", bbox_to_anchor=(0.5, -0.22), ncols=4)
    return drawn
