"""Look-up tables of a cast: from the primitive that a ray hits to its object, normal, material and motion."""

from __future__ import annotations

from pelagos import jit
from pelagos.jit import Array
from pelagos.raycast.surface import Faces


@jit.struct
class HitTables:
    """Meaning of primitives and instances: a Dr.Jit struct, always handed to frozen functions as an argument.

    Attributes:
        origin: `Array3f64` (1), world position of the scenes' own origin [m].
        static_base, moving_base: `UInt32` (1), lowest identifier of a shape or instance.
        static_row, moving_row: `UInt32`, row of each shape or instance, by its identifier from the lowest on.
        static_first, moving_first: `UInt32`, by row, the first face in the tables of faces.
        static, models, moving: `Faces` of static meshes, of models whose copies are static, of bodies, the latter two
            in their own frames. Without models, `models` has one face, which nothing hits.
        static_turn: `Array4f`, by static row, model to world, w first.
        static_thing: `UInt32`, by static row, what the copy adds to the object rows of its model.
        label, instance, material: `UInt32`, by object.
        moving_thing: `UInt32`, by moving row, what the body adds to the object rows of its mesh.
        copy_offset: `Array3f`, by copy [m].
        body_position: `Array3f`, by moving row, relative to `origin`, offset of the copy included [m].
        body_attitude: `Array4f`, by moving row, body to world, w first.
        body_velocity, body_angular_velocity: `Array3f`, by moving row, world frame [m/s], [rad/s].
    """

    origin: Array
    static_base: Array
    moving_base: Array
    static_row: Array
    moving_row: Array
    static_first: Array
    moving_first: Array
    moving_thing: Array
    static: Faces
    models: Faces
    moving: Faces
    static_turn: Array
    static_thing: Array
    label: Array
    instance: Array
    material: Array
    copy_offset: Array
    body_position: Array
    body_attitude: Array
    body_velocity: Array
    body_angular_velocity: Array
