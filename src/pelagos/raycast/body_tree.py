"""A tree of boxes about the bodies that move, and rays through it.

Each mesh stands once in a scene that never changes (`Shapes`). A ray goes down a tree of boxes about the bodies of its
copy, and is cast in the frame of each body that it may meet. So bodies move at the price of the tree, a fraction of a
millisecond for a thousand; a ray's own hull, and the bodies of other copies, cost it nothing; and what is hit depends
on where ray and body are to one another, not on where in the world, which copy, or how many others there are.

Source: the tree is the complete binary one over bodies along a Morton curve, C. Lauterbach et al., Fast BVH
Construction on GPUs, Eurographics 2009, doi 10.1111/j.1467-8659.2009.01377.x; the way through it without a stack is
that of J. Barringer and T. Akenine-Moeller, Dynamic Stackless Binary Tree Traversal, JCGT 2 (1), 2013.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.so3 import rotate_back
from pelagos.raycast.rays import NO_BODY, Rays, ray_of

if TYPE_CHECKING:
    from pelagos.raycast.hit_tables import HitTables

_NODE: Final = 8  # numbers of a node: the box's low corner, high corner, and one to spare after each
_NOWHERE: Final = 1e30  # [m], where boxes of nothing are
_SKIN_M: Final = 1e-3  # about every box, beside what single precision loses far from the origin
_RELATIVE: Final = 1e-6
_AXIS_BITS: Final = 10  # of the Morton curve
_FLAT: Final = 1e-20  # the least component of a direction, by which distances to a box's sides are divided


@jit.struct
class BodyTree:
    """Boxes about bodies, and whose they are: a Dr.Jit struct.

    Attributes:
        boxes: `Float`, by copy and node: low corner, 0, high corner, 0, relative to the scenes' origin [m]. Node 1 is
            the root, and 2 i and 2 i + 1 are the children of i.
        rows: `UInt32`, by copy and leaf the body's row; `NO_BODY` where a leaf is empty.
        roots: `UInt32`, by copy the place before its root among all nodes.
    """

    boxes: Array
    rows: Array
    roots: Array


@jit.struct
class BodyHits:
    """The nearest hit of each ray on a body that is not its own: a Dr.Jit struct.

    Attributes:
        t: `Float`, distance [m]; infinite where nothing is hit.
        row: `UInt32`, the body's.
        face: `UInt32`, of the table of faces of all meshes.
        place: `Array2f`, weights of the face's second and third corner.
    """

    t: Array
    row: Array
    face: Array
    place: Array


def tree_of(low: NDArray[np.float64], high: NDArray[np.float64], copies: int) -> BodyTree:
    """The tree over boxes `(b, 3)` [m] about bodies, whose rows are bodies by copies."""
    boxes, rows = nodes_of(low, high, copies)
    roots = np.arange(copies, dtype=np.uint32) * boxes.shape[1]
    made = BodyTree(jit.Float(boxes.ravel()), jit.UInt32(rows.ravel()), jit.UInt32(roots))
    jit.align(made)
    return made


def nodes_of(
    low: NDArray[np.float64], high: NDArray[np.float64], copies: int
) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """The same as arrays: `(copies, 2 leaves, 8)` and `(copies, leaves)`; the leaves are a power of two."""
    count = len(low) // copies
    leaves = 1 << max(count - 1, 0).bit_length()
    lows, highs = (np.swapaxes(corner.reshape(count, copies, 3), 0, 1) for corner in (low, high))
    order = np.argsort(_along_curve((lows + highs) / 2), axis=1, kind="stable")
    corners = np.full((2, copies, 2 * leaves, 3), np.inf)
    corners[1] = -np.inf
    corners[0, :, leaves : leaves + count] = np.take_along_axis(lows, order[..., None], axis=1)
    corners[1, :, leaves : leaves + count] = np.take_along_axis(highs, order[..., None], axis=1)
    size = leaves // 2
    while size:
        below = corners[:, :, 2 * size : 4 * size].reshape(2, copies, size, 2, 3)
        corners[0, :, size : 2 * size] = below[0].min(axis=2)
        corners[1, :, size : 2 * size] = below[1].max(axis=2)
        size //= 2
    full = np.isfinite(corners)
    far = np.where(full, corners, 0.0)
    skin = _SKIN_M + _RELATIVE * np.abs(far).max(axis=0)
    boxes = np.zeros((copies, 2 * leaves, _NODE), dtype=np.float32)
    boxes[..., 0:3] = np.where(full[0], corners[0] - skin, _NOWHERE)
    boxes[..., 4:7] = np.where(full[1], corners[1] + skin, _NOWHERE)
    rows = np.full((copies, leaves), NO_BODY, dtype=np.uint32)
    rows[:, :count] = order * copies + np.arange(copies)[:, None]
    return boxes, rows


def _along_curve(place: NDArray[np.float64]) -> NDArray[np.int64]:
    """`(copies, b, 3)` places -> `(copies, b)` how far along the Morton curve of their copy's own box they are."""
    low = place.min(axis=1, keepdims=True)
    span = np.maximum((place.max(axis=1, keepdims=True) - low).max(axis=2, keepdims=True), 1e-9)
    cell = ((place - low) / span * ((1 << _AXIS_BITS) - 1)).astype(np.int64)
    for shift, mask in ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249)):
        cell = (cell | (cell << shift)) & mask  # two zeros after every bit
    return np.asarray(cell @ np.array([1, 2, 4]))


