"""The fan of a sonar: its water, its rays, the surfaces that scatter, and the way from hits to patches."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.absorption import absorption, check_frequency
from pelagos.acoustics.echo import Patches, strip_span, widened
from pelagos.acoustics.loss_column import LossColumn, loss_column
from pelagos.acoustics.refraction import LEVELS, Profile, arc, depart, profile_from, reduced_range, turned
from pelagos.acoustics.spreading import patch_intensity
from pelagos.jit import Array
from pelagos.math.quick import larger, smaller
from pelagos.math.so3 import rotate
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Hits, Rays
from pelagos.sensors.sonar.ping.sea_surface import Sea, with_sea_surface
from pelagos.sensors.sonar.ping.surface_scattering import Surfaces, patch_factor, scattering

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean

Trace: TypeAlias = "Callable[[str, Array, str], None] | None"

_ARC: Final = 60.0  # [m], longest arc of a bent ray where it needs few
_ARCS: Final = (4, 16)  # fewest and most of them
_STEEPEST: Final = 2.0  # longest strip, relative to one on level ground
_GROUND: Final = 0.8  # upward part of the normal of ground, which goes on where a strip leaves its triangle
_SLOPING: Final = 0.01  # [rad], angle that a strip of ground may stretch to, at most four times as far as others
_LEAST_SINE: Final = 0.01  # grazing angle below which patches are cut off (0.6 deg)


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
class Medium:
    """Water at the sonar, one lane a copy and tick, `Float` each: a Dr.Jit struct.

    Attributes:
        sound_speed: c [m/s].
        absorption: [dB/m].
        column: absorption above and below; None: the same everywhere.
    """

    sound_speed: Array
    absorption: Array
    column: LossColumn | None = None

    def mean_loss(self, row: Array, start: Array, end: Array) -> Array:
        """Mean absorption [dB/m] along straight ways from a height `start` to `end`, relative to the sonar's [m]."""
        return spread(self.absorption, row) if self.column is None else self.column.mean(row, start, end)


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


def medium_of(
    frequency_hz: float, ph: float, where: str = "", *, reach: float = 0.0, bottom: float = 0.0
) -> Callable[[Ocean, Array, Array], Medium]:
    """A function (ocean, position, t) -> `Medium` for a sonar of that frequency, to be frozen; `where` names it.

    Args:
        frequency_hz: [Hz].
        ph: acidity.
        where: path of the sonar.
        reach: how far its rays go [m]; 0: only the water at the sonar counts.
        bottom: height of the deepest ground [m].
    """
    check_frequency(frequency_hz, where)

    def medium(ocean: Ocean, position: Array, t: Array) -> Medium:
        def loss(place: Array, when: Array) -> Array:
            temperature, salinity = ocean.temperature(place, when), ocean.salinity(place, when)
            return absorption(jit.Float64(frequency_hz), temperature, salinity, dr.maximum(-place[2], 0.0), ph)

        speed = jit.Float(ocean.sound_speed(position, t))
        if reach <= 0.0:
            return Medium(speed, jit.Float(loss(position, t)))
        dr.eval(position)
        ends = (partial(lowest, reach=reach, bottom=bottom), partial(highest, reach=reach))
        column = loss_column(loss, position, t, *ends)
        return Medium(speed, column.here, column)

    return medium


def profile_of(ocean: Ocean, position: Array, t: Array, *, reach: float, bottom: float) -> Profile:
    """Sound speed above and below each place, from the surface or `reach` [m] above it down to as far below.

    `bottom` is the height of the deepest ground [m]: there is no water below it.
    """
    top, low = highest(position[2], reach), lowest(position[2], reach, bottom)
    step = (top - low) * (1.0 / (LEVELS - 1))
    dr.eval(low, step)
    level = dr.arange(jit.UInt32, dr.width(position) * LEVELS)
    row = level // LEVELS
    height = dr.gather(jit.Float64, low, row) + dr.gather(jit.Float64, step, row) * jit.Float64(level % LEVELS)
    x, y, z = (dr.gather(jit.Float64, p, row) for p in position)
    when = dr.gather(jit.Float64, t, row) if dr.width(t) > 1 else t
    here = ocean.sound_speed(position, t)
    excess = ocean.sound_speed(jit.Array3f64(x, y, z + height), when) - dr.gather(jit.Float64, here, row)
    made = jit.Float(excess)
    dr.eval(made)
    return profile_from(made, jit.Float(here), jit.Float(low), jit.Float(step))


