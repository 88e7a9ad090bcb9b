"""A depth sounder of your own in NumPy: one ray straight down, one range with noise. Prints five readings."""

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from pelagos.math.so3 import rotate_np
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.noise import NumpyNoise
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


class PlumbConfig(SensorConfig):
    """Keys of the sounder; those of every sensor (rate, place, orientation) come with `SensorConfig`."""

    type: Literal["plumb"] = "plumb"
    rate_hz: float = Field(default=5.0, gt=0)
    """Readings per second [Hz]."""
    noise_m: float = Field(default=0.02, ge=0)
    """Standard deviation of a range [m]."""


class Plumb:
    """`data` `(m, 1)`: distance along -z of the vehicle [m], NaN where nothing is within 100 m."""

    Config: ClassVar[type[SensorConfig]] = PlumbConfig
    MAY_LACK: ClassVar[bool] = True

    def __init__(self, config: PlumbConfig, context: SensorContext) -> None:
        self.config, self.context = config, context
        self.noise = NumpyNoise(context.seed, context.path)

    def sense(self, motion: Kinematics) -> Measurement:
        position, attitude = np.array(motion.position).T, np.array(motion.attitude).T  # (m, 3), (m, 4)
        down = rotate_np(attitude, np.broadcast_to([0.0, 0.0, -1.0], position.shape))
        hits = self.context.cast(motion, position, down, 100.0)
        truth = np.where(hits.valid, hits.t, np.nan)[:, None]
        return Measurement(truth + self.config.noise_m * self.noise.normals(motion), truth)


if __name__ == "__main__":
    context = SensorContext.alone("me.plumb", world={"type": "flat", "depth_m": 20.0})
    sensor = Plumb(PlumbConfig(), context)
    reading = sensor.sense(lanes(range(5), dt_ns=200_000_000, position=(3.0, -2.0, -4.0)))
    print(np.round(reading.data[:, 0], 3), "for", reading.truth[:, 0])
