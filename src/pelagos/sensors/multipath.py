"""Echoes by one bounce: rays that go on behind a mirror-like surface, and come home the same way or straight.

A bounced ray sees a target at the whole length of its broken path (out and home by the bounce), and once more at the
mean of broken and straight path (out one way, home the other). The second happens in both directions at the same time
and with the same phase, so that its amplitude counts twice. No echo arrives before the direct one: a broken path is
longer than a straight one.
Image construction is exact for plane mirrors: X. Lurton, An Introduction to Underwater
Acoustics (2nd ed., 2010), Section 2.4.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import drjit as dr

from pelagos import jit
from pelagos.acoustics.echo import Patches
from pelagos.acoustics.spreading import from_db
from pelagos.jit import Array
from pelagos.raycast.caster import cast
from pelagos.raycast.rays import Rays
from pelagos.raycast.scene import Tables
from pelagos.sensors.echo import SEA_SURFACE_INSTANCE, Fan, Lanes, View, patches_of, with_sea_surface
from pelagos.sensors.scattering import Surfaces

_OFF: Final = 2e-3  # [m], start of the second leg above the mirror
_SEEN: Final = 0.05  # [m], slack of the test for a free straight way home


def bounced(
    static: Any,
    moving: Any,
    tables: Tables,
    view: View,
    fan: Fan,
    lanes: Lanes,
    surfaces: Surfaces,
    *,
    max_range: float,
    longest: float,
    surface_loss_db: float,
    bottom_loss_db: float | None,
) -> list[Patches]:
    """Patches of both kinds of bounced echoes: home by the bounce, and home straight.

    Args:
        view: first legs.
        surface_loss_db, bottom_loss_db: loss of a bounce [dB]; None: no bounces there.
    """
    first = view.hits
    at_sea = first.instance == SEA_SURFACE_INSTANCE
    loss_db = dr.select(at_sea, surface_loss_db, 0.0 if bottom_loss_db is None else bottom_loss_db)
    mirror = first.valid & at_sea if bottom_loss_db is None else first.valid
    leg = dr.select(mirror, first.t, 0.0)
    normal = first.shading_normal
    direction = view.direction - 2.0 * dr.dot(view.direction, normal) * normal
    start = first.position + jit.Array3f64(normal) * _OFF
    copy = dr.gather(jit.UInt32, lanes.copy, view.lane)
    own = dr.gather(jit.UInt32, lanes.own, view.lane)
    shot = Rays(start, direction, dr.select(mirror, dr.maximum(max_range - leg, 0.0), 0.0), copy, own)
    second = with_sea_surface(cast(static, moving, tables, shot, smooth=True), shot, surfaces.sea_row)
    second.valid &= mirror
    target = second.position
    second.t = dr.select(second.valid, second.t + leg, dr.inf)
    sine = dr.abs(dr.dot(second.shading_normal, direction))
    onward = replace(view, hits=second, direction=direction, sine=sine)
    whole = patches_of(onward, fan, lanes, surfaces, longest=longest)
    way = jit.Array3f(target - view.origin)
    straight = dr.maximum(dr.norm(way), 1e-3)
    home = cast(static, moving, tables, Rays(view.origin, way / straight, straight, copy, own), smooth=False)
    free = whole.valid & (~home.valid | (home.t > straight - _SEEN))
    half = replace(
        whole,
        valid=free,
        energy=4.0 * whole.energy * (whole.distance / straight) ** 2 * from_db(-loss_db),
    )
    _move(half, 0.5 * (straight - whole.distance))
    whole.energy = whole.energy * from_db(-2.0 * loss_db)
    return [whole, half]


def _move(patches: Patches, by: Array) -> None:
    """Shift patches in range."""
    patches.distance, patches.near, patches.far = patches.distance + by, patches.near + by, patches.far + by
