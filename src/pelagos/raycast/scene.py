"""The two ray-tracing scenes, and the tables that say what was hit.

Static geometry stands in a Mitsuba scene that never changes; everything that moves stands in a second, small one,
because moving one instance rebuilds every acceleration structure of its scene. Single precision is kept exact to a
millimetre by working relative to `origin`. Copies of a fleet share the static scene; their moving bodies
stand `COPY_SPACING` apart.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Sequence
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.streamed import StreamedGround

COPY_SPACING: Final = 500.0  # [m], between the bodies of two copies of a fleet
_MANY_FACES = 1_000_000  # from here on a scene spares memory while it is loaded
_LATTICE: Final = 16  # copies along one edge of the lattice: 4096 copies within 8 km


@jit.struct
class Tables:
    """What primitives and instances mean: a Dr.Jit struct, always handed to frozen functions as an argument.

    Attributes:
        origin: `Array3f64` (1), world position of the scenes' own origin [m].
        static_base, moving_base: `UInt32` (1), lowest identifier of a shape or instance.
        static_row, moving_row: `UInt32`, row of each shape or instance, by its identifier from the lowest on.
        static_first, moving_first: `UInt32`, first face of each static mesh, of each moving row, in the face tables.
        static_face, moving_face: `UInt32`, object of each face.
        label, instance, material: `UInt32`, by object.
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
    static_face: Array
    moving_face: Array
    label: Array
    instance: Array
    material: Array
    copy_offset: Array
    body_position: Array
    body_attitude: Array
    body_velocity: Array
    body_angular_velocity: Array


