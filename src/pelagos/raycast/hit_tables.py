"""Look-up tables of a cast: from the primitive that a ray hits to its object, normal, material and motion.

The ray tracer is asked for no more than the distance, the triangle and the place on it. To let it complete the hit
would call every shape of every scene in the process in turn, and a world may hold thousands of instances.
"""

from __future__ import annotations

from pelagos import jit
from pelagos.jit import Array
from pelagos.raycast.body_tree import BodyTree


@jit.struct
class Faces:
    """Triangles, one after the other: a Dr.Jit struct.

    Attributes:
        corner: `UInt32` `(3 f,)`, rows of the corners of each face.
        place: `Float` `(3 v,)`, corners [m].
        normal: `Float` `(3 v,)`, unit normals of smooth surfaces at the corners; zero on flat ones.
        thing: `UInt32` `(f,)`, object row of each face.
    """

    corner: Array
    place: Array
    normal: Array
    thing: Array


@jit.struct
class HitTables:
    """Meaning of primitives and instances: a Dr.Jit struct, always handed to frozen functions as an argument.

    Attributes:
        origin: `Array3f64` (1), world position of the scenes' own origin [m].
        static_base: `UInt32` (1), lowest identifier of a static shape or instance.
        static_row: `UInt32`, row of each static shape or instance, by its identifier from the lowest on.
        static_first: `UInt32`, by static row, the first face in the tables of faces.
        static, models, moving: `Faces` of static meshes, of models whose copies are static, of bodies, the latter two
            in their own frames. Without models, `models` has one face, which nothing hits.
        static_turn: `Array4f`, by static row, model to world, w first.
        static_thing: `UInt32`, by static row, what the copy adds to the object rows of its model.
        label, instance, material: `UInt32`, by object.
        moving_thing: `UInt32`, by moving row, what the body adds to the object rows of its mesh.
        tree: boxes about the bodies, see `BodyTree`.
        body_offset, body_radius: `Array3f` and `Float`, by moving row, where its mesh stands among those of all bodies,
            and the sphere about the body's origin that holds it [m].
        body_position: `Array3f64`, by moving row, world [m].
        body_attitude: `Array4f`, by moving row, body to world, w first.
        body_velocity, body_angular_velocity: `Array3f`, by moving row, world frame [m/s], [rad/s].
    """

    origin: Array
    static_base: Array
    static_row: Array
    static_first: Array
    moving_thing: Array
    static: Faces
    models: Faces
    moving: Faces
    static_turn: Array
    static_thing: Array
    label: Array
    instance: Array
    material: Array
    tree: BodyTree
    body_offset: Array
    body_radius: Array
    body_position: Array
    body_attitude: Array
    body_velocity: Array
    body_angular_velocity: Array
