"""Load of a sea on a hull: the pressure of still water and of the undisturbed waves (Froude and Krylov) on its wet
part.

The hull is clipped at the actual surface of the waves. The pressure is that of linear theory: below the mean surface
the weight of the still water and the waves' dynamic pressure, above it the weight of the water that stands there.
Diffraction, radiation and slamming are not part of it. Source: J. M. J. Journee and W. W. Massie, Offshore
Hydromechanics (2001), 7.3.
"""

from __future__ import annotations

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.hydro.wetted_hull import wetted_load
from pelagos.jit import Array
from pelagos.math.constants import GRAVITY
from pelagos.math.so3 import rotate
from pelagos.ocean.ocean import Ocean


@jit.struct
class Hull:
    """A closed mesh, body frame FLU, faces counter-clockwise from outside: a Dr.Jit struct.

    Attributes:
        points: `Array3f64` [m].
        a, b, c: `UInt32`, rows of `points`, one entry a face.
    """

    points: Array
    a: Array
    b: Array
    c: Array


def make_hull(vertices: NDArray[np.float64], faces: NDArray[np.integer]) -> Hull:
    """A hull from vertices `(v, 3)` [m] and faces `(f, 3)`."""
    corners = [jit.UInt32(np.ascontiguousarray(faces[:, i], dtype=np.uint32)) for i in range(3)]
    hull = Hull(jit.Array3f64(np.ascontiguousarray(vertices.T, dtype=np.float64)), *corners)
    jit.align(hull)
    return hull


def hull_load(ocean: Ocean, hull: Hull, position: Array, attitude: Array, t: Array) -> tuple[Array, Array]:
    """Force [N] and moment about `position` [N m] on one hull, `Array3f64` NWU, one lane.

    Args:
        ocean: waves, tide and density.
        hull: see `Hull`.
        position, attitude: `Array3f64` NWU [m] and `Array4f64`, body to world, one lane.
        t: time [s].
    """
    arm = rotate(attitude, hull.points)
    place = arm + position
    level = jit.Float64(0.0) if ocean.tide is None else ocean.tide.level(t)
    z = place[2] - level
    waves = ocean.sea(dr.width(place))
    if waves is None:
        immersion = head = -z
    else:
        surface, dynamic = waves.head(jit.Array3f64(place[0], place[1], z), t)
        immersion = surface - z
        head = dr.select(z < 0, dynamic - z, immersion)
    packed = dr.ravel(jit.ArrayXf64([arm[0], arm[1], arm[2], immersion, head, 0 * z, 0 * z, 0 * z]))
    rows = [(dr.gather(jit.Array4f64, packed, 2 * i), dr.gather(jit.Float64, packed, 8 * i + 4)) for i in
            (hull.a, hull.b, hull.c)]  # fmt: skip
    corner0, corner1, corner2 = (jit.Array3f64(r[0], r[1], r[2]) for r, _ in rows)
    wet0, wet1, wet2 = (r[3] for r, _ in rows)
    head0, head1, head2 = (h for _, h in rows)
    load = wetted_load((corner0, corner1, corner2), (wet0, wet1, wet2), (head0, head1, head2))
    weight = ocean.density(jit.Array3f64(position[0], position[1], dr.minimum(position[2], 0.0)), t) * GRAVITY
    columns = dr.ravel(jit.ArrayXf64([*load.force, *load.moment]), order="C")
    sums = weight * dr.block_sum(columns, dr.width(load.area))  # each component by one thread, in order
    total = [dr.gather(jit.Float64, sums, jit.UInt32(i)) for i in range(6)]
    return jit.Array3f64(total[:3]), jit.Array3f64(total[3:])
