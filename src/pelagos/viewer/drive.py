"""Driving by hand: four axes of a stick become the set-points of whatever control mode a vehicle has for it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from pelagos.errors import CommandError
from pelagos.sim.simulation import Simulation

HEADING_RADPS: Final = math.radians(25.0)
"""How fast the set-point of the heading turns at full deflection."""
DEPTH_MPS: Final = 0.4
SPEED_MPS2: Final = 0.4
"""How fast the set-point of the speed grows."""
_SPEED_MPS: Final = 1.0  # of a hovering vehicle at full deflection
_YAW_RADPS: Final = math.radians(25.0)
_LONGEST_S: Final = 0.5  # between two messages of a stick; more is a pause
_AXES: Final = ("surge", "sway", "heave", "yaw")


@dataclass(frozen=True)
class Axes:
    """Of a stick, -1 to 1: ahead, to port, up, and turning to port."""

    surge: float = 0.0
    sway: float = 0.0
    heave: float = 0.0
    yaw: float = 0.0

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Axes:
        """From a message.

        Raises:
            CommandError: an axis is no number.
        """
        values = {}
        for name in _AXES:
            value = given.get(name, 0.0)
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
                raise CommandError(f"the axis {name} is a number from -1 to 1, not {value!r}")
            values[name] = max(-1.0, min(1.0, float(value)))
        return cls(**values)


def drive(sim: Simulation, agent: str, axes: Axes, dt_s: float) -> None:
    """Command an agent by a stick that has been held like this for a time [s].

    A hovering vehicle gets velocities. Others get a heading that turns, a depth that sinks and a speed that grows.

    Raises:
        CommandError: no such agent, or one without a mode for it.
    """
    if agent not in sim.model.agents:
        raise CommandError(f"there is no agent {agent!r} to drive")
    vehicle = sim.model.agents[agent].vehicle
    dt_s = min(max(dt_s, 0.0), _LONGEST_S)
    if "velocity" in vehicle.modes:
        _enter(sim, agent, "velocity")
        speeds = {
            "surge_speed": _SPEED_MPS * axes.surge, "sway_speed": _SPEED_MPS * axes.sway,
            "heave_speed": 0.6 * _SPEED_MPS * axes.heave, "yaw_rate": _YAW_RADPS * axes.yaw,
        }  # fmt: skip
        sim.command({agent: [speeds.get(name, 0.0) for name in vehicle.command_names("velocity")]})
        return
    for mode in ("depth_heading_speed", "heading_speed", "height_heading_speed"):
        if mode in vehicle.modes:
            _integrate(sim, agent, mode, axes, dt_s)
            return
    able = ", ".join(vehicle.modes)
    raise CommandError(f"{agent}: a {vehicle.name} has no control mode to be driven by hand; modes: {able}")


def _integrate(sim: Simulation, agent: str, mode: str, axes: Axes, dt_s: float) -> None:
    vehicle, state = sim.model.agents[agent].vehicle, sim.state[agent]
    names = vehicle.command_names(mode)
    if sim.stepper.mode(agent) == mode:
        held = dict(zip(names, sim.held_command(agent)[0].tolist(), strict=True))
    else:
        held = {"speed": float(state.velocity[0, 0]), "airspeed": float(state.velocity[0, 0])}
    speed_key = "airspeed" if "airspeed" in names else "speed"
    top = vehicle.config.envelope.top_mps or 2.0
    heading = held.get("heading", -float(state.euler[0, 2]))
    given = {
        "heading": math.remainder(heading - HEADING_RADPS * axes.yaw * dt_s, 2 * math.pi),
        "depth": max(0.0, held.get("depth", float(state.depth[0])) - DEPTH_MPS * axes.heave * dt_s),
        "height": max(0.0, held.get("height", -float(state.depth[0])) + DEPTH_MPS * axes.heave * dt_s),
        speed_key: max(0.0, min(top, held.get(speed_key, 0.0) + SPEED_MPS2 * axes.surge * dt_s)),
    }
    _enter(sim, agent, mode)
    sim.command({agent: [given[name] for name in names]})


def _enter(sim: Simulation, agent: str, mode: str) -> None:
    if sim.stepper.mode(agent) != mode:
        sim.set_mode(agent, mode)
