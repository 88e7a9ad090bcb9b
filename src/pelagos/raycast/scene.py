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
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.jit import Array
from pelagos.raycast.geometry import Geometry, PlacedGeometry
from pelagos.raycast.streamed import StreamedGround
from pelagos.raycast.surface import Faces

COPY_SPACING: Final = 500.0  # [m], between the bodies of two copies of a fleet
_MANY_FACES = 1_000_000  # from here on a scene spares memory while it is loaded
_MANY_COPIED: Final = 500_000  # faces of all copies of a model from which on they become instances of it
_MANY_COPIES: Final = 500  # instances beside which nothing is frozen
_LATTICE: Final = 16  # copies along one edge of the lattice: 4096 copies within 8 km


@jit.struct
class Tables:
    """What primitives and instances mean: a Dr.Jit struct, always handed to frozen functions as an argument.

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
        extents = [g.extent for g in static if len(g.faces)]
        if ground is not None:
            corners = ground.patch.vertices + ground.patch.origin
            extents.append(np.stack([corners.min(axis=0), corners.max(axis=0)]))
        low = np.min([e[0] for e in extents], axis=0) if extents else np.zeros(3)
        high = np.max([e[1] for e in extents], axis=0) if extents else np.zeros(3)
        self.bounds: NDArray[np.float64] = np.stack([low, high])
        self.origin: NDArray[np.float64] = np.round((low + high) / 2) if ground is None else ground.patch.origin
        self._poses: tuple[NDArray[np.float64], ...] | None = None
        objects = _Objects()
        copies_of = _models(static) if ground is None else {}
        copied = {id(g) for group in copies_of.values() for g in group}
        single = [g for g in static if id(g) not in copied]
        # smooth ones first, and among them the largest: the first one can share its arrays
        self._standing = sorted(single, key=lambda g: (g.vertex_normals is None, len(g.faces) <= _MANY_FACES))
        self._static_things = [objects.rows(g) for g in self._standing]
        if ground is not None:
            self._ground_rows = objects.add(*ground.identity)
            self._static_things.append(self._ground_rows[ground.patch.face_materials])
        self._copies = _Copies(copies_of, objects, self.origin)
        self.static: Any = None
        self._static_parameters: Any = None
        self._static_faces: list[Faces] = []
        if len(static) or ground is not None:
            self._load_static()
        self._objects = objects
        self._bodies: list[Geometry] = []
        self.moving: Any = None
        self._parameters: Any = None
        self._refresh_tables(moving_first=[], moving=[])
        if ground is not None:
            self._exchange_ground()  # from now on all its arrays are our own: frozen functions see exchanges

    def _load_static(self) -> None:
        """Load the static scene: what stands in one mesh, then a streamed ground, then copies of models."""
        shapes: dict[str, Any] = {}
        self._static_faces = []
        if self._standing:
            shapes["standing"], faces = _mesh("standing", self._standing, self.origin)
            self._static_faces.append(faces)
        if self._ground is not None:
            patch = self._ground.patch
            part = Geometry(patch.vertices.astype(np.float64), patch.faces, 0, 0, 0, patch.normals)
            shapes["ground"], faces = _mesh("ground", [part], np.zeros(3))
            self._static_faces.append(faces)
        if sum(m.face_count() for m in shapes.values()) > _MANY_FACES:
            _give_back()  # the tree over the triangles is about to need more than all that was built before
        shapes |= self._copies.shapes
        self.static = jit.mi.load_dict({"type": "scene", **_watertight(), **shapes}, optimize=False)
        self._static_parameters = jit.mi.traverse(self.static) if self._ground is not None else None

    def _static_tables(self) -> Faces:
        """Faces of the static meshes; those of a single mesh are its own arrays, not copies."""
        things = jit.own(
            jit.UInt32, np.concatenate(self._static_things) if self._static_things else np.zeros(1, np.uint32)
        )
        return _joined(self._static_faces, things)

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

    def _first_faces(self) -> list[int]:
        """First face of each static mesh."""
        return [0, *np.cumsum([dr.width(f.corner) // 3 for f in self._static_faces]).tolist()][
            : len(self._static_faces)
        ]

    def forget(self) -> None:
        """A run begins anew: where a streamed ground was before has no effect."""
        if self._ground is not None:
            self._ground.forget()

    def _exchange_ground(self) -> None:
        """Put the present patch into the static scene, and move the origin with it."""
        assert self._ground is not None
        patch = self._ground.patch
        if len(patch.faces) != len(self._static_things[-1]):  # more places than ever before: a larger mesh
            self.generation += 1
            self._load_static()
            base, rows = _rows_by_identifier(self.static)
            self.tables.static_base, self.tables.static_row = dr.opaque(jit.UInt32, base), jit.own(jit.UInt32, rows)
        parameters = self._static_parameters
        place, normal = jit.own(jit.Float, patch.vertices), jit.own(jit.Float, patch.normals)
        corner = jit.own(jit.UInt32, patch.faces)
        parameters["ground.vertex_positions"], parameters["ground.faces"] = place, corner
        self._static_faces[-1] = Faces(corner, place, normal, corner)
        if (patch.origin != self.origin).any() and self._standing:
            moved = np.concatenate([g.vertices - patch.origin for g in self._standing]).astype(np.float32)
            parameters["standing.vertex_positions"] = self._static_faces[0].place = jit.own(jit.Float, moved)
        parameters.update()
        self.origin = patch.origin
        self._static_things[-1] = self._ground_rows[patch.face_materials]
        t = self.tables
        t.origin = _single(patch.origin)
        t.static = self._static_tables()
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
        faces: list[Faces] = []
        first: list[int] = []
        total = 0
        for row, (geometry, _) in enumerate(bodies):
            key = id(geometry)
            if key not in starts:
                mesh, made = _mesh(f"group{key}", [geometry], np.zeros(3))
                groups[f"group{key}"] = {"type": "shapegroup", "mesh": mesh}
                starts[key] = total
                made.thing = jit.own(jit.UInt32, self._objects.rows(geometry))
                faces.append(made)
                total += len(geometry.faces)
            first.append(starts[key])
            instances[f"body{row}"] = {"type": "instance", "group": {"type": "ref", "id": f"group{key}"}}
        # in this order, so that shapes follow rows
        description = {"type": "scene", **_watertight(), **groups, **instances}
        self.moving = jit.mi.load_dict(description, parallel=False, optimize=False) if bodies else None
        self._parameters = jit.mi.traverse(self.moving) if bodies else None
        self._refresh_tables(moving_first=first, moving=faces)

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

        A frozen function sees only scenes that its own body names, and only arrays that are its arguments. Beside
        thousands of instances it is not frozen: Dr.Jit looks at each of them in every frozen call, which takes longer
        than to record the work again.
        """
        frozen: Callable[..., Any] | None = None
        generation = -1

        def call(*arguments: Any) -> Any:
            nonlocal frozen, generation
            if frozen is None or generation != self.generation:
                many = len(self._copies.first) > _MANY_COPIES
                frozen = make(self.static, self.moving) if many else jit.freeze(make, self.static, self.moving)
                generation = self.generation
            return frozen(*arguments)

        return call

    def _refresh_tables(self, *, moving_first: list[int], moving: list[Faces]) -> None:
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
            static_row=jit.own(u32, static_row),
            moving_row=jit.own(u32, moving_row),
            static_first=jit.own(u32, _table([*self._first_faces(), *self._copies.first])),
            moving_first=jit.own(u32, _table(moving_first)),
            static=self._static_tables(),
            models=self._copies.faces,
            moving=_joined(moving),
            static_turn=_array4f(np.concatenate([_upright(max(len(self._static_faces), 1)), self._copies.attitude])),
            static_thing=jit.own(u32, _table([0] * len(self._static_faces) + self._copies.thing)),
            label=jit.own(u32, _table(o.label)),
            instance=jit.own(u32, _table(o.instance)),
            material=jit.own(u32, _table(o.material)),
            copy_offset=_array3f(copy_offsets(self.copies)),
            body_position=zero,
            body_attitude=_array4f(_upright(rows)),
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


