"""Statistics of a run and its cost: the numbers of `stats.json`."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING, Any

from pelagos.report.mission import Mission
from pelagos.sim.memory import peak_memory_mb
from pelagos.sim.replay import Recording

if TYPE_CHECKING:
    from pelagos.sim.run import RunResult
    from pelagos.sim.simulation import Simulation


def run_statistics(sim: Simulation, result: RunResult) -> dict[str, Any]:
    """Numbers of a run that has just ended."""
    import drjit as dr

    from pelagos import jit

    return {
        "simulated_s": result.simulated_s,
        "wall_s": result.wall_s,
        "real_time_factor": result.real_time_factor,
        "ended": result.ended,
        "seed": sim.seed,
        "copies": sim.n,
        "tick_ms": sim.dt_ns * 1e-6,
        "device": jit.device,
        "processor": processor(),
        "threads": int(dr.thread_count()),
        "memory_mb": peak_memory_mb(),
        "triangles": int(sim.world.triangles),
        "readings": dict(result.counts),
        "ms_per_call": dict(result.ms_per_call),
        "seconds": dict(result.seconds_by_part),
    }


def recording_statistics(recording: Recording, missions: list[Mission]) -> dict[str, Any]:
    """Numbers that the recording itself tells."""
    versions = {k.removesuffix("_version"): v for k, v in recording.metadata.items() if k.endswith("_version")}
    return {
        "recording": {
            "bytes": recording.path.stat().st_size,
            "messages": sum(recording.count(topic) for topic in recording.channels),
            "complete": recording.complete,
        },
        "versions": {**versions, "python": recording.metadata.get("python", "")},
        "sensors": {mission.name: sensor_table(mission) for mission in missions},
    }


def sensor_table(mission: Mission) -> list[dict[str, Any]]:
    """One row a sensor: what was asked for, and what the file holds."""
    found: dict[str, dict[str, Any]] = {}
    for channel in mission.recording.channels.values():
        name = channel.about.get("sensor")
        if name is None or not channel.topic.startswith(f"/{mission.agent}/"):
            continue
        times = mission.recording.times(channel.topic)
        row = found.setdefault(
            name,
            {"sensor": name, "type": channel.about["type"], "rate_hz": float(channel.about["rate_hz"]), "count": 0,
             "recorded_hz": None, "messages": []},
        )  # fmt: skip
        row["messages"].append(channel.type)
        row["count"] = max(row["count"], len(times))
        if len(times) > 1 and row["recorded_hz"] is None:
            row["recorded_hz"] = (len(times) - 1) / ((times[-1] - times[0]) * 1e-9)
    return list(found.values())


def processor() -> str:
    """Name of the processor, and how many cores this process may use."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    name = ""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            name = next((line.split(":", 1)[1].strip() for line in file if line.startswith("model name")), "")
    except OSError:
        pass
    return f"{name or sys.platform}, {cores} cores"
