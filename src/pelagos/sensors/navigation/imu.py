"""Inertial measurement unit: three accelerometers and three gyroscopes."""

from __future__ import annotations

import math
from typing import ClassVar, Final, Literal

from pydantic import Field

from pelagos.config.rate import Rate
from pelagos.jit import Array
from pelagos.math.constants import GRAVITY
from pelagos.sensors import noise
from pelagos.sensors.mount import sensor_angular_velocity, specific_force
from pelagos.sensors.noise import digitise
from pelagos.sensors.recorded import Program, Results
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext

_DEG_PER_HOUR: Final = math.radians(1) / 3600


class ImuConfig(SensorConfig):
    """An inertial measurement unit; the figures where not given are those of a tactical-grade MEMS unit.

    Figures: Sensonor STIM300, datasheet TS1524, 10 g accelerometers; its +- limits are taken as three standard
    deviations.
    """

    type: Literal["imu"] = "imu"
    """The sensor's kind."""
    rate_hz: Rate = 200.0
    """Samples per second [Hz]; must divide the tick rate."""
    accelerometer_noise_density: float = Field(default=0.06 / 60, ge=0)
    """White noise (velocity random walk) [m/s^2/sqrt(Hz)]; 0.06 m/s/sqrt(h)."""
    accelerometer_bias_instability: float = Field(default=0.05e-3 * GRAVITY, ge=0)
    """Bias instability B: the Allan deviation has its floor at 0.664 B [m/s^2]; 0.05 mg."""
    accelerometer_random_walk: float = Field(default=0.0, ge=0)
    """Random walk of the bias [m/s^2/sqrt(s)]."""
    accelerometer_bias_std: float = Field(default=0.25e-3 * GRAVITY, ge=0)
    """Standard deviation of the constant bias, drawn once a run and axis [m/s^2]; 0.75 mg is three of them."""
    accelerometer_scale_std: float = Field(default=100e-6, ge=0)
    """Standard deviation of the scale error, drawn once a run and axis [1]; 300 ppm is three of them."""
    accelerometer_range: float = Field(default=10 * GRAVITY, gt=0)
    """Largest reading, either sign [m/s^2]; 10 g."""
    accelerometer_resolution: float = Field(default=1.9e-6 * GRAVITY, ge=0)
    """Step of the digital output [m/s^2]; 0 for none."""
    gyroscope_noise_density: float = Field(default=math.radians(0.15) / 60, ge=0)
    """White noise (angle random walk) [rad/s/sqrt(Hz)]; 0.15 deg/sqrt(h)."""
    gyroscope_bias_instability: float = Field(default=0.5 * _DEG_PER_HOUR, ge=0)
    """Bias instability B: the Allan deviation has its floor at 0.664 B [rad/s]; 0.5 deg/h."""
    gyroscope_random_walk: float = Field(default=0.0, ge=0)
    """Random walk of the bias [rad/s/sqrt(s)]."""
    gyroscope_bias_std: float = Field(default=5 * _DEG_PER_HOUR, ge=0)
    """Standard deviation of the constant bias, drawn once a run and axis [rad/s]; 5 deg/h rms over temperature."""
    gyroscope_scale_std: float = Field(default=167e-6, ge=0)
    """Standard deviation of the scale error, drawn once a run and axis [1]; 500 ppm is three of them."""
    gyroscope_range: float = Field(default=math.radians(400), gt=0)
    """Largest reading, either sign [rad/s]; 400 deg/s."""
    gyroscope_resolution: float = Field(default=0.22 * _DEG_PER_HOUR, ge=0)
    """Step of the digital output [rad/s]; 0 for none."""
    misalignment_std: float = Field(default=0.33e-3, ge=0)
    """Standard deviation of each small angle between an axis and where it should be, drawn once a run [rad]."""
    bias_correlation_time_s: float = Field(default=200.0, gt=0)
    """Correlation time of the bias instability; its Allan deviation peaks at 1.89 times this [s]."""


