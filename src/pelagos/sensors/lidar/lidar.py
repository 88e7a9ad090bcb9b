"""A LiDAR: points with intensity, in the sensor's frame.

Data and truth are `(m, channels, steps, 4)` float32: x, y, z [m] and intensity 0 .. 1, NaN where a pulse gave no
point. The first axis after the lanes is the ring. `points` lists those that are there as CARLA and ROS do. In truth
nothing is dropped, and range has no noise. Extra `horizontal_angle_rad` `(m,)`: how far the scanner has turned at the
end of the sample, clockwise from the left edge of its field.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.philox import normal_pair32, uniform32
from pelagos.optics.atmosphere import fog_extinction, rain_extinction
from pelagos.optics.water import WaterArrays, several
from pelagos.sensors.camera.picture.camera_rays import Trace
from pelagos.sensors.camera.picture.turbid_sight import suspended_tracers, suspended_water
from pelagos.sensors.lidar.scan.laser import Echoes, LaserConfig
from pelagos.sensors.lidar.scan.scanner import Returns, Scanner, cloud, ring_of
from pelagos.sensors.noise import opaque_key, stream_key, words32
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean

_WAVELENGTH_NM: Final = 905.0


class LidarConfig(LaserConfig):
    """A LiDAR with intensity, dropout and noise."""

    type: Literal["lidar"] = "lidar"
    """The sensor's kind."""
    atmosphere_attenuation_rate: float = Field(default=0.004, ge=0)
    """Intensity falls as exp(-rate d) with the way d in air [1/m]; the weather's fog and rain come on top of it."""
    water_attenuation_rate: float | None = Field(default=None, ge=0)
    """The same under water [1/m]; None: twice the green beam attenuation of the ocean's water (there and back), with
    the plankton and sediment that are at the scanner."""
    reflectance: bool = False
    """Whether intensity also carries the surface's green albedo and the cosine of incidence, or only the way."""
    dropoff_general_rate: float = Field(default=0.45, ge=0, le=1)
    """Share of points that are dropped at random."""
    dropoff_intensity_limit: float = Field(default=0.8, gt=0, le=1)
    """Intensity above which no point is dropped for its weakness."""
    dropoff_zero_intensity: float = Field(default=0.4, ge=0, le=1)
    """Probability that a point of no intensity is dropped; it falls linearly to the limit."""
    noise_stddev_m: float = Field(default=0.0, ge=0)
    """Standard deviation of range [m]."""


class Lidar:
    """See `LidarConfig`."""

    TITLE: ClassVar[str] = "LiDAR: points with intensity, in air and water, as CARLA defines it"
    KERNELS: ClassVar[int] = 12
    CASTS: ClassVar[int] = 1
    MAY_LACK: ClassVar[bool] = True
    Config: ClassVar[type[SensorConfig]] = LidarConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "Parameters and dropout: CARLA documentation, Sensors reference, LIDAR sensor (release 0.9)",
    )

    def __init__(self, config: LidarConfig, context: SensorContext) -> None:
        self.config = config
        albedo = jit.Float(np.array(context.world.material_tables().albedo)[1])
        rate, ocean = config.water_attenuation_rate, context.ocean
        in_water = 2 * ocean.water.attenuation[1] if rate is None else rate
        uneven = bool(suspended_tracers(ocean) or ocean.turbidities)
        murk = (ocean, several(ocean.waters or [ocean.water])) if rate is None and uneven else None
        weather = ocean.weather
        in_air = config.atmosphere_attenuation_rate + 2 * (
            fog_extinction(weather.visibility, _WAVELENGTH_NM) + rain_extinction(weather.rain)
        )
        rates = tuple(dr.opaque(jit.Float, r) for r in (in_air, in_water))
        key = opaque_key(stream_key(context.seed, context.path, "lidar"))
        jit.align(albedo)
        self._scanner = Scanner(config, context, self._points, (albedo, rates, key, murk))

    def sense(self, motion: Kinematics) -> Measurement:
        """One sample for every lane."""
        data, truth = self._scanner.samples(motion)
        return Measurement(data=data, truth=truth, extras={"horizontal_angle_rad": self._scanner.angle(motion)})

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen sample: (name, values, unit)."""
        return self._scanner.explain(motion)

    def _points(self, heard: Returns, extra: Any, trace: Trace | None) -> tuple[Array, Array]:
        """Points with dropout and noise, and all of them without noise."""
        config, echo = self.config, heard.echo
        albedo, rates, key, murk = extra
        if murk is not None:
            rates = rates[0], rate_in_murk(heard, *murk)
        intensity = echo_intensity(echo, albedo, rates, reflectance=config.reflectance)
        words = words32(key, heard.pulse, heard.environment, heard.tick)
        kept = echo.valid & survives(intensity, words, config)
        distance = echo.distance + config.noise_stddev_m * normal_pair32(words[2], words[3])[0]
        if trace is not None:
            trace("intensity", intensity, "1")
            trace("kept", kept, "")
        data = cloud(echo.direction, distance, intensity, kept)
        return data, cloud(echo.direction, echo.distance, intensity, echo.valid)


def echo_intensity(echo: Echoes, albedo: Array, rates: tuple[Array, Array], *, reflectance: bool) -> Array:
    """exp(-rate d), each medium at its own rate; times albedo and cosine of incidence where the surface counts."""
    intensity = dr.exp(-(rates[0] * echo.in_air + rates[1] * echo.in_water))
    if reflectance:
        intensity *= dr.gather(jit.Float, albedo, echo.material, echo.valid) * echo.incidence
    return intensity


def rate_in_murk(heard: Returns, ocean: Ocean, clear: WaterArrays) -> Array:
    """Rate at which intensity falls in water with plankton and sediment, as they are at the scanner, or at the surface
    below one in air, by pulse [1/m]: twice the green beam attenuation."""
    if heard.turbidity is not None:
        clear = clear.of(heard.turbidity)
    at = jit.Array3f64(heard.place.x, heard.place.y, dr.minimum(heard.place.z, 0))
    green = jit.Float(suspended_water(ocean, clear, at, heard.t).attenuation[1])
    dr.eval(green)
    return 2 * dr.gather(jit.Float, green, heard.lane)


def survives(intensity: Array, words: tuple[Array, Array, Array, Array], config: LidarConfig) -> Array:
    """`Bool`: kept by the general dropout, and by that of weak points: 1 - z (1 - I / limit) of them stay."""
    general = uniform32(words[0]) >= config.dropoff_general_rate
    stay = 1 - config.dropoff_zero_intensity * (1 - intensity / config.dropoff_intensity_limit)
    return general & ((intensity >= config.dropoff_intensity_limit) | (uniform32(words[1]) < stay))


def points(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """`(channels, steps, 4)` of one copy -> its points `(k, 5)`: x, y, z, intensity, ring; ring by ring."""
    there, ring = ring_of(image)
    return np.concatenate([image[there], ring[:, None].astype(np.float32)], axis=1)
