"""Daylight in the water at any depth and in any direction, from tables that `radiative_transfer` fills once.

The sun's beam stays a beam (it casts shadows and carries the pattern of the waves) until it is scattered by more than
a few degrees; everything else is diffuse light: irradiance on a surface of any orientation, radiance from any
direction, and what water sends on per metre. Tables are over e^{-K z}, by depth z = 0.1 (e^{B i} - 1) m.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.interface import fresnel, sun_below_surface
from pelagos.optics.light_tables import (
    CRITICAL_COSINE,
    LEVELS,
    MOLECULES,
    ROWS,
    SHALLOW,
    SIDES,
    UPS,
    depth_step,
    solved,
)
from pelagos.optics.phase import PEAK_EDGE, henyey_greenstein, turning_phase
from pelagos.optics.radiative_transfer import PEAK
from pelagos.optics.sunlight import Daylight, LightArrays, sky_radiance
from pelagos.optics.transport import path_length
from pelagos.optics.water import FORWARD_PEAK, MEAN_COSINE, REFRACTIVE_INDEX, WaterArrays, WaterOptics

_MOST_GAINED: Final = 30.0  # of diffuse light, in murk under a clear sea
_LEVEL_WITH_SUN: Final = 2e-3  # of d_z over the sun's


@jit.struct
class Fall:
    """Decrease of light with depth where the water is not the same everywhere, a Dr.Jit struct of `Array3f`.

    From the place on it is the place's own rate, and never slower than in the clearest water.

    Attributes:
        excess: rate of the place times its depth, over what the column above it takes.
        clear: least rate [1/m].
    """

    excess: Array
    clear: Array


@jit.struct
class Local:
    """Differences of water with something suspended in it from that of the tables, a Dr.Jit struct.

    Attributes:
        decay, loss, fading: `Fall`s of diffuse light, of the beam, and of light that will be scattered once.
        irradiance, source, radiance: `Array3f`, factors on the tables: what the beam loses more is diffuse light there.
    """

    decay: Fall
    loss: Fall
    fading: Fall
    irradiance: Array
    source: Array
    radiance: Array


@jit.struct
class LightField:
    """Sun and sky above and in the water, a Dr.Jit struct.

    Attributes:
        towards_sun, below: `Array3f`, unit vectors to the sun in air and in the water.
        beam: `Array3f`, irradiance across the sun's beam just below the surface [lx].
        loss: `Array3f`, rate at which the beam and the light of surfaces is lost, a + b_w + (1 - g^2) b_p: what is
            scattered by a few degrees still belongs to them [1/m].
        fading: `Array3f`, rate at which light that will be scattered once is lost [1/m], more than that.
        decay: `Array3f`, K of the tables [1/m].
        irradiance: `Float`, `(rows, 3, 8)` flattened: terms of `diffuse_irradiance` [lx].
        radiance: `Float`, `(levels, ups, sides, 4)`, scattered more than once, or once from the sky [cd/m^2].
        calm: likewise, without the glow around the sun, which counts as its beam on surfaces.
        source: likewise, of that light's sources [cd/m^2 per m].
        blur: `Float`, rate at which the waves' pattern is lost, against depth [1/m].
        local: see `Local`; None where the water is the same everywhere.
        row: `UInt32`, of each place the field that is its own, of several whose tables lie one after the other; None
            where there is one.
    """

    towards_sun: Array
    below: Array
    beam: Array
    loss: Array
    fading: Array
    decay: Array
    irradiance: Array
    radiance: Array
    calm: Array
    source: Array
    blur: Array
    local: Local | None = None
    row: Array | None = None


def light_field(water: WaterOptics, light: Daylight) -> LightField:
    """The tables for a kind of water under a sky."""
    tables = solved(water, light)
    towards = jit.Array3f(*light.towards_sun)
    high = dr.maximum(towards.z, 0)
    field = LightField(
        towards_sun=towards,
        below=sun_below_surface(jit.Array3f(towards.x, towards.y, high)),
        beam=jit.Array3f(tables.beam.tolist()),
        loss=jit.Array3f(tables.loss.tolist()),
        fading=jit.Array3f(tables.fading.tolist()),
        decay=jit.Array3f(tables.decay.tolist()),
        irradiance=jit.Float(tables.irradiance.ravel()),
        radiance=jit.Float(tables.radiance.ravel()),
        calm=jit.Float(tables.calm.ravel()),
        source=jit.Float(tables.source.ravel()),
        blur=jit.Float(0.25 * water.particle_scattering[1]),
    )
    jit.align(field)
    return field


def with_column(
    field: LightField, base: WaterArrays, here: WaterArrays, column: list[WaterArrays], depth: Array
) -> LightField:
    """The field around places in water of its own optics, by place.

    Args:
        field: of `base` alone.
        base: the clearest water, that it was solved for.
        here: the water at the places.
        column: at even steps of depth above them.
        depth: of the places [m].
    """
    down = dr.maximum(depth, 0)
    own, clear, above = _rates(here), _rates(base), [_rates(w) for w in column]
    falls = [
        Fall(down * (rate - sum(a[k] for a in above) / len(column)), clear[k] + dr.zeros(jit.Array3f, dr.width(depth)))
        for k, rate in enumerate(own)
    ]
    one = dr.zeros(jit.Array3f, dr.width(depth)) + 1
    source = here.turning / base.turning
    radiance = source * (field.loss + field.decay) / (own[1] + own[0])
    local = LightField(
        towards_sun=field.towards_sun,
        below=field.below,
        beam=field.beam,
        loss=own[1],
        fading=own[2],
        decay=own[0],
        irradiance=field.irradiance,
        radiance=field.radiance,
        calm=field.calm,
        source=field.source,
        blur=0.25 * here.particle_scattering.y,
        local=Local(falls[0], falls[1], falls[2], one, source, radiance),
        row=field.row,
    )
    # all light on level ground falls with K: what is no beam any more is diffuse
    up, rise = jit.Array3f(0, 0, 1), field.below.z
    diffuse = diffuse_irradiance(local, down, up)
    kept = _fallen(local, down) / dr.exp(-field.decay * down)
    whole = (diffuse_irradiance(field, down, up) + beam_at(field, down) * rise) * kept
    gain = dr.maximum(whole - beam_at(local, down) * rise, 0) / dr.maximum(diffuse, 1e-12)
    gain = dr.clip(gain, 1, _MOST_GAINED)
    return replace(local, local=Local(falls[0], falls[1], falls[2], gain, gain * source, gain * radiance))


def seen_through(field: LightField, here: WaterArrays, between: WaterArrays, depth: Array) -> LightField:
    """The field around places that are seen through other water than the eye's.

    Args:
        field: around the eye, of `with_column`.
        here: the water there.
        between: mean of the water along the lines of sight: light on its way down to the places goes through the same.
        depth: of the eye [m].
    """
    local = field.local
    if local is None:
        return field
    down, own, way = dr.maximum(depth, 0), _rates(here), _rates(between)
    falls = [
        Fall(fall.excess + down * (new - old), fall.clear)
        for fall, old, new in zip((local.decay, local.loss, local.fading), own, way, strict=True)
    ]
    around = replace(local, decay=falls[0], loss=falls[1], fading=falls[2])
    return replace(field, decay=way[0], loss=way[1], fading=way[2], local=around)


def _rates(water: WaterArrays) -> tuple[Array, Array, Array]:
    """Of diffuse light, of the beam, and of light that will be scattered once [1/m]."""
    a = water.absorption + water.water_scattering
    beam, once = (a + (1 - peak) * water.particle_scattering for peak in (FORWARD_PEAK, PEAK))
    return water.downwelling, beam, once


def beam_at(field: LightField, depth: Array) -> Array:
    """Irradiance across the sun's beam at a depth in the water, `Array3f` [lx]."""
    fall = None if field.local is None else field.local.loss
    return field.beam * dr.exp(-_taken(field.loss, fall, depth) / field.below.z)