class Scene:
    """Static and moving geometry of one world, for a fleet of `copies`.

    Attributes:
        static, moving: the two `mi.Scene`; `moving` is None while nothing moves.
        tables: see `Tables`.
        generation: counts replacements of `moving` (not its motions).
    """

    def __init__(self, static: Sequence[Geometry], *, copies: int = 1, ground: StreamedGround | None = None) -> None:
        self.copies = copies
        self._ground = ground
        self.generation = 0
        self._static_geometry = list(static)
        corners = [g.vertices for g in static if len(g.vertices)]
        if ground is not None:
            corners.append(ground.patch.vertices + ground.patch.origin)
        low = np.min([c.min(axis=0) for c in corners], axis=0) if corners else np.zeros(3)
        high = np.max([c.max(axis=0) for c in corners], axis=0) if corners else np.zeros(3)
        self.bounds: NDArray[np.float64] = np.stack([low, high])
        self.origin: NDArray[np.float64] = np.round((low + high) / 2) if ground is None else ground.patch.origin
        smooth = [g for g in static if g.vertex_normals is not None]
        flat = [g for g in static if g.vertex_normals is None]
        meshes, self._static_faces, self._static_first = [], [], []
        self._poses: tuple[NDArray[np.float64], ...] | None = None
        self._static_groups: dict[str, list[Geometry]] = {}
        first = 0
        objects = _Objects()
        for name, group in (("smooth", smooth), ("flat", flat)):
            if not group:
                continue
            if ground is not None:  # the origin moves with the ground, and they stay where they are
                self._static_groups[name] = group
            meshes.append(_mesh(name, group, self.origin))
            faces = np.concatenate([objects.rows(g) for g in group])
            self._static_faces.append(faces)
            self._static_first.append(first)
            first += len(faces)
        if ground is not None:
            self._ground_rows = objects.add(*ground.identity)
            self._static_faces.append(self._ground_rows[ground.patch.face_materials])
            self._static_first.append(first)
        self.static: Any = None
        self._static_parameters: Any = None
        if meshes or ground is not None:
            self._load_static(meshes)
        self._objects = objects
        self._bodies: list[Geometry] = []
        self.moving: Any = None
        self._parameters: Any = None
        self._refresh_tables(moving_first=[], moving_faces=[])
        if ground is not None:
            self._exchange_ground()  # from now on all its arrays are our own: frozen functions see exchanges

    def _load_static(self, meshes: list[Any]) -> None:
        """Load the static scene, a streamed ground last."""
        if self._ground is not None:
            patch = self._ground.patch
            part = Geometry(patch.vertices.astype(np.float64), patch.faces, 0, 0, 0, patch.normals)
            meshes = [*meshes, _mesh("ground", [part], np.zeros(3))]
        if sum(m.face_count() for m in meshes) > _MANY_FACES:
            _give_back()  # the tree over the triangles is about to need more than all that was built before
        shapes = {f"m{i}": m for i, m in enumerate(meshes)}
        self.static = jit.mi.load_dict({"type": "scene", **_watertight(), **shapes}, optimize=False)
        self._static_parameters = jit.mi.traverse(self.static) if self._ground is not None else None

    @property
    def streamed(self) -> bool:
        """Part of the ground is exchanged as vehicles go on."""
        return self._ground is not None

    def follow(self, places: NDArray[np.float64]) -> bool:
        """Bring a streamed ground to vehicles at `(k, 3)` [m]; whether what stands there is new."""
        if self._ground is None or not self._ground.follow(places[:, :2]):
            return False
        self._exchange_ground()
        return True

    def look(self, places: NDArray[np.float64]) -> bool:
        """The same for rays of other origin; the next `follow` is as if this had not been."""
        if self._ground is None or not self._ground.look(places[:, :2]):
            return False
        self._exchange_ground()
        return True

    def forget(self) -> None:
        """A run begins anew: where a streamed ground was before has no effect."""
        if self._ground is not None:
            self._ground.forget()

    def _exchange_ground(self) -> None:
        """Put the present patch into the static scene, and move the origin with it."""
        assert self._ground is not None
        patch = self._ground.patch
        mesh = f"m{len(self._static_first) - 1}"
        if len(patch.faces) != len(self._static_faces[-1]):  # more places than ever before: a larger mesh
            self.generation += 1
            self._load_static([_mesh(n, g, self.origin) for n, g in self._static_groups.items()])
            base, rows = _rows_by_identifier(self.static)
            self.tables.static_base, self.tables.static_row = dr.opaque(jit.UInt32, base), _own(jit.UInt32, rows)
        parameters = self._static_parameters
        parameters[f"{mesh}.vertex_positions"] = _own(jit.Float, patch.vertices)
        parameters[f"{mesh}.vertex_normals"] = _own(jit.Float, patch.normals)
        parameters[f"{mesh}.faces"] = _own(jit.UInt32, patch.faces)
        if (patch.origin != self.origin).any():
            for k, group in enumerate(self._static_groups.values()):
                parameters[f"m{k}.vertex_positions"] = _own(
                    jit.Float, np.concatenate([g.vertices - patch.origin for g in group]).astype(np.float32)
                )
        parameters.update()
        self.origin = patch.origin
        self._static_faces[-1] = self._ground_rows[patch.face_materials]
        t = self.tables
        t.origin = _single(patch.origin)
        t.static_face = _own(jit.UInt32, np.concatenate(self._static_faces))
        if self._poses is not None:
            self.move(*self._poses)

    def set_moving(self, bodies: Sequence[tuple[Geometry, int]]) -> None:
        """Replace everything that moves: `(geometry in its body frame, copy)` by row. Poses follow with `move`."""
        self.generation += 1
        self._poses = None
        self._bodies = [g for g, _ in bodies]
        self._body_copy = np.array([c for _, c in bodies], dtype=np.int64)
        groups: dict[str, Any] = {}
        instances: dict[str, Any] = {}
        starts: dict[int, int] = {}
        faces: list[NDArray[np.uint32]] = []
        first: list[int] = []
        total = 0
        for row, (geometry, _) in enumerate(bodies):
            key = id(geometry)
            if key not in starts:
                mesh = _mesh(f"group{key}", [geometry], np.zeros(3))
                groups[f"group{key}"] = {"type": "shapegroup", "mesh": mesh}
                starts[key] = total
                faces.append(self._objects.rows(geometry))
                total += len(geometry.faces)
            first.append(starts[key])
            instances[f"body{row}"] = {"type": "instance", "group": {"type": "ref", "id": f"group{key}"}}
        # in this order, so that shapes follow rows
        description = {"type": "scene", **_watertight(), **groups, **instances}
        self.moving = jit.mi.load_dict(description, parallel=False, optimize=False) if bodies else None
        self._parameters = jit.mi.traverse(self.moving) if bodies else None
        self._refresh_tables(moving_first=first, moving_faces=faces)

    def move(
        self,
        position: NDArray[np.float64],
        attitude: NDArray[np.float64],
        velocity: NDArray[np.float64],
        angular_velocity: NDArray[np.float64],
    ) -> None:
        """Place every moving row: position `(b, 3)` NWU [m], attitude `(b, 4)`, world-frame velocities `(b, 3)`."""
        if self.moving is None:
            return
        self._poses = (position, attitude, velocity, angular_velocity)
        offset = copy_offsets(self.copies)[self._body_copy]
        local = position - self.origin + offset
        matrices = np.tile(np.eye(4), (len(local), 1, 1))
        matrices[:, :3, :3] = _rotation_matrices(attitude)
        matrices[:, :3, 3] = local
        for row, matrix in enumerate(matrices):
            transform = jit.mi.Transform4f(jit.mi.Matrix4f(matrix.astype(np.float32)))
            dr.make_opaque(transform)
            self._parameters[f"body{row}.to_world"] = transform
        self._parameters.update()
        t = self.tables
        t.body_position = _array3f(local)
        t.body_attitude = _array4f(attitude)
        t.body_velocity = _array3f(velocity)
        t.body_angular_velocity = _array3f(angular_velocity)
        dr.make_opaque(t.body_position, t.body_attitude, t.body_velocity, t.body_angular_velocity)

    def compile(self, make: Callable[[Any, Any], Callable[..., Any]]) -> Callable[..., Any]:
        """Freeze `make(static, moving)`, a function of arrays only, and freeze it anew when `moving` is replaced.

        A frozen function sees only scenes that its own body names, and only arrays that are its arguments.
        """
        frozen: Callable[..., Any] | None = None
        generation = -1

        def call(*arguments: Any) -> Any:
            nonlocal frozen, generation
            if frozen is None or generation != self.generation:
                frozen, generation = jit.freeze(make, self.static, self.moving), self.generation
            return frozen(*arguments)

        return call

    def _refresh_tables(self, *, moving_first: list[int], moving_faces: list[NDArray[np.uint32]]) -> None:
        u32 = jit.UInt32
        rows = max(len(moving_first), 1)
        zero = _array3f(np.zeros((rows, 3)))
        o = self._objects
        static_base, static_row = _rows_by_identifier(self.static)
        moving_base, moving_row = _rows_by_identifier(self.moving)
        self.tables = Tables(
            origin=_single(self.origin),
            static_base=u32(static_base),
            moving_base=u32(moving_base),
            static_row=_own(u32, static_row),
            moving_row=_own(u32, moving_row),
            static_first=_own(u32, _table(self._static_first)),
            moving_first=_own(u32, _table(moving_first)),
            static_face=_own(u32, np.concatenate(self._static_faces) if self._static_faces else np.zeros(1, np.uint32)),
            moving_face=_own(u32, np.concatenate(moving_faces) if moving_faces else np.zeros(1, np.uint32)),
            label=_own(u32, _table(o.label)),
            instance=_own(u32, _table(o.instance)),
            material=_own(u32, _table(o.material)),
            copy_offset=_array3f(copy_offsets(self.copies)),
            body_position=zero,
            body_attitude=_array4f(np.tile([1.0, 0.0, 0.0, 0.0], (rows, 1))),
            body_velocity=jit.Array3f(zero),
            body_angular_velocity=jit.Array3f(zero),
        )
        dr.make_opaque(self.tables)


