"""Contacts of all agents: where one is possible, the wrench of the present tick, and those of the last second.

All contacts of a tick are found, and solved, at the states at its beginning, before anything moves.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.frames import flip_yz_np
from pelagos.sim.batch import Batch
from pelagos.sim.bodies import BLOCK_S, Bodies
from pelagos.sim.collisions import Collisions
from pelagos.sim.driver import Wrench
from pelagos.sim.model import Model
from pelagos.sim.touch import Touch
from pelagos.sim.trajectory import CHANNELS

MARGIN_MPS: Final = 2.0  # a hull is taken to gain at most this much speed within a block, when its way is bounded
AHEAD_M: Final = 1.0  # a single vehicle is asked for with so much more room, and not again until it has gone so far
ASKS: Final = 50  # without that room, before it is asked for again
GAP_M: Final = 0.05  # bodies nearer than this to the swept sphere are asked for by rays
Rows = Mapping[str, NDArray[np.float64]]


@dataclass
class _Free:
    """A sphere without anything static in it, around where a single vehicle was [m]."""

    centre: list[float]
    radius_m: float = 0.0
    wait: int = 0


class Contacts:
    """Contacts of hulls, by batch.

    Attributes:
        remembered: by batch, (tick, wrench `(rows, 6)`) of the contacts in the last second, oldest first; kept for
            those of `Blows.asked`.
    """

    def __init__(self, model: Model, bodies: Bodies) -> None:
        self._model, self._bodies = model, bodies
        self._touch = {name: Touch(batch, model) for name, batch in model.batches.items()}
        self._collisions = Collisions(model, bodies)
        self._free: dict[str, _Free] = {}
        self._now: dict[str, Wrench] = {}
        self.remembered: dict[str, list[tuple[int, NDArray[np.float64]]]] = {}

    def begin(self) -> None:
        """Nothing has touched anything yet.

        Meshes that may collide are loaded now, before a sensor is recorded: Dr.Jit records it anew for a mesh more.
        """
        self._now.clear()
        self.remembered.clear()
        if self._collisions.any:
            self._collisions.look()

    def forget(self, where: NDArray[np.bool_]) -> None:
        """Some copies have touched nothing yet."""
        for name, kept in self.remembered.items():
            gone = np.tile(where, len(self._model.batches[name].members))
            self.remembered[name] = [(tick, np.where(gone[:, None], 0.0, wrench)) for tick, wrench in kept]
        for name, wrench in self._now.items():
            rows = self._model.batches[name].rows
            gone = np.tile(where, rows // self._model.n)
            self._now[name] = _wrench(np.where(gone[:, None], 0.0, _numbers(wrench, rows)))

    def memory(self) -> dict[str, Any]:
        """Contacts of the last tick and of the last second; copies."""
        now = {name: [np.array(part) for part in wrench] for name, wrench in self._now.items()}
        return {"now": now, "remembered": {name: list(kept) for name, kept in self.remembered.items()}}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Go on from there."""
        self._now = {
            name: (jit.Array3f64(force), jit.Array3f64(moment)) for name, (force, moment) in memory["now"].items()
        }
        jit.align(self._now)
        self.remembered = {name: list(kept) for name, kept in memory["remembered"].items()}

    def possible(self, rows: Rows, ticks: int) -> bool:
        """Whether anything may touch anything within `ticks`, from where agents are, `(rows, CHANNELS)` by batch."""
        reach = {name: self._reach(name, row, ticks) for name, row in rows.items()}
        if any(self._grounds(name, row[:, 0:3], reach[name]) for name, row in rows.items()):
            return True
        return self._collisions.any and bool(len(self._collisions.close(rows, reach, moving_s=BLOCK_S)))

    def near(self, rows: Rows) -> frozenset[str]:
        """Batches of which a member may touch something within the tick that begins."""
        reach = {name: self._reach(name, row, 1) for name, row in rows.items()}
        near = {name for name, row in rows.items() if self._grounds(name, row[:, 0:3], reach[name])}
        if self._collisions.any:
            near |= self._collisions.meeting(rows, reach)
        return frozenset(near)

    def act(self, rows: Rows, states: Mapping[str, tuple[Array, Array]]) -> Mapping[str, Wrench]:
        """Contact in the tick that begins, of the batches where there is any.

        Args:
            rows: motion of all batches now.
            states: packed states of the batches that are `near`, now and after the tick without contact.
        """
        self._now.clear()
        for name, (now, free) in states.items():
            wrench = self._touch[name].wrench(now, free)
            if wrench is not None:
                self._now[name] = wrench
        if self._collisions.any:
            grounds = {name: _numbers(wrench, self._model.batches[name].rows) for name, wrench in self._now.items()}
            for name, hit in self._collisions.wrenches(rows, {n: free for n, (_, free) in states.items()}, grounds):
                self._now[name] = _wrench(hit + grounds.get(name, 0.0))
        return dict(self._now)

    def pass_by(self) -> None:
        """Nothing is near anything in the block that begins."""
        self._now.clear()

    def remember(self, batch: str, tick: int) -> None:
        """Keep the contact of the tick that begins for a second."""
        kept = self.remembered.setdefault(batch, [])
        if batch in self._now:
            kept.append((tick + 1, self.wrench(batch)))
        oldest = tick - round(1e9 / self._model.clock.dt_ns)
        while kept and kept[0][0] < oldest:
            kept.pop(0)

    def wrench(self, batch: str) -> NDArray[np.float64]:
        """`(rows, 6)` force [N] and moment about the body's origin [N m], FLU, by contact over the last tick."""
        rows = self._model.batches[batch].rows
        wrench = self._now.get(batch)
        if wrench is None:
            return np.zeros((rows, 6))
        both = _numbers(wrench, rows)
        return np.concatenate([flip_yz_np(both[:, :3]), flip_yz_np(both[:, 3:])], axis=1) + 0.0  # never -0.0

    def strongest(self, batch: str, after: int) -> NDArray[np.float64]:
        """`(rows, 6)` of the contacts after tick `after` the one with the greatest force; see `Blows.latest`."""
        rows = self._model.batches[batch].rows
        found = [wrench for tick, wrench in self.remembered.get(batch, ()) if tick > after]
        if not found:
            return np.zeros((rows, 6))
        wrenches = np.stack(found)
        strongest = np.linalg.norm(wrenches[..., :3], axis=-1).argmax(axis=0)
        return np.asarray(wrenches[strongest, np.arange(rows)])

    def _reach(self, name: str, row: NDArray[np.float64], ticks: int) -> NDArray[np.float64]:
        """`(rows,)` about the origin of each vehicle, what it may touch within `ticks` [m]."""
        assert row.shape[1] == CHANNELS
        batch: Batch = self._model.batches[name]
        elapsed = ticks * self._model.clock.dt_ns * 1e-9
        if len(row) == 1:  # NumPy's calls take longer than the sums
            way = (math.hypot(*row[0, 7:10].tolist()) + MARGIN_MPS) * elapsed
            return np.array([batch.vehicle.bounding_radius_m + way + GAP_M])
        way = (np.sqrt(np.einsum("ij,ij->i", row[:, 7:10], row[:, 7:10])) + MARGIN_MPS) * elapsed
        return np.asarray(batch.vehicle.bounding_radius_m + way + GAP_M)

    def _grounds(self, name: str, position: NDArray[np.float64], reach: NDArray[np.float64]) -> bool:
        near = self._model.world.near
        if len(position) > 1:
            return bool(np.any(near(position, reach)))
        place, margin = position[0].tolist(), float(reach[0])
        free = self._free.setdefault(name, _Free(place))
        if math.dist(place, free.centre) + margin <= free.radius_m:
            return False
        if near(position, reach)[0]:
            return True
        if free.wait:  # a larger one was not free a while ago
            free.wait -= 1
        elif near(position, margin + AHEAD_M)[0]:
            free.wait = ASKS
        else:
            free.centre, free.radius_m = place, margin + AHEAD_M
        return False


def _numbers(wrench: Wrench, rows: int) -> NDArray[np.float64]:
    """`(rows, 6)` in the frame that it has."""
    return np.concatenate([np.broadcast_to(np.array(w), (3, rows)) for w in wrench]).T


def _wrench(values: NDArray[np.float64]) -> Wrench:
    force, moment = (jit.Array3f64(np.ascontiguousarray(part.T)) for part in (values[:, :3], values[:, 3:]))
    jit.align(force, moment)
    return force, moment
