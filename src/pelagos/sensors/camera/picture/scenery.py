"""Scenery of a camera's view: materials, water, sun and sky, air with its fog and rain, waves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.atmosphere import Air, airlight, through_air, way_to_sky
from pelagos.optics.caustics import Waves
from pelagos.optics.light_field import Fall, LightField, Local
from pelagos.optics.rain import streaks
from pelagos.optics.sunlight import LightArrays, sky_radiance
from pelagos.optics.swell import elevation_at
from pelagos.optics.texture import Looks
from pelagos.optics.water import WaterArrays
from pelagos.raycast.hit_tables import HitTables
from pelagos.raycast.rays import Hits, Rays

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean

_SEA_ALBEDO: Final = 0.06  # from above (R. E. Payne, J. Atmos. Sci. 29:959, 1972)
FAR: Final = 1e4  # [m], where there is nothing


@jit.struct
class Murk:
    """Water that varies from place to place, a Dr.Jit struct.

    Attributes:
        ocean: with its tracers.
        clear: the water without them.
    """

    ocean: Ocean
    clear: WaterArrays


@dataclass
class Scenery:
    """All that light depends on besides the rays, a Dr.Jit struct handed to frozen functions.

    Attributes:
        tables: of the ray-tracing scene.
        looks: by material row.
        water: its optics.
        light: sun and sky.
        field: what of them is in the water.
        air: fog and rain, None where it is clear.
        waves: of the moments of the lanes.
        level: `Float`, height of the sea surface over each camera [m].
        tide: `Float`, mean level of the sea, likewise [m]; None where that is z = 0.
        depth: `Float`, of each camera below it [m].
        t: `Float64`, the moments [s].
        murk: see `Murk`; None where the water is the same everywhere.
    """

    tables: HitTables
    looks: Looks
    water: WaterArrays
    light: LightArrays
    field: LightField
    air: Air | None
    waves: Waves
    level: Array
    tide: Array | None
    depth: Array
    t: Array
    murk: Murk | None = None


def by_ray(scenery: Scenery, lane: Array) -> Scenery:
    """The same with the tide and the water of the image that each ray belongs to."""

    def spread(v: Array) -> Array:
        return dr.gather(type(v), v, lane)

    if scenery.tide is not None:
        scenery = replace(scenery, tide=spread(scenery.tide))
    field, water = scenery.field, scenery.water
    if field.local is None and field.row is None:
        return scenery

    def fall(f: Fall) -> Fall:
        return Fall(spread(f.excess), spread(f.clear))

    of, local = field.local, None
    if of is not None:
        gains = (spread(v) for v in (of.irradiance, of.source, of.radiance))
        local = Local(fall(of.decay), fall(of.loss), fall(of.fading), *gains)
    here = replace(
        field, loss=spread(field.loss), fading=spread(field.fading), decay=spread(field.decay),
        blur=spread(field.blur), local=local, row=None if field.row is None else spread(field.row),
    )  # fmt: skip
    murk = scenery.murk
    if murk is not None and field.row is not None:
        murk = replace(murk, clear=murk.clear.of(lane))
    return replace(scenery, water=water.of(lane), field=here, murk=murk)


def fog_radiance(scenery: Scenery) -> Array:
    """Radiance of thick fog and rain, and of a white level surface: `Array3f` [cd/m^2]."""
    light = scenery.light
    return airlight(light.sun, light.sky, light.towards_sun)


def behind_air(scenery: Scenery, radiance: Array, distance: Array) -> Array:
    """Radiance seen through a stretch of the scenery's air [m]."""
    air = scenery.air
    return radiance if air is None else through_air(radiance, (air.fog + air.rain) * distance, fog_radiance(scenery))


def sky_in_air(scenery: Scenery, direction: Array, *, glare: Array = 1.0) -> Array:
    """The sky, and the fog before it, `Array3f` [cd/m^2]; see `sky_radiance`."""
    sky = sky_radiance(scenery.light, direction, glare=glare)
    if scenery.air is None:
        return sky
    return through_air(sky, way_to_sky(scenery.air, direction.z), fog_radiance(scenery))


def sea_from_above(scenery: Scenery) -> Array:
    """Mean radiance of the sea, `Array3f` [cd/m^2]."""
    return fog_radiance(scenery) * _SEA_ALBEDO


def depth_at(scenery: Scenery, place: Array) -> Array:
    """Depth of places `Array3f64` below the mean level of the sea [m], `Float`; `scenery` of `by_ray`."""
    z = jit.Float(place.z)
    return -z if scenery.tide is None else scenery.tide - z


def depth_of_starts(scenery: Scenery, rays: Rays, lane: Array) -> Array:
    """Depth of rays' starts below the sea surface [m]: those through one port may start on both sides of it."""
    swell = scenery.waves.swell
    if swell is None:
        level = dr.gather(jit.Float, scenery.level, lane)
    else:
        x = jit.Float(rays.origin.x - dr.gather(jit.Float64, swell.corner_x, lane))
        y = jit.Float(rays.origin.y - dr.gather(jit.Float64, swell.corner_y, lane))
        level = elevation_at(swell, x, y, lane)
    return level - jit.Float(rays.origin.z)


def in_rain(
    scenery: Scenery, light: Array, rays: Rays, first: Hits, lane: Array, exposure: Array, pixel_angle: float
) -> Array:
    """`light` at the pixels behind falling drops, where the camera is above the water; `exposure` by lane [s]."""
    if scenery.air is None or scenery.air.drops is None:
        return light
    depth, d = depth_of_starts(scenery, rays, lane), rays.direction
    to_sea = dr.select(d.z < -1e-6, depth / dr.minimum(d.z, -1e-6), FAR)
    reach = dr.minimum(dr.select(first.valid, first.t, FAR), to_sea)
    tenths_of_ms = jit.UInt64(dr.maximum(dr.gather(jit.Float64, scenery.t, lane), 0) * 1e4)
    fall = jit.UInt32(tenths_of_ms) * 0x9E3779B1
    cover = streaks(d, dr.select(depth > 0, 0, reach), scenery.air.drops, fall, exposure, pixel_angle)
    return dr.lerp(light, fog_radiance(scenery), cover)
