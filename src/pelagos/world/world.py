"""A world: everything that does not move, what it is made of, and where on Earth it lies."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib import import_module
from typing import Any
from weakref import WeakMethod

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos.errors import CommandError, LookupFailed, WorldError
from pelagos.jit import Array
from pelagos.math.geodesy import GeoOrigin
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.world.clearance import Clearance
from pelagos.world.label import label_name, label_number
from pelagos.world.large.clearance import GroundClearance
from pelagos.world.large.ground import LargeGround
from pelagos.world.large.stream import Stream
from pelagos.world.material import MATERIALS, Material, MaterialTables, material_tables
from pelagos.world.mover import MoverConfig
from pelagos.world.reflector import CORNERS
from pelagos.world.terrain import HeightField


@dataclass(frozen=True)
class Hits:
    """Hits of rays, as NumPy arrays `(m, ...)`; where a ray misses, `t` is infinite and the rest is zero.

    Attributes:
        t: `(m,)` float32, distance [m].
        position: `(m, 3)` float64, world NWU [m].
        normal: `(m, 3)` float32, unit, turned towards the ray's origin.
        label: `(m,)` uint32, semantic label.
        instance: `(m,)` uint32, 0 where nothing was hit.
        material: `(m,)` uint32, row of `World.materials`.
        velocity: `(m, 3)` float32, of the surface point, world NWU [m/s].
    """

    t: NDArray[np.float32]
    position: NDArray[np.float64]
    normal: NDArray[np.float32]
    label: NDArray[np.uint32]
    instance: NDArray[np.uint32]
    material: NDArray[np.uint32]
    velocity: NDArray[np.float32]

    @property
    def valid(self) -> NDArray[np.bool_]:
        """`(m,)` whether the ray hit anything."""
        return np.isfinite(self.t)


@dataclass(frozen=True)
class World:
    """Static geometry with meaning.

    Attributes:
        geometries: meshes in world NWU, each with material rows, label and instance id.
        materials: the material table; `Geometry.material` is a row of it.
        origin: where on Earth (0, 0, 0) lies.
        name, description: for people.
        terrain: the ground as a height field, where there is one.
        notes: what the builder wants people to know (holes filled, objects that found no place).
        user_labels: labels of the scenario's own, name to number.
        movers: bodies on scripted paths, which a simulation puts into the moving scene.
        paused: movers that stand still here as the last of `geometries`, see `at_time`.
        ground: ground that is streamed; the one of `geometries` with its instance id is then an overview for people,
            which rays do not hit.
    """

    geometries: Sequence[Geometry]
    materials: Sequence[Material]
    origin: GeoOrigin = field(default_factory=lambda: GeoOrigin(0.0, 0.0))
    name: str = "world"
    description: str = ""
    terrain: HeightField | None = None
    notes: tuple[str, ...] = ()
    user_labels: Mapping[str, int] = field(default_factory=dict)
    movers: Sequence[MoverConfig] = ()
    paused: Sequence[MoverConfig] = ()
    ground: LargeGround | None = None
    _live: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)

    def scene(self, copies: int = 1) -> Scene:
        """A new ray-tracing scene for a fleet of `copies`; from now on `cast` asks this one, bodies included."""
        standing = self.geometries if self.ground is None else self._standing
        ground = None if self.ground is None else Stream(self.ground)
        made = Scene(standing, copies=copies, ground=ground)
        self._live.clear()
        self._live["scene"] = made
        return made

    def twin(self) -> World:
        """The same world and scene for another simulation, whose bodies its own `cast` sees."""
        made = copy.copy(self)
        object.__setattr__(made, "_live", {k: v for k, v in self._live.items() if k != "update"})
        return made

    def at_time(self, t: float) -> World:
        """The world with its movers standing still where they are at time t [s]: for pictures, maps and exports."""
        if not self.movers:
            return self
        made = [m.standing(t, instance=self.next_instance + k, world=self) for k, m in enumerate(self.movers)]
        more = np.unique(np.concatenate([g.face_materials for g in made]))
        more = more[more >= len(self.materials)]
        row = np.arange(len(self.palette), dtype=np.uint32)
        row[more] = len(self.materials) + np.arange(len(more))
        return replace(
            self,
            geometries=(*self.geometries, *(replace(g, material=row[g.face_materials]) for g in made)),
            materials=(*self.materials, *(self.palette[m] for m in more)),
            movers=(),
            paused=tuple(self.movers),
            _live={},
        )

    def material_tables(self) -> MaterialTables:
        """The materials' properties on the device: rows as in `materials`, then all others that a scenario may name."""
        return material_tables(self.palette)

    @cached_property
    def palette(self) -> tuple[Material, ...]:
        """The rows of `material_tables`: `materials`, all others that a scenario may name, and those of corners."""
        own = {m.name for m in self.materials}
        return (*self.materials, *(m for name, m in (MATERIALS | CORNERS).items() if name not in own))

    def material_row(self, name: str) -> int:
        """The row of a material in `material_tables`, for bodies that are spawned later.

        Raises:
            LookupFailed: no material has this name.
        """
        names = [m.name for m in self.palette]
        if name not in names:
            raise LookupFailed("material", name, names)
        return names.index(name)

    def label_number(self, name: str | int) -> int:
        """The number of a label by name; the scenario's own labels count too."""
        return label_number(name, dict(self.user_labels))

    @cached_property
    def labels(self) -> dict[int, str]:
        """Numbers and names of the labels in this world."""
        numbers = {g.label for g in self.geometries} | {m.label_number(self) for m in self.movers}
        return {n: label_name(n, dict(self.user_labels)) for n in sorted(numbers)}

    @cached_property
    def names(self) -> dict[int, str]:
        """Names of the static objects by instance id."""
        return {g.instance: g.name for g in self.geometries}

    @property
    def next_instance(self) -> int:
        """The first instance id that no static object has."""
        return max((g.instance for g in self.geometries), default=0) + 1

    @property
    def still(self) -> Sequence[Geometry]:
        """The geometries without paused movers."""
        return self.geometries[: len(self.geometries) - len(self.paused)]

    @cached_property
    def bounds(self) -> NDArray[np.float64]:
        """`(2, 3)` lowest and highest coordinates of anything static, paused movers left out [m]."""
        extents = np.array([g.extent for g in self.still if len(g.faces)])
        if not len(extents):
            return np.zeros((2, 3))
        return np.stack([extents[:, 0].min(axis=0), extents[:, 1].max(axis=0)])

    @cached_property
    def triangles(self) -> int:
        """Number of faces."""
        return sum(len(g.faces) for g in self.geometries)

    @cached_property
    def clearance(self) -> Clearance:
        """See `Clearance`; without a streamed ground."""
        return Clearance(self._standing)

    @cached_property
    def _standing(self) -> list[Geometry]:
        """Things that stand in the static scene as they are."""
        streamed = None if self.ground is None else self.ground.instance
        return [g for g in self.geometries if g.instance != streamed]

    @cached_property
    def _ground_clearance(self) -> GroundClearance | None:
        return None if self.ground is None else GroundClearance(self.ground)

    def near(self, position: NDArray[np.float64], margin_m: float | NDArray[np.float64]) -> NDArray[np.bool_]:
        """`(n,)`: whether anything static may be within `margin_m` [m], one or `(n,)`, of positions `(n, 3)` [m]; False
        is certain."""
        near = self.clearance.near(position, margin_m)
        return near if self._ground_clearance is None else near | self._ground_clearance.near(position, margin_m)

    def height(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Height of the ground [m] at x, y [m], on the triangles that rays hit; NaN where the world has no ground."""
        if self.terrain is None:
            return np.full(np.broadcast(np.asarray(x), np.asarray(y)).shape, np.nan)
        return self.terrain.surface(x, y)

    def cast(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        max_range: ArrayLike = 100.0,
        *,
        copy: ArrayLike = 0,
        own_body: ArrayLike = NO_BODY,
        bodies: bool = True,
    ) -> Hits:
        """The nearest thing along each ray; in a simulation, what moves stands where it is at the current time.

        Args:
            origins: `(m, 3)` or `(3,)` world NWU [m].
            directions: `(m, 3)` or `(3,)`, of any length but zero.
            max_range: `(m,)` or one number [m].
            copy: `(m,)` or one number: the copy of the fleet whose bodies a ray may hit.
            own_body: `(m,)` or one number: the body that a ray passes through, see `SensorContext.own_body`.
            bodies: whether rays hit what moves too; else they pass through all of it.

        Raises:
            CommandError: a wrong shape, a value that is not finite, or a direction of no length.
        """
        start, along, reach = _rays(origins, directions, max_range)
        caster = self._caster(bodies=bodies)
        update = self._live["update"]() if "update" in self._live else None
        if update is not None:
            update()
        whose, own = (np.broadcast_to(np.asarray(v, dtype=np.uint32), (len(start),)) for v in (copy, own_body))
        return caster(start, along, reach, whose, own)

    def before_cast(self, update: Callable[[], None]) -> None:
        """From now on, `cast` first calls this bound method, as long as its owner lives."""
        self._live["update"] = WeakMethod(update)

    def inside(self, position: ArrayLike, radius: float = 0.0) -> str | None:
        """Reason for which a sphere would touch something at one of these places; None where it touches nothing.

        Args:
            position: centres `(n, 3)` or `(3,)`, world NWU [m].
            radius: of the sphere that must be free [m].
        """
        from pelagos.world.placement import why_not_free

        return why_not_free(self, np.atleast_2d(np.asarray(position, dtype=np.float64)), radius)

    def _repr_html_(self) -> str:
        return str(import_module("pelagos.drawing.notebook").world_html(self))

    def _scene(self) -> Scene:
        if "scene" not in self._live:
            self.scene()
        found: Scene = self._live["scene"]
        return found

    def _caster(self, *, bodies: bool) -> Callable[..., Hits]:
        scene, name = self._scene(), "cast" if bodies else "cast past bodies"
        if name not in self._live:
            self._live[name] = _make_caster(scene, bodies=bodies)
        found: Callable[..., Hits] = self._live[name]
        return found


def _rays(
    origins: ArrayLike, directions: ArrayLike, max_range: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float32], NDArray[np.float32]]:
    start = np.atleast_2d(np.asarray(origins, dtype=np.float64))
    along = np.atleast_2d(np.asarray(directions, dtype=np.float64))
    if start.ndim != 2 or along.ndim != 2 or start.shape[1] != 3 or along.shape[1] != 3:
        raise CommandError(f"cast takes origins and directions (m, 3), not {start.shape} and {along.shape}")
    try:
        start, along = np.broadcast_arrays(start, along)
        reach = np.broadcast_to(np.asarray(max_range, dtype=np.float32), (len(start),))
    except ValueError as error:
        raise CommandError(
            f"cast: origins {start.shape}, directions {along.shape} and max_range do not go together"
        ) from error
    length = np.sqrt((along * along).sum(axis=1, keepdims=True))
    if not (np.isfinite(start).all() and np.isfinite(length).all() and (length > 0).all()):
        raise CommandError("cast: an origin or direction is not finite, or a direction has no length")
    if not (reach > 0).all():
        raise CommandError("cast: max_range must be greater than zero")
    return start, (along / length).astype(np.float32), reach


def _make_caster(scene: Scene, *, bodies: bool) -> Callable[..., Hits]:
    """A recorded NumPy face of `Caster.cast` on this scene, with or without what moves."""
    from pelagos import jit
    from pelagos.raycast.caster import Caster
    from pelagos.raycast.rays import Rays

    def shoot(caster: Caster, origin: Array, direction: Array, reach: Array, copy: Array, own: Array) -> Any:
        asked = caster if bodies else Caster(caster.static, None, caster.tables)
        hits = asked.cast(Rays(origin, direction, reach, copy, own))
        return hits.t, hits.position, hits.normal, hits.label, hits.instance, hits.material, hits.velocity

    frozen = scene.compile(shoot)

    def call(
        start: NDArray[np.float64],
        along: NDArray[np.float32],
        reach: NDArray[np.float32],
        copy: NDArray[np.uint32],
        own: NDArray[np.uint32],
    ) -> Hits:
        try:
            scene.peek(start)
        except WorldError:  # a streamed ground cannot have full detail at so many places: some after the others
            return _halves(call, start, along, reach, copy, own)
        if scene.static is None and (scene.moving is None or not bodies):
            return _misses(len(start))
        out = frozen(
            jit.Array3f64(*(jit.padded(column) for column in start.T)),
            jit.Array3f(*(jit.padded(column) for column in along.T)),
            jit.Float(jit.padded(reach)),
            jit.UInt32(jit.padded(copy)),
            jit.UInt32(jit.padded(own)),
        )
        t, position, normal, label, instance, material, velocity = (a.numpy() for a in out)
        return Hits(t, position.T, normal.T, label, instance, material, velocity.T)

    return call


def _halves(call: Callable[..., Hits], start: NDArray[np.float64], *more: NDArray[Any]) -> Hits:
    """Rays of the one half of the world, then of the other."""
    axis = int(np.argmax(np.ptp(start[:, :2], axis=0)))
    order = np.argsort(start[:, axis], kind="stable")
    parts = [order[: len(order) // 2], order[len(order) // 2 :]]
    found = [call(start[p], *(m[p] for m in more)) for p in parts]
    back = np.argsort(order, kind="stable")
    names = Hits.__dataclass_fields__
    return Hits(**{name: np.concatenate([getattr(f, name) for f in found])[back] for name in names})


def _misses(count: int) -> Hits:
    number = np.zeros(count, dtype=np.uint32)
    vector = np.zeros((count, 3), dtype=np.float32)
    return Hits(np.full(count, np.inf, np.float32), vector.astype(np.float64), vector, number, number, number, vector)