class Imu:
    """Specific force and angular rate in the sensor frame FLU.

    A reading is clip(quantise((I + S) x + b)), where S holds scale errors and misalignments and b is the sum of a
    constant, a Gauss-Markov process, a random walk and white noise. The Earth's rotation is not part of it: the world
    does not turn.

    Reading: `data` `(n, 6)`: specific force x, y, z [m/s^2] (at rest and level 0, 0, +9.81), angular rate x, y, z
    [rad/s]. Extras: `bias` `(n, 6)`, what was added to `truth` besides white noise, scale and rounding.
    """

    Config: ClassVar[type[SensorConfig]] = ImuConfig
    TITLE: ClassVar[str] = "Inertial measurement unit: specific force and angular rate, with IEEE 952 noise"
    KERNELS: ClassVar[int] = 1
    CASTS: ClassVar[int] = 0
    ERRS: ClassVar[bool] = True
    SEES_SCENE: ClassVar[bool] = False
    SOURCES: ClassVar[tuple[str, ...]] = (
        "IEEE Std 952-1997, Annex C: noise terms of gyroscopes and their Allan deviation",
        "T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), 14.1: lever arm",
        "Sensonor, STIM300 Inertia Measurement Unit, datasheet TS1524: default figures",
    )

    def __init__(self, config: ImuConfig, context: SensorContext) -> None:
        self._config = config
        self._key = noise.opaque_key(noise.stream_key(context.seed, context.path, "noise"))
        self._program = Program(self._kernel)

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the sensor on every lane of `motion`."""
        found = self._program(motion, self._key)
        return Measurement(found["data"], found["truth"], extras={"bias": found["bias"]})

    def _kernel(self, motion: Kinematics, key: noise.Key) -> Results:
        c = self._config
        force, rate = specific_force(motion, c), sensor_angular_velocity(motion, c)
        truth = [*force, *rate]
        white = noise.normals64(key, motion, 6)
        bias = self._bias(motion, key)
        turned = self._distort(motion, key, force, rate)
        density = [c.accelerometer_noise_density] * 3 + [c.gyroscope_noise_density] * 3
        step = [c.accelerometer_resolution] * 3 + [c.gyroscope_resolution] * 3
        limit = [c.accelerometer_range] * 3 + [c.gyroscope_range] * 3
        data = [
            digitise(x + b + n * (d * math.sqrt(c.rate_hz)), resolution=r, lowest=-top, highest=top)
            for x, b, n, d, r, top in zip(turned, bias, white, density, step, limit, strict=True)
        ]
        return {"data": data, "truth": truth, "bias": bias}

    def _bias(self, motion: Kinematics, key: noise.Key) -> list[Array]:
        c = self._config
        constant = noise.constants64(key, motion, 6)
        wander = noise.bias_instability(key, motion, 6, correlation_time=c.bias_correlation_time_s)
        bias = [
            b * s + w * i
            for b, s, w, i in zip(
                constant,
                [c.accelerometer_bias_std] * 3 + [c.gyroscope_bias_std] * 3,
                wander,
                [c.accelerometer_bias_instability] * 3 + [c.gyroscope_bias_instability] * 3,
                strict=True,
            )
        ]
        walk = [c.accelerometer_random_walk] * 3 + [c.gyroscope_random_walk] * 3
        if any(walk):
            bias = [b + k * w for b, k, w in zip(bias, walk, noise.random_walk(key, motion, 6), strict=True)]
        return bias

    def _distort(self, motion: Kinematics, key: noise.Key, force: Array, rate: Array) -> list[Array]:
        """(I + S) x: scale errors on the diagonal of S, misalignments off it, for both triads."""
        c = self._config
        draws = iter(noise.constants64(key, motion, 6 + 18)[6:])
        found: list[Array] = []
        for vector, scale in ((force, c.accelerometer_scale_std), (rate, c.gyroscope_scale_std)):
            for i in range(3):
                std = [scale if j == i else c.misalignment_std for j in range(3)]
                found.append(vector[i] + sum(next(draws) * (s * vector[j]) for j, s in enumerate(std)))
        return found
