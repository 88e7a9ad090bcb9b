"""A depth sounder of your own in NumPy: one ray straight down, one range with noise. Prints five readings."""

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from pelagos.config.loader import load_scenario
from pelagos.math.so3 import rotate_np
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.world.build import build_world


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

    def __init__(self, config: PlumbConfig, context: SensorContext) -> None:
        self.config, self.context = config, context

    def sense(self, motion: Kinematics) -> Measurement:
        position, attitude = np.array(motion.position).T, np.array(motion.attitude).T  # (m, 3), (m, 4)
        down = rotate_np(attitude, np.broadcast_to([0.0, 0.0, -1.0], position.shape))
        hits = self.context.cast(motion, position, down, 100.0)
        truth = np.where(hits.valid, hits.t, np.nan)[:, None]
        # noise by tick and copy: a reading must not depend on which readings were asked for before
        draws = [
            np.random.default_rng([self.context.seed, tick, copy]).standard_normal()
            for tick, copy in zip(np.array(motion.tick), np.array(motion.environment), strict=True)
        ]
        return Measurement(truth + self.config.noise_m * np.array(draws)[:, None], truth)


if __name__ == "__main__":
    scenario = load_scenario({"world": {"type": "flat", "depth_m": 20.0}, "agents": {}})
    sensor = Plumb(PlumbConfig(), SensorContext.alone("me.plumb", world=build_world(scenario.world)))
    reading = sensor.sense(lanes(range(5), dt_ns=200_000_000, position=(3.0, -2.0, -4.0)))
    print(np.round(reading.data[:, 0], 3), "for", reading.truth[:, 0])
