"""Columns and commands of a recording that `pelagos run` wrote, for a plan that does not name them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import yaml

from pelagos.config.swarm import topic_name
from pelagos.errors import InputError, LookupFailed
from pelagos.identification.run_steps import SHORTEST_STEP_S, run_steps
from pelagos.sim.command_log import COMMANDS
from pelagos.sim.record import SCENARIO
from pelagos.sim.replay import Recording

COLUMNS: Final[dict[str, tuple[str, float, float]]] = {
    "north": ("pose.pose.position.y", 1.0, 0.0), "east": ("pose.pose.position.x", 1.0, 0.0),
    "depth": ("pose.pose.position.z", -1.0, 0.0), "roll": ("pose.pose.orientation.roll", 1.0, 0.0),
    "pitch": ("pose.pose.orientation.pitch", -1.0, 0.0), "heading": ("pose.pose.orientation.yaw", -1.0, math.pi / 2),
    "u": ("twist.twist.linear.x", 1.0, 0.0), "v": ("twist.twist.linear.y", -1.0, 0.0),
    "w": ("twist.twist.linear.z", -1.0, 0.0), "p": ("twist.twist.angular.x", 1.0, 0.0),
    "q": ("twist.twist.angular.y", -1.0, 0.0), "r": ("twist.twist.angular.z", -1.0, 0.0),
}  # fmt: skip
"""Field of nav_msgs/Odometry (ENU, FLU), scale and zero, by coordinate (NED, FRD)."""


def completed(data: dict[str, Any], path: Path, agent: str) -> dict[str, Any]:
    """Keys of a plan with those columns and commands that it leaves to the recording.

    True motion has no error but that of the run's own steps: a fit takes the same, whatever its vehicle has, unless the
    plan says how. A run
    begins with its actuators at rest; those of a recording that begins later, or of sensors, are not known at first.

    Args:
        data: the plan's keys.
        path: of the recording; of several copies the first counts.
        agent: whose topics.

    Raises:
        InputError: the recording has no commands, or no motion of the agent.
    """
    if data.get("columns") and "commands" in data:
        return data
    recording = Recording(path)
    channels, found = recording.channels, dict(data)
    if not data.get("columns"):
        topic = _topic(channels, agent, "truth")
        if topic is None:
            agents = sorted({name.split("/")[-2] for name in channels if name.endswith("/truth")})
            raise LookupFailed("agent", agent, agents, where=str(path))
        found["columns"] = {
            name: {"column": f"{topic}.{field}", "scale": scale, "zero": zero}
            for name, (field, scale, zero) in COLUMNS.items()
        }
        begun = recording.times(topic)[:1].tolist() == [0]
        found.setdefault("actuators_from", "rest" if begun else "unknown")
        if not {"integrator", "substeps", "step_s"} & data.keys():
            period_ns = 1e9 / yaml.safe_load(recording.attachments[SCENARIO])["record"]["state_rate_hz"]
            dt_ns = int(recording.metadata["dt_ns"])
            ticks = round(period_ns / dt_ns)
            if 1e-9 * dt_ns >= SHORTEST_STEP_S:  # the error of shorter ones is nothing
                run = None if _says_integrator(data) else run_steps(recording, [topic])
                way = "vehicle" if run is None else run.integrator
                found |= {"integrator": way, "substeps": ticks, "step_s": 1e-9 * ticks * dt_ns}
    if "commands" not in data:
        topic = _topic(channels, agent, COMMANDS)
        if topic is None:
            raise InputError(
                f"{path}: holds no commands to the actuators of {agent}: record them with pelagos run SCENARIO "
                "--set record.commands=true, or name their topics in the plan under commands"
            )
        found.setdefault("actuators_from", "unknown")
        found["commands"] = {name: f"{topic}.{name}" for name in channels[topic].about["actuators"].split()}
    return found


def _says_integrator(data: dict[str, Any]) -> bool:
    changes = data.get("vehicle")
    return isinstance(changes, Mapping) and changes.get("integrator") is not None


def _topic(channels: Any, agent: str, name: str) -> str | None:
    for place in ("", "/env0"):
        topic = f"{place}/{topic_name(agent)}/{name}"
        if topic in channels:
            return topic
    return None