def pattern_left(field: LightField, depth: Array) -> Array:
    """Share of the waves' pattern left in the beam, 0 .. 1; assumed: a quarter of the scattering length."""
    return dr.exp(-field.blur * depth)


def diffuse_irradiance(field: LightField, depth: Array, normal: Array) -> Array:
    """Irradiance of all light but the beam on a surface with unit `normal` at a depth in the water, `Array3f` [lx]."""
    row = jit.UInt32(dr.clip(_index(depth, ROWS) + 0.5, 0, ROWS - 1))
    if field.row is not None:
        row += field.row * ROWS
    x, z = _along(field, normal), normal.z
    z2 = z * z
    found = []
    for c in range(3):
        a = dr.gather(jit.Array4f, field.irradiance, row * 6 + 2 * c)
        b = dr.gather(jit.Array4f, field.irradiance, row * 6 + (2 * c + 1))
        found.append(a[0] + a[1] * x + a[2] * z + a[3] * x * x + b[0] * z2 + b[1] * x * z + b[2] * z2 * z2)
    light = dr.maximum(jit.Array3f(*found), 0) * _fallen(field, depth)
    return light if field.local is None else light * field.local.irradiance


def diffuse_radiance(field: LightField, depth: Array, direction: Array) -> Array:
    """Scattered light from a direction at a depth, `Array3f` [cd/m^2]; without the beam's light turned once."""
    return _looked_up(field, field.radiance, depth, direction) * _radiance_gain(field)


