"""Collision: whether the hull has touched something since the last reading, and how hard."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos.config.rate import Rate
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


@dataclass
class Blows:
    """Recent collisions of hulls; the simulation keeps them for the agents that are `asked` for.

    Attributes:
        asked: agents that carry a collision sensor.
        latest: (agent, ticks) -> `(n, 6)`, of the last so many ticks the contact with the greatest force [N] and its
            moment about the body's origin [N m], FLU; set by the simulation.
    """

    asked: set[str] = field(default_factory=set)
    latest: Callable[[str, int], NDArray[np.float64]] | None = None


class CollisionConfig(SensorConfig):
    """A contact switch around the whole hull."""

    type: Literal["collision"] = "collision"
    """The sensor's kind."""
    rate_hz: Rate = 50.0
    """Readings per second [Hz]; must divide the tick rate."""
    least_force_n: float = Field(default=0.0, ge=0)
    """Contact forces up to this do not count [N]."""


class Collision:
    """Whether the hull touches seabed, walls, bodies or other vehicles.

    Reading: `data` `(n, 1)` bool, true if at any tick since the last reading; extras `force` `(n, 3)` [N] and `moment`
    `(n, 3)` about the body's origin [N m], body FLU, of the strongest contact in that time.
    """

    Config: ClassVar[type[SensorConfig]] = CollisionConfig
    TITLE: ClassVar[str] = "Contact of the hull with anything, and its force"
    KERNELS: ClassVar[int] = 0
    CASTS: ClassVar[int] = 0
    ASKS_SCENE: ClassVar[bool] = False
    OF_A_RUN: ClassVar[bool] = True
    SOURCES: ClassVar[tuple[str, ...]] = ()

    def __init__(self, config: CollisionConfig, context: SensorContext) -> None:
        self._least = config.least_force_n
        self._agent = context.path.split(".")[0]  # of several, the first
        self._ticks = max(round(1e9 / (config.rate_hz * context.dt_ns)), 1)
        self._blows = context.blows
        if self._blows is not None:
            self._blows.asked.add(self._agent)

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the switch on every lane of `motion`."""
        wrench = self._wrench(motion)
        touched = (np.linalg.norm(wrench[:, :3], axis=1) > self._least)[:, None]
        return Measurement(data=touched, truth=touched, extras={"force": wrench[:, :3], "moment": wrench[:, 3:]})

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one reading: (name, values, unit)."""
        wrench = self._wrench(motion)
        return [("contact force", wrench[:, :3], "N"), ("contact moment", wrench[:, 3:], "N m")]

    def _wrench(self, motion: Kinematics) -> NDArray[np.float64]:
        copies = np.array(motion.copy)
        if self._blows is None or self._blows.latest is None:
            return np.zeros((len(copies), 6))
        return np.asarray(self._blows.latest(self._agent, self._ticks)[copies])
