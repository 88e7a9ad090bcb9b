"""An obstacle alarm of your own from a pattern of rays and what to read from their hits. Prints one reading."""

from typing import ClassVar, Literal

import drjit as dr
import numpy as np
from pydantic import Field

from pelagos import jit
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.ray_sensor import RaySensor
from pelagos.sensors.sensor import SensorConfig, SensorContext


class AlarmConfig(SensorConfig):
    """Keys of the alarm."""

    type: Literal["alarm"] = "alarm"
    rate_hz: float = Field(default=10.0, gt=0)
    """Readings per second [Hz]."""
    range_max_m: float = Field(default=30.0, gt=0)
    """How far it looks [m]."""
    noise_relative: float = Field(default=0.01, ge=0)
    """Standard deviation in parts of the range."""


class Alarm(RaySensor):
    """`data` `(m,)`: range of the nearest thing in a cone of 10 degrees ahead [m]; extra `echo_s`, its travel time."""

    Config: ClassVar[type[SensorConfig]] = AlarmConfig

    def pattern(self, config):
        around = np.linspace(0, 2 * np.pi, 16, endpoint=False)
        edge = np.tan(np.radians(10.0))
        return np.stack([np.ones(16), edge * np.cos(around), edge * np.sin(around)], axis=1)

    def read(self, hits, medium, draw, rays):
        nearest = jit.Float64(dr.block_reduce(dr.ReduceOp.Min, hits.t, rays))
        (white,) = draw(1)
        measured = nearest * (1 + self.config.noise_relative * white)
        return {
            "data": measured,
            "truth": nearest,
            "valid": nearest < dr.inf,
            "echo_s": 2 * nearest / medium.sound_speed,
        }


if __name__ == "__main__":
    context = SensorContext.alone(world={"type": "flat", "depth_m": 20.0})
    sensor = Alarm(AlarmConfig(orientation_deg=(0, 30, 0)), context)
    reading = sensor.sense(lanes([7], dt_ns=100_000_000, position=(0.0, 0.0, -12.0)))
    print(
        f"{reading.data[0]:.3f} m for {reading.truth[0]:.3f} m, echo after {1e3 * reading.extras['echo_s'][0]:.3f} ms"
    )