def nearest_body(scene: Any, tables: HitTables, rays: Rays, reach: Array, *, coherent: bool) -> BodyHits:
    """The nearest hit within `reach` [m] on a body of each ray's copy that is not the ray's own.

    Args:
        scene: of the meshes, see `Shapes`.
        tables: see `HitTables`.
        rays: see `Rays`.
        reach: `Float` [m].
        coherent: see `Caster.cast`.
    """
    lanes = dr.width(rays.direction)

    def ask(row: Array, best: BodyHits) -> BodyHits:
        near, ray = _in_frame_of(tables, rays, row, best.t)
        found = scene.ray_intersect_preliminary(ray, coherent, True)
        t = near + found.t
        nearer = found.is_valid() & (t < best.t)
        return BodyHits(
            dr.select(nearer, t, best.t),
            dr.select(nearer, row, best.row),
            dr.select(nearer, found.prim_index, best.face),
            dr.select(nearer, found.prim_uv, best.place),
        )

    nothing = dr.full(jit.UInt32, NO_BODY, lanes)
    start = BodyHits(jit.Float(reach) + dr.zeros(jit.Float, lanes), nothing, nothing + 0, dr.zeros(jit.Array2f, lanes))
    best: BodyHits = _visited(tables, rays, start, ask, lambda best: best.t, lambda best: jit.Bool(True))
    best.t = dr.select(best.row != NO_BODY, best.t, dr.inf)
    return best


def any_body(scene: Any, tables: HitTables, rays: Rays, *, coherent: bool) -> Array:
    """`Bool`: a body of each ray's copy that is not the ray's own stands within its range; see `nearest_body`."""

    def ask(row: Array, open_: Array) -> Array:
        _, ray = _in_frame_of(tables, rays, row, rays.max_range)
        return open_ & ~scene.ray_test(ray, coherent, open_)

    free = dr.full(jit.Bool, True, dr.width(rays.direction))
    return ~_visited(tables, rays, free, ask, lambda open_: rays.max_range, lambda open_: open_)


def through_sphere(start: Array, way: Array, radius: Array) -> tuple[Array, Array]:
    """Distances to where a ray enters and leaves a sphere about the origin [m]; it leaves first where it misses.

    Beyond the sphere of the body that is asked for stand the meshes of others.
    """
    middle = -dr.dot(start, way)
    square = radius * radius - dr.squared_norm(start) + middle * middle
    half = dr.sqrt(dr.maximum(square, 0.0))
    return dr.maximum(middle - half, 0.0), dr.select(square > 0.0, middle + half, -1.0)


def _visited(
    tables: HitTables,
    rays: Rays,
    state: Any,
    ask: Callable[[Array, Any], Any],
    reach: Callable[[Any], Array],
    goes_on: Callable[[Any], Array],
) -> Any:
    """The state of each ray after it has asked every body whose box it meets within `reach` of its state."""
    tree: BodyTree = tables.tree
    copies = dr.width(tree.roots)
    leaves = dr.width(tree.rows) // copies
    copy = rays.copy % copies if copies > 1 else jit.UInt32(0)  # rows of a batch go copy by copy within a vehicle
    root = dr.gather(jit.UInt32, tree.roots, copy)
    start = jit.Array3f(rays.origin - tables.origin)
    if rays.drift is not None:
        start = start - rays.drift
    way = rays.direction
    inverse = 1.0 / dr.select(dr.abs(way) < _FLAT, dr.copysign(jit.Array3f(_FLAT), way), way)

    def unfinished(node: Array, state: Any) -> Array:
        return (node != 0) & goes_on(state)

    def go(node: Array, state: Any) -> tuple[Array, Any]:
        at = 2 * (root + node)
        low, high = (dr.gather(jit.Array4f, tree.boxes, at + side) for side in (0, 1))
        first, second = ((jit.Array3f(c[0], c[1], c[2]) - start) * inverse for c in (low, high))
        near, far = dr.max(dr.minimum(first, second)), dr.min(dr.maximum(first, second))
        meets = (dr.maximum(near, 0.0) <= far) & (near <= reach(state))
        leaf = node >= leaves
        row = dr.gather(jit.UInt32, tree.rows, root // 2 + node - leaves, meets & leaf)
        asked = meets & leaf & (row != rays.own) & (row != NO_BODY)
        state = dr.if_stmt((row, state), asked, ask, lambda row, state: state, mode="symbolic")
        after = node + 1
        after = after >> dr.tzcnt(after)  # past all that lies below: the next node to the right, here or further up
        return dr.select(meets & ~leaf, 2 * node, dr.select(after == 1, 0, after)), state

    node = dr.full(jit.UInt32, 1, dr.width(rays.direction))
    return dr.while_loop((node, state), unfinished, go, mode="symbolic")[1]


def _in_frame_of(tables: HitTables, rays: Rays, row: Array, reach: Array) -> tuple[Array, Any]:
    """Way of a ray to the sphere about a body [m], and the rest of it there, as `mi.Ray3f` in
    the frame in which the body's mesh stands."""
    apart = rays.origin - dr.gather(jit.Array3f64, tables.body_position, row)
    if rays.drift is not None:
        apart = apart - jit.Array3f64(rays.drift)
    way = jit.Array3f64(rays.direction)
    offset = dr.gather(jit.Array3f, tables.body_offset, row)
    near, far = through_sphere(apart, way, jit.Float64(dr.gather(jit.Float, tables.body_radius, row)))
    attitude = dr.gather(jit.Array4f, tables.body_attitude, row)
    begin = rotate_back(attitude, jit.Array3f(apart + near * way)) + offset
    left = jit.Float(dr.maximum(dr.minimum(far, jit.Float64(reach)) - near, 0.0))  # below 0 is a hit to Embree
    return jit.Float(near), ray_of(begin, rotate_back(attitude, rays.direction), left)
