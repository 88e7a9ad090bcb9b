"""The fan of a sonar: its water, its rays, the surfaces that scatter, and the way from hits to patches."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final, TypeAlias

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.refraction import Bend, Profile, arc, depart, entered, reduced_range, turned
from pelagos.jit import Array
from pelagos.math.so3 import rotate
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Hits, Rays, no_hits
from pelagos.sensors.sonar.ping.medium import Medium, spread
from pelagos.sensors.sonar.ping.sea_surface import Sea, with_sea_surface
from pelagos.sensors.sonar.ping.surface_scattering import Surfaces
from pelagos.sensors.sonar.ping.water_around import STATIONS, Around

Trace: TypeAlias = "Callable[[str, Array, str], None] | None"

_ARC: Final = 60.0  # [m], longest arc of a bent ray where it needs few
_ARCS: Final = (4, 16)  # fewest and most of them


@jit.struct
class Fan:
    """The rays of a sonar in its own frame, a Dr.Jit struct; each stands for a stratum of directions.

    Attributes:
        direction: `Array3f`, unit vectors.
        along: `Array3f`, unit vectors, square to `direction`: the way in which the strata are thin.
        aside: `Array3f`, from the ray's direction to the one in its beam's middle at the same place along `along`.
        lower, upper: `Float` [rad], from the ray to the edges of its stratum along `along` (`lower` negative).
        weight: `Float` [sr]: solid angle of the stratum times the two-way power pattern that is no beamformer's.
        beam: `UInt32`.
        half: `Float` [rad], how far the stratum reaches to both sides, square to `along`; None where that is of no
            matter, since its neighbours in the beam reach as far.
        across: `Float` [rad], angle square to `along` that the ray stands for alone, see `rays_per_facet`; None where
            no two rays are to meet one facet of the roughness.
    """

    direction: Array
    along: Array
    aside: Array
    lower: Array
    upper: Array
    weight: Array
    beam: Array
    half: Array | None = None
    across: Array | None = None


@jit.struct
class Lanes:
    """A sonar on every lane (copy and tick): a Dr.Jit struct.

    Attributes:
        position: `Array3f64`, world NWU [m].
        attitude: `Array4f64`, sensor frame to world.
        copy, own: `UInt32`, see `Rays`.
        environment, tick: `UInt32`, what random numbers are counted by.
        medium: water at the sonar.
        profile: sound speed above and below it, one row a lane; None where rays are straight.
        sea: the surface around it; None where that is flat and at rest.
        wet: `Bool`, the sonar is in the water; None: it is.
        around: profiles along the ways of rays; None where they are all as at the sonar.
    """

    position: Array
    attitude: Array
    copy: Array
    own: Array
    environment: Array
    tick: Array
    medium: Medium
    profile: Profile | None = None
    sea: Sea | None = None
    wet: Array | None = None
    around: Around | None = None


def arcs_of(reach: float) -> int:
    """Number of arcs that a bent ray is made of."""
    return min(max(math.ceil(reach / _ARC), _ARCS[0]), _ARCS[1])


def fan_struct(fan: dict[str, NDArray[Any]]) -> Fan:
    """The device arrays of a ray pattern made on the host: `direction`, `along`, `aside` `(r, 3)`; the rest `(r,)`, of
    which `half` and `across` may be absent."""
    made = Fan(
        direction=jit.Array3f(np.ascontiguousarray(fan["direction"].T, dtype=np.float32)),
        along=jit.Array3f(np.ascontiguousarray(fan["along"].T, dtype=np.float32)),
        aside=jit.Array3f(np.ascontiguousarray(fan["aside"].T, dtype=np.float32)),
        lower=jit.Float(fan["lower"].astype(np.float32)),
        upper=jit.Float(fan["upper"].astype(np.float32)),
        weight=jit.Float(fan["weight"].astype(np.float32)),
        beam=jit.UInt32(fan["beam"].astype(np.uint32)),
        half=jit.Float(fan["half"].astype(np.float32)) if "half" in fan else None,
        across=jit.Float(fan["across"].astype(np.float32)) if "across" in fan else None,
    )
    jit.align(made)
    return made


@jit.struct
class FanHits:
    """Hits of a sonar's rays, one lane a ray: a Dr.Jit struct.

    Attributes:
        lane: `UInt32`, copy and tick that the ray belongs to.
        ray: `UInt32`, row of the fan.
        origin: `Array3f64`, of the ray, world [m].
        direction, along, aside: `Array3f`, world frame, see `Fan`.
        hits: see `Hits`; the sea surface from below counts as a hit of the material row behind the world's last.
        sine: `Float`, of the grazing angle.
        loss: `Float`, mean absorption along the way [dB/m].
    """

    lane: Array
    ray: Array
    origin: Array
    direction: Array
    along: Array
    aside: Array
    hits: Hits
    sine: Array
    loss: Array

    def of_lane(self, values: Array) -> Array:
        """Values by lane as values by ray."""
        return spread(values, self.lane)

    def of_ray(self, values: Array) -> Array:
        """Values by ray of the fan as values by ray of all fans."""
        return values if dr.width(values) == dr.width(self.ray) else dr.gather(type(values), values, self.ray)


def cast_fan(
    caster: Caster,
    fan: Fan,
    lanes: Lanes,
    surfaces: Surfaces,
    *,
    max_range: float,
    smooth: bool = True,
    assumed_speed: float | None = None,
) -> FanHits:
    """Cast a sonar's fan on every lane.

    Args:
        caster: the world, see `Caster`.
        fan: rays in the sensor frame, r of them.
        lanes: where the sonar is.
        surfaces: names the row of the sea surface.
        max_range: [m].
        smooth: interpolate normals.
        assumed_speed: sound speed that an array along y steers its beams by [m/s]; None: that of the water.

    Where the lanes have a profile, rays follow it: `hits.t` is then the range that the echo's time means at the sonar's
    sound speed, and `direction` that of arrival. A sonar in the air sees nothing: next to no sound leaves its face.
    """
    aim = aim_of(fan, lanes, assumed_speed)
    return cast_along(caster, aim, lanes, surfaces, max_range=max_range, smooth=smooth)


@jit.struct
class Aim:
    """Directions of rays, one lane a ray: a Dr.Jit struct; fields as of `FanHits`."""

    lane: Array
    ray: Array
    direction: Array
    along: Array
    aside: Array


def aim_of(fan: Fan, lanes: Lanes, assumed_speed: float | None = None) -> Aim:
    """The fan as it stands on every lane; `assumed_speed` see `cast_fan`."""
    rays = dr.width(fan.beam)
    index = dr.arange(jit.UInt32, rays * dr.width(lanes.position))
    lane, ray = index // rays, index % rays
    q = spread(jit.Array4f(lanes.attitude), lane)
    ways = [fan.direction, fan.along, fan.aside]
    if dr.width(lanes.position) > 1:
        ways = [dr.gather(jit.Array3f, way, ray) for way in ways]
    if assumed_speed is not None:
        ways[0] = steered_directions(ways[0], spread(lanes.medium.sound_speed, lane) * (1.0 / assumed_speed))
    return Aim(lane, ray, *(rotate(q, way) for way in ways))


def cast_along(
    caster: Caster, aim: Aim, lanes: Lanes, surfaces: Surfaces, *, max_range: float, smooth: bool = True
) -> FanHits:
    """Cast rays that look where `aim` says; the rest as of `cast_fan`."""
    lane, direction = aim.lane, aim.direction
    origin = spread(lanes.position, lane)
    far = jit.Float(max_range)
    if lanes.wet is not None:
        far = dr.select(spread(lanes.wet, lane), far, 0.0)
    shot = Rays(origin, direction, far, spread(lanes.copy, lane), spread(lanes.own, lane))
    if lanes.profile is not None:
        hits, direction = cast_bent(caster, shot, surfaces, lanes, lane, max_range, smooth=smooth)
    else:
        hits = caster.cast(shot, smooth=smooth)
        hits = with_sea_surface(hits, shot, surfaces.sea_row, lanes.sea, lane)
    sine = dr.abs(dr.dot(hits.shading_normal, direction))
    loss = lanes.medium.mean_loss(lane, jit.Float(0), jit.Float(hits.position.z - origin.z))
    return FanHits(lane, aim.ray, origin, direction, aim.along, aim.aside, hits, sine, loss)


def steered_directions(direction: Array, factor: Array) -> Array:
    """Directions of beams of an array along y whose phases are for another sound speed: sin a c/c' in place of sin a.

    `direction` in the sensor frame; `factor` c/c', water over assumed.
    """
    left = dr.clip(direction.y * factor, -1.0, 1.0)
    ahead = dr.sqrt(dr.maximum(1.0 - left * left, 0.0) / dr.maximum(1.0 - dr.square(direction.y), 1e-9))
    return jit.Array3f(direction.x * ahead, left, direction.z * ahead)


def cast_bent(
    caster: Caster, rays: Rays, surfaces: Surfaces, lanes: Lanes, row: Array,
    max_range: float, *, smooth: bool,
) -> tuple[Hits, Array]:  # fmt: skip
    """Cast rays along the chords of their arcs; hits with reduced ranges (see `arc`), and directions of arrival."""
    profile, around = lanes.profile, lanes.around
    assert profile is not None
    count = arcs_of(max_range) if around is None else STATIONS
    reach = max_range / count
    home = dr.gather(jit.Float, profile.speed, row)
    water = profile if around is None else around.profile

    def go_in(before: Profile, ray: Bend, origin: Array) -> Bend:
        if around is None:
            return ray
        way = jit.Array3f(origin - rays.origin)
        away = dr.sqrt(dr.square(way.x) + dr.square(way.y)) + 0.5 * reach * ray.cosine
        return entered(before, ray, around.profile, around.row(row, rays.direction, away))

    def go_on(k: Array, origin: Array, ray: Bend, _: Array, __: Hits) -> tuple[Any, ...]:
        length = jit.Float(reach) if around is None else reach * dr.gather(jit.Float, water.speed, ray.row) / home
        after, chord = arc(water, ray, length)
        direction = turned(rays.direction, chord.sine, chord.cosine)
        shot = Rays(origin, direction, chord.length, rays.copy, rays.own)
        hits = caster.cast(shot, smooth=smooth)
        hits = with_sea_surface(hits, shot, surfaces.sea_row, lanes.sea, row)
        part = dr.clip(hits.t / chord.length, 0.0, 1.0)
        s, c = dr.sincos(chord.turn * (part - 0.5))  # the arc's own direction there, from its chord's
        arrival = turned(direction, chord.sine * c + chord.cosine * s, chord.cosine * c - chord.sine * s)
        before = jit.Float(jit.Float64(k) * reach)
        hits.t = dr.select(hits.valid, before + reduced_range(chord, part, jit.Float(reach)), dr.inf)
        origin = origin + jit.Array3f64(direction) * jit.Float64(chord.length)
        return k + 1, origin, go_in(water, after, origin), arrival, hits

    rows = dr.width(row)
    ray = go_in(profile, depart(profile, row, dr.zeros(jit.Float, rows), rays.direction.z), rays.origin)
    start = (dr.zeros(jit.UInt32, rows), rays.origin, ray, rays.direction, no_hits())
    asked = rays.max_range > 0.0
    end = dr.while_loop(
        start, lambda k, origin, ray, final, found: asked & (k < count) & ~found.valid, go_on, mode="symbolic",
        labels=("arc", "origin", "ray", "final", "found"),
    )  # fmt: skip
    return end[4], end[3]
