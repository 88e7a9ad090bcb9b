"""Things in a ping as a sonar hears them: where, how much of each, and by which beams.

A thing's own rays go to places spread evenly over its disc, as the sonar sees it. They tell what stands before it, and
what its surface scatters; the coherent part of a smooth sphere, box or cylinder is computed from its shape.

Source: X. Lurton, An Introduction to Underwater Acoustics (2nd ed., 2010), Chapters 3 and 5; see also `specular`.
"""

from __future__ import annotations

import math
from typing import Any, Final

import drjit as dr

from pelagos import jit
from pelagos.acoustics.speckle import lattice_word, on_instance, scramble
from pelagos.acoustics.specular import roughness_loss
from pelagos.acoustics.spreading import from_db
from pelagos.jit import Array
from pelagos.math.philox import complex_normal32
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import NO_BODY, Rays
from pelagos.sensors.sonar.ping.listener import Listener
from pelagos.sensors.sonar.ping.mirror_echo import MirrorEcho, mirror_echo
from pelagos.sensors.sonar.ping.surface_scattering import Surfaces, scattering
from pelagos.sensors.sonar.ping.target_place import Place, target_places
from pelagos.sensors.sonar.ping.targets import FEW, SPHERE, Targets

_GOLDEN: Final = math.pi * (3.0 - math.sqrt(5.0))
_RAYS: Final = (64, 16)  # of a thing, where there are few things, and many
_MANY_THINGS: Final = 64
_INSIDE: Final = 0.985  # of a thing's disc: the limb of a polyhedron lies within that of its sphere
_NEAREST: Final = 0.2  # [m]
_COHERENT: Final = 1e-3  # part of the intensity below which nothing is coherent


@jit.struct
class Sighting:
    """Sight of each thing in a ping, pings by things (and by its rays): a Dr.Jit struct.

    Attributes:
        small: `Bool`, it has rays of its own, and no others hear it.
        dulled: `Float`, part of its scattering that is not coherent.
        energy: `Float`, by ray: intensity re the source level at 1 m.
        distance: `Float`, by ray [m].
        real, imaginary: `Float`, by ray: amplitude of that energy.
        beam: `UInt32`, by ray: the sector it comes from; the number of beams where it comes from none.
        label: `UInt32`, by ray.
        size: `Float`, amplitude of the coherent echo re 1 m, with the patterns that are no array's.
        reach: `Float`, its range [m].
        cosine, sine: `Float`, of its phase.
        direction: `Array3f`, where it comes from, in the sensor frame; of steered arrays, without its height.
        nearest: `UInt32`, the beam that looks there.
        point: `Bool`, its rays' echoes come from one range, as a whole: a sphere's.
    """

    small: Array
    dulled: Array
    energy: Array
    distance: Array
    real: Array
    imaginary: Array
    beam: Array
    label: Array
    size: Array
    reach: Array
    cosine: Array
    sine: Array
    direction: Array
    nearest: Array
    point: Array


def rays_of(things: int) -> int:
    """Rays of each thing."""
    return _RAYS[0] if things <= _MANY_THINGS else _RAYS[1]


@jit.struct
class _Asked:
    """Of things: whether rays go to them, how much of their scattering is coherent, and that echo."""

    here: Array
    rays: Array
    coherent: Array
    echo: MirrorEcho


