"""Everything that moves, kept in step with the moving scene: the agents' hulls, and props that come and go."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import CommandError
from pelagos.math.so3 import rotate_np
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.scene import Scene
from pelagos.sim.state import States
from pelagos.sim.trajectory import CHANNELS
from pelagos.vehicles.vehicle import Vehicle
from pelagos.world.world import World

BLOCK_S = 1.0  # the step loop asks at least this often whether anything is near
_LEVEL = (1.0, 0.0, 0.0, 0.0)


@dataclass
class Body:
    """A spawned thing: the handle that `Simulation.spawn` returns.

    Attributes:
        name: unique in a run.
        geometry: in its own frame FLU.
        position: `(n, 3)` NWU [m].
        attitude: `(n, 4)` (w, x, y, z).
        velocity, angular_velocity: `(n, 3)` in the world frame [m/s], [rad/s].
        fastest_mps: of a body on a scripted path, the greatest speed of its origin [m/s]; None for one that stays where
            it is put.
        of_scenario: it is a prop of the scenario, which a reset puts back; what was spawned is taken away.
    """

    name: str
    geometry: Geometry
    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    velocity: NDArray[np.float64]
    angular_velocity: NDArray[np.float64]
    _bodies: Bodies = field(repr=False)
    fastest_mps: float | None = None
    of_scenario: bool = False

    def move(
        self,
        *,
        position: object = None,
        attitude: object = None,
        velocity: object = None,
        angular_velocity: object = None,
    ) -> None:
        """Place the body anew, in every copy or (leading axis n) in each; what is not given stays.

        A body stays where it is put: its velocity is what sonars and contacts feel, and does not carry it away.

        Raises:
            CommandError: a wrong shape, a value that is not finite, or the body was removed.
        """
        self._bodies.require(self)
        n = len(self.position)
        if position is not None:
            self.position = rows(position, n, 3, f"{self.name}: position")
        if attitude is not None:
            self.attitude = unit_rows(attitude, n, f"{self.name}: attitude")
        if velocity is not None:
            self.velocity = rows(velocity, n, 3, f"{self.name}: velocity")
        if angular_velocity is not None:
            self.angular_velocity = rows(angular_velocity, n, 3, f"{self.name}: angular_velocity")
        self._bodies.changed = True
        self._bodies.changes += 1

    def remove(self) -> None:
        """Take the body out of the world: the next ray passes where it stood."""
        self._bodies.remove(self)


class Bodies:
    """The rows of the moving scene: agents first, `n` rows each where agents can see each other, then bodies.

    Attributes:
        hulls: by agent, where there are several.
        bodies: movers, then what was spawned.
        script: moves what follows a script to where it is at a tick.
        changed: a body was moved since the scene was brought up to date.
        changes: counts what was spawned, moved and removed.
        spawned: bodies that were spawned since the start, for their names.
    """

    def __init__(self, scene: Scene, hulls: Mapping[str, Geometry], *, n: int, first_instance: int) -> None:
        self._scene = scene
        self._n = n
        self._all_hulls = dict(hulls)
        self._first_instance = self._next_instance = first_instance
        self.spawned = 0
        shown = len(hulls) > 1
        self.hulls: dict[str, Geometry] = {}
        for name, hull in hulls.items():
            if shown:
                self.hulls[name] = replace(hull, instance=self.new_instance(), name=name)
        self.bodies: list[Body] = []
        self.script: Callable[[int], None] | None = None
        self.changed = True
        self.changes = 0
        self._ground: object = None
        self._rebuild()

    def twin(self) -> Bodies:
        """The same bodies for another simulation, which takes turns with this one at the scene."""
        made = copy.copy(self)
        made.bodies = [replace(b, _bodies=made) for b in self.bodies]
        made.script, made._ground = None, self._of_ground()
        return made

    def memory(self) -> dict[str, Any]:
        """Every spawned body, and what a streamed ground has settled on."""
        kept = [
            {
                "name": b.name, "geometry": b.geometry, "position": b.position.copy(), "attitude": b.attitude.copy(),
                "velocity": b.velocity.copy(), "angular_velocity": b.angular_velocity.copy(),
                "of_scenario": b.of_scenario,
            }
            for b in self.bodies if b.fastest_mps is None
        ]  # fmt: skip
        return {
            "spawned": kept,
            "count": self.spawned,
            "next_instance": self._next_instance,
            "ground": self._of_ground(),
        }

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Put those bodies where they were; handles of bodies that are still here stay good."""
        now = [b for b in self.bodies if b.fastest_mps is None]
        scripted = [b for b in self.bodies if b.fastest_mps is not None]
        spawned = []
        for kept in memory["spawned"]:
            poses = {k: kept[k].copy() for k in ("position", "attitude", "velocity", "angular_velocity")}
            instance = kept["geometry"].instance
            body = next((b for b in now if (b.name, b.geometry.instance) == (kept["name"], instance)), None)
            if body is None:
                body = Body(kept["name"], kept["geometry"], **poses, _bodies=self, of_scenario=kept["of_scenario"])
            for key, values in poses.items():
                setattr(body, key, values)
            spawned.append(body)
        same = len(now) == len(spawned) and all(a is b for a, b in zip(now, spawned, strict=True))
        self.bodies[:] = [*scripted, *spawned]
        self._next_instance, self.spawned = memory["next_instance"], memory["count"]
        self.changed = True
        if not same:
            self._rebuild()
        self._hold()
        self._scene.recall(memory["ground"])

    def forget(self) -> None:
        """A run begins anew: where a streamed ground was before has no effect."""
        self._hold()
        self._scene.forget()

    def _of_ground(self) -> object:
        return self._scene.memory() if self._scene.holder is self else self._ground

    def _hold(self) -> None:
        """Have the scene hold these bodies, where it holds those of another simulation."""
        if self._scene.holder is not self:
            self._take_over()
            if not self._scene.holds(self._rows()):
                self._rebuild()

    def _take_over(self) -> None:
        before = self._scene.holder
        if before is self:
            return
        if isinstance(before, Bodies):
            before._ground = self._scene.memory()
        self._scene.holder = self
        self._scene.recall(self._ground)
        self.changed = True

    @property
    def any(self) -> bool:
        """Something stands in the moving scene."""
        return bool(self.hulls or self.bodies)

    def new_instance(self) -> int:
        """An instance id that nothing had before."""
        self._next_instance += 1
        return self._next_instance - 1

    def instance_of_prop(self, number: int) -> int:
        """The instance id of the scenario's prop of that number: behind hulls and movers, in every episode the same."""
        instance = self._first_instance + len(self.hulls) + self._scripted() + number
        self._next_instance = max(self._next_instance, instance + 1)
        return instance

    def _scripted(self) -> int:
        return sum(b.fastest_mps is not None for b in self.bodies)

    def add(
        self, name: str, geometry: Geometry, position: object, attitude: object = _LEVEL, *, prop: int | None = None
    ) -> Body:
        """Put a body into every copy of the world; `prop` is its number among the scenario's, which come first."""
        if any(b.name == name for b in self.bodies):
            raise CommandError(f"a body named {name!r} is there already; names are unique")
        n, zero = self._n, np.zeros((self._n, 3))
        at = rows(position, n, 3, f"{name}: position")
        turned = unit_rows(attitude, n, f"{name}: attitude")
        body = Body(name, geometry, at, turned, zero, zero, self, of_scenario=prop is not None)
        self.bodies.insert(len(self.bodies) if prop is None else self._scripted() + prop, body)
        self._rebuild()
        return body

    def add_scripted(self, made: Sequence[tuple[str, Geometry, float]]) -> list[Body]:
        """Put bodies on scripted paths into every copy: `(name, geometry, fastest_mps)`. They outlive `clear`."""
        n, zero = self._n, np.zeros((self._n, 3))
        level = np.tile(np.array(_LEVEL), (n, 1))
        added = [Body(name, g, zero, level, zero, zero, self, fastest_mps=fastest) for name, g, fastest in made]
        if added:
            self.bodies += added
            self._rebuild()
        return added

    def remove(self, body: Body) -> None:
        """Take a body out."""
        self.require(body)
        self.bodies.remove(body)
        self._rebuild()

    def clear(self) -> None:
        """Take every spawned body out; those on scripted paths and the scenario's props stay."""
        kept = [b for b in self.bodies if b.fastest_mps is not None or b.of_scenario]
        geometries = (*self.hulls.values(), *(b.geometry for b in kept))
        self._next_instance = max((g.instance + 1 for g in geometries), default=self._first_instance)
        self.spawned = 0
        if len(kept) < len(self.bodies):
            self.bodies[:] = kept
            self._rebuild()

    def require(self, body: Body) -> None:
        """Raises CommandError where the body is not in the world any more."""
        if not any(b is body for b in self.bodies):
            raise CommandError(f"the body {body.name!r} was removed; spawn it again")

    def rows_of(self, body: Body) -> NDArray[np.uint32]:
        """`(n,)` rows of a body in the moving scene: `World.cast(..., own_body=...)` looks through it."""
        self.require(body)
        index = next(i for i, b in enumerate(self.bodies) if b is body)
        return hull_rows(len(self.hulls) + index, self._n)

    def follow(self, tick: int) -> None:
        """Move what follows a script to where it is at a tick."""
        if self.script is not None:
            self.script(tick)

    def place(self, agents: States) -> None:
        """Bring the moving scene up to date, where anything changed, and a streamed ground to where the agents are."""
        self._hold()
        if len(agents) and self._scene.streamed:
            self._scene.follow(agents.motion[:, 0:3])
        self.show(agents)

    def show(self, agents: States) -> None:
        """Bring the moving scene alone up to date."""
        self._hold()
        if not self.any or not (self.changed or self.hulls):
            return
        motion, b = agents.motion if self.hulls else np.zeros((0, CHANNELS)), self.bodies
        q = motion[:, 3:7]
        self._scene.move(
            np.concatenate([motion[:, 0:3], *(x.position for x in b)]),
            np.concatenate([q, *(x.attitude for x in b)]),
            np.concatenate([rotate_np(q, motion[:, 7:10]), *(x.velocity for x in b)]),
            np.concatenate([rotate_np(q, motion[:, 10:13]), *(x.angular_velocity for x in b)]),
        )
        self.changed = False

    def hull_of(self, agent: str) -> Geometry:
        """The hull of an agent, in its own frame, whether or not it stands in the moving scene."""
        return self._all_hulls[agent]

    def _rows(self) -> list[tuple[Geometry, int]]:
        """Rows of the moving scene, and the copy of each."""
        shown = (*self.hulls.values(), *(b.geometry for b in self.bodies))
        return [(geometry, k) for geometry in shown for k in range(self._n)]

    def _rebuild(self) -> None:
        self.changes += 1
        self._take_over()
        geometries = self._rows()
        if geometries or self._scene.moving is not None:
            self._scene.set_moving(geometries)
        self.changed = True


