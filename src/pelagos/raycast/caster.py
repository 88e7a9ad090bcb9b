"""Cast rays against the static and the moving scene, and keep the nearer hit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.so3 import rotate, rotate_back
from pelagos.raycast.body_tree import any_body, nearest_body
from pelagos.raycast.hit_tables import Faces, HitTables
from pelagos.raycast.rays import NO_BODY, Hits, Rays, ray_of


@dataclass(frozen=True, slots=True)
class Caster:
    """The world as rays meet it: two scenes and what their primitives mean. Made inside a frozen function.

    Attributes:
        static, moving: the two `mi.Scene` of `Scene`, or None where nothing stands, or moves.
        tables: see `HitTables`.
    """

    static: Any
    moving: Any
    tables: HitTables

    def cast(self, rays: Rays, *, smooth: bool = False, coherent: bool = True) -> Hits:
        """The nearest hit of each ray; a ray passes through the body that it names as its own.

        Args:
            rays: see `Rays`.
            smooth: interpolate `shading_normal`; otherwise it is the geometric normal, at less cost.
            coherent: neighbouring rays run side by side. Only speed changes: False is 33 % faster for random
                directions, True 2.5 times faster for a sonar's fan.
        """
        static, moving, tables = self.static, self.moving, self.tables
        local = jit.Array3f(rays.origin - tables.origin)
        t, normal, shading = jit.Float(dr.inf), jit.Array3f(0), jit.Array3f(0)
        thing, row = jit.UInt32(0), jit.UInt32(0)
        on_body = jit.Bool(False)
        if static is not None:
            t, normal, shading, thing = first_static(
                static, tables, local, rays.direction, rays.max_range, smooth=smooth, coherent=coherent
            )
        if moving is not None:
            found = nearest_body(moving, tables, rays, dr.minimum(t, rays.max_range), coherent=coherent)
            nearer = found.t < t
            row, on_body = dr.select(nearer, found.row, 0), nearer
            attitude = dr.gather(jit.Array4f, tables.body_attitude, row, nearer)
            sides = normals(tables.moving, found.face, found.place, nearer, smooth=smooth)
            t = dr.select(nearer, found.t, t)
            normal = dr.select(nearer, rotate(attitude, sides[0]), normal)
            shading = dr.select(nearer, rotate(attitude, sides[1]), shading) if smooth else normal
            part = dr.gather(jit.UInt32, tables.moving.thing, found.face, nearer)
            thing = dr.select(nearer, part + dr.gather(jit.UInt32, tables.moving_thing, row, nearer), thing)
        return _hits(tables, rays, t, normal, shading, thing, row, on_body)

    def occluded(self, rays: Rays, *, coherent: bool = False, past_own: bool = False) -> Array:
        """`Bool`: something stands within `max_range` of each ray. A shadow ray: the own hull casts shadows too.

        Args:
            rays: see `Rays`.
            coherent: neighbouring rays run side by side: sunlight does.
            past_own: pass through the own hull, as rays to lamps that are mounted on it do.
        """
        static, moving, tables = self.static, self.moving, self.tables
        blocked = jit.Bool(False)
        if static is not None:
            local = jit.Array3f(rays.origin - tables.origin)
            blocked = static.ray_test(ray_of(local, rays.direction, rays.max_range), coherent, True)
        if moving is not None:
            passed, left = rays.own if past_own else jit.UInt32(NO_BODY), dr.select(blocked, 0.0, rays.max_range)
            open_ = Rays(rays.origin, rays.direction, left, rays.copy, passed, rays.drift)
            blocked |= any_body(moving, tables, open_, coherent=coherent)
        return blocked


def first_static(
    static: Any, tables: HitTables, start: Array, direction: Array, reach: Array, *, smooth: bool, coherent: bool = True
) -> tuple[Array, Array, Array, Array]:
    """The nearest static hit of rays that start at `start`, `Array3f` relative to `tables.origin` [m].

    Returns:
        distance [m], infinite without a hit; normal and interpolated normal (see `normals`); object row.
    """
    found = static.ray_intersect_preliminary(ray_of(start, direction, reach), coherent, True)
    hit = found.is_valid()
    shape = dr.reinterpret_array(jit.UInt32, found.shape)
    instanced = dr.width(tables.models.thing) > 1
    if instanced:
        copied = dr.reinterpret_array(jit.UInt32, found.instance)
        shape = dr.select(copied != 0, copied, shape)
    row = dr.gather(jit.UInt32, tables.static_row, shape - tables.static_base, hit)
    face = dr.gather(jit.UInt32, tables.static_first, row, hit) + found.prim_index
    if not instanced:
        sides = normals(tables.static, face, found.prim_uv, hit, smooth=smooth)
        return found.t, *sides, dr.gather(jit.UInt32, tables.static.thing, face, hit)
    model = hit & (copied != 0)
    fixed = normals(tables.static, face, found.prim_uv, hit & ~model, smooth=smooth)
    turned = normals(tables.models, face, found.prim_uv, model, smooth=smooth)
    turn = dr.gather(jit.Array4f, tables.static_turn, row, model)
    thing = dr.gather(jit.UInt32, tables.static.thing, face, hit & ~model)
    part = dr.gather(jit.UInt32, tables.models.thing, face, model)
    thing = dr.select(model, part + dr.gather(jit.UInt32, tables.static_thing, row, model), thing)
    first, second = (dr.select(model, rotate(turn, m), f) for m, f in zip(turned, fixed, strict=True))
    return found.t, first, second, thing


def normals(faces: Faces, face: Array, place: Array, hit: Array, *, smooth: bool) -> tuple[Array, Array]:
    """Normals of faces that were hit, on the side from which their corners run counter-clockwise.

    Args:
        faces: see `Faces`.
        face: `UInt32`, row of the face.
        place: `Array2f`, weights of its second and third corner where it was hit.
        hit: `Bool`, whether there is one.
        smooth: also interpolate the normals at the corners.

    Returns:
        `Array3f` unit normal of the face, and the interpolated one, which is the same where the surface is flat.
    """
    corners = [dr.gather(jit.UInt32, faces.corner, 3 * face + k, hit) for k in range(3)]
    a, b, c = (dr.gather(jit.Array3f, faces.place, k, hit) for k in corners)
    normal = dr.normalize(dr.cross(b - a, c - a))
    if not smooth:
        return normal, normal
    weights = (1.0 - place[0] - place[1], place[0], place[1])
    blend = jit.Array3f(0)
    for weight, corner in zip(weights, corners, strict=True):
        blend = dr.fma(dr.gather(jit.Array3f, faces.normal, corner, hit), weight, blend)
    square = dr.squared_norm(blend)
    return normal, dr.select(square > 0.0, blend * dr.rsqrt(square), normal)


def _hits(
    tables: HitTables, rays: Rays, t: Array, normal: Array, shading: Array, thing: Array, row: Array, on_body: Array
) -> Hits:
    valid = t < dr.inf
    away = dr.dot(normal, rays.direction) > 0
    normal = dr.select(valid, dr.select(away, -normal, normal), 0)
    shading = dr.select(valid, dr.select(away, -shading, shading), 0)
    reach = dr.select(valid, t, 0)
    position = dr.select(valid, rays.origin + jit.Array3f64(rays.direction) * jit.Float64(reach), 0)
    moves = on_body & valid
    arm = jit.Array3f(position - dr.gather(jit.Array3f64, tables.body_position, row, moves))
    if rays.drift is not None:
        arm -= rays.drift
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
