"""Pose: where the mount truly is. For control experiments and as the reference of estimators."""

from __future__ import annotations

from typing import ClassVar, Literal

from pelagos.config.rate import Rate
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.recorded import Program, Results
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


class PoseConfig(SensorConfig):
    """The true pose of the mount."""

    type: Literal["pose"] = "pose"
    """The sensor's kind."""
    rate_hz: Rate = 50.0
    """Samples per second [Hz]; must divide the tick rate."""


class Pose:
    """True position and attitude of the mount.

    Reading: `data` `(n, 7)`: x, y, z in the world NWU [m]; quaternion w, x, y, z, sensor frame to world.
    """

    Config: ClassVar[type[SensorConfig]] = PoseConfig
    TITLE: ClassVar[str] = "True position and attitude"
    KERNELS: ClassVar[int] = 1
    CASTS: ClassVar[int] = 0
    SEES_SCENE: ClassVar[bool] = False
    SOURCES: ClassVar[tuple[str, ...]] = ()

    def __init__(self, config: PoseConfig, context: SensorContext) -> None:
        self._config = config
        self._program = Program(self._kernel)

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the sensor on every lane of `motion`."""
        pose = self._program(motion)["pose"]
        return Measurement(data=pose, truth=pose)

    def _kernel(self, motion: Kinematics) -> Results:
        position, attitude = sensor_pose(motion, self._config)
        return {"pose": [*position, *attitude]}
