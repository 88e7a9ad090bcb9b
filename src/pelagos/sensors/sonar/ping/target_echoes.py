"""Echoes of things that few rays would meet, and of smooth ones: where and how strongly each is heard.

A thing's own rays go to places spread evenly over its disc, as the sonar sees it. They tell what stands before it, and
what its surface scatters; the coherent part of a smooth sphere, box or cylinder is computed from its shape. Coherent
echoes are heard by each beam through the array's pattern in their own direction, and by each bin through the pulse at
their own range: neither sectors nor bins round them.

Source: X. Lurton, An Introduction to Underwater Acoustics (2nd ed., 2010), Chapters 3 and 5; see also `specular`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import drjit as dr

from pelagos import jit
from pelagos.acoustics.echo_walk import Bins, pitch
from pelagos.acoustics.pulse import response
from pelagos.acoustics.speckle import lattice_word, on_instance, scramble
from pelagos.acoustics.specular import flat_side, roughness_loss, round_side, sphere_amplitude
from pelagos.acoustics.spreading import from_db, time_varied_gain
from pelagos.acoustics.target_tag import tag
from pelagos.jit import Array
from pelagos.math.philox import complex_normal32
from pelagos.math.so3 import multiply, rotate, rotate_back
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import NO_BODY, Rays
from pelagos.sensors.sonar.ping.aperture import Aperture, Facing
from pelagos.sensors.sonar.ping.fan import Lanes, steered
from pelagos.sensors.sonar.ping.surface_scattering import Surfaces, scattering
from pelagos.sensors.sonar.ping.targets import BOX, CYLINDER, FEW, SPHERE, Targets

_GOLDEN: Final = math.pi * (3.0 - math.sqrt(5.0))
_RAYS: Final = (64, 16)  # of a thing, where there are few things, and many
_MANY_THINGS: Final = 64
_INSIDE: Final = 0.985  # of a thing's disc: the limb of a polyhedron lies within that of its sphere
_NEAREST: Final = 0.2  # [m]
_SAMPLED: Final = 0.3  # of a resolution between samples, of which a wide bin keeps the strongest
_COHERENT: Final = 1e-3  # part of the intensity below which nothing is coherent


@dataclass(frozen=True)
class Hearing:
    """How a sonar hears targets.

    Attributes:
        aperture: its patterns.
        beams: their number.
        rays_per_sr: of its fan.
        wave_cycles: 2 f [Hz].
        wavelength: at 1500 m/s [m].
        reach: farthest range [m].
        coupling_s: range that a chirp mistakes for a closing speed of 1 m/s, see `range_coupling` [s].
        doppler: whether motion shifts ranges.
        assumed_speed: sound speed that turns times into ranges, and phases into angles [m/s]; None: the water's.
    """

    aperture: Aperture
    beams: int
    rays_per_sr: float
    wave_cycles: float
    wavelength: float
    reach: float
    coupling_s: float
    doppler: bool
    assumed_speed: float | None = None


@jit.struct
class Sighting:
    """What is known of each thing in a ping, pings by things (and by its rays): a Dr.Jit struct.

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


