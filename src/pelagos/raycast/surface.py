"""Surface properties of a triangle that was hit: its normals and its object, gathered from tables of our own.

The ray tracer is asked for no more than the distance, the triangle and the place on it. To let it complete the hit
would call every shape of every scene in the process in turn, and a world may hold thousands of instances.
"""

from __future__ import annotations

import drjit as dr

from pelagos import jit
from pelagos.jit import Array


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
