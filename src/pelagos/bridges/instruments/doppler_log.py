"""`DopplerLog`: parts that all Doppler velocity logs share, whatever language they speak."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any

from pelagos.bridges.autopilot import motion_of
from pelagos.bridges.instruments import teledyne
from pelagos.bridges.instruments.dvl_velocity import DvlVelocity
from pelagos.bridges.instruments.speaker import Place, Silent


class DopplerLog(Silent, ABC):
    """A log without requests; it goes on without bottom lock, and says that it has none."""

    tells_loss = True

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.before_ns = 0
        self.number = 0

    def begin(self) -> None:
        """See `Speaker`."""
        self.before_ns = self.number = 0

    def hear(self, reading: Any) -> bytes:
        """See `Speaker`."""
        self.number += 1
        dvl = DvlVelocity.of(reading, self.place.config.beams)
        raw = self.say(dvl)
        self.before_ns = dvl.t_ns
        return raw

    @abstractmethod
    def say(self, dvl: DvlVelocity) -> bytes:
        """In this log's language."""

    def attitude(self) -> teledyne.Attitude:
        """By the log's own compass and inclinometers."""
        motion = motion_of(self.place.sim, self.place.agent)
        roll, pitch, yaw = (math.degrees(a) for a in motion.euler)
        return teledyne.Attitude(yaw, pitch, roll, motion.position[2])

    def down(self) -> tuple[float, ...]:
        """The downward part of each beam's direction."""
        return tuple(-float(b[2]) for b in self.place.config.beams)
