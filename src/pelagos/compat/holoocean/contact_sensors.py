"""HoloOcean's sensors of distance and touch, and of numbers that the world keeps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from pelagos.compat.holoocean.exceptions import HoloOceanConfigurationException
from pelagos.compat.holoocean.sensor import HoloOceanSensor
from pelagos.sensors.sensor import Reading

if TYPE_CHECKING:
    from pelagos.compat.holoocean.motion import AgentMotion


class RangeFinderSensor(HoloOceanSensor):
    """Ranges of lasers around the sensor, counter-clockwise from its x axis; -1 without a hit."""

    sensor_type = "RangeFinderSensor"
    keys = frozenset({"LaserMaxDistance", "LaserCount", "LaserAngle", "LaserDebug"})

    @property
    def data_shape(self) -> Sequence[int]:
        return [int(self.config.get("LaserCount", 1))]

    def native(self) -> dict[str, Any] | None:
        count = int(self.config.get("LaserCount", 1))
        return {
            "type": "range_finder",
            "range_max_m": float(self.config.get("LaserMaxDistance", 10)),
            "azimuth_deg": [360.0 * i / count for i in range(count)],
            "elevation_deg": [float(self.config.get("LaserAngle", 0))] * count,
        }

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        assert reading is not None
        return np.where(np.isfinite(reading.data[0]), reading.data[0], -1.0).astype(np.float32)


class CollisionSensor(HoloOceanSensor):
    """True where the hull touched something in the last tick."""

    sensor_type = "CollisionSensor"

    @property
    def data_shape(self) -> Sequence[int]:
        return [1]

    @property
    def dtype(self) -> Any:
        return np.bool_

    def native(self) -> dict[str, Any] | None:
        return {"type": "collision"}

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        return np.array([False]) if reading is None else np.array(reading.data[0], dtype=np.bool_)


class AbuseSensor(HoloOceanSensor):
    """1 where the agent was accelerated beyond `AccelerationLimit`, or lies on its back."""

    sensor_type = "AbuseSensor"
    keys = frozenset({"AccelerationLimit"})

    @property
    def data_shape(self) -> Sequence[int]:
        return [1]

    @property
    def dtype(self) -> Any:
        return np.int8

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        limit = float(self.config.get("AccelerationLimit", self.env.agents[self.agent_name].kind.accel_limit))
        hard = limit >= 0 and float(np.linalg.norm(motion.acceleration)) > limit
        return np.array([hard or motion.rotation[2, 2] < 0], dtype=np.int8)


class WorldNumSensor(HoloOceanSensor):
    """A number that the world keeps by the name `Key`: 0 where nothing was set (`env.world_numbers`)."""

    sensor_type = "WorldNumSensor"
    keys = frozenset({"Key"})
    default: ClassVar[str] = ""

    @property
    def data_shape(self) -> Sequence[int]:
        return [1]

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        number = self.env.world_numbers.get(str(self.config.get("Key", self.default)), 0.0)
        return np.array([number], dtype=self.dtype)


class BallLocationSensor(WorldNumSensor):
    """The world's number "BallLocation"."""

    sensor_type = "BallLocationSensor"
    default = "BallLocation"

    @property
    def dtype(self) -> Any:
        return np.int8


class _OfHands(HoloOceanSensor):
    """Sensors of agents that Pelagos does not have."""

    def __new__(cls, *_: Any) -> Self:  # before anything asks what such a sensor would read
        raise HoloOceanConfigurationException(
            f"{cls.sensor_type} is for AndroidAgent and HandAgent, which have no joints to read in Pelagos"
        )


class JointRotationSensor(_OfHands):
    """Of AndroidAgent and HandAgent."""

    sensor_type = "JointRotationSensor"


class PressureSensor(_OfHands):
    """Of AndroidAgent and HandAgent."""

    sensor_type = "PressureSensor"


class RelativeSkeletalPositionSensor(_OfHands):
    """Of AndroidAgent and HandAgent."""

    sensor_type = "RelativeSkeletalPositionSensor"
