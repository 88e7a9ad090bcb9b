"""Daylight in the water at any depth and in any direction, from tables that `radiative_transfer` fills once.

The sun's beam stays a beam (it casts shadows and carries the pattern of the waves) until it is scattered by more than
a few degrees; everything else is diffuse light: irradiance on a surface of any orientation, radiance from any
direction, and what water sends on per metre. Tables are over e^{-K z}, by depth z = 0.1 (e^{B i} - 1) m.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.interface import fresnel, sun_below_surface
from pelagos.optics.phase import PEAK_EDGE, henyey_greenstein, turning_phase
from pelagos.optics.radiative_transfer import MODES, PEAK, Above, Field, gauss, media, mirror, solve
from pelagos.optics.sunlight import Daylight, LightArrays, beam_and_mean_sky, sky_radiance
from pelagos.optics.transport import path_length
from pelagos.optics.water import FORWARD_PEAK, MEAN_COSINE, REFRACTIVE_INDEX, WaterArrays, WaterOptics

_SHALLOW: Final = 0.1  # [m]
_DEEPEST: Final = 400.0  # [m]
_LEVELS: Final = 56
_ROWS: Final = 384  # of irradiance: fine enough to take the nearest
_UPS: Final = 33  # of u = d_z, -1 .. 1
_SIDES: Final = 9  # of azimuth from the sun, 0 .. pi
_TERMS: Final = 8  # of irradiance; one is idle
_MOST_GAINED: Final = 30.0  # of diffuse light, in murk under a clear sea
_LEVEL_WITH_SUN: Final = 2e-3  # of d_z over the sun's
CRITICAL_COSINE: Final = math.sqrt(1 - REFRACTIVE_INDEX**-2)
_MOLECULES: Final = 1 / (4 * math.pi)


@jit.struct
class Fall:
    """How light falls with depth where the water is not the same everywhere, a Dr.Jit struct of `Array3f`.

    From the place on it is the place's own rate, and never slower than in the clearest water.

    Attributes:
        excess: rate of the place times its depth, over what the column above it takes.
        clear: least rate [1/m].
    """

    excess: Array
    clear: Array


@jit.struct
class Local:
    """How water with something suspended in it differs from what the tables are of, a Dr.Jit struct.

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


@dataclass(frozen=True)
class _Solved:
    """Tables on the host, see `LightField`."""

    beam: NDArray[np.float64]
    loss: NDArray[np.float64]
    fading: NDArray[np.float64]
    decay: NDArray[np.float64]
    irradiance: NDArray[np.float32]
    radiance: NDArray[np.float32]
    calm: NDArray[np.float32]
    source: NDArray[np.float32]


def light_field(water: WaterOptics, light: Daylight) -> LightField:
    """The tables for a kind of water under a sky."""
    solved = _solved(water, light)
    towards = jit.Array3f(*light.towards_sun)
    high = dr.maximum(towards.z, 0)
    field = LightField(
        towards_sun=towards,
        below=sun_below_surface(jit.Array3f(towards.x, towards.y, high)),
        beam=jit.Array3f(solved.beam.tolist()),
        loss=jit.Array3f(solved.loss.tolist()),
        fading=jit.Array3f(solved.fading.tolist()),
        decay=jit.Array3f(solved.decay.tolist()),
        irradiance=jit.Float(solved.irradiance.ravel()),
        radiance=jit.Float(solved.radiance.ravel()),
        calm=jit.Float(solved.calm.ravel()),
        source=jit.Float(solved.source.ravel()),
        blur=jit.Float(0.25 * water.particle_scattering[1]),
    )
    jit.settle(field)
    return field


