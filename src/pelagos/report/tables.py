"""Tables of a report: sensors, parts of the step loop, and the run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pelagos.report.mission import Mission
from pelagos.report.page import Section, table, two_columns
from pelagos.sim.replay import Recording

_ENDINGS = {
    "time": "end of the time", "missions": "end of every mission", "interrupt": "the user",
    "stopped": "the program, or the wall-clock limit",
}  # fmt: skip


def sensors_table(mission: Mission, numbers: Mapping[str, Any]) -> Section:
    """Table of each sensor's settings and of what the recording holds of it."""
    cost = numbers.get("ms_per_call", {})
    rows = []
    for row in numbers["sensors"][mission.name]:
        recorded = "-" if row["recorded_hz"] is None else f"{row['recorded_hz']:.4g}"
        ms = cost.get(f"{mission.name}.{row['sensor']}")
        rows.append([
            row["sensor"], row["type"], f"{row['rate_hz']:g}", recorded, f"{row['count']:,}",
            "-" if ms is None else f"{ms:.2f}", ", ".join(dict.fromkeys(row["messages"])),
        ])  # fmt: skip
    head = ["sensor", "type", "rate asked [Hz]", "recorded [Hz]", "readings", "ms a call", "messages"]
    return Section(f"Sensors of {mission.name}", "", table(head, rows, numbers=(2, 3, 4, 5), code=(6,)))


def parts_table(numbers: Mapping[str, Any]) -> Section:
    """Table of the time that parts of the run took."""
    seconds: Mapping[str, float] = numbers.get("seconds", {})
    wall = float(numbers.get("wall_s") or 0.0) or float("inf")
    cost = numbers.get("ms_per_call", {})
    ordered = sorted(seconds.items(), key=lambda item: -item[1])
    rows = [[name, f"{s:.2f}", f"{100 * s / wall:.1f}", f"{cost.get(name, 0.0):.3f}"] for name, s in ordered]
    text = "Wall-clock time by part of the step loop; the rest is Python between them."
    if not rows:
        return Section("Where the time went", "Not measured.", "")
    return Section(
        "Where the time went", text, table(["part", "s", "% of the run", "ms a call"], rows, numbers=(1, 2, 3))
    )


def run_table(numbers: Mapping[str, Any], recording: Recording) -> Section:
    """The run and the machine."""
    about = recording.metadata
    size = numbers["recording"]["bytes"] / 1e6
    left = [
        ["seed", str(numbers.get("seed", about.get("seed", "")))],
        ["simulated", _number(numbers.get("simulated_s"), "s")],
        ["wall clock", _number(numbers.get("wall_s"), "s")],
        ["real-time factor", _number(numbers.get("real_time_factor"), "")],
        ["tick", f"{float(about.get('dt_ns', 0)) * 1e-6:g} ms"],
        ["copies", str(numbers.get("copies", about.get("copies", "")))],
        ["ended by", _ENDINGS.get(str(numbers.get("ended")), "unknown")],
        ["recording", f"{size:.1f} MB, {numbers['recording']['messages']:,} messages"
            + ("" if numbers["recording"]["complete"] else " (cut off)")],
    ]  # fmt: skip
    right = [
        ["device", str(numbers.get("device", "unknown"))],
        ["processor", str(numbers.get("processor", "unknown"))],
        ["threads", str(numbers.get("threads", "unknown"))],
        ["peak memory", _number(numbers.get("memory_mb"), "MB")],
        ["world", f"{numbers['triangles']:,} triangles" if "triangles" in numbers else "unknown"],
        *([name, version] for name, version in numbers["versions"].items()),
    ]
    return Section("Run", "", two_columns(table(["what", ""], left), table(["where", ""], right)))


def _number(value: float | None, unit: str) -> str:
    return "unknown" if value is None else f"{value:.4g} {unit}".rstrip()