class _Copies:
    """Models of which many copies stand in the static scene, each copy an instance.

    Attributes:
        shapes: Mitsuba's, models and copies.
        faces: of all models, in their own frames.
        first, thing, attitude: by copy, see `Tables`.
    """

    def __init__(self, copies: dict[int, list[PlacedGeometry]], objects: _Objects, origin: NDArray[np.float64]) -> None:
        self.shapes: dict[str, Any] = {}
        self.first: list[int] = []
        self.thing: list[int] = []
        parts: list[Faces] = []
        matrices: list[NDArray[np.float64]] = []
        total = 0
        for key, group in copies.items():
            model = group[0].model
            mesh, faces = _mesh(f"model{key}", [model], np.zeros(3))
            faces.thing = dr.zeros(jit.UInt32, len(model.faces))
            parts.append(faces)
            self.shapes[f"model{key}"] = {"type": "shapegroup", "mesh": mesh}
            for copy in group:
                matrix = np.eye(4)
                matrix[:3, :3], matrix[:3, 3] = copy.scale * copy.turn, copy.offset - origin
                self.shapes[f"copy{len(self.first)}"] = {
                    "type": "instance",
                    "group": {"type": "ref", "id": f"model{key}"},
                    "to_world": jit.mi.ScalarTransform4f(matrix),
                }
                self.first.append(total)
                self.thing.append(int(objects.rows(copy)[0]))
                matrices.append(copy.turn)
            total += len(model.faces)
        self.attitude = _upright(len(matrices))
        if matrices:
            self.attitude = Rotation.from_matrix(np.array(matrices)).as_quat(scalar_first=True)
        self.faces = _joined(parts)


