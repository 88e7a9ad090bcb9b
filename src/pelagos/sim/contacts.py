"""Contacts of all agents: where one is possible, the wrench of the present tick, and those of the last second."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.frames import flip_yz_np
from pelagos.sim.bodies import Bodies
from pelagos.sim.driver import Wrench
from pelagos.sim.model import Model
from pelagos.sim.state import AgentState
from pelagos.sim.touch import Touch

MARGIN_MPS: Final = 2.0  # a hull is taken to gain at most this much speed within a block, when its way is bounded
States = Callable[[], Mapping[str, AgentState]]


class Contacts:
    """What hulls touch, by agent.

    Attributes:
        remembered: by agent, (tick, wrench `(n, 6)`) of the contacts in the last second, oldest first; kept for the
            agents of `Blows.asked`.
    """

    def __init__(self, model: Model, bodies: Bodies) -> None:
        self._model, self._bodies = model, bodies
        self._touch = {name: Touch(agent, model, bodies) for name, agent in model.agents.items()}
        self._now: dict[str, Wrench] = {}
        self.remembered: dict[str, list[tuple[int, NDArray[np.float64]]]] = {}

    def clear(self) -> None:
        """Forget all contacts."""
        self._now.clear()
        self.remembered.clear()

    def forget(self, where: NDArray[np.bool_]) -> None:
        """Some copies have touched nothing yet."""
        for agent, kept in self.remembered.items():
            self.remembered[agent] = [(tick, np.where(where[:, None], 0.0, wrench)) for tick, wrench in kept]
        free = jit.Bool(~where)
        self._now = {
            name: (dr.select(free, force, 0.0), dr.select(free, moment, 0.0))
            for name, (force, moment) in self._now.items()
        }

    def memory(self) -> dict[str, Any]:
        """Contacts of the last tick and of the last second; copies."""
        now = {name: [np.array(part) for part in wrench] for name, wrench in self._now.items()}
        return {"now": now, "remembered": {name: list(kept) for name, kept in self.remembered.items()}}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Go on from there."""
        self._now = {
            name: (jit.Array3f64(force), jit.Array3f64(moment)) for name, (force, moment) in memory["now"].items()
        }
        self.remembered = {name: list(kept) for name, kept in memory["remembered"].items()}

    def near(self, agent: str, row: NDArray[np.float64], ticks: int, states: States, *, now: bool = False) -> bool:
        """Whether an agent whose motion is `row` may touch anything within `ticks`, or where bodies stand `now`."""
        speed = np.sqrt(np.einsum("ij,ij->i", row[:, 7:10], row[:, 7:10])) + MARGIN_MPS  # (n,)
        way = speed * (ticks * self._model.clock.dt_ns * 1e-9)
        return self._touch[agent].possible(row[:, 0:3], way, states, now=now)

    def pass_by(self, agent: str) -> None:
        """An agent touches nothing in the tick that begins."""
        self._now.pop(agent, None)

    def touch(self, agent: str, packed: Array, states: States, tick: int, *, remember: bool) -> Wrench:
        """Contact of an agent in the tick that begins, of its packed state; kept for a second with `remember`."""
        self._bodies.place(states())
        wrench = self._now[agent] = self._touch[agent].wrench(packed)
        if remember:
            kept = self.remembered.setdefault(agent, [])
            kept.append((tick + 1, self.wrench(agent)))
            oldest = tick - round(1e9 / self._model.clock.dt_ns)
            while kept[0][0] < oldest:
                kept.pop(0)
        return wrench

    def wrench(self, agent: str) -> NDArray[np.float64]:
        """`(n, 6)` force [N] and moment about the body's origin [N m], FLU, by contact over the last tick."""
        wrench = self._now.get(agent)
        if wrench is None:
            return np.zeros((self._model.n, 6))
        force, moment = (np.broadcast_to(np.array(w), (3, self._model.n)).T for w in wrench)
        return np.concatenate([flip_yz_np(force), flip_yz_np(moment)], axis=1) + 0.0  # never -0.0

    def strongest(self, agent: str, after: int) -> NDArray[np.float64]:
        """`(n, 6)` of the contacts after tick `after` the one with the greatest force; see `Blows.latest`."""
        found = [wrench for tick, wrench in self.remembered.get(agent, ()) if tick > after]
        if not found:
            return np.zeros((self._model.n, 6))
        wrenches = np.stack(found)
        strongest = np.linalg.norm(wrenches[..., :3], axis=-1).argmax(axis=0)
        return np.asarray(wrenches[strongest, np.arange(self._model.n)])