def hull_rows(index: int, n: int) -> NDArray[np.uint32]:
    """`(n,)` rows of the hull of the agent number `index`."""
    return np.arange(index * n, (index + 1) * n, dtype=np.uint32)


def rows(values: object, n: int, width: int, what: str) -> NDArray[np.float64]:
    """`(width,)` or `(n, width)` finite numbers -> `(n, width)`.

    Raises:
        CommandError: another shape, or a value that is not finite.
    """
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise CommandError(f"{what} is {width} numbers, or {n} rows of them; given {values!r}") from None
    if array.shape not in ((width,), (n, width)):
        raise CommandError(f"{what} has shape ({width},) or ({n}, {width}); given {array.shape}")
    if not np.isfinite(array).all():
        raise CommandError(f"{what} must be finite; given {array.tolist()}")
    return np.array(np.broadcast_to(array, (n, width)))


def unit_rows(values: object, n: int, what: str) -> NDArray[np.float64]:
    """Quaternions `(n, 4)`, normalised.

    Raises:
        CommandError: as `rows`, or a quaternion of length 0.
    """
    q = rows(values, n, 4, what)
    length = np.linalg.norm(q, axis=1, keepdims=True)
    if (length < 1e-9).any():
        raise CommandError(f"{what} is a quaternion (w, x, y, z), and must not be 0")
    return np.asarray(q / length)


def hull_of(vehicle: Vehicle, world: World) -> Geometry:
    """The hull with its materials as rows of the world's table."""
    hull = vehicle.hull
    rows_of = np.array([world.material_row(name) for name in vehicle.materials], dtype=np.uint32)
    return replace(hull, material=rows_of[hull.face_materials])
