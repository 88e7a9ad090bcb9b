"""HoloOcean's task sensors: reward and end of a task, from where agents are.

Facts of their keys: documentation of Holodeck (BYU PCCL, MIT licence), from which HoloOcean has them; lengths are in
metres here.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from pelagos.compat.holoocean.exceptions import HoloOceanConfigurationException
from pelagos.compat.holoocean.sensor import Array, HoloOceanSensor
from pelagos.errors import did_you_mean
from pelagos.sensors.sensor import Reading

if TYPE_CHECKING:
    from pelagos.compat.holoocean.motion import AgentMotion

_FULL = 100.0  # the best reward of those who follow or avoid
_MISSPELT = "FOVRadains"


class _Task(HoloOceanSensor):
    """Reward, and 1 where the task has ended."""

    @property
    def data_shape(self) -> Sequence[int]:
        return [2]

    def actor(self, name: str) -> AgentMotion:
        """The motion of an agent by its name.

        Raises:
            HoloOceanConfigurationException: there is no such agent.
        """
        if name not in self.env.motions:
            raise HoloOceanConfigurationException(
                f"{self.agent_name}.{self.name}: there is no agent {name!r}{did_you_mean(name, self.env.motions)}"
            )
        return self.env.motions[name]

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        return np.array(self.judge(motion), dtype=np.float32)

    @abstractmethod
    def judge(self, motion: AgentMotion) -> tuple[float, bool]:
        """Reward and end at a tick."""


class _ToGoal(_Task):
    """A distance from one agent to another, or to a place."""

    mover: ClassVar[str]
    """Key that names the agent whose distance counts: else the sensor's own."""

    def setup(self) -> None:
        if "GoalActor" in self.config and "GoalLocation" in self.config:
            raise HoloOceanConfigurationException(f"{self.name}: give either GoalActor or GoalLocation, not both")
        self._start: Array | None = None
        self._near = float(self.config.get("GoalDistance", 0.0))

    def left(self, motion: AgentMotion) -> float:
        """Distance to the goal [m]; without a goal from where the agent was at first."""
        moving = self.actor(self.config[self.mover]) if self.mover in self.config else motion
        if self._start is None:
            self._start = moving.position.copy()
        goal = self.config.get("GoalLocation", self._start)
        if "GoalActor" in self.config:
            goal = self.actor(self.config["GoalActor"]).position
        return float(np.linalg.norm(moving.position - np.asarray(goal, dtype=np.float64)))


class DistanceTask(_ToGoal):
    """1 for every `Interval` that the distance to the goal has become less (or more, with `MaximizeDistance`)."""

    sensor_type = "DistanceTask"
    keys = frozenset({"DistanceActor", "GoalActor", "GoalLocation", "Interval", "GoalDistance", "MaximizeDistance"})
    mover = "DistanceActor"

    def setup(self) -> None:
        super().setup()
        self._interval = float(self.config.get("Interval", 1.0))
        if not self._interval > 0:
            raise HoloOceanConfigurationException(f"{self.name}: Interval is above 0, not {self._interval:g}")
        self._rewarded: float | None = None

    def judge(self, motion: AgentMotion) -> tuple[float, bool]:
        distance, away = self.left(motion), bool(self.config.get("MaximizeDistance", False))
        if self._rewarded is None:
            self._rewarded = distance
        won = (distance - self._rewarded) * (1 if away else -1) >= self._interval
        if won:
            self._rewarded = distance
        return float(won), distance > self._near if away else distance < self._near


class LocationTask(_ToGoal):
    """1 (or -1 with `NegativeReward`) within `GoalDistance` of the goal, where `HasTerminal` ends the task."""

    sensor_type = "LocationTask"
    keys = frozenset({"LocationActor", "GoalActor", "GoalLocation", "GoalDistance", "NegativeReward", "HasTerminal"})
    mover = "LocationActor"

    def judge(self, motion: AgentMotion) -> tuple[float, bool]:
        there = self.left(motion) < self._near
        reward = -1.0 if self.config.get("NegativeReward", False) else 1.0
        return (reward if there else 0.0), there and bool(self.config.get("HasTerminal", False))


class _Sighted(_Task):
    """A reward by the distance of another agent, where one sees the other."""

    other: ClassVar[str]

    def setup(self) -> None:
        if self.other not in self.config:
            raise HoloOceanConfigurationException(f"{self.name}: {self.sensor_type} needs {self.other}")
        self._reach = float(self.config.get("MinDistance", 10.0))
        self._half = float(self.config.get("FOVRadians", self.config.get(_MISSPELT, math.pi)))
        if not self._reach > 0:
            raise HoloOceanConfigurationException(f"{self.name}: MinDistance is above 0, not {self._reach:g}")

    def share(self, motion: AgentMotion) -> float:
        """Share of `MinDistance` that lies between the two."""
        other = self.actor(self.config[self.other])
        return min(float(np.linalg.norm(other.position - motion.position)) / self._reach, 1.0)

    def seen(self, eye: str, there: str) -> bool:
        """True where an agent has another in its field of view with nothing between, and where that is not asked."""
        if not self.config.get("OnlyWithinSight", False):
            return True
        start, end = self.actor(eye), self.actor(there)
        line = end.position - start.position
        distance = float(np.linalg.norm(line))
        if distance == 0:
            return True
        angle = math.acos(min(max(float(start.rotation[:, 0] @ line) / distance, -1.0), 1.0))
        return angle < self._half and self.env.sees(eye, start.position, there, end.position)


class FollowTask(_Sighted):
    """0 to 100: the nearer to the agent that is followed, the more; 0 where it is not seen."""

    sensor_type = "FollowTask"
    keys = frozenset({"ToFollow", "OnlyWithinSight", "FOVRadians", _MISSPELT, "MinDistance", "FollowSocket"})
    other = "ToFollow"

    def judge(self, motion: AgentMotion) -> tuple[float, bool]:
        seen = self.seen(self.agent_name, self.config["ToFollow"])
        return (_FULL * (1 - self.share(motion)) if seen else 0.0), False


class AvoidTask(_Sighted):
    """0 to 100: the farther from the agent that is avoided, the more; 100 where it does not see this one."""

    sensor_type = "AvoidTask"
    keys = frozenset({"ToAvoid", "OnlyWithinSight", "FOVRadians", _MISSPELT, "MinDistance", "StartSocket", "EndSocket"})
    other = "ToAvoid"

    def judge(self, motion: AgentMotion) -> tuple[float, bool]:
        seen = self.seen(self.config["ToAvoid"], self.agent_name)
        return (_FULL * self.share(motion) if seen else _FULL), False


class _OfLevels(_Task):
    """Tasks of levels that Pelagos does not have."""

    def __new__(cls, *_: Any) -> Self:
        raise HoloOceanConfigurationException(
            f"{cls.sensor_type} belongs to a level with cups or trash on a table, for hands: Pelagos has none"
        )


class CupGameTask(_OfLevels):
    """Of hands that lift cups."""

    sensor_type = "CupGameTask"

    def start_game(self, num_shuffles: int, speed: int = 3, seed: int | None = None) -> None:
        """Nothing: no environment has this sensor."""


class CleanUpTask(_OfLevels):
    """Of hands that clear trash away."""

    sensor_type = "CleanUpTask"

    def start_task(self, num_trash: int, use_table: bool = False) -> None:
        """Nothing: no environment has this sensor."""
