"""A thermal camera for work above water: apparent temperature in the long-wave infrared.

Data and truth are `(m, height, width)` float32 [degC]. Water is opaque to these waves, so that under water everything
has the water's temperature, and the sea shows its own and, at grazing angles, the sky's. Solids have the air's
temperature, plus what the sun adds.

Power of the band is taken to go with the fourth power of temperature, as that of all heat radiation does (Stefan and
Boltzmann): mixing emitted and reflected power that way stays within 0.1 K of Planck's law over 8-14 um between 260
and 320 K.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.philox import normal_pair32
from pelagos.optics.interface import fresnel
from pelagos.optics.sunlight import LightArrays
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Hits, Rays
from pelagos.sensors.camera.picture.camera_rays import Imager, Lens, Trace, ViewConfig, view_rays
from pelagos.sensors.camera.picture.pixel_order import image_rows, pixels
from pelagos.sensors.camera.picture.sea_crossing import Crossing, level_over, sea_crossing, uneven_sea
from pelagos.sensors.camera.picture.surroundings import Surroundings
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.noise import Key, opaque_key, stream_key, words32
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean

_ZERO_C: Final = 273.15
_EFFICACY: Final = 105.0  # [lm/W] of sunlight (P. J. Littlefair 1985)
_INFRARED_INDEX: Final = 1.22  # of water, mean of 8-14 um (G. M. Hale and M. R. Querry 1973, doi 10.1364/AO.12.000555)
_EMISSIVITY: Final = 0.95  # of paint, stone, wood, growth
_EXCHANGE: Final = 22.0  # [W/m^2/K] between a surface and still air, convection and radiation; assumed
_HORIZON_LOSS: Final = 0.35  # how much of the sky's coldness is left at the horizon; assumed


class ThermalCameraConfig(ViewConfig):
    """A thermal camera (surface use)."""

    type: Literal["thermal_camera"] = "thermal_camera"
    """The sensor's kind."""
    max_range_m: float = Field(default=500.0, gt=0)
    """How far to look for surfaces [m]."""
    air_c: float = Field(default=15.0, ge=-60, le=60)
    """Temperature of the air [degC]."""
    sky_c: float = Field(default=-25.0, ge=-120, le=40)
    """Apparent temperature of the sky overhead [degC]; clear and dry is colder than overcast."""
    attenuation_per_km: float = Field(default=0.2, ge=0, le=10)
    """Loss in the air [1/km]; 0.2 in a humid marine atmosphere."""
    noise_k: float = Field(default=0.05, ge=0)
    """Noise-equivalent temperature difference [K]."""


