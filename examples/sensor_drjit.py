"""A turn-rate meter of your own in Dr.Jit arrays: recorded once, replayed for every reading. Prints its statistics."""

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from pelagos.sensors import noise
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.mount import sensor_angular_velocity
from pelagos.sensors.recorded import Program, Results
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


class TurnRateConfig(SensorConfig):
    """Keys of the meter."""

    type: Literal["turn_rate"] = "turn_rate"
    rate_hz: float = Field(default=50.0, gt=0)
    """Readings per second [Hz]."""
    noise_rad_s: float = Field(default=0.01, ge=0)
    """Standard deviation of a reading [rad/s]."""


class TurnRate:
    """`data` `(m,)`: angular velocity about the mount's z axis [rad/s]."""

    Config: ClassVar[type[SensorConfig]] = TurnRateConfig
    SEES_SCENE: ClassVar[bool] = False

    def __init__(self, config: TurnRateConfig, context: SensorContext) -> None:
        self.config = config
        self.key = noise.opaque_key(noise.stream_key(context.seed, context.path, "noise"))
        self.program = Program(self.kernel)

    def sense(self, motion: Kinematics) -> Measurement:
        found = self.program(motion, self.key)  # every array is an argument
        return Measurement(found["data"], found["truth"])

    def kernel(self, motion: Kinematics, key: noise.Key) -> Results:
        rate = sensor_angular_velocity(motion, self.config)[2]
        (white,) = noise.normals64(key, motion, 1)
        return {"data": rate + self.config.noise_rad_s * white, "truth": rate}


if __name__ == "__main__":
    sensor = TurnRate(TurnRateConfig(), SensorContext.alone("me.turn_rate", seed=4))
    reading = sensor.sense(lanes(range(10_000), dt_ns=20_000_000, angular_velocity=(0.1, -0.2, 0.3)))
    print(f"mean {np.mean(reading.data):.4f} rad/s, standard deviation {np.std(reading.data):.4f} rad/s")