class _Objects:
    """One row for each (label, instance, material) in use."""

    def __init__(self) -> None:
        self.label: list[int] = []
        self.instance: list[int] = []
        self.material: list[int] = []

    def rows(self, geometry: Geometry) -> NDArray[np.unsignedinteger]:
        """`(f,)` object row of each face."""
        start = len(self.label)
        if isinstance(geometry.material, int):
            materials, inverse = np.array([geometry.material]), np.zeros(len(geometry.faces), dtype=np.uint8)
        else:
            counts = np.bincount(geometry.material)
            materials = np.flatnonzero(counts)
            kind = np.min_scalar_type(len(materials))
            inverse = (np.cumsum(counts > 0) - 1).astype(kind)[geometry.material]
        self.label += [geometry.label] * len(materials)
        self.instance += [geometry.instance] * len(materials)
        self.material += [int(m) for m in materials]
        kind = np.min_scalar_type(len(self.label))  # there are as many rows as triangles: bytes where they suffice
        return np.add(inverse, start, dtype=kind)

    def add(self, label: int, instance: int, materials: Sequence[int]) -> NDArray[np.uint32]:
        """`(len(materials),)` object row of one thing in each of its materials."""
        start = len(self.label)
        self.label += [label] * len(materials)
        self.instance += [instance] * len(materials)
        self.material += list(materials)
        return np.arange(start, len(self.label), dtype=np.uint32)


