"""Places of things as sonars see them."""

from __future__ import annotations

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.so3 import multiply, rotate, rotate_back
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import NO_BODY
from pelagos.sensors.sonar.ping.fan import Lanes
from pelagos.sensors.sonar.ping.targets import Targets


@jit.struct
class Place:
    """Things as a sonar sees them, pings by things: a Dr.Jit struct.

    Attributes:
        kind, radius, form, mirror, smooth, lambert, half, instance: see `Targets`.
        distance: `Float`, to the middle [m].
        direction: `Array3f`, there, world frame.
        local: `Array3f`, the sonar's place in the thing's own frame [m].
        attitude: `Array4f`, own frame to world.
        body, velocity: `UInt32` and `Array3f` [m/s], of what carries it.
        small: `Bool`, see `Sighting`.
    """

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


def target_places(caster: Caster, things: Targets, lanes: Lanes, row: Array, count: int) -> Place:
    """Places of things, as sonars see them."""
    tables = caster.tables
    lane, thing = row // count, row % count
    copy = dr.gather(jit.UInt32, lanes.copy, lane)
    copies = dr.width(things.body) // count
    body = dr.gather(jit.UInt32, things.body, thing * copies + copy % copies)  # vehicle by vehicle, copies within
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

    return Place(
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
