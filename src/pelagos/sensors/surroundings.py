"""What lights a camera's view: sun, sky and water of the ocean, materials of the world, waves, the vehicle's lamps."""

from __future__ import annotations

import math
from typing import Any

import drjit as dr
from pydantic import Field

from pelagos import jit
from pelagos.config.strict import Strict
from pelagos.jit import Array
from pelagos.math.so3 import from_euler, rotate
from pelagos.optics.atmosphere import under_weather
from pelagos.optics.caustics import Ripple, Waves, sea_level, waves_at
from pelagos.optics.lamp import Beam, axis_intensity
from pelagos.optics.light_field import light_field
from pelagos.optics.sunlight import daylight
from pelagos.optics.swell import swell_around
from pelagos.optics.texture import looks
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.scenery import Scenery
from pelagos.sensors.sensor import Kinematics, SensorConfig, SensorContext
from pelagos.sensors.view import ViewConfig


class LampConfig(Strict):
    """A lamp on the vehicle."""

    position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Place in the body frame, forward-left-up of the vehicle's origin [m]."""
    orientation_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Roll, pitch, yaw of the lamp's axis (its x) in the body frame [deg]; positive pitch shines down."""
    flux_lm: float = Field(default=1500.0, gt=0)
    """Luminous flux [lm]."""
    beam_angle_deg: float = Field(default=100.0, gt=1, le=170)
    """Full width of the cone [deg]; the light fades over its outer half."""
    color: tuple[float, float, float] = (1.0, 0.97, 0.92)
    """Colour: linear red, green, blue, relative to daylight."""


class LitViewConfig(ViewConfig):
    """A view that light matters for."""

    lamps: tuple[LampConfig, ...] = ()
    """Lamps that shine when this camera looks."""
    ripple: float = Field(default=0.004, ge=0, le=0.05)
    """Mean square slope of waves of 0.3 to 4 m that make caustics, on top of the ocean's waves."""


class Surroundings:
    """Light, water and materials on the device; none of them changes.

    Args:
        context: see `SensorContext`.

    Attributes:
        looks: of the world's materials.
        light: sun and sky.
    """

    def __init__(self, context: SensorContext) -> None:
        materials = context.world.material_tables()
        self.looks = looks(materials.albedo, materials.texture_scale, [m.texture for m in context.world.palette])
        ocean = context.ocean
        self._water = ocean.water.arrays()
        weather = ocean.weather
        clear = daylight(float(ocean.sun_elevation[0]), -float(ocean.sun_azimuth[0]), cloud=weather.cloud)
        light = under_weather(clear, weather)
        self.light, self._field = light.arrays(), light_field(ocean.water, light)
        self._air = None if weather.clear else weather.air()
        self._ocean = ocean if ocean.waves is not None else None

    def arguments(self) -> tuple[Any, ...]:
        """For `scenery_of`, inside a frozen function."""
        return self.looks, self._water, self.light, self._field, self._air, self._ocean


def scenery_of(
    tables: Any, light: tuple[Any, ...], sea: Ripple, motion: Kinematics, config: SensorConfig, delay: float = 0.0
) -> Scenery:
    """Everything that light depends on, at the moments of `motion` plus `delay` [s]."""
    materials, water, daylit, field, air, ocean = light
    waves = waves_of(sea, ocean, daylit.towards_sun, motion, config, delay)
    position, _ = sensor_pose(motion, config)
    level = sea_level(waves, dr.width(motion.tick))
    t = jit.Float64(motion.t_ns) * 1e-9 + delay
    depth = level - jit.Float(position.z)
    dr.eval(level, depth)
    return Scenery(tables, materials, water, daylit, field, air, waves, level, depth, t)


def waves_of(
    sea: Ripple, ocean: Any, towards_sun: Array, motion: Kinematics, config: SensorConfig, delay: float = 0.0
) -> Waves:
    """The sea surface around the cameras."""
    t = jit.Float64(motion.t_ns) * 1e-9 + delay
    position, _ = sensor_pose(motion, config)
    images = dr.width(motion.tick)
    foam = ocean.waves.foam if ocean is not None and ocean.waves.breaks else None
    swell = None if ocean is None else swell_around(ocean.elevation, position, t, images, foam)
    return waves_at(sea, t, towards_sun, images, swell)


def lamp_beam(lamp: LampConfig, config: SensorConfig, motion: Kinematics, image: Array) -> Beam:
    """A lamp of the vehicle at the moments of the images, by ray."""
    attitude = jit.Array4f(*(jit.Float(motion.attitude[i]) for i in range(4)))
    offset = rotate(attitude, jit.Array3f(*(a - b for a, b in zip(lamp.position_m, config.position_m, strict=True))))
    w, x, y, z = from_euler(*(math.radians(a) for a in lamp.orientation_deg))
    axis = rotate(attitude, rotate(jit.Array4f(w, x, y, z), jit.Array3f(1, 0, 0)))
    half = math.radians(lamp.beam_angle_deg) / 2
    candela = axis_intensity(lamp.flux_lm, 2 * half)
    return Beam(
        position=dr.gather(jit.Array3f, offset, image),
        axis=dr.gather(jit.Array3f, axis, image),
        intensity=jit.Array3f(*(candela * c for c in lamp.color)),
        inner=jit.Float(math.cos(0.5 * half)),
        outer=jit.Float(math.cos(half)),
    )
