"""Which control mode an agent begins in, and whether the scenario's command fits it; needs no device."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from pelagos.errors import ScenarioError, did_you_mean

if TYPE_CHECKING:
    from pelagos.config.scenario import Scenario
    from pelagos.vehicles.vehicle import Vehicle

GUIDANCE_MODE: Final = "depth_heading_speed"
"""The mode that missions steer by."""


def first_mode(scenario: Scenario, name: str, vehicle: Vehicle) -> str:
    """The control mode of agent `name` at the start.

    Raises:
        ScenarioError: the vehicle has no such mode, a mission cannot steer by it, or the scenario's command has other
            channels.
    """
    agent = scenario.agents[name]
    mode = agent.control or (GUIDANCE_MODE if agent.mission else vehicle.default_mode)
    if agent.mission and GUIDANCE_MODE not in vehicle.modes:
        raise ScenarioError(
            f"{agent.vehicle.type} cannot follow a mission: it has no mode {GUIDANCE_MODE!r}; give a command instead, "
            f"in one of {', '.join(vehicle.modes)}",
            where=scenario.where("agents", name, "mission"),
        )
    allowed = (GUIDANCE_MODE,) if agent.mission else vehicle.modes
    if mode not in allowed:
        raise ScenarioError(
            f"control mode {mode!r} cannot be used here{did_you_mean(mode, allowed)}; allowed: {', '.join(allowed)}",
            where=scenario.where("agents", name, "control"),
        )
    if agent.command is not None:
        names = vehicle.command_names(mode)
        where = scenario.where("agents", name, "command")
        if len(agent.command) != len(names):
            raise ScenarioError(
                f"mode {mode!r} takes {len(names)} numbers, [{', '.join(names)}], not {len(agent.command)}", where=where
            )
        for channel, value in zip(names, agent.command, strict=True):
            if not math.isfinite(value):
                raise ScenarioError(f"{channel} is {value}, not a finite number", where=where)
    return mode
