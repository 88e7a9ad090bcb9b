"""Cast rays against the static and the moving scene, and keep the nearer hit."""

from __future__ import annotations

from typing import Any

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.so3 import rotate_back
from pelagos.raycast.rays import Hits, Rays
from pelagos.raycast.scene import Tables

_OWN_SURFACES = 4  # surfaces of the own hull that a ray may pass: two walls, in and out of two convex parts
_SKIP = 1e-4  # [m], step behind a surface of the own hull


def cast(static: Any, moving: Any, tables: Tables, rays: Rays, *, smooth: bool = False) -> Hits:
    """The nearest hit of each ray; a ray passes through the body that it names as its own.

    Args:
        static, moving: the two `mi.Scene` of `Scene`, or None; a frozen function must name them in its own body.
        tables: `Scene.tables`.
        rays: see `Rays`.
        smooth: interpolate `shading_normal`; otherwise it is the geometric normal, at less cost.
    """
    local = jit.Array3f(rays.origin - tables.origin)
    t, normal, shading = jit.Float(dr.inf), jit.Array3f(0), jit.Array3f(0)
    thing, row = jit.UInt32(0), jit.UInt32(0)
    on_body = jit.Bool(False)
    flags = jit.mi.RayFlags.ShadingFrame if smooth else jit.mi.RayFlags.Minimal
    if static is not None:
        ray = jit.mi.Ray3f(local, rays.direction, rays.max_range, 0.0, [])
        si = static.ray_intersect(ray, flags, True)
        hit = si.is_valid()
        identifier = dr.reinterpret_array(jit.UInt32, si.shape)
        shape = dr.gather(jit.UInt32, tables.static_row, identifier - tables.static_base, hit)
        face = dr.gather(jit.UInt32, tables.static_first, shape, hit) + si.prim_index
        t = dr.select(hit, si.t, dr.inf)
        normal, shading = jit.Array3f(si.n), jit.Array3f(si.sh_frame.n if smooth else si.n)
        thing = dr.gather(jit.UInt32, tables.static_face, face, hit)
    if moving is not None:
        start = local + dr.gather(jit.Array3f, tables.copy_offset, rays.copy)
        si, travelled, body = _first_foreign(moving, tables, start, rays, dr.minimum(t, rays.max_range), flags)
        hit = si.is_valid()
        nearer = hit & (si.t + travelled < t)
        face = dr.gather(jit.UInt32, tables.moving_first, body, hit) + si.prim_index
        t = dr.select(nearer, si.t + travelled, t)
        normal = dr.select(nearer, jit.Array3f(si.n), normal)
        shading = dr.select(nearer, jit.Array3f(si.sh_frame.n if smooth else si.n), shading)
        thing = dr.select(nearer, dr.gather(jit.UInt32, tables.moving_face, face, hit), thing)
        row, on_body = dr.select(nearer, body, row), nearer
    return _hits(tables, rays, t, normal, shading, thing, row, on_body)


def occluded(static: Any, moving: Any, tables: Tables, rays: Rays, *, coherent: bool = False) -> Array:
    """`Bool`: something stands within `max_range` of each ray. A shadow ray: the own hull casts shadows too.

    `coherent` says that neighbouring rays run side by side: sunlight does.
    """
    local = jit.Array3f(rays.origin - tables.origin)
    blocked = jit.Bool(False)
    if static is not None:
        blocked = static.ray_test(jit.mi.Ray3f(local, rays.direction, rays.max_range, 0.0, []), coherent, True)
    if moving is not None:
        start = local + dr.gather(jit.Array3f, tables.copy_offset, rays.copy)
        blocked |= moving.ray_test(jit.mi.Ray3f(start, rays.direction, rays.max_range, 0.0, []), coherent, ~blocked)
    return blocked


def _first_foreign(
    moving: Any, tables: Tables, start: Array, rays: Rays, reach: Array, flags: Any
) -> tuple[Any, Array, Array]:
    """The first hit that is not on the own hull: interaction, way already travelled [m], moving row."""
    ray = jit.mi.Ray3f(start, rays.direction, reach, 0.0, [])
    si = moving.ray_intersect(ray, flags, True)
    travelled = jit.Float(0)
    body = _row(tables, si)
    for _ in range(_OWN_SURFACES):
        own = si.is_valid() & (body == rays.own)
        step = dr.select(own, si.t + _SKIP, 0)
        travelled = travelled + step
        ray = jit.mi.Ray3f(start + travelled * rays.direction, rays.direction, reach - travelled, 0.0, [])
        again = moving.ray_intersect(ray, flags, True, own)
        si = dr.select(own, again, si)
        body = _row(tables, si)
    si.t = dr.select(si.is_valid() & (body == rays.own), dr.inf, si.t)
    return si, travelled, body


def _row(tables: Tables, si: Any) -> Array:
    identifier = dr.reinterpret_array(jit.UInt32, si.instance)
    return dr.gather(jit.UInt32, tables.moving_row, identifier - tables.moving_base, si.is_valid())


def _hits(
    tables: Tables, rays: Rays, t: Array, normal: Array, shading: Array, thing: Array, row: Array, on_body: Array
) -> Hits:
    valid = t < dr.inf
    away = dr.dot(normal, rays.direction) > 0
    normal = dr.select(valid, dr.select(away, -normal, normal), 0)
    shading = dr.select(valid, dr.select(away, -shading, shading), 0)
    reach = dr.select(valid, t, 0)
    position = dr.select(valid, rays.origin + jit.Array3f64(rays.direction) * jit.Float64(reach), 0)
    moves = on_body & valid
    arm = jit.Array3f(position - tables.origin) + dr.gather(jit.Array3f, tables.copy_offset, rays.copy, moves)
    arm -= dr.gather(jit.Array3f, tables.body_position, row, moves)
    attitude = dr.gather(jit.Array4f, tables.body_attitude, row, moves)
    spin = dr.gather(jit.Array3f, tables.body_angular_velocity, row, moves)
    velocity = dr.gather(jit.Array3f, tables.body_velocity, row, moves) + dr.cross(spin, arm)
    return Hits(
        valid=valid,
        t=t,
        position=position,
        place=dr.select(moves, rotate_back(attitude, arm), jit.Array3f(position)),
        normal=normal,
        shading_normal=shading,
        label=dr.gather(jit.UInt32, tables.label, thing, valid),
        instance=dr.gather(jit.UInt32, tables.instance, thing, valid),
        material=dr.gather(jit.UInt32, tables.material, thing, valid),
        velocity=dr.select(moves, velocity, 0),
    )