def surface_radiance(field: LightField, direction: Array) -> Array:
    """The same just below the surface."""
    light = _of_level(field, field.radiance, jit.UInt32(0), direction)
    return light if field.local is None else light * _fallen(field, jit.Float(0)) * field.local.radiance


def calm_radiance(field: LightField, depth: Array, direction: Array) -> Array:
    """The same without the glow around the sun: what falls on surfaces besides the beam."""
    return _looked_up(field, field.calm, depth, direction) * _radiance_gain(field)


def diffuse_source(field: LightField, depth: Array, direction: Array) -> Array:
    """Light that a metre of water sends to an eye that looks along `direction`, `Array3f` [cd/m^2 per m]; without
    the beam's own light."""
    light = _looked_up(field, field.source, depth, direction)
    return light if field.local is None else light * field.local.source


def beam_veil(field: LightField, water: WaterArrays, depth: Array, direction: Array, distance: Array) -> Array:
    """The beam's light, turned once into a line of sight that ends at `distance`, `Array3f` [cd/m^2]."""
    along = field.loss * (1 - direction.z / field.below.z)
    return beam_at(field, depth) * turned_phase(field, water, direction) * path_length(along, distance)


def aureole(field: LightField, water: WaterArrays, depth: Array, direction: Array, distance: Array) -> Array:
    """The glow around the sun, `Array3f` [cd/m^2]: light scattered once by a few degrees, by the true phase function.

    What arrives from all the way to the surface, less what would have come from behind `distance` as the light of
    surfaces does (T. Nakajima and M. Tanaka, JQSRT 40:51, 1988, doi 10.1016/0022-4073(88)90031-3, correct truncated
    phase functions likewise).
    """
    rise = direction.z / field.below.z
    rise = dr.select(dr.abs(1 - rise) < _LEVEL_WITH_SUN, 1 - _LEVEL_WITH_SUN, rise)  # along is divided by
    along = field.fading * (1 - rise)
    to_sea = dr.select(direction.z > 1e-4, depth / dr.maximum(direction.z, 1e-4), 1e4)
    # beyond e^60 the beam itself is none: a product of the two must not become 0 times infinity
    beyond, whole = (
        dr.minimum(e, 60) for e in ((field.fading - field.loss) * distance - along * to_sea, -along * to_sea)
    )
    seen = 1 - dr.exp(whole) - dr.exp(-(field.loss - field.fading * rise) * distance) + dr.exp(beyond)
    column = _taken(field.fading, None if field.local is None else field.local.fading, depth)
    beam = field.beam * dr.exp(-column / field.below.z)
    cosine = dr.dot(direction, field.below)
    peak = dr.maximum(henyey_greenstein(cosine, MEAN_COSINE) - henyey_greenstein(PEAK_EDGE, MEAN_COSINE), 0)
    return beam * water.particle_scattering * peak * dr.maximum(seen / along, 0)


