"""Sound velocity probe."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from pelagos.jit import Array
from pelagos.ocean.ocean import Ocean
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.water.sample.probe import Probe, ProbeConfig


class SoundVelocityConfig(ProbeConfig):
    """A sound velocity probe; figures where not given: Valeport miniSVS 100 mm, accuracy 0.017 m/s, resolution 0.001
    m/s.
    """

    type: Literal["sound_velocity"] = "sound_velocity"
    """The sensor's kind."""
    noise_density: float = Field(default=0.002, ge=0)
    """White noise [m/s/sqrt(Hz)]."""
    bias_std: float = Field(default=0.006, ge=0)
    """Standard deviation of the constant offset, drawn once a run [m/s]."""
    resolution: float = Field(default=0.001, ge=0)
    """Step of the digital output [m/s]; 0 for none."""
    lowest: float | None = 1375.0
    """Smallest reading [m/s]."""
    highest: float | None = 1900.0
    """Largest reading [m/s]."""


class SoundVelocity:
    """Speed of sound in the water around the mount.

    Reading: `data` `(n,)` [m/s]; none in the air.
    """

    Config: ClassVar[type[SensorConfig]] = SoundVelocityConfig
    TITLE: ClassVar[str] = "Sound velocity probe"
    KERNELS: ClassVar[int] = 1
    CASTS: ClassVar[int] = 0
    SEES_SCENE: ClassVar[bool] = False
    SOURCES: ClassVar[tuple[str, ...]] = ("Valeport, miniSVS data sheet: default figures",)

    def __init__(self, config: SoundVelocityConfig, context: SensorContext) -> None:
        self._probe = Probe(config, context, _sample)

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the sensor on every lane of `motion`."""
        return self._probe.sense(motion)


def _sample(ocean: Ocean, motion: Kinematics, position: Array, t: Array) -> list[Array]:
    return [ocean.sound_speed(position, t)]
