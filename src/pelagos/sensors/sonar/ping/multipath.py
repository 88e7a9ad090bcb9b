"""Echoes by bounces: rays that go on behind a mirror-like surface, and come home the same way or straight.

A bounced ray sees a target at the whole length of its broken path (out and home by the same bounces), and once more at
the mean of broken and straight path (out one way, home the other). The second happens in both directions at the same
time and with the same phase, so that its amplitude counts twice. No echo arrives before the direct one: a broken path
is longer than a straight one. Mirrors are surfaces as they are hit: slopes of waves and of the bottom turn the ray.

Image construction is exact for plane mirrors: X. Lurton, An Introduction to Underwater Acoustics (2nd ed., 2010),
Section 2.4.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.acoustics.echo import Patches
from pelagos.acoustics.spreading import from_db
from pelagos.jit import Array
from pelagos.math.so3 import rotate_back
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Hits, Rays
from pelagos.sensors.sonar.ping.aperture import BEHIND, Aperture, Facing
from pelagos.sensors.sonar.ping.fan import Fan, FanHits, Lanes
from pelagos.sensors.sonar.ping.patches import patches_of
from pelagos.sensors.sonar.ping.sea_surface import SEA_SURFACE_INSTANCE, with_sea_surface
from pelagos.sensors.sonar.ping.surface_scattering import Surfaces, mirror_share

_OFF: Final = 2e-3  # [m], start of a leg above the mirror
_SEEN: Final = 0.05  # [m], slack of the test for a free straight way home
_MOST: Final = 1e3  # of a pattern over another's: beside nulls


@dataclass(frozen=True)
class Mirrors:
    """Boundaries at which sound bounces.

    Attributes:
        bottom: whether at the bottom and at all else, besides the sea surface.
        order: bounces of one way at most.
        max_range: longest path, one way [m].
        longest: how far a ray's patch of surface may reach in range [m].
        surface_loss_db: of each bounce at the sea surface; None: by bubbles.
        bottom_loss_db: of each bounce anywhere else, besides what its material takes.
        aperture, facing: how beams hear any direction.
    """

    bottom: bool
    order: int
    max_range: float
    longest: float
    surface_loss_db: float | None
    bottom_loss_db: float
    aperture: Aperture
    facing: Facing


def bounced_echoes(
    caster: Caster, view: FanHits, fan: Fan, lanes: Lanes, surfaces: Surfaces, mirrors: Mirrors
) -> list[Patches]:
    """Patches of bounced echoes: for each number of bounces, those home by the same bounces and those home straight.

    Args:
        view: first legs.
    """
    found: list[Patches] = []
    leg, kept = view, jit.Float(1)
    for _ in range(mirrors.order):
        dr.eval(leg, kept)  # each echo has a kernel of its own, which would cast all legs again
        mirror, part = _reflected(leg.hits, leg.sine, surfaces, mirrors)
        kept = kept * dr.select(mirror, part, 0.0)
        leg = _onward(caster, leg, lanes, surfaces, mirror, mirrors.max_range)
        found += _echoes(caster, leg, view.direction, fan, lanes, surfaces, kept, mirrors)
    return found


def _reflected(hits: Hits, sine: Array, surfaces: Surfaces, mirrors: Mirrors) -> tuple[Array, Array]:
    """Whether a leg goes on, and the part of its energy that does."""
    at_sea = hits.valid & (hits.instance == SEA_SURFACE_INSTANCE)
    part = mirror_share(surfaces, hits.material, sine)
    sea = part if mirrors.surface_loss_db is None else from_db(jit.Float(-mirrors.surface_loss_db))
    part = dr.select(at_sea, sea, part * from_db(jit.Float(-mirrors.bottom_loss_db)))
    return hits.valid if mirrors.bottom else at_sea, part


def _onward(
    caster: Caster, leg: FanHits, lanes: Lanes, surfaces: Surfaces, mirror: Array,
    max_range: float,
) -> FanHits:  # fmt: skip
    """The next leg, with the length of the whole path."""
    before = leg.hits
    travelled = dr.select(mirror, before.t, 0.0)
    normal = before.shading_normal
    direction = leg.direction - 2.0 * dr.dot(leg.direction, normal) * normal
    start = before.position + jit.Array3f64(normal) * _OFF
    left = dr.select(mirror, dr.maximum(max_range - travelled, 0.0), 0.0)
    copy, own = dr.gather(jit.UInt32, lanes.copy, leg.lane), dr.gather(jit.UInt32, lanes.own, leg.lane)
    shot = Rays(start, direction, left, copy, own)
    after = caster.cast(shot, smooth=True)
    after = with_sea_surface(after, shot, surfaces.sea_row, lanes.sea, leg.lane)
    after.valid &= mirror
    after.t = dr.select(after.valid, after.t + travelled, dr.inf)
    rise = [jit.Float(place.z - leg.origin.z) for place in (start, after.position)]
    gone = after.t - travelled
    loss = leg.loss * travelled + lanes.medium.mean_loss(leg.lane, *rise) * gone
    loss = dr.select(after.valid, loss / dr.maximum(after.t, 1e-3), 0.0)
    sine = dr.abs(dr.dot(after.shading_normal, direction))
    return replace(leg, hits=after, direction=direction, sine=sine, loss=loss)


def _echoes(
    caster: Caster, leg: FanHits, departure: Array, fan: Fan, lanes: Lanes, surfaces: Surfaces, kept: Array,
    mirrors: Mirrors,
) -> list[Patches]:  # fmt: skip
    """Echoes from the end of a broken path: home by it, and home straight where nothing stands in between.

    Home straight it is heard through the pattern in its own direction, which the ray at its `departure` is not: behind
    the array's baffle next to nothing.
    """
    whole = patches_of(leg, fan, lanes, surfaces, longest=mirrors.longest)
    way = jit.Array3f(leg.hits.position - leg.origin)
    straight = dr.maximum(dr.norm(way), 1e-3)
    copy, own = dr.gather(jit.UInt32, lanes.copy, leg.lane), dr.gather(jit.UInt32, lanes.own, leg.lane)
    reach = dr.select(whole.valid, straight, 0.0)
    home = caster.cast(Rays(leg.origin, way / straight, reach, copy, own), smooth=False)
    free = whole.valid & (~home.valid | (home.t > straight - _SEEN))
    loss = lanes.medium.mean_loss(leg.lane, jit.Float(0), way.z)
    saved = from_db(leg.loss * whole.distance - loss * straight)  # of the way home, by its own absorption
    heard = saved * _other_direction(mirrors, leg, fan, lanes, way / straight, departure)
    half = replace(whole, valid=free, energy=4.0 * whole.energy * kept * heard * (whole.distance / straight) ** 2)
    _move(half, 0.5 * (straight - whole.distance))
    whole.energy = whole.energy * kept * kept
    return [whole, half]


def _other_direction(
    mirrors: Mirrors, leg: FanHits, fan: Fan, lanes: Lanes, arrival: Array, departure: Array
) -> Array:  # fmt: skip
    """One-way power pattern at the direction of arrival over that at the ray's departure (world frame, unit)."""
    attitude = jit.Array4f(leg.of_lane(lanes.attitude))
    beam = leg.of_ray(fan.beam)
    one_way = [
        mirrors.aperture.one_way_up(mirrors.facing, beam, rotate_back(attitude, direction))
        for direction in (arrival, departure)
    ]
    baffle = dr.select(dr.dot(arrival, departure) > 0.0, 1.0, BEHIND)
    return baffle * dr.minimum(one_way[0] / dr.maximum(one_way[1], 1e-6), _MOST)


def _move(patches: Patches, by: Array) -> None:
    """Shift patches in range."""
    patches.distance, patches.near, patches.far = patches.distance + by, patches.near + by, patches.far + by
