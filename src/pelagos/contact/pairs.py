"""Contacts between two bodies that move: the probes of one against the mesh of the other, in the other's own frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.contact.probe import HullProbes
from pelagos.jit import Array
from pelagos.math.so3 import rotate, rotate_back
from pelagos.raycast.body_tree import through_sphere
from pelagos.raycast.caster import normals
from pelagos.raycast.shapes import ShapeTables

if TYPE_CHECKING:
    from pelagos.world.material import MaterialTables

BODY_COLUMNS: Final = 17
_COLUMNS: Final = 11
_AHEAD: Final = 0.002  # [m], look-ahead of bodies at rest


@dataclass(frozen=True)
class PairContacts:
    """Places at which two bodies touch or are about to; `(c, ...)`.

    Attributes:
        first, second: rows of the two bodies.
        point: where, world [m].
        normal: unit, from the second body's surface towards the first, world.
        depth: how far they overlap, negative while they are apart [m].
        stiffness, damping, friction: of the surface [N/m], [N s/m], 1.
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    point: NDArray[np.float64]
    normal: NDArray[np.float64]
    depth: NDArray[np.float64]
    stiffness: NDArray[np.float64]
    damping: NDArray[np.float64]
    friction: NDArray[np.float64]

    @classmethod
    def joined(cls, parts: list[PairContacts]) -> PairContacts:
        """Several as one."""
        return cls(*(np.concatenate([getattr(p, name) for p in parts]) for name in cls.__dataclass_fields__))


def body_table(
    position: NDArray[np.float64], attitude: NDArray[np.float64], velocity: NDArray[np.float64],
    spin: NDArray[np.float64], offset: NDArray[np.float64], radius: NDArray[np.float64],
) -> Array:  # fmt: skip
    """Bodies for `pair_contacts`, row by row.

    Pose, velocities in the world frame, place of the mesh among `Shapes`, radius of the sphere that holds it.
    """
    rows = np.concatenate([position, attitude, velocity, spin, offset, radius[:, None]], axis=1)
    return jit.from_numpy(jit.Float64, rows)


def pair_contacts(scene: Any) -> Callable[..., Array]:
    """A function of arrays that casts the probes of each pair's first body against its second; freeze it.

    Its arguments: `ShapeTables`, `MaterialTables`, `HullProbes` of the first bodies, `body_table`, `UInt32` rows of
    first and second bodies (equal ones are no pair), and the step [s]. What it returns is for `read_contacts`.
    """

    def cast(
        shapes: ShapeTables, materials: MaterialTables, probes: HullProbes, bodies: Array, first: Array, second: Array,
        h: Array,
    ) -> Array:  # fmt: skip
        count = dr.width(probes.length)
        lane = dr.arange(jit.UInt32, dr.width(first) * count)
        pair = lane // count
        probe = lane - pair * count
        a, b = dr.gather(jit.UInt32, first, pair), dr.gather(jit.UInt32, second, pair)
        here, there = _Body.of(bodies, a), _Body.of(bodies, b)
        start = dr.gather(jit.Array3f64, probes.start, probe)
        along = dr.gather(jit.Array3f64, probes.direction, probe)
        length = dr.gather(jit.Float64, probes.length, probe)
        way = rotate(here.attitude, along)
        apart = here.position - there.position + rotate(here.attitude, start)
        speed = dr.norm(here.velocity - there.velocity) + dr.norm(here.spin) * (dr.norm(start) + length)
        speed += dr.norm(there.spin) * (dr.norm(apart) + length)
        near, far = through_sphere(apart, way, there.radius)
        far = dr.minimum(far, length + _AHEAD + 1.5 * h * speed)
        origin = rotate_back(there.attitude, apart + near * way) + there.offset
        active = (a != b) & (far > near)
        ray = jit.mi.Ray3f(
            jit.Array3f(origin), jit.Array3f(rotate_back(there.attitude, way)), jit.Float(far - near), 0.0, []
        )
        found = scene.ray_intersect_preliminary(ray, False, active)
        hit = found.is_valid() & active
        outward = normals(shapes.faces, found.prim_index, found.prim_uv, hit, smooth=False)[0]
        normal = rotate(there.attitude, jit.Array3f64(outward))
        facing = -dr.dot(normal, way)
        hit &= facing > 0.0
        t = near + jit.Float64(dr.select(hit, found.t, 0))
        point = here.position + rotate(here.attitude, start + t * along)
        material = dr.gather(jit.UInt32, shapes.material, found.prim_index, hit)
        touch = [
            jit.Float64(dr.gather(jit.Float, table, material, hit))
            for table in (materials.stiffness, materials.damping, materials.friction)
        ]
        touch[2] *= dr.gather(jit.Float64, probes.grip, jit.UInt32(0))
        columns = [dr.select(hit, 1.0, 0.0), (length - t) * facing, *point, *normal, *touch]
        return dr.ravel(jit.ArrayXf64([jit.Float64(c) for c in columns]))

    return cast


def read_contacts(packed: Array, first: NDArray[np.int64], second: NDArray[np.int64]) -> PairContacts:
    """Findings of `pair_contacts`, of the same rows."""
    rows = np.array(packed).reshape(-1, _COLUMNS)
    hit = np.flatnonzero(rows[:, 0] > 0.5)
    found, pair = rows[hit], hit // (len(rows) // len(first))
    return PairContacts(
        first[pair], second[pair], found[:, 2:5], found[:, 5:8], found[:, 1], found[:, 8], found[:, 9], found[:, 10]
    )


@jit.struct
class _Body:
    """One body of each lane: a Dr.Jit struct; see `body_table`."""

    position: Array
    attitude: Array
    velocity: Array
    spin: Array
    offset: Array
    radius: Array

    @staticmethod
    def of(table: Array, row: Array) -> _Body:
        c = [dr.gather(jit.Float64, table, row * BODY_COLUMNS + i) for i in range(BODY_COLUMNS)]
        v3: Any = jit.Array3f64
        return _Body(v3(c[0:3]), jit.Array4f64(c[3:7]), v3(c[7:10]), v3(c[10:13]), v3(c[13:16]), c[16])
