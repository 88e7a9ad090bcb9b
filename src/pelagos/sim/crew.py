"""Estimators of many agents in one call: those of a kind, whose lanes follow one another."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property

from pelagos.sim.estimator import Estimator
from pelagos.sim.guidance.aboard import Fix
from pelagos.sim.navigator import Navigator
from pelagos.sim.sampled import Sampled


class Crew:
    """Navigation of several agents of one batch. While there is a crew, it has their state; `settle` gives it back.

    Args:
        members: estimator of each, all of one configuration, which have heard the same up to now.
        rows: their places in the batch.
        size: agents in the batch.
        n: copies.

    Attributes:
        members: names of the agents.
    """

    def __init__(self, members: Mapping[str, Estimator], rows: Sequence[int], size: int, n: int) -> None:
        self.members, self._each = tuple(members), tuple(members.values())
        self._rows, self._all, self._n = rows, len(rows) == size, n
        self._whole = Estimator.joined(self._each)
        self._fix: Fix | None = None

    @property
    def listens(self) -> frozenset[str]:
        """Names of the sensors that all take."""
        return self._whole.listens

    @property
    def whole(self) -> Navigator:
        """The navigator of all lanes, agent by agent."""
        return self._whole

    @property
    def fix(self) -> Fix:
        """The newest solution of all lanes."""
        if self._fix is None:
            self._fix = self._whole.fix
        return self._fix

    @cached_property
    def _lanes(self) -> dict[str, slice]:
        return {name: slice(i * self._n, (i + 1) * self._n) for i, name in enumerate(self.members)}

    def lanes(self, name: str) -> slice:
        """Lanes of an agent."""
        return self._lanes[name]

    def fix_of(self, name: str) -> Fix:
        """The newest solution of an agent."""
        own, fix = self._lanes[name], self.fix
        return Fix(fix.position[own], fix.heading[own], fix.velocity[own])

    def hear(self, sampled: Sampled) -> None:
        """Take readings of a sensor of all agents of the batch."""
        self._whole.hear(sampled if self._all else sampled.some(self._rows, self._n))

    def advance(self, tick: int) -> None:
        """Bring all solutions to a tick."""
        self._whole.advance(tick)
        self._fix = None

    def settle(self) -> None:
        """Give every agent's estimator its state."""
        self._whole.part(self._each)


def crews_of(
    navigators: Mapping[str, Navigator], batches: Mapping[str, tuple[str, int, int]], n: int
) -> Iterable[Crew]:
    """Crews of estimators; an estimator that is like no other is in none.

    Args:
        navigators: by agent.
        batches: by agent, name of its batch, place in it, and how many agents are in the batch.
        n: copies.
    """
    kinds: dict[object, list[str]] = {}
    for name, navigator in navigators.items():
        if isinstance(navigator, Estimator):
            kinds.setdefault((batches[name][0], navigator.kind), []).append(name)
    for names in kinds.values():
        if len(names) > 1:
            rows = sorted(names, key=lambda name: batches[name][1])
            members = {name: navigators[name] for name in rows}
            yield Crew(members, [batches[name][1] for name in rows], batches[rows[0]][2], n)  # type: ignore[arg-type]