def _models(static: Sequence[Geometry]) -> dict[int, list[PlacedGeometry]]:
    """Copies by model, of those models whose copies would together be large."""
    groups: dict[int, list[PlacedGeometry]] = {}
    for g in static:
        if isinstance(g, PlacedGeometry) and len(g.faces):
            groups.setdefault(id(g.model), []).append(g)
    return {k: group for k, group in groups.items() if len(group) * len(group[0].faces) > _MANY_COPIED}


def _give_back() -> None:
    """Return memory that nothing uses any more to the system: Dr.Jit and the C library keep it for later."""
    dr.sync_thread()
    dr.flush_malloc_cache()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
    if trim is not None:
        trim(0)


def _watertight() -> dict[str, bool]:
    """Without it, Embree lets rays slip through that meet an edge or a vertex exactly; it costs no measurable time."""
    return {"embree_use_robust_intersections": True} if _on_host() else {}


def _on_host() -> bool:
    """Whether arrays lie in the machine's own memory, where NumPy sees them without a copy."""
    return str(jit.mi.variant()).startswith("llvm")


def copy_offsets(copies: int) -> NDArray[np.float64]:
    """`(copies, 3)` where the moving bodies of each copy stand [m]; the first copy stands where it is."""
    c = np.arange(copies)
    cell = np.stack([c % _LATTICE, c // _LATTICE % _LATTICE, c // _LATTICE**2], axis=-1)
    return np.asarray(cell * COPY_SPACING, dtype=np.float64)


def _single(place: NDArray[np.float64]) -> Array:
    """One place, each coordinate in memory of its own: equal literals would share it, and change what is recorded."""
    return jit.Array3f64(*(dr.opaque(jit.Float64, float(c)) for c in place))


def _mesh(name: str, group: Sequence[Geometry], origin: NDArray[np.float64]) -> tuple[Any, Faces]:
    """One Mitsuba mesh of several geometries, relative to `origin`, filled part by part to spare memory.

    Its tables of faces share its arrays. `thing` is still to be filled in.
    """
    starts = np.cumsum([0] + [len(g.vertices) for g in group])
    ends = np.cumsum([0] + [len(g.faces) for g in group])
    vertices = np.empty((starts[-1], 3), dtype=np.float32)
    faces = np.empty((ends[-1], 3), dtype=np.uint32)
    normals = np.zeros((starts[-1], 3), dtype=np.float32)
    for g, v, w, f in zip(group, starts, starts[1:], ends, strict=False):
        np.subtract(g.vertices, origin, out=vertices[v:w], casting="same_kind")
        np.add(g.faces, np.uint32(v), out=faces[f : f + len(g.faces)], casting="same_kind")
        if g.vertex_normals is not None:
            normals[v:w] = g.vertex_normals
    mesh = jit.mi.Mesh(name, len(vertices), len(faces))
    parameters = jit.mi.traverse(mesh)
    made = Faces(jit.own(jit.UInt32, faces), jit.own(jit.Float, vertices), jit.own(jit.Float, normals), jit.UInt32(0))
    del faces, vertices, normals
    first = group[0]
    large = len(first.faces) > _MANY_FACES and not isinstance(first, PlacedGeometry)
    if large and first.vertex_normals is not None and _on_host():
        corners, directions = made.corner.numpy().reshape(-1, 3), made.normal.numpy().reshape(-1, 3)
        first.share(corners[: len(first.faces)], directions[: len(first.vertex_normals)])
    parameters["vertex_positions"], parameters["faces"] = made.place, made.corner
    parameters.update()
    return mesh, made


def _joined(parts: Sequence[Faces], thing: Array | None = None) -> Faces:
    """Several tables of faces as one; that of one part is the part itself."""
    if not parts:
        return _no_faces()
    if thing is None:
        thing = dr.concat([p.thing for p in parts])
    if len(parts) == 1:
        return Faces(parts[0].corner, parts[0].place, parts[0].normal, thing)
    corners = np.cumsum([0] + [dr.width(p.place) // 3 for p in parts])
    corner = dr.concat([p.corner + int(c) for p, c in zip(parts, corners, strict=False)])
    made = Faces(corner, dr.concat([p.place for p in parts]), dr.concat([p.normal for p in parts]), thing)
    dr.eval(made)
    return made


def _no_faces() -> Faces:
    """One face of no size, for scenes without any."""
    made = Faces(dr.zeros(jit.UInt32, 3), dr.zeros(jit.Float, 3), dr.zeros(jit.Float, 3), dr.zeros(jit.UInt32, 1))
    dr.make_opaque(made)
    return made


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


def _upright(count: int) -> NDArray[np.float64]:
    return np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))


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
