"""Control mode of an agent at the start, and a check of the scenario's command against it; needs no device."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pelagos.errors import ScenarioError, did_you_mean
from pelagos.vehicles.family import Family, mission_mode

if TYPE_CHECKING:
    from pelagos.config.scenario import Scenario
    from pelagos.vehicles.vehicle import Vehicle


def first_mode(scenario: Scenario, name: str, vehicle: Vehicle) -> str:
    """The control mode of agent `name` at the start.

    Raises:
        ScenarioError: the vehicle has no such mode, a mission cannot steer by it, or the scenario's command has other
            channels.
    """
    agent = scenario.members[name]
    mode, allowed = agent.control or vehicle.default_mode, vehicle.modes
    if agent.mission:
        mode, allowed = _steered(scenario, name, vehicle), steered_modes(vehicle)
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
    return mode


def steered_modes(vehicle: Vehicle) -> tuple[str, ...]:
    """The control modes that missions can steer by, the usual one first."""
    names = {mode: vehicle.set_points(mode) for mode in vehicle.modes}
    usual = mission_mode(names)
    rest = [mode for mode in vehicle.modes if mission_mode({mode: names[mode]}) and usual and mode != usual[0]]
    return () if usual is None else (usual[0], *rest)


def family_of(vehicle: Vehicle, mode: str) -> Family:
    """Family of a mode, by which a mission steers a vehicle."""
    found = mission_mode({mode: vehicle.set_points(mode)})
    assert found is not None
    return found[1]


def _steered(scenario: Scenario, name: str, vehicle: Vehicle) -> str:
    agent, modes = scenario.members[name], steered_modes(vehicle)
    if not modes:
        raise ScenarioError(
            f"{agent.vehicle.type} cannot follow a mission: none of its modes {', '.join(vehicle.modes)} has the "
            "set-points that missions steer by; give a command instead",
            where=scenario.where("agents", name, "mission"),
        )
    return agent.control or modes[0]
