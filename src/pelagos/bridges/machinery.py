"""Machinery of vehicles for software outside: JointState of actuators, BatteryState where there is a battery.

Doors alone say it, at boundaries of steps: a recording has commands and motion, from which it can be repeated.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.bridges.pace import next_ns
from pelagos.bridges.tap import Tap
from pelagos.config.swarm import topic_name
from pelagos.messages.store import header, make, serialize
from pelagos.sim.simulation import Simulation
from pelagos.vehicles.actuators.t200 import load, shaft_speed
from pelagos.vehicles.build import battery
from pelagos.vehicles.vehicle import Vehicle

JOINTS: Final = "sensor_msgs/msg/JointState"
BATTERY: Final = "sensor_msgs/msg/BatteryState"
RATE_HZ: Final = 20.0
"""The most messages in a simulated second."""
_RAD_S_OF_RPM: Final = 2 * math.pi / 60
_PLACES: Final = {"rad": ("position", 1.0), "m": ("position", 1.0), "rad/s": ("velocity", 1.0),
                  "rpm": ("velocity", _RAD_S_OF_RPM), "N": ("effort", 1.0)}  # fmt: skip
"""Field of JointState and factor, by the unit of an actuator's state."""
_DISCHARGING, _UNKNOWN = 2, 0  # BatteryState.POWER_SUPPLY_STATUS_DISCHARGING, ..._HEALTH_UNKNOWN, ..._TECHNOLOGY_...
_NOT_KNOWN: Final = math.nan


@dataclass(frozen=True)
class _Speaker:
    """One agent: its vehicle, its frame, and its channels; `battery` None without one."""

    agent: str
    copy: int
    vehicle: Vehicle
    frame: str
    joints: int
    battery: int | None


class Machinery:
    """Says what actuators and batteries do, at most at `RATE_HZ`.

    Args:
        sim: the simulation.
        tap: what its doors listen to.
    """

    def __init__(self, sim: Simulation, tap: Tap) -> None:
        self._tap = tap
        self._next_ns = 0
        self._speakers: list[_Speaker] = []
        for agent, model in sim.model.agents.items():
            if not model.vehicle.actuator_names:
                continue
            for copy in range(sim.n):
                place = topic_name(agent) if sim.n == 1 else f"env{copy}/{topic_name(agent)}"
                about = {"agent": agent, "rate_hz": f"{RATE_HZ:g}"}
                joints = tap.declare_live(f"/{place}/joint_states", JOINTS, about)
                fed = model.vehicle.config.battery is not None
                supply = tap.declare_live(f"/{place}/battery", BATTERY, about) if fed else None
                frame = f"{place}/base_link"
                self._speakers.append(_Speaker(agent, copy, model.vehicle, frame, joints, supply))

    def say(self, sim: Simulation) -> None:
        """A boundary of steps: say what is so now, where it is time."""
        now = sim.time_ns
        if now < self._next_ns:
            return
        self._next_ns = next_ns(now, RATE_HZ)
        for one in self._speakers:
            states = sim.state[one.agent].actuators[one.copy]
            supply = supply_of(one.vehicle, states)
            voltage = None if supply is None else supply[0]
            self._tap.say(one.joints, now, joint_message(one.vehicle, states, one.frame, now, voltage))
            if supply is not None and one.battery is not None:
                self._tap.say(one.battery, now, battery_message(*supply, one.frame, now))


def supply_of(vehicle: Vehicle, states: NDArray[np.float64]) -> tuple[float, float] | None:
    """Voltage [V] and drawn current [A] at states `(k,)` of a vehicle's actuators; None without a battery."""
    if vehicle.config.battery is None:
        return None
    throttles = [s for s, a in zip(states, vehicle.model.actuators.values(), strict=True) if a.unit == "throttle"]
    return load(battery(vehicle.config.battery), np.array(throttles))


def joint_message(
    vehicle: Vehicle, states: NDArray[np.float64], frame: str, t_ns: int, voltage: float | None = None
) -> bytes:
    """JointState of states `(k,)`: positions [rad] or [m], velocities [rad/s], efforts [N]; the others not a number.

    T200 thrusters turn as the maker's table says at their throttle and `voltage` [V].
    """
    names = vehicle.actuator_names
    parts = {part: np.full(len(names), _NOT_KNOWN) for part in ("position", "velocity", "effort")}
    for i, actuator in enumerate(vehicle.model.actuators.values()):
        if actuator.unit == "throttle" and voltage is not None:
            parts["velocity"][i] = shaft_speed(states[i], voltage)
        elif actuator.unit in _PLACES:
            part, factor = _PLACES[actuator.unit]
            parts[part][i] = factor * states[i]
    return serialize(JOINTS, make(JOINTS, header=header(frame, t_ns), name=list(names), **parts))


def battery_message(voltage: float, current: float, frame: str, t_ns: int) -> bytes:
    """BatteryState of a voltage [V] and a drawn current [A], which the message has negative; no charge is modelled."""
    unknown: dict[str, Any] = dict.fromkeys(
        ("temperature", "charge", "capacity", "design_capacity", "percentage"), _NOT_KNOWN
    )
    message = make(
        BATTERY,
        header=header(frame, t_ns),
        voltage=voltage,
        current=-current,
        power_supply_status=_DISCHARGING,
        power_supply_health=_UNKNOWN,
        power_supply_technology=_UNKNOWN,
        present=True,
        cell_voltage=np.empty(0, dtype=np.float32),
        cell_temperature=np.empty(0, dtype=np.float32),
        location="",
        serial_number="",
        **unknown,
    )
    return serialize(BATTERY, message)
