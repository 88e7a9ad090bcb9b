"""The log of commands to actuators: what acted from each tick on, on its way into a recording."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.messages.numbers import MULTI_ARRAY, LabelledRow
from pelagos.sim.record import Recorder
from pelagos.sim.trajectory import Trajectory

if TYPE_CHECKING:
    from pelagos.sim.simulation import Simulation

COMMANDS: Final = "actuator_commands"
"""Topic below an agent's name: std_msgs/Float64MultiArray, whose label names the actuators and their units."""
ACTS: Final = "from this time on"


class CommandLog:
    """Writes down commands, one message for each of an agent's copies at each time of its motion.

    A message's time is that from which its commands act; they are those before the limits and lags of actuators.
    """

    def __init__(self, sim: Simulation, recorder: Recorder) -> None:
        self._sim, self._recorder = sim, recorder
        self._made: dict[str, tuple[LabelledRow, list[int]]] = {}
        for name, agent in sim.model.agents.items():
            found = [recorder.number(f"/{place}/{COMMANDS}") for place in recorder.places(name)]
            channels = [number for number in found if number is not None]
            if channels:
                units = [a.unit for a in agent.vehicle.model.actuators.values()]
                self._made[name] = LabelledRow(agent.vehicle.actuator_names, units), channels

    def write(self, name: str, trajectory: Trajectory, period: int) -> None:
        """Write down an agent's commands in the steps of a block that begin at multiples of `period` ticks."""
        told = trajectory.told()
        if name not in self._made or not len(told):
            return
        agent, first = self._sim.model.agents[name], trajectory.first_tick - 1
        ticks = np.arange(-(-first // period) * period, first + trajectory.ticks, period, dtype=np.int64)
        if not len(ticks):
            return
        own: NDArray[np.float64] = told[ticks - first][:, agent.rows]
        message, channels = self._made[name]
        for copy, channel in enumerate(channels):
            self._recorder.write_rows(channel, ticks * self._sim.dt_ns, message.rows(own[:, copy]))


def declare_commands(recorder: Recorder, sim: Simulation) -> None:
    """Topics "/AGENT/actuator_commands" of all agents that have actuators."""
    for name, agent in sim.model.agents.items():
        units = [a.unit or "-" for a in agent.vehicle.model.actuators.values()]
        about = {"agent": name, "actuators": " ".join(agent.vehicle.actuator_names), "units": " ".join(units),
                 "acts": ACTS}  # fmt: skip
        for place in recorder.places(name) if units else ():
            recorder.channel(f"/{place}/{COMMANDS}", MULTI_ARRAY, about)
