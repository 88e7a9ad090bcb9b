"""Surroundings that light a view: sun, sky and water of the ocean, materials of the world, waves, own lamps."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Final, TypeAlias, TypeGuard

import drjit as dr
import numpy as np
from pydantic import Field

from pelagos import jit
from pelagos.config.strict import Strict
from pelagos.jit import Array
from pelagos.math.so3 import from_euler, rotate
from pelagos.ocean.surface_wind import surface_wind, wave_slope
from pelagos.ocean.tracer import OscillationField, UniformField
from pelagos.optics.atmosphere import under_weather
from pelagos.optics.caustics import Ripple, Waves, ripple, sea_level, waves_at
from pelagos.optics.lamp import Beam, axis_intensity
from pelagos.optics.laser_beam import LaserBeam
from pelagos.optics.light_field import LightField, light_field, with_column
from pelagos.optics.light_fields import LightFields, by_place
from pelagos.optics.light_source import LightSource
from pelagos.optics.roughness import long_mean_square_slope, mean_square_slope
from pelagos.optics.sunlight import daylight
from pelagos.optics.swell import STEPS, swell_around
from pelagos.optics.texture import looks
from pelagos.optics.water import WaterArrays
from pelagos.raycast.hit_tables import HitTables
from pelagos.sensors.camera.picture.camera_rays import ViewConfig
from pelagos.sensors.camera.picture.scenery import Murk, Scenery
from pelagos.sensors.camera.picture.turbid_sight import suspended_tracers, suspended_water
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.sensor import Kinematics, SensorConfig, SensorContext

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean

_RESOLVED: Final = 2 * STEPS[0]  # [m], shortest of the ocean's waves that are drawn
_LEAST_RIPPLE: Final = 0.25  # share of the slope of waves over 0.3 m that short waves have at least; assumed
_RIPPLES_TOWARDS: Final = 0.4  # from north to west, where no wind blows [rad]
_COLUMN: Final = 8  # places above a camera at which the water is asked for

Lit: TypeAlias = tuple[Any, ...]
"""Arguments of `scenery_of`: materials, water, daylight, light field, air, ocean, moments."""
Share: TypeAlias = Annotated[float, Field(ge=0)]


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
    color: tuple[Share, Share, Share] = (1.0, 0.97, 0.92)
    """Colour: linear red, green, blue, relative to daylight."""


class LaserLightConfig(Strict):
    """A laser on the vehicle that the camera sees: a dot, for scale, or a line, for structured light."""

    position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Place in the body frame, forward-left-up of the vehicle's origin [m]."""
    orientation_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Roll, pitch, yaw of the laser's axis (its x) in the body frame [deg]; a line lies along its y, from left to
    right."""
    flux_lm: float = Field(default=3.0, gt=0)
    """Luminous flux [lm]; 5 mW at 532 nm are 3 lm."""
    fan_deg: float = Field(default=0.0, ge=0, le=120)
    """Angle of a line laser's fan [deg]; 0 is a dot."""
    aperture_mm: float = Field(default=2.0, gt=0, le=100)
    """Diameter of the beam at the laser (1/e^2) [mm]."""
    divergence_mrad: float = Field(default=1.0, ge=0, le=200)
    """Full angle by which it grows [mrad]."""
    color: tuple[Share, Share, Share] = (0.0, 1.0, 0.0)
    """Colour: linear red, green, blue, relative to daylight."""