def highest(z: Array, reach: float) -> Array:
    """Top of the water over a height, or how far up rays reach [m]."""
    return dr.minimum(jit.Float64(reach), dr.maximum(-z, 0.0) + 1.0)


def lowest(z: Array, reach: float, bottom: float) -> Array:
    """The deepest ground under a height, or how far down rays reach [m], negative."""
    return -dr.minimum(jit.Float64(reach), dr.maximum(z - bottom, 0.0) + 1.0)


def arcs_of(reach: float) -> int:
    """How many arcs a bent ray is made of."""
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
    dr.make_opaque(made)
    return made


@jit.struct
class View:
    """What a sonar's rays saw, one lane a ray: a Dr.Jit struct.

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


def spread(values: Array, row: Array) -> Array:
    """Values of rows; of the only one without looking it up, which is what a single sonar's rays would spend their
    time on."""
    return values if dr.width(values) == 1 else dr.gather(type(values), values, row)


def look(
    caster: Caster,
    fan: Fan,
    lanes: Lanes,
    surfaces: Surfaces,
    *,
    max_range: float,
    smooth: bool = True,
    assumed_speed: float | None = None,
) -> View:
    """Cast a sonar's fan on every lane.

    Args:
        caster, tables: see `cast`.
        fan: rays in the sensor frame, r of them.
        lanes: where the sonar is.
        surfaces: names the row of the sea surface.
        max_range: [m].
        smooth: interpolate normals.
        assumed_speed: sound speed that an array along y steers its beams by [m/s]; None: that of the water.

    Where the lanes have a profile, rays follow it: `hits.t` is then the range that the echo's time means at the sonar's
    sound speed, and `direction` that of arrival. A sonar in the air sees nothing: next to no sound leaves its face.
    """
    sight = pointed(fan, lanes, assumed_speed)
    return see(caster, sight, lanes, surfaces, max_range=max_range, smooth=smooth)


@jit.struct
class Sight:
    """Where rays look, one lane a ray: a Dr.Jit struct; fields as of `View`."""

    lane: Array
    ray: Array
    direction: Array
    along: Array
    aside: Array


def pointed(fan: Fan, lanes: Lanes, assumed_speed: float | None = None) -> Sight:
    """The fan as it stands on every lane; `assumed_speed` see `look`."""
    rays = dr.width(fan.beam)
    index = dr.arange(jit.UInt32, rays * dr.width(lanes.position))
    lane, ray = index // rays, index % rays
    q = spread(jit.Array4f(lanes.attitude), lane)
    ways = [fan.direction, fan.along, fan.aside]
    if dr.width(lanes.position) > 1:
        ways = [dr.gather(jit.Array3f, way, ray) for way in ways]
    if assumed_speed is not None:
        ways[0] = steered(ways[0], spread(lanes.medium.sound_speed, lane) * (1.0 / assumed_speed))
    return Sight(lane, ray, *(rotate(q, way) for way in ways))


def see(
    caster: Caster, sight: Sight, lanes: Lanes, surfaces: Surfaces, *, max_range: float, smooth: bool = True
) -> View:
    """Cast rays that look where `sight` says; the rest as of `look`."""
    lane, direction = sight.lane, sight.direction
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
    return View(lane, sight.ray, origin, direction, sight.along, sight.aside, hits, sine, loss)


def steered(direction: Array, factor: Array) -> Array:
    """Where beams of an array along y look whose phases are for another sound speed: sin a c/c' in place of sin a.

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
    profile, count = lanes.profile, arcs_of(max_range)
    assert profile is not None
    reach = max_range / count
    ray = depart(profile, row, dr.zeros(jit.Float, dr.width(row)), rays.direction.z)
    origin, final = rays.origin, rays.direction
    found: Hits | None = None
    for k in range(count):
        after, chord = arc(profile, ray, jit.Float(reach))
        direction = turned(rays.direction, chord.sine, chord.cosine)
        active = rays.max_range > 0.0 if found is None else (rays.max_range > 0.0) & ~found.valid
        shot = Rays(origin, direction, dr.select(active, chord.length, 0.0), rays.copy, rays.own)
        hits = caster.cast(shot, smooth=smooth)
        hits = with_sea_surface(hits, shot, surfaces.sea_row, lanes.sea, row)
        part = dr.clip(hits.t / chord.length, 0.0, 1.0)
        s, c = dr.sincos(chord.turn * (part - 0.5))  # the arc's own direction there, from its chord's
        arrival = turned(direction, chord.sine * c + chord.cosine * s, chord.cosine * c - chord.sine * s)
        hits.t = dr.select(hits.valid, k * reach + reduced_range(chord, part, jit.Float(reach)), dr.inf)
        final = dr.select(active, arrival, final)
        found = hits if found is None else dr.select(active, hits, found)
        origin = origin + jit.Array3f64(direction) * jit.Float64(chord.length)
        ray = after
    assert found is not None
    return found, final


