"""Velocity: how the mount truly moves over ground."""

from __future__ import annotations

from typing import ClassVar, Literal

from pelagos.config.rate import Rate
from pelagos.math.so3 import rotate
from pelagos.sensors.mount import sensor_pose, sensor_velocity
from pelagos.sensors.recorded import Program, Results
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


class VelocityConfig(SensorConfig):
    """The true velocity of the mount."""

    type: Literal["velocity"] = "velocity"
    """The sensor's kind."""
    rate_hz: Rate = 50.0
    """Samples per second [Hz]; must divide the tick rate."""


class Velocity:
    """True velocity of the mount over ground.

    Reading: `data` `(n, 3)` world NWU [m/s].
    """

    Config: ClassVar[type[SensorConfig]] = VelocityConfig
    TITLE: ClassVar[str] = "True velocity over ground"
    KERNELS: ClassVar[int] = 1
    CASTS: ClassVar[int] = 0
    SEES_SCENE: ClassVar[bool] = False
    SOURCES: ClassVar[tuple[str, ...]] = ()

    def __init__(self, config: VelocityConfig, context: SensorContext) -> None:
        self._config = config
        self._program = Program(self._kernel)

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the sensor on every lane of `motion`."""
        velocity = self._program(motion)["velocity"]
        return Measurement(data=velocity, truth=velocity)

    def _kernel(self, motion: Kinematics) -> Results:
        _, attitude = sensor_pose(motion, self._config)
        return {"velocity": rotate(attitude, sensor_velocity(motion, self._config))}