def sighted(
    caster: Caster, things: Targets, lanes: Lanes, surfaces: Surfaces, facing: Facing, hearing: Hearing, velocity: Array
) -> Sighting:
    """Look for all things on every lane; `velocity` `Array3f64` of the sonar by lane, world frame [m/s]."""
    count, pings = dr.width(things.kind), dr.width(lanes.position)
    k = rays_of(count)
    row = dr.arange(jit.UInt32, pings * count)
    place = _placed(caster, things, lanes, row, count)
    dr.eval(place)
    far = place.distance < hearing.reach + place.radius
    own = dr.gather(jit.UInt32, lanes.own, row // count)
    here = far & (place.distance > place.radius + _NEAREST) & ((own == NO_BODY) | (place.body != own))
    if lanes.wet is not None:
        here &= dr.gather(jit.Bool, lanes.wet, row // count)
    solid_angle = dr.pi * dr.square(place.radius / place.distance)
    place.small = here & (solid_angle * hearing.rays_per_sr < FEW)
    coherent = roughness_loss(place.smooth, jit.Float(1.0))
    echo = _coherent(place, hearing)
    asked = here & (place.small | (coherent > _COHERENT) & (echo.size > 0.0))  # rays to all others tell nothing
    dr.eval(place.small, here, coherent, echo, asked)
    rays = _own_rays(caster, place, asked, echo, lanes, surfaces, facing, hearing, velocity, k=k, count=count)
    return _merged(place, here, coherent, echo, rays, lanes, facing, hearing, velocity, k=k, count=count)


@jit.struct
class _Place:
    kind: Array
    distance: Array
    direction: Array
    local: Array
    attitude: Array
    half: Array
    radius: Array
    form: Array
    mirror: Array
    smooth: Array
    lambert: Array
    instance: Array
    body: Array
    velocity: Array
    small: Array


@jit.struct
class _Echo:
    """Coherent amplitude over what the surface reflects, its range, and the place it comes from, from the sonar."""

    size: Array
    reach: Array
    way: Array


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


def _placed(caster: Caster, things: Targets, lanes: Lanes, row: Array, count: int) -> _Place:
    """Where things are as their sonars see them: `local` is the sonar's place in the thing's own frame [m]."""
    tables = caster.tables
    lane, thing = row // count, row % count
    copy = dr.gather(jit.UInt32, lanes.copy, lane)
    copies = dr.width(things.body) // count
    body = dr.gather(jit.UInt32, things.body, thing * copies + dr.minimum(copy, copies - 1))
    moves = body != NO_BODY
    origin = dr.gather(jit.Array3f64, lanes.position, lane)
    centre = dr.gather(jit.Array3f64, things.centre, thing)
    turn = dr.gather(jit.Array4f, tables.body_attitude, body, moves)
    at = dr.gather(jit.Array3f64, tables.body_position, body, moves)
    carried = at + jit.Array3f64(rotate(turn, jit.Array3f(centre)))
    way = jit.Array3f(dr.select(moves, carried, centre) - origin)
    axes = dr.gather(jit.Array4f, things.axes, thing)
    attitude = dr.select(moves, multiply(turn, axes), axes)
    distance = dr.maximum(dr.norm(way), 1e-3)

    def gather(values: Array) -> Array:
        return dr.gather(jit.Float, values, thing)

    return _Place(
        kind=dr.gather(jit.UInt32, things.kind, thing),
        distance=distance,
        direction=way / distance,
        local=rotate_back(attitude, -way),
        attitude=attitude,
        half=dr.gather(jit.Array3f, things.half, thing),
        radius=gather(things.radius),
        form=gather(things.form),
        mirror=gather(things.mirror),
        smooth=gather(things.smooth),
        lambert=gather(things.lambert),
        instance=dr.gather(jit.UInt32, things.instance, thing),
        body=body,
        velocity=dr.select(moves, dr.gather(jit.Array3f, tables.body_velocity, body, moves), 0.0),
        small=jit.Bool(False),
    )


def _coherent(place: _Place, hearing: Hearing) -> _Echo:
    """The mirror's part of each thing's echo, before roughness; of a box that of its loudest side."""
    wavelength = jit.Float(hearing.wavelength)
    near = dr.maximum(place.distance - place.radius, 1e-3)
    size = dr.select(place.kind == SPHERE, sphere_amplitude(place.form, place.radius, near), 0.0)
    reach, foot = jit.Float(near), place.local * (place.radius / place.distance)
    p, h = place.local, place.half
    for a in range(3):
        u, v = (a + 1) % 3, (a + 2) % 3
        loud, far, _ = flat_side((h[u], h[v]), (p[u], p[v]), dr.abs(p[a]) - h[a], wavelength)
        loud = dr.select((place.kind == BOX) & (dr.abs(p[a]) > h[a]), loud * place.mirror, 0.0)
        spot = jit.Array3f(0)
        spot[a], spot[u], spot[v] = (
            dr.select(p[a] < 0.0, -h[a], h[a]),
            dr.clip(p[u], -h[u], h[u]),
            dr.clip(p[v], -h[v], h[v]),
        )
        louder = loud > size
        size, reach = dr.select(louder, loud, size), dr.select(louder, far, reach)
        foot = dr.select(louder, spot, foot)
    across = dr.sqrt(p.x * p.x + p.y * p.y)
    loud, far, _ = round_side(h.x, h.z, p.z, across, wavelength)
    loud = dr.select((place.kind == CYLINDER) & (across > h.x), loud * place.mirror, 0.0)
    rim = h.x / dr.maximum(across, 1e-6)
    side = jit.Array3f(p.x * rim, p.y * rim, dr.clip(p.z, -h.z, h.z))
    edge = h.x * (0.5 * math.sqrt(math.pi))  # a square as large as the cap
    cap, cap_far, _ = flat_side((edge, edge), (p.x, p.y), dr.abs(p.z) - h.z, wavelength)
    cap = dr.select((place.kind == CYLINDER) & (dr.abs(p.z) > h.z), cap * place.mirror, 0.0)
    top = jit.Array3f(dr.clip(p.x, -edge, edge), dr.clip(p.y, -edge, edge), dr.select(p.z < 0.0, -h.z, h.z))
    for loud_, far_, spot in ((loud, far, side), (cap, cap_far, top)):
        louder = loud_ > size
        size, reach = dr.select(louder, loud_, size), dr.select(louder, far_, reach)
        foot = dr.select(louder, spot, foot)
    return _Echo(size, reach, rotate(place.attitude, foot - place.local))


def _own_rays(
    caster: Caster, place: _Place, asked: Array, echo: _Echo, lanes: Lanes, surfaces: Surfaces, facing: Facing,
    hearing: Hearing, velocity: Array, *, k: int, count: int,
) -> _OwnRays:  # fmt: skip
    """Rays over the disc of small things; those of others go to the place that their coherent echo comes from."""
    index = dr.arange(jit.UInt32, dr.width(place.distance) * k)
    row, ray = index // k, index % k
    lane = row // count

    def gather(kind: Any, values: Array) -> Array:
        return dr.gather(kind, values, row)

    small, distance = gather(jit.Bool, place.small), gather(jit.Float, place.distance)
    towards, radius = gather(jit.Array3f, place.direction), gather(jit.Float, place.radius)
    spot = gather(jit.Array3f, echo.way)
    target = dr.select(small, towards * distance, spot)
    disc = dr.select(small, radius * _INSIDE, 0.01 * dr.norm(spot))
    part = dr.sqrt((jit.Float(ray) + 0.5) * (1.0 / k)) * disc
    s, c = dr.sincos(jit.Float(ray) * _GOLDEN)
    aside = dr.normalize(
        dr.cross(dr.select(dr.abs(towards.z) < 0.9, jit.Array3f(0, 0, 1), jit.Array3f(1, 0, 0)), towards)
    )
    above = dr.cross(towards, aside)
    direction = dr.normalize(target + aside * (part * c) + above * (part * s))
    active = gather(jit.Bool, asked)
    origin = dr.gather(jit.Array3f64, lanes.position, lane)
    copy, own = dr.gather(jit.UInt32, lanes.copy, lane), dr.gather(jit.UInt32, lanes.own, lane)
    hits = caster.cast(Rays(origin, direction, dr.select(active, distance + radius, 0.0), copy, own), smooth=True)
    met = hits.valid & (hits.instance == gather(jit.UInt32, place.instance))
    end = dr.select(small, distance - radius, dr.norm(spot))
    blocked = hits.valid & ~met & (hits.t < end)
    sine = dr.abs(dr.dot(hits.shading_normal, direction))
    facing_sine = dr.maximum(dr.abs(dr.dot(hits.normal, direction)), 0.02)
    section = scattering(surfaces, hits.material, sine)
    t = dr.select(met, hits.t, 1.0)
    loss = lanes.medium.mean_loss(lane, jit.Float(0), jit.Float(hits.position.z - origin.z))
    solid_angle = (math.pi / k) * dr.square(disc / distance)
    in_sensor = rotate_back(dr.gather(jit.Array4f, jit.Array4f(lanes.attitude), lane), direction)
    in_sensor = _apparent(in_sensor, lanes, lane, hearing)
    beam, pattern = _sector(facing, hearing, in_sensor)
    energy = section / facing_sine * solid_angle * from_db(-2.0 * loss * t) / dr.square(t) * pattern
    closing = _closing(velocity, lane, hits.velocity, direction)
    shifted = _shifted(t, closing, lanes, lane, hearing)
    cell = (jit.UInt32(jit.Int32(dr.floor(v))) for v in hits.place * (2.0 / hearing.wavelength))
    word = scramble(on_instance(lattice_word(tuple(cell), jit.UInt32(0)), hits.instance) + ray)
    made = _OwnRays(
        energy=dr.select(met & small, energy, 0.0), distance=shifted, word=word, beam=beam, label=hits.label,
        hit=dr.select(met, jit.Float(1), 0.0), blocked=dr.select(blocked, jit.Float(1), 0.0), loss=loss,
    )  # fmt: skip
    dr.eval(made)
    return made


def _merged(
    place: _Place, here: Array, coherent: Array, echo: _Echo, rays: _OwnRays, lanes: Lanes, facing: Facing,
    hearing: Hearing, velocity: Array, *, k: int, count: int,
) -> Sighting:  # fmt: skip
    row = dr.arange(jit.UInt32, dr.width(place.distance))
    lane = row // count
    total = dr.block_sum(rays.energy, k)
    hit, blocked = dr.block_sum(rays.hit, k), dr.block_sum(rays.blocked, k)
    dr.eval(total, hit, blocked)
    seen = hit / dr.maximum(hit + blocked, 1.0)
    at = dr.maximum(echo.reach, 1e-2)
    way = dr.normalize(echo.way)
    q = dr.gather(jit.Array4f, jit.Array4f(lanes.attitude), lane)
    in_sensor = _apparent(rotate_back(q, way), lanes, lane, hearing)
    loss = lanes.medium.mean_loss(lane, jit.Float(0), echo.way.z)
    heard = from_db(-loss * at)  # amplitude there and back
    beam, pattern = _sector(facing, hearing, in_sensor)
    is_coherent = here & (coherent > _COHERENT) & (echo.size > 0.0)
    size = dr.select(is_coherent, echo.size * dr.sqrt(coherent * seen) * heard * dr.sqrt(pattern), 0.0)
    if hearing.aperture.steered:
        in_sensor = _level(facing, in_sensor)
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
        reach=_shifted(at, _closing(velocity, lane, place.velocity, way), lanes, lane, hearing), direction=in_sensor,
        nearest=beam, point=place.kind == SPHERE,
    )  # fmt: skip
    dr.eval(made)
    return made


def _sphere_energy(place: _Place, coherent: Array) -> Array:
    """Backscattering cross section [m^2] of what is not coherent: its facets' f^2, and Lambert's (2/3) pi a^2 mu."""
    rough = dr.square(place.form) + (2.0 / 3.0 * math.pi) * place.lambert * dr.square(place.radius)
    return (1.0 - coherent) * rough


def _apparent(direction: Array, lanes: Lanes, lane: Array, hearing: Hearing) -> Array:
    """A direction as an array takes it that steers by another sound speed."""
    if hearing.assumed_speed is None or not hearing.aperture.steered:
        return direction
    return steered(direction, hearing.assumed_speed / dr.gather(jit.Float, lanes.medium.sound_speed, lane))


def _closing(velocity: Array, lane: Array, other: Array, direction: Array) -> Array:
    return dr.dot(jit.Array3f(dr.gather(jit.Array3f64, velocity, lane)) - other, direction)


def _level(facing: Facing, direction: Array) -> Array:
    """A direction turned into the plane of a steered array's beams, at its own angle."""
    up = dr.gather(jit.Array3f, facing.up, jit.UInt32(0))
    return dr.normalize(direction - up * dr.dot(up, direction))


def _shifted(distance: Array, closing: Array, lanes: Lanes, lane: Array, hearing: Hearing) -> Array:
    speed = dr.gather(jit.Float, lanes.medium.sound_speed, lane)
    if hearing.assumed_speed is not None:
        distance = distance * (hearing.assumed_speed / speed)
    if not hearing.doppler:
        return distance
    return distance * (1.0 - closing / speed) - hearing.coupling_s * closing


def _sector(facing: Facing, hearing: Hearing, direction: Array) -> tuple[Array, Array]:
    """The beam whose sector a direction of the sensor frame lies in, and the two-way power pattern that is no
    array's; the number of beams where it lies in none."""
    aperture, beams = hearing.aperture, hearing.beams
    beam, best = jit.UInt32(beams), jit.Float(-2.0)
    if aperture.steered:
        side, up = (dr.gather(jit.Array3f, v, jit.UInt32(0)) for v in (facing.side, facing.up))
        front = dr.cross(side, up)
        angle = dr.atan2(dr.dot(side, direction), dr.dot(front, direction))

        def edge(index: Array) -> Array:
            return _edge_angle(facing, side, front, index, beams)

        found = dr.binary_search(0, beams, lambda index: edge(index) > angle)  # beams go from left to right
        inside = (found > 0) & (found <= beams) & (angle <= edge(jit.UInt32(0))) & (angle > edge(jit.UInt32(beams)))
        beam = dr.select(inside, jit.UInt32(found) - 1, beams)
    else:
        for b in range(beams):
            along = dr.dot(dr.gather(jit.Array3f, facing.axis, jit.UInt32(b)), direction)
            beam, best = dr.select(along > best, jit.UInt32(b), beam), dr.maximum(best, along)
    row = dr.minimum(beam, beams - 1)
    power = aperture.one_way_up(facing, row, direction) ** aperture.ways
    if not aperture.steered:
        power = power * dr.square(aperture.side_amplitude(facing, row, direction))
    ahead = dr.dot(dr.gather(jit.Array3f, facing.axis, row), direction)
    return beam, dr.select(ahead > -0.2, power, 0.0)


def _edge_angle(facing: Facing, side: Array, front: Array, index: Array, beams: int) -> Array:
    """Angle of the edge between sectors `index` - 1 and `index` [rad]."""

    def middle(row: Array) -> Array:
        axis = dr.gather(jit.Array3f, facing.axis, jit.UInt32(row))
        return dr.atan2(dr.dot(side, axis), dr.dot(front, axis))

    if beams == 1:
        return dr.select(index == 0, jit.Float(math.pi), jit.Float(-math.pi))
    at = dr.clip(jit.Int32(index), 1, beams - 1)
    left, right = middle(at - 1), middle(at)
    half = 0.5 * (left - right)
    edge = 0.5 * (left + right)
    return dr.select(index == 0, edge + 2.0 * half, dr.select(index >= beams, edge - 2.0 * half, edge))


@dataclass(frozen=True)
class Grid:
    """Cells of a ping.

    Attributes:
        beams: their number.
        bins: see `Bins`.
        resolution: c/(2B) [m].
        pulse: "chirp" or "cw".
        cell: that levels of the field are calibrated to [rad m].
    """

    beams: int
    bins: Bins
    resolution: float
    pulse: str
    cell: float


def with_small_things(
    sighting: Sighting, grid: Grid, lanes: Lanes, boost: Array, field: Array, tags: Array | None, instances: Array
) -> None:
    """Add the small things' own rays to the amplitudes of a ping's cells, and to its tags; in place.

    One lane a ping takes them one after the other, so that sums do not depend on the number of threads.
    """
    rays = dr.width(sighting.energy) // dr.width(lanes.position)
    k = dr.width(sighting.energy) // dr.width(sighting.size)

    def put(index: Array, at: Array, heard: Array, level: Array) -> None:
        factor = dr.sqrt(level)
        pair = jit.Array2f(*(dr.gather(jit.Float, v, index) * factor for v in (sighting.real, sighting.imaginary)))
        dr.scatter_add(field, pair, at, heard, mode=dr.ReduceMode.NoConflicts)
        if tags is not None:
            energy = dr.gather(jit.Float, sighting.energy, index) * level
            things = dr.width(instances)
            word = tag(energy, dr.gather(jit.UInt32, sighting.label, index),
                       dr.gather(jit.UInt32, instances, index // k % things))  # fmt: skip
            dr.scatter_reduce(dr.ReduceOp.Max, tags, word, at, heard, mode=dr.ReduceMode.NoConflicts)

    _each_ray(sighting, grid, lanes.medium.absorption, boost, rays, put)


def with_small_energies(sighting: Sighting, grid: Grid, absorption: Array, boost: Array, energies: Array) -> None:
    """The same for energies without interference."""
    rays = dr.width(sighting.energy) // dr.width(absorption)

    def put(index: Array, at: Array, heard: Array, level: Array) -> None:
        energy = dr.gather(jit.Float, sighting.energy, index) * level
        dr.scatter_add(energies, energy, at, heard, mode=dr.ReduceMode.NoConflicts)

    _each_ray(sighting, grid, absorption, boost, rays, put)


def _each_ray(
    sighting: Sighting, grid: Grid, absorption: Array, boost: Array, rays: int,
    put: Callable[[Array, Array, Array, Array], None],
) -> None:  # fmt: skip
    """Call `put` with (row of the ray, cell, whether it is heard, level re the source level to that of the field)."""
    ping = dr.arange(jit.UInt32, dr.width(absorption))
    loss, k = jit.Float(absorption), dr.width(sighting.energy) // dr.width(sighting.size)

    def take(j: Array) -> tuple[Array]:
        index = ping * rays + j
        distance, beam = dr.gather(jit.Float, sighting.distance, index), dr.gather(jit.UInt32, sighting.beam, index)
        bin_ = jit.Int32(dr.floor((distance - grid.bins.first_range) * (1.0 / grid.bins.width)))
        heard = (dr.gather(jit.Float, sighting.energy, index) > 0.0) & (beam < grid.beams)
        heard &= (bin_ >= 0) & (bin_ < grid.bins.count)
        row = dr.minimum(beam, grid.beams - 1)
        whole = dr.select(dr.gather(jit.Bool, sighting.point, index // k), dr.gather(jit.Float, boost, row), 1.0)
        level = time_varied_gain(distance, loss, spreading=30.0) * (1.0 / grid.cell) * whole
        put(index, (ping * grid.beams + row) * pitch(grid.bins.count) + jit.UInt32(bin_), heard, level)
        return (j + 1,)

    dr.while_loop((dr.zeros(jit.UInt32, dr.width(absorption)),), lambda j: j < rays, take, mode="symbolic")


def coherent_echoes(
    sighting: Sighting, grid: Grid, aperture: Aperture, facing: Facing, pings: int, *, energies: bool
) -> Array:
    """What each beam hears of coherent echoes in each bin, re the source level at 1 m: two `Float` a cell, or with
    `energies` its intensity, one."""
    beams, bins = grid.beams, grid.bins
    channels = 1 if energies else 2
    field = dr.zeros(jit.Float, pings * beams * bins.count * channels)
    lane = dr.arange(jit.UInt32, pings * beams)
    ping, beam = lane // beams, lane % beams
    things = dr.width(sighting.size) // pings
    taps = math.ceil(2.5 * grid.resolution / bins.width)
    slack = max(0.5 * (bins.width - _SAMPLED * grid.resolution), 0.0)  # a wide bin keeps the strongest of its samples

    def take(m: Array) -> tuple[Array]:
        index = ping * things + m
        size = dr.gather(jit.Float, sighting.size, index)
        if aperture.steered:
            size *= aperture.side_amplitude(facing, beam, dr.gather(jit.Array3f, sighting.direction, index))
        else:
            size = dr.select(dr.gather(jit.UInt32, sighting.nearest, index) == beam, size, 0.0)
        distance = dr.gather(jit.Float, sighting.reach, index)
        middle = jit.Int32(dr.floor((distance - bins.first_range) * (1.0 / bins.width)))
        c, s = dr.gather(jit.Float, sighting.cosine, index), dr.gather(jit.Float, sighting.sine, index)

        def spread(j: Array) -> tuple[Array]:
            bin_ = middle + j
            off = dr.abs(bins.first_range + (jit.Float(bin_) + 0.5) * bins.width - distance)
            part = size * response(dr.maximum(off - slack, 0.0) * (1.0 / grid.resolution), grid.pulse)
            at = lane * bins.count + jit.UInt32(bin_)
            inside = (bin_ >= 0) & (bin_ < bins.count)
            value = part * part if energies else jit.Array2f(part * c, part * s)
            dr.scatter_add(field, value, at, inside, mode=dr.ReduceMode.NoConflicts)
            return (j + 1,)

        first = dr.select(dr.abs(size) > 0.0, jit.Int32(-taps), taps + 1)
        dr.while_loop((first,), lambda j: j <= taps, spread, mode="symbolic")
        return (m + 1,)

    dr.while_loop((dr.zeros(jit.UInt32, pings * beams),), lambda m: m < things, take, mode="symbolic")
    dr.eval(field)
    return field


def excluded(things: Targets, sighting: Sighting, instance: Array, lane: Array) -> tuple[Array, Array]:
    """Of rays that met `instance`: whether the thing has rays of its own, and what part of its scattering is left."""
    count = dr.width(things.kind)
    known = dr.width(things.of_instance)
    row = dr.gather(jit.UInt32, things.of_instance, dr.minimum(instance, known - 1), instance < known)
    is_thing = (instance < known) & (row < count)
    index = lane * count + dr.minimum(row, count - 1)
    small = dr.gather(jit.Bool, sighting.small, index, is_thing)
    return small, dr.select(is_thing, dr.gather(jit.Float, sighting.dulled, index, is_thing), 1.0)