def _give_back() -> None:
    """Return memory that nothing uses any more to the system: Dr.Jit and the C library keep it for later."""
    dr.sync_thread()
    dr.flush_malloc_cache()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
    if trim is not None:
        trim(0)


def _watertight() -> dict[str, bool]:
    """Without it, Embree lets rays slip through that meet an edge or a vertex exactly; it costs no measurable time."""
    return {"embree_use_robust_intersections": True} if str(jit.mi.variant()).startswith("llvm") else {}


def copy_offsets(copies: int) -> NDArray[np.float64]:
    """`(copies, 3)` where the moving bodies of each copy stand [m]; the first copy stands where it is."""
    c = np.arange(copies)
    cell = np.stack([c % _LATTICE, c // _LATTICE % _LATTICE, c // _LATTICE**2], axis=-1)
    return np.asarray(cell * COPY_SPACING, dtype=np.float64)


def _single(place: NDArray[np.float64]) -> Array:
    """One place, each coordinate in memory of its own: equal literals would share it, and change what is recorded."""
    return jit.Array3f64(*(dr.opaque(jit.Float64, float(c)) for c in place))


def _own(kind: Any, values: NDArray[Any]) -> Array:
    """Flat values in memory of Dr.Jit's own, not in NumPy's: always aligned, which a recording relies on."""
    whole = values.astype(np.uint32, copy=False) if values.dtype.kind == "u" else values
    borrowed = kind(np.ascontiguousarray(whole).reshape(-1))
    owned = borrowed + dr.opaque(kind, 0)  # a sum that is not known beforehand: anything simpler shares the memory
    dr.eval(owned)
    dr.sync_thread()
    return owned


def _mesh(name: str, group: Sequence[Geometry], origin: NDArray[np.float64]) -> Any:
    """One Mitsuba mesh of several geometries, relative to `origin`, filled part by part to spare memory."""
    starts = np.cumsum([0] + [len(g.vertices) for g in group])
    ends = np.cumsum([0] + [len(g.faces) for g in group])
    vertices = np.empty((starts[-1], 3), dtype=np.float32)
    faces = np.empty((ends[-1], 3), dtype=np.uint32)
    normals = np.empty((starts[-1], 3), dtype=np.float32) if group[0].vertex_normals is not None else None
    for g, v, f in zip(group, starts, ends, strict=False):
        np.subtract(g.vertices, origin, out=vertices[v : v + len(g.vertices)], casting="same_kind")
        np.add(g.faces, np.uint32(v), out=faces[f : f + len(g.faces)], casting="same_kind")
        if normals is not None:
            normals[v : v + len(g.vertices)] = g.vertex_normals
    mesh = jit.mi.Mesh(name, len(vertices), len(faces), has_vertex_normals=normals is not None)
    parameters = jit.mi.traverse(mesh)
    parameters["vertex_positions"] = _own(jit.Float, vertices)
    parameters["faces"] = _own(jit.UInt32, faces)
    if normals is not None:
        parameters["vertex_normals"] = _own(jit.Float, normals)
    parameters.update()
    return mesh


def _rows_by_identifier(scene: Any) -> tuple[int, NDArray[np.uint32]]:
    """The lowest identifier of a scene's shapes, and the row of each: freed identifiers come back in any order."""
    if scene is None:
        return 0, np.zeros(1, dtype=np.uint32)
    identifiers = np.array(dr.reinterpret_array(jit.UInt32, scene.shapes_dr())).astype(np.int64)
    rows = np.zeros(int(np.ptp(identifiers)) + 1, dtype=np.uint32)
    rows[identifiers - identifiers.min()] = np.arange(len(identifiers))
    return int(identifiers.min()), rows


def _table(values: Sequence[int]) -> NDArray[np.uint32]:
    return np.array(values if len(values) else [0], dtype=np.uint32)


def _array3f(values: NDArray[np.float64]) -> Array:
    return jit.Array3f(np.ascontiguousarray(values.T, dtype=np.float32))


def _array4f(values: NDArray[np.float64]) -> Array:
    return jit.Array4f(np.ascontiguousarray(values.T, dtype=np.float32))


def _rotation_matrices(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """`(b, 4)` w first -> `(b, 3, 3)`."""
    w, x, y, z = q.T
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], axis=-1),
            np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=-1),
            np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=-1),
        ],
        axis=-2,
    )
