"""Acoustic beacons and optical modems: what is received, and who is who."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pelagos.compat.holoocean.exceptions import HoloOceanConfigurationException
from pelagos.compat.holoocean.sensor import HoloOceanSensor
from pelagos.sensors.sensor import Reading

if TYPE_CHECKING:
    from pelagos.compat.holoocean.motion import AgentMotion


class _Station(HoloOceanSensor):
    """A station of a medium, by its number; a value is there at every tick at which a message came in."""

    registry = ""
    every_tick = True

    @property
    def data_shape(self) -> Sequence[int]:
        return [0]

    def zero(self) -> Any:
        return None

    def setup(self) -> None:
        known = self.env.stations(self.registry)
        number = self.config.get("id")
        self.id = next(i for i in range(len(known) + 1) if i not in known) if number is None else int(number)
        if self.id in known:
            raise HoloOceanConfigurationException(f"two {self.sensor_type} have the id {self.id}")
        known[self.id] = self
        self.inbox: list[Any] = []
        self.distance_noise = self.noise("Distance", 1)

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        return self.inbox.pop(0) if self.inbox else None

    def within(self, distance: float, default: float | None) -> bool:
        """Whether a distance [m] is within `MaxDistance`, with its noise."""
        most = self.config.get("MaxDistance", default)
        return most is None or distance <= float(most) + float(np.ravel(self.distance_noise.draw(self.stream))[0])


class AcousticBeaconSensor(_Station):
    """Messages as lists: type, sender, data, and what the type adds."""

    sensor_type = "AcousticBeaconSensor"
    keys = frozenset({"id", "CheckVisible", "MaxDistance", "DistanceSigma", "DistanceCov"})
    registry = "beacons"

    def setup(self) -> None:
        super().setup()
        self.status = "Idle"

    def reset(self) -> None:
        self.status = "Idle"
        self.inbox.clear()


class OpticalModemSensor(_Station):
    """Messages as they were sent."""

    sensor_type = "OpticalModemSensor"
    keys = frozenset(
        {
            "id", "MaxDistance", "DistanceSigma", "DistanceCov", "LaserAngle", "AngleSigma", "AngleCov", "LaserDebug",
            "DebugNumSides", "DebugColor",
        }
    )  # fmt: skip
    registry = "modems"

    def setup(self) -> None:
        super().setup()
        self.angle_noise = self.noise("Angle", 1)

    def looks_at(self, axes: Any, line: Any) -> bool:
        """Whether a direction (3) in the world lies within the cone about its x axis."""
        cosine = float(np.clip(axes[:, 0] @ line, -1.0, 1.0))
        half = float(self.config.get("LaserAngle", 60)) + float(np.ravel(self.angle_noise.draw(self.stream))[0])
        return float(np.degrees(np.arccos(cosine))) <= half

    def reset(self) -> None:
        self.inbox.clear()