class LitViewConfig(ViewConfig):
    """A view that light matters for."""

    lamps: tuple[LampConfig, ...] = ()
    """Lamps that shine when this camera looks."""
    lasers: tuple[LaserLightConfig, ...] = ()
    """Lasers that shine when this camera looks."""
    ripple: float | None = Field(default=None, ge=0, le=0.05)
    """Mean square slope of waves of 0.3 to 4 m that make caustics, on top of the ocean's waves. None: what the wind
    makes."""


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
        self._ocean = ocean = context.ocean
        self._water = ocean.water.arrays()
        weather = ocean.weather
        clear = daylight(float(ocean.sun_elevation[0]), -float(ocean.sun_azimuth[0]), cloud=weather.cloud)
        light = under_weather(clear, weather)
        self.light = light.arrays()
        self._field = None if ocean.turbidities else light_field(ocean.water, light)
        self._fields = LightFields(ocean.waters, light) if ocean.turbidities else None
        self._air = None if weather.clear else weather.air()
        self._varying = ocean if _has_uneven_sea(ocean) or suspended_tracers(ocean) else None
        self._measures: Array | None = None

    def ripple(self, config: LitViewConfig) -> Ripple:
        """Short waves: as `config` has them, or what the wind makes besides the ocean's own waves."""
        if config.ripple is not None:
            return ripple(config.ripple)
        wind, heading = surface_wind(self._ocean)
        whole, long = mean_square_slope(wind), long_mean_square_slope(wind)
        own = wave_slope(self._ocean, _RESOLVED)
        left = max(long - own, _LEAST_RIPPLE * long)
        towards = _RIPPLES_TOWARDS if heading is None else heading
        return ripple(left, heading=towards, finer=whole - long, longer=own)

    def arguments(self, motion: Kinematics, config: LitViewConfig) -> Lit:
        """For `scenery_of`, inside a frozen function; of one sensor's configuration."""
        if self._measures is None:
            self._measures = self.ripple(config).measures()
        times, moment = np.unique(np.array(motion.t_ns), return_inverse=True)
        if len(times) == 1:
            moments = dr.opaque(jit.UInt64, int(times[0])), dr.opaque(jit.UInt32, 0, moment.size)
        else:
            moments = jit.from_numpy(jit.UInt64, times), jit.from_numpy(jit.UInt32, moment.ravel())
        water, field = self._light_in(motion)
        return self.looks, water, self.light, field, self._air, self._varying, self._measures, moments

    def _light_in(self, motion: Kinematics) -> tuple[WaterArrays, LightField]:
        """Water and light of all copies, or, where copies differ, of each kind, and which is each lane's."""
        if self._fields is None or motion.turbidity is None:
            assert self._field is not None
            return self._water, self._field
        return self._fields.water, replace(self._fields.of(motion.turbidity.numpy()), row=motion.turbidity)


def scenery_of(
    tables: HitTables, light: Lit, ripples: Ripple, motion: Kinematics, config: SensorConfig, delay: float | Array = 0.0
) -> Scenery:
    """Everything that light depends on, at the moments of `motion` plus `delay` [s]."""
    materials, water, daylit, field, air, ocean, measures, moments = light
    waves = waves_of((ripples, measures), ocean, daylit.towards_sun, motion, moments, config, delay)
    position, _ = sensor_pose(motion, config)
    level = sea_level(waves, dr.width(motion.tick))
    t = jit.Float64(motion.t_ns) * 1e-9 + delay
    depth = level - jit.Float(position.z)
    tide = None if ocean is None or ocean.tide is None else jit.Float(ocean.tide.level(t))
    dr.eval(level, tide, depth)
    if field.row is not None:
        water, field = by_place(water, field)
        dr.eval(water, field)
    murk = Murk(ocean, water) if _has_uneven_suspension(ocean) else None
    if ocean is not None and suspended_tracers(ocean):
        water, field = _suspension(ocean, water, field, position, depth, t)
    return Scenery(tables, materials, water, daylit, field, air, waves, level, tide, depth, t, murk)


def _has_uneven_sea(ocean: Ocean | None) -> TypeGuard[Ocean]:
    """Whether the surface is anything but a plane at z = 0: it has waves or a tide."""
    return ocean is not None and (ocean.waves is not None or ocean.tide is not None)


def _has_uneven_suspension(ocean: Ocean | None) -> TypeGuard[Ocean]:
    """Whether plankton or sediment differ from place to place."""
    if ocean is None:
        return False
    even = (UniformField, OscillationField)
    return any(not isinstance(f, even) for n in suspended_tracers(ocean) for f in ocean.tracers[n])


