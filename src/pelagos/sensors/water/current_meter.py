"""Current meter: velocity of the water past the mount."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from pelagos.jit import Array
from pelagos.math.so3 import rotate_back
from pelagos.ocean.ocean import Ocean
from pelagos.sensors.mount import sensor_velocity, to_sensor
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.water.sample.probe import Probe, ProbeConfig, Sample


class CurrentMeterConfig(ProbeConfig):
    """An acoustic current meter; figures where not given: Nortek Vector, accuracy 0.5 % or 1 mm/s, noise 1 % of 1 m/s
    at 25 Hz.
    """

    type: Literal["current_meter"] = "current_meter"
    """The sensor's kind."""
    noise_density: float = Field(default=0.002, ge=0)
    """White noise of each component [m/s/sqrt(Hz)]."""
    bias_std: float = Field(default=0.0005, ge=0)
    """Standard deviation of the constant offset, drawn once a run and component [m/s]."""
    lowest: float | None = -7.0
    """Smallest reading [m/s]."""
    highest: float | None = 7.0
    """Largest reading [m/s]."""


class CurrentMeter:
    """Velocity of the water relative to the mount: current and orbital motion of waves, minus the own motion.

    Reading: `data` `(n, 3)` sensor frame FLU [m/s]; none in the air. The hull does not disturb the flow.
    """

    Config: ClassVar[type[SensorConfig]] = CurrentMeterConfig
    TITLE: ClassVar[str] = "Current meter: velocity of the water past the sensor"
    KERNELS: ClassVar[int] = 1
    CASTS: ClassVar[int] = 0
    ERRS: ClassVar[bool] = True
    SEES_SCENE: ClassVar[bool] = False
    SOURCES: ClassVar[tuple[str, ...]] = ("Nortek, Vector data sheet: default figures",)

    def __init__(self, config: CurrentMeterConfig, context: SensorContext) -> None:
        self._probe = Probe(config, context, _sampler(config), count=3)

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the sensor on every lane of `motion`."""
        return self._probe.sense(motion)


def _sampler(config: CurrentMeterConfig) -> Sample:
    def sample(ocean: Ocean, motion: Kinematics, position: Array, t: Array) -> list[Array]:
        water = to_sensor(rotate_back(motion.attitude, ocean.flow(position, t, motion.copy)), config)
        return [*(water - sensor_velocity(motion, config))]

    return sample
