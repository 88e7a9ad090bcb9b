"""The two ray-tracing scenes, and the tables that say what was hit.

Static geometry stands in a Mitsuba scene that never changes; the meshes of everything that moves stand side by side in
a second one, which does not change either: rays find bodies by a tree of boxes (`body_tree.py`). Single precision is
kept exact to a millimetre by working relative to `origin`, and to each body. Copies of a fleet share both scenes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.so3 import matrix_np
from pelagos.raycast.body_tree import tree_of
from pelagos.raycast.caster import Caster
from pelagos.raycast.copies import Copies, models, upright
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.hit_tables import Faces, HitTables
from pelagos.raycast.meshes import give_back, joined, large, mesh_of, no_faces, watertight
from pelagos.raycast.objects import Objects
from pelagos.raycast.shapes import Shapes
from pelagos.raycast.spheres import Spheres
from pelagos.raycast.streamed import StreamedGround

_SKIN_M: Final = 0.01  # about the sphere that holds a mesh: rays begin outside of it
_MANY_COPIES: Final = 500  # instances beside which nothing is frozen


class Scene:
    """Static and moving geometry of one world, for a fleet of `copies`.

    Attributes:
        static, moving: the two `mi.Scene`; `moving` holds the meshes of bodies and is None while there are none.
        tables: see `HitTables`.
        generation: counts replacements of `moving` (not its motions).
        holder: whose bodies these are, where several simulations share a scene.
        reading: a sensor is asked: bodies are where it shall see them.
    """

    def __init__(
        self,
        static: Sequence[Geometry],
        *,
        copies: int = 1,
        ground: StreamedGround | None = None,
    ) -> None:
        self.copies = copies
        self._ground = ground
        self.generation = 0
        self._merged = -1  # generation of the scenes that are said to be merged
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
        objects = Objects()
        copies_of = models(static) if ground is None else {}
        copied = {id(g) for group in copies_of.values() for g in group}
        single = [g for g in static if id(g) not in copied]
        # smooth ones first, and among them the largest: the first one can share its arrays
        self._standing = sorted(single, key=lambda g: (g.vertex_normals is None, not large(len(g.faces))))
        self._static_things = [objects.rows(g) for g in self._standing]
        if ground is not None:
            self._ground_rows = objects.add(*ground.identity)
            self._static_things.append(self._ground_rows[ground.patch.face_materials])
        self._copies = Copies(copies_of, objects, self.origin)
        self.static: Any = None
        self._static_parameters: Any = None
        self._static_faces: list[Faces] = []
        if len(static) or ground is not None:
            self._load_static()
        self._objects = objects
        self._fixed_objects = len(objects.label)
        self._bodies: list[Geometry] = []
        self._body_copy = np.zeros(0, dtype=np.int64)
        self._body_radius = np.zeros(0)
        self.holder: object = None
        self.reading = False
        self.moving: Any = None
        self._boxes: NDArray[np.float64] = np.zeros((0, 2, 3))
        self._refresh_tables(None, [])
        if ground is not None:
            self._exchange_ground()  # from now on all its arrays are our own: frozen functions see exchanges

    def _load_static(self) -> None:
        """Load the static scene: what stands in one mesh, then a streamed ground, then copies of models."""
        shapes: dict[str, Any] = {}
        self._static_faces = []
        if self._standing:
            shapes["standing"], faces = mesh_of("standing", self._standing, self.origin)
            self._static_faces.append(faces)
        if self._ground is not None:
            patch = self._ground.patch
            part = Geometry(patch.vertices.astype(np.float64), patch.faces, 0, 0, 0, patch.normals)
            shapes["ground"], faces = mesh_of("ground", [part], np.zeros(3))
            self._static_faces.append(faces)
        if large(sum(m.face_count() for m in shapes.values())):
            give_back()  # the tree over the triangles is about to need more than all that was built before
        shapes |= self._copies.shapes
        self.static = jit.mi.load_dict({"type": "scene", **watertight(), **shapes}, optimize=False)
        self._static_parameters = jit.mi.traverse(self.static) if self._ground is not None else None

    def _static_tables(self) -> Faces:
        """Faces of the static meshes; those of a single mesh are its own arrays, not copies."""
        things = jit.from_numpy(
            jit.UInt32, np.concatenate(self._static_things) if self._static_things else np.zeros(1, np.uint32)
        )
        return joined(self._static_faces, things)

    @property
    def standing(self) -> Sequence[Geometry]:
        """Things that stand still, each in a mesh of its own; without copies of models and streamed ground."""
        return self._standing

    @property
    def bodies(self) -> Sequence[tuple[Geometry, int]]:
        """Bodies that move, by row: geometry in its own frame, and copy."""
        return [(g, int(c)) for g, c in zip(self._bodies, self._body_copy, strict=True)]

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

    def peek(self, places: NDArray[np.float64]) -> bool:
        """The same for rays of other origin; the next `follow` is as if this had not been."""
        if self._ground is None or not self._ground.peek(places[:, :2]):
            return False
        self._exchange_ground()
        return True

    def _first_faces(self) -> list[int]:
        """First face of each static mesh."""
        return [0, *np.cumsum([dr.width(f.corner) // 3 for f in self._static_faces]).tolist()][
            : len(self._static_faces)
        ]

    def memory(self) -> object:
        """Memory of a streamed ground; None without one."""
        return None if self._ground is None else self._ground.memory()

    def recall(self, memory: object) -> None:
        """Take a streamed ground back to what it had settled on."""
        if self._ground is not None:
            self._ground.recall(memory)

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
            self.tables.static_base, self.tables.static_row = (
                dr.opaque(jit.UInt32, base),
                jit.from_numpy(jit.UInt32, rows),
            )
        parameters = self._static_parameters
        place, normal = jit.from_numpy(jit.Float, patch.vertices), jit.from_numpy(jit.Float, patch.normals)
        corner = jit.from_numpy(jit.UInt32, patch.faces)
        parameters["ground.vertex_positions"], parameters["ground.faces"] = place, corner
        self._static_faces[-1] = Faces(corner, place, normal, corner)
        if (patch.origin != self.origin).any() and self._standing:
            moved = np.concatenate([g.vertices - patch.origin for g in self._standing]).astype(np.float32)
            parameters["standing.vertex_positions"] = self._static_faces[0].place = jit.from_numpy(jit.Float, moved)
        parameters.update()
        self.origin = patch.origin
        self._static_things[-1] = self._ground_rows[patch.face_materials]
        t = self.tables
        t.origin = _single(patch.origin)
        t.static = self._static_tables()
        if self._poses is not None:
            self.move(*self._poses)

    def set_moving(self, bodies: Sequence[tuple[Geometry, int]]) -> None:
        """Replace everything that moves: `(geometry in its body frame, copy)` by row, bodies by copies. Poses follow
        with `move`."""
        self.generation += 1
        self._poses = None
        self._bodies = [g for g, _ in bodies]
        self._body_copy = np.array([c for _, c in bodies], dtype=np.int64)
        assert np.array_equal(self._body_copy, np.arange(len(bodies)) % self.copies)
        shapes = Shapes(self._bodies) if bodies else None
        self.moving = None if shapes is None else shapes.scene
        self._boxes = np.array([g.extent for g in self._bodies]).reshape(-1, 2, 3)
        self._body_radius = np.zeros(0) if shapes is None else shapes.radius
        self._objects.cut(self._fixed_objects)
        things: dict[int, int] = {}
        for row, geometry in enumerate(self._bodies):
            if id(geometry) not in things:
                assert shapes is not None
                rows = self._objects.add(geometry.label, geometry.instance, shapes.materials[row])
                things[id(geometry)] = int(rows[0])
        self._refresh_tables(shapes, [things[id(g)] for g in self._bodies])

    def holds(self, bodies: Sequence[tuple[Geometry, int]]) -> bool:
        """Whether these, in this order, are what moves now."""
        return len(bodies) == len(self._bodies) and all(
            g is held and copy == held_copy
            for (g, copy), held, held_copy in zip(bodies, self._bodies, self._body_copy, strict=True)
        )

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
        t = self.tables
        t.body_position = _array3(position, jit.Array3f64)
        t.body_attitude = _array4f(attitude)
        t.body_velocity = _array3(velocity, jit.Array3f)
        t.body_angular_velocity = _array3(angular_velocity, jit.Array3f)
        dr.make_opaque(t.body_position, t.body_attitude, t.body_velocity, t.body_angular_velocity)
        t.tree = tree_of(*self._boxes_about(position - self.origin, attitude), self.copies)

    def _boxes_about(
        self, place: NDArray[np.float64], attitude: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Corners `(b, 3)`, `(b, 3)` of the boxes, along the world's axes, about the boxes of all bodies."""
        turn = matrix_np(attitude)
        low, high = self._boxes[:, 0], self._boxes[:, 1]
        middle = place + np.einsum("bij,bj->bi", turn, (low + high) / 2)
        half = np.einsum("bij,bj->bi", np.abs(turn), (high - low) / 2)
        return middle - half, middle + half

    @property
    def spheres(self) -> Spheres | None:
        """Around what moves, where it is now; None before it was placed."""
        return None if self._poses is None else Spheres(self._poses[0], self._body_radius, self._body_copy)

    @property
    def caster(self) -> Caster:
        """Caster of rays into the world as it is now, for calls that are not frozen."""
        return Caster(self.static, self.moving, self.tables)

    def compile(self, kernel: Callable[..., Any]) -> Callable[..., Any]:
        """Freeze `kernel(caster, *arrays)`, and freeze it anew when the moving scene is replaced.

        A frozen function sees only arrays that are its arguments; the `Caster` is made inside it, because it sees only
        scenes that its own body names. Beside thousands of instances it is not frozen: Dr.Jit looks at each of them in
        every frozen call, which takes longer than to record the work again.
        """
        frozen: Callable[..., Any] | None = None
        generation = -1

        def seeing(static: Any, moving: Any) -> Callable[..., Any]:
            return lambda tables, *arguments: kernel(Caster(static, moving, tables), *arguments)

        def call(*arguments: Any) -> Any:
            nonlocal frozen, generation
            if frozen is None or generation != self.generation:
                many = len(self._copies.first) > _MANY_COPIES
                if not many and self._merged != self.generation:
                    _merge(self.static, self.moving)
                    self._merged = self.generation
                make = seeing(self.static, self.moving) if many else jit.freeze(seeing, self.static, self.moving)
                frozen, generation = make, self.generation
            return frozen(self.tables, *arguments)

        return call

    def _refresh_tables(self, shapes: Shapes | None, moving_thing: list[int]) -> None:
        u32 = jit.UInt32
        rows = max(len(moving_thing), 1)
        zero = np.zeros((rows, 3))
        offset, radius = (zero, zero[:, 0]) if shapes is None else (shapes.offset, shapes.radius + _SKIN_M)
        o = self._objects
        static_base, static_row = _rows_by_identifier(self.static)
        boxes = np.zeros((max(len(moving_thing), self.copies), 3))  # of the size that they will keep
        self.tables = HitTables(
            origin=_single(self.origin),
            static_base=u32(static_base),
            static_row=jit.from_numpy(u32, static_row),
            static_first=jit.from_numpy(u32, _table([*self._first_faces(), *self._copies.first])),
            moving_thing=jit.from_numpy(u32, _table(moving_thing)),
            static=self._static_tables(),
            models=self._copies.faces,
            moving=no_faces() if shapes is None else shapes.tables.faces,
            static_turn=_array4f(np.concatenate([upright(max(len(self._static_faces), 1)), self._copies.attitude])),
            static_thing=jit.from_numpy(u32, _table([0] * len(self._static_faces) + self._copies.thing)),
            label=jit.from_numpy(u32, _table(o.label)),
            instance=jit.from_numpy(u32, _table(o.instance)),
            material=jit.from_numpy(u32, _table(o.material)),
            tree=tree_of(boxes, boxes, self.copies),
            body_offset=_array3(offset, jit.Array3f),
            body_radius=jit.from_numpy(jit.Float, radius),
            body_position=_array3(zero, jit.Array3f64),
            body_attitude=_array4f(upright(rows)),
            body_velocity=_array3(zero, jit.Array3f),
            body_angular_velocity=_array3(zero, jit.Array3f),
        )
        dr.make_opaque(self.tables)


def _merge(static: Any, moving: Any) -> None:
    """Let two scenes share what they hold alike: the addresses of the functions that trace rays.

    Dr.Jit finds out in the first two calls that see both scenes. A kernel that was recorded before would be recorded,
    and compiled, once more: for a sonar's ping up to a minute.
    """
    if static is None or moving is None:
        return
    see = jit.freeze(lambda _static, _moving: lambda x: x, static, moving)
    for _ in range(2):
        see(dr.opaque(jit.Float, 0.0))


def _single(place: NDArray[np.float64]) -> Array:
    """One place, each coordinate in memory of its own: equal literals would share it, and change what is recorded."""
    return jit.Array3f64(*(dr.opaque(jit.Float64, float(c)) for c in place))


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


def _array3(values: NDArray[np.float64], kind: Any) -> Array:
    made = kind(np.ascontiguousarray(values.T, dtype=np.float64 if kind is jit.Array3f64 else np.float32))
    jit.align(made)
    return made


def _array4f(values: NDArray[np.float64]) -> Array:
    made = jit.Array4f(np.ascontiguousarray(values.T, dtype=np.float32))
    jit.align(made)
    return made