def _suspension(
    ocean: Ocean, water: WaterArrays, field: LightField, position: Array, depth: Array, t: Array
) -> tuple[WaterArrays, LightField]:
    """Water and light around the cameras, by image, where plankton and sediment vary."""

    def at(share: float) -> WaterArrays:
        place = jit.Array3f64(position[0], position[1], position[2] + jit.Float64(dr.maximum(depth, 0)) * (1 - share))
        return suspended_water(ocean, water, place, t)

    here, column = at(1.0), [at((k + 0.5) / _COLUMN) for k in range(_COLUMN)]
    local = with_column(field, water, here, column, depth)
    dr.eval(here, local)
    return here, local


def waves_of(
    ripples: tuple[Ripple, Array], ocean: Ocean | None, towards_sun: Array, motion: Kinematics,
    moments: tuple[Array, Array],
    config: SensorConfig, delay: float | Array = 0.0,
) -> Waves:  # fmt: skip
    """The sea surface around the cameras.

    `ripples`: short waves and their measures; `moments`: the times of `motion`, each once, and which is each lane's.
    """
    t = jit.Float64(motion.t_ns) * 1e-9 + delay
    position, _ = sensor_pose(motion, config)
    images = dr.width(motion.tick)
    foam = ocean.foam if ocean is not None and ocean.breaks else None
    swell = swell_around(ocean.elevation, position, t, images, foam, motion.copy) if _has_uneven_sea(ocean) else None
    times, moment = moments
    sea, measures = ripples
    when = jit.Float64(times) * 1e-9 + delay
    return waves_at(sea, when, towards_sun, dr.width(times), swell, moment, measures=measures)


def light_sources(config: LitViewConfig, motion: Kinematics, image: Array) -> list[LightSource]:
    """Lamps and lasers of the vehicle at the moments of the images, by ray."""
    lamps = [_lamp_beam(lamp, config, motion, image) for lamp in config.lamps]
    return [*lamps, *(_laser_beam(laser, config, motion, image) for laser in config.lasers)]


def _lamp_beam(lamp: LampConfig, config: LitViewConfig, motion: Kinematics, image: Array) -> Beam:
    offset, turned = _mounted(lamp, config, motion)
    half = math.radians(lamp.beam_angle_deg) / 2
    candela = axis_intensity(lamp.flux_lm, 2 * half)
    return Beam(
        position=dr.gather(jit.Array3f, offset, image),
        axis=dr.gather(jit.Array3f, turned(1, 0, 0), image),
        intensity=_drawn(jit.Array3f(*(candela * c for c in lamp.color)), motion, image),
        inner=jit.Float(math.cos(0.5 * half)),
        outer=jit.Float(math.cos(half)),
    )


def _laser_beam(laser: LaserLightConfig, config: LitViewConfig, motion: Kinematics, image: Array) -> LaserBeam:
    offset, turned = _mounted(laser, config, motion)
    return LaserBeam(
        position=dr.gather(jit.Array3f, offset, image),
        axis=dr.gather(jit.Array3f, turned(1, 0, 0), image),
        across=dr.gather(jit.Array3f, turned(0, 0, 1), image),
        flux=_drawn(jit.Array3f(*(laser.flux_lm * c for c in laser.color)), motion, image),
        waist=jit.Float(0.5e-3 * laser.aperture_mm),
        spread=jit.Float(0.5e-3 * laser.divergence_mrad),
        fan=jit.Float(math.radians(laser.fan_deg)) if laser.fan_deg > 0 else None,
    )


def _drawn(light: Array, motion: Kinematics, image: Array) -> Array:
    """As much light as the copy of each image has: `Array3f` for all, or by ray."""
    return light if motion.lamps is None else light * dr.gather(jit.Float, motion.lamps, image)


def _mounted(
    light: LampConfig | LaserLightConfig, config: LitViewConfig, motion: Kinematics
) -> tuple[Array, Callable[[float, float, float], Array]]:
    """Place relative to the camera, by image; a function that turns a vector from the light's frame to the world's."""
    attitude = jit.Array4f(*(jit.Float(motion.attitude[i]) for i in range(4)))
    offset = rotate(attitude, jit.Array3f(*(a - b for a, b in zip(light.position_m, config.position_m, strict=True))))
    w, x, y, z = from_euler(*(math.radians(a) for a in light.orientation_deg))
    return offset, lambda i, j, k: rotate(attitude, rotate(jit.Array4f(w, x, y, z), jit.Array3f(i, j, k)))