def turned_phase(field: LightField, water: WaterArrays, direction: Array) -> Array:
    """Share of the beam that a metre of water turns into the line of sight, `Array3f` [1/(m sr)]: without the peak of
    what is scattered by a few degrees."""
    particles = turning_phase(dr.dot(direction, field.below))
    return water.water_scattering * MOLECULES + water.particle_scattering * particles


def window_radiance(field: LightField, light: LightArrays, depth: Array, direction: Array) -> Array:
    """The sky in Snell's window, seen from a depth through calm water, `Array3f` [cd/m^2]; nothing outside of it."""
    n = REFRACTIVE_INDEX
    up = dr.maximum(direction.z, 0)
    inside = up > CRITICAL_COSINE
    air = dr.sqrt(dr.maximum(1 - (1 - up * up) * n * n, 0))
    sky = sky_radiance(light, jit.Array3f(n * direction.x, n * direction.y, air), glare=0.0)
    passed = (1 - fresnel(dr.maximum(up, 0.1), 1 / n)) * n * n
    column = _taken(field.loss, None if field.local is None else field.local.loss, depth)
    kept = dr.exp(-column / dr.maximum(up, 0.1))
    return dr.select(inside, sky * passed * kept, 0)


def _looked_up(field: LightField, table: Array, depth: Array, direction: Array) -> Array:
    level = dr.clip(_index(depth, LEVELS), 0, LEVELS - 1.001)
    i = jit.UInt32(level)
    above, below = (_of_level(field, table, k, direction) for k in (i, i + 1))
    return dr.lerp(above, below, level - jit.Float(i)) * _fallen(field, depth)


def _fallen(field: LightField, depth: Array) -> Array:
    """e^{-K z}."""
    return dr.exp(-_taken(field.decay, None if field.local is None else field.local.decay, depth))


def _taken(rate: Array, fall: Fall | None, depth: Array) -> Array:
    """Optical depth of a depth."""
    return rate * depth if fall is None else dr.maximum(rate * depth - fall.excess, fall.clear * depth)


def _radiance_gain(field: LightField) -> Array:
    return 1 if field.local is None else field.local.radiance


def _of_level(field: LightField, table: Array, level: Array, direction: Array) -> Array:
    """A level of a table, interpolated between directions, `Array3f`; over e^{-K z}."""
    if field.row is not None:
        level = level + field.row * LEVELS
    up = dr.clip((direction.z + 1) * (0.5 * (UPS - 1)), 0, UPS - 1.001)
    level_sine = dr.sqrt(dr.maximum(1 - direction.z * direction.z, 1e-9))
    angle = dr.acos(dr.clip(_along(field, direction) / level_sine, -1, 1))
    side = dr.clip(angle * ((SIDES - 1) / math.pi), 0, SIDES - 1.001)
    j, k = jit.UInt32(up), jit.UInt32(side)
    q, r = up - jit.Float(j), side - jit.Float(k)

    def at(b: Array, c: Array) -> Array:
        found = dr.gather(jit.Array4f, table, (level * UPS + b) * SIDES + c)
        return jit.Array3f(found[0], found[1], found[2])

    return dr.lerp(dr.lerp(at(j, k), at(j, k + 1), r), dr.lerp(at(j + 1, k), at(j + 1, k + 1), r), q)


def _along(field: LightField, direction: Array) -> Array:
    """Horizontal component of a direction towards the sun."""
    s = field.towards_sun
    across = dr.sqrt(s.x * s.x + s.y * s.y)
    scale = dr.rcp(dr.maximum(across, 1e-6))
    return (direction.x * s.x + direction.y * s.y) * scale


def _index(depth: Array, count: int) -> Array:
    return dr.log(1 + dr.maximum(depth, 0) / SHALLOW) * (1 / depth_step(count))