def patches_of(
    view: View,
    fan: Fan,
    lanes: Lanes,
    surfaces: Surfaces,
    *,
    longest: float,
    fall: Callable[[Array, Array], Array] = patch_intensity,
    trace: Trace = None,
) -> Patches:
    """The echo of every ray as a strip of surface: its intensity re the source level at 1 m, or, with another `fall`
    of distance [m] and absorption [dB/m] than the water's, what a gain makes of it.

    The patch of a stratum with solid angle w has the area w t^2/sin(grazing); its echo is sigma w/(t^2 sin) times the
    two-way absorption (Lurton 2010, Eq. 3.38). Area and strip are those of the triangle that was hit, so that patches
    tile the mesh as it is; what it scatters follows the interpolated normal.
    """
    hits = view.hits
    t = dr.select(hits.valid, hits.t, 1.0)
    loss = view.loss
    section = scattering(surfaces, hits.material, view.sine) * patch_factor(hits, surfaces)
    normal = hits.normal
    facing = larger(dr.abs(dr.dot(normal, view.direction)), _LEAST_SINE)
    scattered = section / facing * view.of_ray(fan.weight)
    lower, upper = view.of_ray(fan.lower), view.of_ray(fan.upper)
    # a strip much longer than on level ground leaves the thing that was hit: the side of a boulder, the rim of a hull
    level = _STEEPEST * (upper - lower)
    angle = dr.select(normal.z > _GROUND, larger(smaller(4.0 * level, _SLOPING), level), level)
    slant = t / larger(dr.abs(view.direction.z), 0.02)
    limit = smaller(angle * slant, longest)
    near, far, slide = strip_span(t, view.direction, normal, view.along, view.aside, lower, upper, limit)
    length, width = None, None
    if fan.across is not None:  # their product is the strip's area
        length = larger((far - near) * dr.norm(slide), t * (upper - lower))
        width = t * view.of_ray(fan.across) * dr.rsqrt(dr.square(facing) + dr.square(dr.dot(normal, view.along)))
    if fan.half is not None:
        half = view.of_ray(fan.half)
        limit = smaller(_STEEPEST * half * slant, longest)
        near, far = widened(near, far, t, view.direction, normal, view.along, half, limit)
    if trace is not None:
        for name, value, unit in (
            ("ray direction, up component", view.direction.z, "1"),
            ("slant range", hits.t, "m"),
            ("sine of the grazing angle", view.sine, "1"),
            ("cross section per unit area", section, "1"),
            ("echo intensity of a ray re 1 m", scattered * patch_intensity(t, loss), "1"),
            ("range span of a ray's patch", far - near, "m"),
        ):
            trace(name, value, unit)
    return Patches(
        valid=hits.valid,
        distance=t,
        near=near,
        far=far,
        energy=dr.select(hits.valid, scattered * fall(t, loss), 0.0),
        slide=slide,
        direction=view.direction,
        label=hits.label,
        instance=hits.instance,
        length=length,
        width=width,
    )