@lru_cache(maxsize=32)
def _solved(water: WaterOptics, light: Daylight) -> _Solved:
    depths = _SHALLOW * np.expm1(_step(_LEVELS) * np.arange(_LEVELS))
    rows = _SHALLOW * np.expm1(_step(_ROWS) * np.arange(_ROWS))
    fields = [solve(m, a, depths) for m, a in zip(media(water), entering(light), strict=True)]
    ups = np.linspace(-1, 1, _UPS)
    ups[_UPS // 2] = 1e-3
    waves = np.cos(np.arange(MODES)[:, None] * np.linspace(0, math.pi, _SIDES))  # (MODES, sides)
    radiance, calm, source = np.zeros((3, _LEVELS, _UPS, _SIDES, 4))
    terms = np.zeros((_ROWS, 3, _TERMS))
    loss = np.add(water.absorption, water.water_scattering) + np.multiply(1 - FORWARD_PEAK, water.particle_scattering)
    for c, field in enumerate(fields):
        excess = field.medium.attenuation - loss[c]
        radiance[..., c] = field.at(ups) @ waves
        source[..., c] = field.source(ups) @ waves - excess * radiance[..., c]
        for rate, sign in ((field.medium.attenuation, 1.0), (loss[c], -1.0)):
            once, made = _turned_once(field, rate, ups, np.linspace(0, math.pi, _SIDES))
            radiance[..., c] += sign * once
            source[..., c] += sign * made - (excess * once if sign > 0 else 0)
        calm[..., c] = _calmed(np.maximum(radiance[..., c], 0), once, field, loss[c], ups)
        for k, column in enumerate(_irradiance_terms(field, loss[c])):
            terms[:, c, k] = np.interp(rows, depths, column)
    return _Solved(
        beam=np.array([f.above.sun for f in fields]),
        loss=loss,
        fading=np.array([f.medium.attenuation for f in fields]),
        decay=np.array([f.medium.decay for f in fields]),
        irradiance=terms.astype(np.float32),
        radiance=np.maximum(radiance, 0).astype(np.float32),
        calm=calm.astype(np.float32),
        source=np.maximum(source, 0).astype(np.float32),
    )


def _turned_once(
    field: Field, rate: float, ups: NDArray[np.float64], sides: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The beam's light that is turned once and lost at a rate, over e^{-K z}: radiance and source."""
    above, medium = field.above, field.medium
    mu = above.towards_sun
    sine = np.sqrt(np.maximum(1 - ups**2, 0) * (1 - mu**2))
    cosine = np.minimum(ups[:, None] * mu + sine[:, None] * np.cos(sides), PEAK_EDGE)
    g = MEAN_COSINE
    particles = (1 - g * g) / (4 * math.pi) / (1 + g * g - 2 * g * cosine) ** 1.5
    made = (medium.molecules * _MOLECULES + medium.particles * particles) * above.sun
    made = made * np.exp((medium.decay - rate / mu) * field.depths)[:, None, None]  # (levels, ups, sides)
    up = ups > 0
    way = np.where(up, field.depths[:, None] / np.where(up, ups, 1), 1e4)
    along = rate * (1 - ups / mu)
    along = np.where(np.abs(along) < 1e-6, 1e-6, along)
    return made * (-np.expm1(-along * way) / along)[..., None], made


def _calmed(
    radiance: NDArray[np.float64], once: NDArray[np.float64], field: Field, loss: float, ups: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Radiance with its brightest part cut off, so that with light turned once (`once`) it gives what irradiance there
    is on level ground besides the beam."""
    side = np.full(_SIDES, 2 * math.pi / (_SIDES - 1))
    side[[0, -1]] /= 2
    weight = (np.maximum(ups, 0) * 2 / (_UPS - 1))[:, None] * side
    weight[-1] /= 2
    mu, u = field.above.towards_sun, field.u
    fall = [np.exp((field.medium.decay - rate / mu) * field.depths) for rate in (loss, field.medium.attenuation)]
    down = 2 * math.pi * field.radiance[:, :, 0] @ (field.weight * np.maximum(u, 0))
    wanted = down - field.above.sun * mu * (fall[0] - fall[1]) - np.sum(once * weight, axis=(1, 2))
    wanted -= _window_irradiance(field, loss) - _window_irradiance(field, field.medium.attenuation)
    low, high = np.zeros(len(wanted)), radiance.max(axis=(1, 2))
    for _ in range(40):
        cap = 0.5 * (low + high)
        over = np.sum(np.minimum(radiance, cap[:, None, None]) * weight, axis=(1, 2)) > wanted
        low, high = np.where(over, low, cap), np.where(over, cap, high)
    return np.asarray(np.minimum(radiance, high[:, None, None]))


def _window_irradiance(field: Field, rate: float) -> NDArray[np.float64]:
    """Irradiance of the sky itself on level ground where it is lost at a rate, over e^{-K z}, `(levels,)`."""
    v = field.above.window_u
    kept = np.exp((field.medium.decay - rate / v) * field.depths[:, None])
    return np.asarray(2 * math.pi * kept @ (field.above.window_weight * field.above.window * v))


def entering(light: Daylight) -> list[Above]:
    """What of sun and sky gets through a level surface, by channel."""
    n = REFRACTIVE_INDEX
    high = max(light.towards_sun[2], 0.0)
    mu = math.sqrt(1 - (1 - high * high) / n**2)
    u, weight = gauss(CRITICAL_COSINE, 1, 16)
    air = np.sqrt(1 - (1 - u * u) * n * n)
    through = (1 - mirror(u)) * n * n
    passed = (1 - float(mirror(np.array(mu)))) * high / mu
    found = []
    beam, sky = beam_and_mean_sky(light, air)
    for sun, radiance in zip(beam, sky.T, strict=True):
        found.append(Above(mu, float(sun) * passed, u, weight, radiance * through))
    return found


def _irradiance_terms(field: Field, loss: float) -> list[NDArray[np.float64]]:
    """Factors of 1, n_x, n_z, n_x^2, n_z^2, n_x n_z, n_z^4, each `(depths,)`; x is towards the sun.

    E(n) is the integral of L max(n . d, 0), and max(x, 0) = 1/4 + x/2 + 5/16 P_2(x) - 3/32 P_4(x) + ... (R. Ramamoorthi
    and P. Hanrahan, SIGGRAPH 2001, doi 10.1145/383259.383317); of the fourth order only what is even about the zenith.
    """
    u, across = field.u, np.sqrt(1 - field.u**2)
    above = field.above
    faded = np.exp((field.medium.decay - field.medium.attenuation / above.window_u) * field.depths[:, None])
    sky = 2 * math.pi * faded * above.window * above.window_weight

    # the beam takes along what is scattered by a few degrees: it is not counted twice
    sine = math.sqrt(1 - above.towards_sun**2)
    fall = [np.exp((field.medium.decay - rate / above.towards_sun) * field.depths)
            for rate in (field.medium.attenuation, loss)]  # fmt: skip
    beamed = above.sun * (fall[1] - fall[0])

    def zonal(f: Any) -> NDArray[np.float64]:
        diffuse = 2 * math.pi * field.radiance[:, :, 0] @ (field.weight * f(u)) + sky @ f(above.window_u)
        return np.asarray(diffuse - beamed * f(np.array(above.towards_sun)))

    def mode(m: int, f: NDArray[np.float64], of_sun: float) -> NDArray[np.float64]:
        return np.asarray(math.pi * field.radiance[:, :, m] @ (field.weight * f) - beamed * of_sun)

    def fourth(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return (35 * x**4 - 30 * x**2 + 3) / 8

    whole, zz = zonal(np.ones_like), zonal(np.square)
    spread = 0.5 * mode(2, across**2, sine**2)
    xx, yy = 0.5 * (whole - zz) + spread, 0.5 * (whole - zz) - spread
    p4 = -3 / 32 * zonal(fourth)
    q = 15 / 32
    return [
        (0.25 - 5 / 32) * whole + q * yy + 3 / 8 * p4,
        0.5 * mode(1, across, sine),
        0.5 * zonal(lambda v: v),
        q * (xx - yy),
        q * (zz - yy) - 30 / 8 * p4,
        2 * q * mode(1, u * across, above.towards_sun * sine),
        35 / 8 * p4,
    ]


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
    """How much of the waves' pattern is left in the beam, 0 .. 1; assumed: a quarter of the scattering length."""
    return dr.exp(-field.blur * depth)


def diffuse_irradiance(field: LightField, depth: Array, normal: Array) -> Array:
    """Irradiance of all light but the beam on a surface with unit `normal` at a depth in the water, `Array3f` [lx]."""
    row = jit.UInt32(dr.clip(_index(depth, _ROWS) + 0.5, 0, _ROWS - 1))
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
    """What a metre of water sends on towards an eye that looks along `direction`, `Array3f` [cd/m^2 per m]; without
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
    return water.water_scattering * _MOLECULES + water.particle_scattering * particles


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
    level = dr.clip(_index(depth, _LEVELS), 0, _LEVELS - 1.001)
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
    up = dr.clip((direction.z + 1) * (0.5 * (_UPS - 1)), 0, _UPS - 1.001)
    level_sine = dr.sqrt(dr.maximum(1 - direction.z * direction.z, 1e-9))
    angle = dr.acos(dr.clip(_along(field, direction) / level_sine, -1, 1))
    side = dr.clip(angle * ((_SIDES - 1) / math.pi), 0, _SIDES - 1.001)
    j, k = jit.UInt32(up), jit.UInt32(side)
    q, r = up - jit.Float(j), side - jit.Float(k)

    def at(b: Array, c: Array) -> Array:
        found = dr.gather(jit.Array4f, table, (level * _UPS + b) * _SIDES + c)
        return jit.Array3f(found[0], found[1], found[2])

    return dr.lerp(dr.lerp(at(j, k), at(j, k + 1), r), dr.lerp(at(j + 1, k), at(j + 1, k + 1), r), q)


def _along(field: LightField, direction: Array) -> Array:
    """Horizontal component of a direction towards the sun."""
    s = field.towards_sun
    across = dr.sqrt(s.x * s.x + s.y * s.y)
    scale = dr.rcp(dr.maximum(across, 1e-6))
    return (direction.x * s.x + direction.y * s.y) * scale


def _index(depth: Array, count: int) -> Array:
    return dr.log(1 + dr.maximum(depth, 0) / _SHALLOW) * (1 / _step(count))


def _step(count: int) -> float:
    return math.log1p(_DEEPEST / _SHALLOW) / (count - 1)
