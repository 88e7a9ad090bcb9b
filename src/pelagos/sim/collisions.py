"""Collisions of agents with one another, and with bodies that were spawned or follow a script."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.contact.broad_phase import BoundedBodies, close_pairs, touching_boxes
from pelagos.contact.impulse import Colliding, collide
from pelagos.contact.pairs import PairContacts, body_table, pair_contacts, read_contacts
from pelagos.jit import Array
from pelagos.math.frames import flip_yz_np
from pelagos.math.so3 import rotate_back_np, rotate_np
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.shapes import Shapes
from pelagos.sim.bodies import Bodies
from pelagos.sim.endings import FARTHEST_M
from pelagos.sim.model import Model
from pelagos.sim.touch import probes_of

_MARGIN_M: Final = 0.05
_SKIN_M: Final = 0.01  # about the sphere that holds a mesh: rays begin outside of it
Rows = Mapping[str, NDArray[np.float64]]


@dataclass(frozen=True)
class _Known:
    """Constants while no body comes or goes; rows are all agents, batch by batch, then all bodies.

    Attributes:
        bodies: those beside the agents, by their number.
        agents: how many rows are agents.
        first: by batch, its first row.
        low, high, radius: of the boxes and spheres [m].
        copy: of each row.
        offset: of the meshes, see `Shapes`.
        fastest: of bodies on a script [m/s].
    """

    bodies: int
    agents: int
    first: Mapping[str, int]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    radius: NDArray[np.float64]
    copy: NDArray[np.int64]
    offset: NDArray[np.float64]
    fastest: NDArray[np.float64]


class Collisions:
    """Finds the pairs of bodies that are near one another, casts their probes, and solves all contacts together."""

    def __init__(self, model: Model, bodies: Bodies) -> None:
        self._model, self._bodies = model, bodies
        self._held: tuple[Geometry, ...] | None = None
        self._known: _Known | None = None
        self._shapes: Shapes | None = None
        self._calls: dict[str, tuple[Callable[..., Array], tuple[Any, ...]]] = {}
        turn = np.diag([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])  # FRD -> FLU
        self._inverse = {
            name: turn @ np.linalg.inv(batch.vehicle.config.body.mass_matrix) @ turn
            for name, batch in model.batches.items()
        }

    @property
    def any(self) -> bool:
        """There are agents that others can touch, or bodies."""
        return self._bodies.any

    def close(self, rows: Rows, reach: Rows, *, moving_s: float = 0.0) -> NDArray[np.int64]:
        """`(k, 2)` rows of bodies, of which one is an agent, whose spheres of `reach` [m] overlap.

        Bodies on a script may go on for `moving_s`.
        """
        known = self.look()
        places = np.concatenate([row[:, 0:3] for row in rows.values()] + [b.position for b in self._bodies.bodies])
        far = np.concatenate([reach[name] for name in rows] + [known.radius[known.agents :]])
        far[known.agents :] += moving_s * known.fastest
        far = np.minimum(far, FARTHEST_M)  # whoever goes farther ends (`Endings`), and no others with it
        pairs = close_pairs(places, far, known.copy)
        return pairs[pairs[:, 0] < known.agents]

    def meeting(self, rows: Rows, reach: Rows) -> set[str]:
        """Batches of which a member's box may meet another body now."""
        pairs = self._near(rows, reach)
        known = self.look()
        agents = np.unique(pairs[pairs < known.agents])
        ends = {name: first + self._model.batches[name].rows for name, first in known.first.items()}
        return {n for n, first in known.first.items() if ((agents >= first) & (agents < ends[n])).any()}

    def wrenches(
        self, rows: Rows, free: Mapping[str, Array], grounds: Mapping[str, NDArray[np.float64]]
    ) -> Iterator[tuple[str, NDArray[np.float64]]]:
        """Force and moment about the origin by batch, FRD, `(rows, 6)` [N], [N m].

        Args:
            rows: motion of all batches at the beginning of the tick.
            free: packed states after it without contact, of the batches that may touch something.
            grounds: wrenches of what else they touch.
        """
        if not free:
            return
        h = self._model.clock.dt_ns * 1e-9
        reach = {name: self._radius(name, row, h) for name, row in rows.items()}
        pairs = self._near(rows, reach)
        if not len(pairs):
            return
        moved = self._free(rows, free, grounds, h)
        contacts = self._cast(pairs, moved, h)
        if not len(contacts.depth):
            return
        used, index = np.unique(np.concatenate([contacts.first, contacts.second]), return_inverse=True)
        ends = index.reshape(2, -1)
        local = PairContacts(ends[0], ends[1], *(getattr(contacts, n) for n in list(vars(contacts))[2:]))
        inverse = self._inverse_mass(used, moved.attitude)
        impulses = collide(local, Colliding(moved.position[used], moved.velocity[used], moved.spin[used], inverse), h)
        known = self.look()
        for name, first in known.first.items():
            own = (used >= first) & (used < first + self._model.batches[name].rows)
            if impulses[own].any():
                whole = np.zeros((self._model.batches[name].rows, 6))
                q = moved.attitude[used[own]]
                parts = [flip_yz_np(rotate_back_np(q, impulses[own][:, at : at + 3])) / h for at in (0, 3)]
                whole[used[own] - first] = np.concatenate(parts, axis=1)
                yield name, whole

    def _near(self, rows: Rows, reach: Rows) -> NDArray[np.int64]:
        pairs = self.close(rows, reach)
        if not len(pairs):
            return pairs
        known, b = self.look(), self._bodies.bodies
        position = np.concatenate([row[:, 0:3] for row in rows.values()] + [x.position for x in b])
        attitude = np.concatenate([row[:, 3:7] for row in rows.values()] + [x.attitude for x in b])
        margin = max(float((reach[n] - self._model.batches[n].vehicle.bounding_radius_m).max()) for n in reach)
        bounds = BoundedBodies(position, attitude, known.radius, known.low, known.high, known.copy)
        return pairs[touching_boxes(bounds, pairs, 2.0 * margin)]

    def _radius(self, name: str, row: NDArray[np.float64], h: float) -> NDArray[np.float64]:
        way = (np.abs(row[:, 7:10]).sum(axis=1) + 2.0) * h
        return np.asarray(self._model.batches[name].vehicle.bounding_radius_m + way + _MARGIN_M)

    def _free(
        self, rows: Rows, free: Mapping[str, Array], grounds: Mapping[str, NDArray[np.float64]], h: float
    ) -> _Moved:
        """Place of everything, and its motion after the tick without collisions."""
        parts = []
        for name, row in rows.items():
            spin, velocity = row[:, 10:13], row[:, 7:10]
            if name in free:
                after = np.array(free[name]).reshape(-1, len(row))
                velocity, spin = flip_yz_np(after[7:10].T), flip_yz_np(after[10:13].T)
            if name in grounds:
                wrench = np.concatenate([flip_yz_np(grounds[name][:, at : at + 3]) for at in (0, 3)], axis=1)
                gained = h * wrench @ self._inverse[name].T
                velocity, spin = velocity + gained[:, :3], spin + gained[:, 3:]
            q = row[:, 3:7]
            parts.append((row[:, 0:3], q, rotate_np(q, velocity), rotate_np(q, spin)))
        parts += [(b.position, b.attitude, b.velocity, b.angular_velocity) for b in self._bodies.bodies]
        return _Moved(*(np.concatenate(values) for values in zip(*parts, strict=True)))

    def _cast(self, pairs: NDArray[np.int64], moved: _Moved, h: float) -> PairContacts:
        """Contacts of pairs, by the probes of each agent in them."""
        known = self.look()
        assert self._shapes is not None
        table = body_table(
            moved.position, moved.attitude, moved.velocity, moved.spin, known.offset, known.radius + _SKIN_M
        )
        both = np.concatenate([pairs, pairs[:, ::-1]])
        found = []
        for name, start in known.first.items():
            own = both[(both[:, 0] >= start) & (both[:, 0] < start + self._model.batches[name].rows)]
            if not len(own):
                continue
            size = 1 << max(len(own) - 1, 7).bit_length()  # few sizes, each of which is recorded once
            padded = np.zeros((size, 2), dtype=np.int64)
            padded[: len(own)] = own
            call, arguments = self._call(name)
            first, second = (jit.from_numpy(jit.UInt32, padded[:, side]) for side in (0, 1))
            packed = call(self._shapes.tables, *arguments[:2], table, first, second, arguments[2])
            found.append(read_contacts(packed, padded[:, 0], padded[:, 1]))
        return PairContacts.joined(found)

    def _call(self, name: str) -> tuple[Callable[..., Array], tuple[Any, ...]]:
        if name not in self._calls:
            assert self._shapes is not None
            materials, vehicle = self._model.world.material_tables(), self._model.batches[name].vehicle
            arguments = (materials, probes_of(vehicle), dr.opaque(jit.Float64, self._model.clock.dt_ns * 1e-9))
            dr.make_opaque(arguments)
            self._calls[name] = jit.freeze(pair_contacts, self._shapes.scene), arguments
        return self._calls[name]

    def _inverse_mass(self, used: NDArray[np.int64], attitude: NDArray[np.float64]) -> NDArray[np.float64]:
        """`(k, 6, 6)` of rows, in the world frame; 0 for bodies that are no agents."""
        known, found = self.look(), np.zeros((len(used), 6, 6))
        for name, first in known.first.items():
            own = (used >= first) & (used < first + self._model.batches[name].rows)
            axes = np.eye(3)
            turn = np.stack([rotate_np(attitude[used[own]], np.tile(a, (int(own.sum()), 1))) for a in axes], axis=-1)
            both = np.zeros((len(turn), 6, 6))
            both[:, :3, :3] = both[:, 3:, 3:] = turn
            found[own] = both @ self._inverse[name] @ both.transpose(0, 2, 1)
        return found

    def look(self) -> _Known:
        """Find the bodies anew when one came or went."""
        held = tuple(b.geometry for b in self._bodies.bodies)
        if self._known is None or self._held is None or not _same(held, self._held):
            self._held, self._known = held, self._find(held)
            self._calls.clear()
        return self._known

    def _find(self, held: tuple[Geometry, ...]) -> _Known:
        n, batches = self._model.n, self._model.batches
        hulls = {name: self._bodies.hull_of(name) for name in batches}
        shapes = self._shapes = Shapes([*hulls.values(), *held])
        first, start = {}, 0
        for name, batch in batches.items():
            first[name], start = start, start + batch.rows
        counts = [batch.rows for batch in batches.values()] + [n] * len(held)
        boxes = np.array([[g.vertices.min(axis=0), g.vertices.max(axis=0)] for g in (*hulls.values(), *held)])
        radius = np.array([float(np.linalg.norm(g.vertices, axis=1).max()) for g in (*hulls.values(), *held)])
        return _Known(
            bodies=len(held),
            agents=start,
            first=first,
            low=np.repeat(boxes[:, 0], counts, axis=0),
            high=np.repeat(boxes[:, 1], counts, axis=0),
            radius=np.repeat(radius, counts),
            copy=np.concatenate([np.arange(c) % n for c in counts]),
            offset=np.repeat(shapes.offset, counts, axis=0),
            fastest=np.repeat([b.fastest_mps or 0.0 for b in self._bodies.bodies], n),
        )


@dataclass(frozen=True)
class _Moved:
    """Everything that moves, in the world frame, `(b, ...)`."""

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    velocity: NDArray[np.float64]
    spin: NDArray[np.float64]


def _same(one: tuple[Geometry, ...], other: tuple[Geometry, ...]) -> bool:
    return len(one) == len(other) and all(a is b for a, b in zip(one, other, strict=True))