class ThermalCamera:
    """See `ThermalCameraConfig`."""

    TITLE: ClassVar[str] = "thermal camera: apparent temperature, above water"
    KERNELS: ClassVar[int] = 8
    CASTS: ClassVar[int] = 2
    Config: ClassVar[type[SensorConfig]] = ThermalCameraConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "Water in the infrared: G. M. Hale and M. R. Querry, Appl. Opt. 12:555 (1973), doi 10.1364/AO.12.000555",
    )

    def __init__(self, config: ThermalCameraConfig, context: SensorContext) -> None:
        self.config, self._context = config, context
        self._view = Imager(config, context)
        self._lit = Surroundings(context)
        self._key = opaque_key(stream_key(context.seed, context.path, "thermal"))
        self._recorded = context.scene.compile(self._kernel)

    def sense(self, motion: Kinematics) -> Measurement:
        """One image for every lane."""
        data, truth = self._recorded(*self._arguments(motion))
        return Measurement(data=self._view.images(data, np.float32), truth=self._view.images(truth, np.float32))

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen frame: (name, values, unit)."""
        return self._view.explain(self._kernel, self._arguments(motion))

    def _arguments(self, motion: Kinematics) -> tuple[Any, ...]:
        view, lit = self._view.arguments(motion), self._lit
        return *view, lit.looks.albedo, lit.light, self._context.ocean, self._key

    def _kernel(
        self,
        caster: Caster,
        lens: Lens,
        motion: Kinematics,
        own: Array,
        albedo: Array,
        light: LightArrays,
        ocean: Ocean,
        key: Key,
        *,
        trace: Trace | None = None,
    ) -> tuple[Array, Array]:
        config, tiling = self.config, self._view.tiling
        images = dr.width(motion.tick)
        where = pixels(tiling, images)
        position, _ = sensor_pose(motion, config)
        uneven = uneven_sea(ocean)
        level = None if lens.dry is None or uneven is None else level_over(uneven, position, motion.t_ns, motion.copy)
        rays = view_rays(lens, where, motion, own, config, level)
        hits = caster.cast(rays)
        towards = light.towards_sun
        facing = dr.maximum(dr.dot(hits.normal, towards), 0)
        start = hits.position + jit.Array3f64(hits.normal) * 2e-3
        sunny = hits.valid & (facing > 0)
        shadow = Rays(start, towards, dr.select(sunny, jit.Float(200), 0), rays.copy, rays.own)
        facing = dr.select(sunny & ~caster.occluded(shadow), facing, 0)
        colour = dr.gather(jit.Array3f, albedo, hits.material, hits.valid)
        absorbed = dr.mean((1 - colour) * light.sun) * facing / _EFFICACY  # [W/m^2]
        solid = config.air_c + absorbed / _EXCHANGE
        surface = jit.Array3f64(0, 0, 0)
        t = jit.Float64(motion.t_ns) * 1e-9
        sea = jit.Float(ocean.temperature(surface, t)) + dr.zeros(jit.Float, images)
        sea = dr.gather(jit.Float, sea, where.image)
        crossing = sea_crossing(rays, where.image, uneven, position, motion.t_ns, motion.copy)
        kelvin = apparent(rays, hits, solid, sea, crossing, config)
        environment, tick = (dr.gather(jit.UInt32, v, where.image) for v in (motion.environment, motion.tick))
        words = words32(key, where.row * tiling.width + where.column, environment, tick)
        data = kelvin + config.noise_k * normal_pair32(words[0], words[1])[0]
        if trace is not None:
            trace("slant range", hits.t, "m")
            trace("temperature of solids", solid, "degC")
            trace("apparent temperature", kelvin - _ZERO_C, "degC")
        return tuple(image_rows(v - _ZERO_C, tiling, where, images) for v in (data, kelvin))


def apparent(
    rays: Rays, hits: Hits, solid: Array, sea: Array, crossing: Crossing, config: ThermalCameraConfig
) -> Array:
    """Apparent temperature [K] along rays, from temperatures [degC] of what they may meet."""
    rise, hit = rays.direction.z, hits.valid
    at_sea = crossing.way < dr.minimum(hits.t, rays.max_range)
    sky = sky_power(dr.abs(rise), config)
    mirror = fresnel(dr.abs(rise), _INFRARED_INDEX)
    sea_power = dr.lerp(_power(sea), sky, mirror)
    solid_power = dr.lerp(sky_power(jit.Float(0.5), config), _power(solid), _EMISSIVITY)
    way = dr.select(at_sea, crossing.way, hits.t)
    kept = dr.exp(-config.attenuation_per_km * 1e-3 * dr.select(at_sea | hit, way, 0))
    power = dr.select(at_sea, sea_power, dr.select(hit, solid_power, sky))
    power = dr.lerp(_power(jit.Float(config.air_c)), power, kept)
    return dr.select(crossing.under, sea + _ZERO_C, dr.sqrt(dr.sqrt(power)) * 100)


def sky_power(rise: Array, config: ThermalCameraConfig) -> Array:
    """The sky at an elevation of sine `rise`: towards the horizon the way through warm air grows."""
    warm = dr.exp(-rise / _HORIZON_LOSS)
    return dr.lerp(_power(jit.Float(config.sky_c)), _power(jit.Float(config.air_c)), warm)


def _power(celsius: Array) -> Array:
    """Fourth power of the temperature over 100 K: of the size of 1."""
    t = (celsius + _ZERO_C) * 0.01
    return t * t * t * t