def sight_targets(caster: Caster, things: Targets, listener: Listener, surfaces: Surfaces) -> Sighting:
    """Look for all things on every lane."""
    lanes, hearing = listener.lanes, listener.hearing
    count, pings = dr.width(things.kind), dr.width(lanes.position)
    k = rays_of(count)
    row = dr.arange(jit.UInt32, pings * count)
    place = target_places(caster, things, lanes, row, count)
    dr.eval(place)
    far = place.distance < hearing.reach + place.radius
    own = dr.gather(jit.UInt32, lanes.own, row // count)
    here = far & (place.distance > place.radius + _NEAREST) & ((own == NO_BODY) | (place.body != own))
    if lanes.wet is not None:
        here &= dr.gather(jit.Bool, lanes.wet, row // count)
    solid_angle = dr.pi * dr.square(place.radius / place.distance)
    place.small = here & (solid_angle * hearing.rays_per_sr < FEW)
    coherent = roughness_loss(place.smooth, jit.Float(1.0))
    echo = mirror_echo(place, hearing)
    asked = here & (place.small | (coherent > _COHERENT) & (echo.size > 0.0))  # rays to all others tell nothing
    dr.eval(place.small, here, coherent, echo, asked)
    chosen = _Asked(here, asked, coherent, echo)
    rays = _own_rays(caster, place, chosen, listener, surfaces, k=k, count=count)
    return _merged(place, chosen, rays, listener, k=k, count=count)


@jit.struct
class _OwnRays:
    energy: Array
    distance: Array
    word: Array
    beam: Array
    label: Array
    hit: Array
    blocked: Array
    loss: Array


def _own_rays(
    caster: Caster, place: Place, chosen: _Asked, listener: Listener, surfaces: Surfaces, *, k: int, count: int
) -> _OwnRays:
    """Rays over the disc of small things; those of others go to the place that their coherent echo comes from.

    Things that are not asked for cost nothing: their rays are a whole packet of the processor, which is passed over.
    """
    index = dr.arange(jit.UInt32, dr.width(place.distance) * k)

    def cast(index: Array) -> _OwnRays:
        return _cast_own(caster, place, chosen, listener, surfaces, index=index, k=k, count=count)

    def silence(index: Array) -> _OwnRays:
        nothing, no_word = jit.Float(0), jit.UInt32(0)
        return _OwnRays(energy=nothing, distance=nothing, word=no_word, beam=no_word, label=no_word,
                        hit=nothing, blocked=nothing, loss=nothing)  # fmt: skip

    asked = dr.gather(jit.Bool, chosen.rays, index // k)
    made: _OwnRays = dr.if_stmt((index,), asked, cast, silence, mode="symbolic")
    dr.eval(made)
    return made


def _cast_own(
    caster: Caster, place: Place, chosen: _Asked, listener: Listener, surfaces: Surfaces,
    *, index: Array, k: int, count: int,
) -> _OwnRays:  # fmt: skip
    """Rays of the things that are asked for."""
    row, ray = index // k, index % k
    lane, lanes = row // count, listener.lanes

    def gather(kind: Any, values: Array) -> Array:
        return dr.gather(kind, values, row)

    small, distance = gather(jit.Bool, place.small), gather(jit.Float, place.distance)
    towards, radius = gather(jit.Array3f, place.direction), gather(jit.Float, place.radius)
    spot = gather(jit.Array3f, chosen.echo.way)
    target = dr.select(small, towards * distance, spot)
    disc = dr.select(small, radius * _INSIDE, 0.01 * dr.norm(spot))
    part = dr.sqrt((jit.Float(ray) + 0.5) * (1.0 / k)) * disc
    s, c = dr.sincos(jit.Float(ray) * _GOLDEN)
    aside = dr.normalize(
        dr.cross(dr.select(dr.abs(towards.z) < 0.9, jit.Array3f(0, 0, 1), jit.Array3f(1, 0, 0)), towards)
    )
    above = dr.cross(towards, aside)
    direction = dr.normalize(target + aside * (part * c) + above * (part * s))
    origin = dr.gather(jit.Array3f64, lanes.position, lane)
    copy, own = dr.gather(jit.UInt32, lanes.copy, lane), dr.gather(jit.UInt32, lanes.own, lane)
    hits = caster.cast(Rays(origin, direction, distance + radius, copy, own), smooth=True)
    met = hits.valid & (hits.instance == gather(jit.UInt32, place.instance))
    end = dr.select(small, distance - radius, dr.norm(spot))
    blocked = hits.valid & ~met & (hits.t < end)
    sine = dr.abs(dr.dot(hits.shading_normal, direction))
    facing_sine = dr.maximum(dr.abs(dr.dot(hits.normal, direction)), 0.02)
    section = scattering(surfaces, hits.material, sine)
    t = dr.select(met, hits.t, 1.0)
    loss = lanes.medium.mean_loss(lane, jit.Float(0), jit.Float(hits.position.z - origin.z))
    solid_angle = (math.pi / k) * dr.square(disc / distance)
    beam, pattern = listener.sector(listener.apparent(direction, lane))
    energy = section / facing_sine * solid_angle * from_db(-2.0 * loss * t) / dr.square(t) * pattern
    shifted = listener.measured_range(t, lane, hits.velocity, direction)
    cell = (jit.UInt32(jit.Int32(dr.floor(v))) for v in hits.place * (2.0 / listener.hearing.wavelength))
    word = scramble(on_instance(lattice_word(tuple(cell), jit.UInt32(0)), hits.instance) + ray)
    return _OwnRays(
        energy=dr.select(met & small, energy, 0.0), distance=shifted, word=word, beam=beam, label=hits.label,
        hit=dr.select(met, jit.Float(1), 0.0), blocked=dr.select(blocked, jit.Float(1), 0.0), loss=loss,
    )  # fmt: skip


def _merged(place: Place, chosen: _Asked, rays: _OwnRays, listener: Listener, *, k: int, count: int) -> Sighting:
    """Sight of each thing by own rays, and its coherent echo."""
    lanes, hearing, echo, coherent = listener.lanes, listener.hearing, chosen.echo, chosen.coherent
    row = dr.arange(jit.UInt32, dr.width(place.distance))
    lane = row // count
    total = dr.block_sum(rays.energy, k)
    hit, blocked = dr.block_sum(rays.hit, k), dr.block_sum(rays.blocked, k)
    dr.eval(total, hit, blocked)
    seen = hit / dr.maximum(hit + blocked, 1.0)
    at = dr.maximum(echo.reach, 1e-2)
    way = dr.normalize(echo.way)
    in_sensor = listener.apparent(way, lane)
    loss = lanes.medium.mean_loss(lane, jit.Float(0), echo.way.z)
    heard = from_db(-loss * at)  # amplitude there and back
    beam, pattern = listener.sector(in_sensor)
    is_coherent = chosen.here & (coherent > _COHERENT) & (echo.size > 0.0)
    size = dr.select(is_coherent, echo.size * dr.sqrt(coherent * seen) * heard * dr.sqrt(pattern), 0.0)
    if hearing.aperture.steered:
        in_sensor = listener.level(in_sensor)
    speed = dr.gather(jit.Float, lanes.medium.sound_speed, lane)
    turns = jit.Float64(at) * jit.Float64(hearing.wave_cycles / speed)
    s, c = dr.sincos(jit.Float(turns - dr.floor(turns)) * (-2.0 * math.pi))

    # what a sphere scatters is known: its rays only share it out
    expected = _sphere_energy(place, coherent) * dr.square(heard) * pattern / dr.square(dr.square(place.distance))
    scale = dr.select(
        (place.kind == SPHERE) & (total > 0.0), expected * seen / dr.maximum(total, 1e-37), 1.0 - coherent
    )
    dr.eval(scale)
    owner = dr.arange(jit.UInt32, dr.width(rays.energy)) // k
    energy = rays.energy * dr.gather(jit.Float, scale, owner)
    strength, turn = complex_normal32(rays.word)
    rs, rc = dr.sincos(2.0 * math.pi * turn)
    amplitude = dr.sqrt(energy * strength)
    made = Sighting(
        small=place.small, dulled=1.0 - coherent, energy=energy, distance=rays.distance, real=amplitude * rc,
        imaginary=amplitude * rs, beam=rays.beam, label=rays.label, size=size, cosine=c, sine=s,
        reach=listener.measured_range(at, lane, place.velocity, way), direction=in_sensor,
        nearest=beam, point=place.kind == SPHERE,
    )  # fmt: skip
    dr.eval(made)
    return made


def _sphere_energy(place: Place, coherent: Array) -> Array:
    """Backscattering cross section [m^2] of what is not coherent: its facets' f^2, and Lambert's (2/3) pi a^2 mu."""
    rough = dr.square(place.form) + (2.0 / 3.0 * math.pi) * place.lambert * dr.square(place.radius)
    return (1.0 - coherent) * rough
