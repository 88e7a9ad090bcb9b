"""Guidance of many vehicles in one call: those of a kind whose missions differ in places alone."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.aboard import Aboard, Floats
from pelagos.sim.guidance.follow import FollowAgent
from pelagos.sim.guidance.guidance import Guidance, Step
from pelagos.sim.guidance.steering.steering import Steering
from pelagos.sim.guidance.task import Task, shape, together


class Squad:
    """Guidance of several agents, whose lanes follow one another; each keeps its own state.

    Args:
        members: guidance of each, all of one `shape`.
        steering: a new one for all lanes.
        names: set-points of the control mode.
        aboard: of all lanes.

    Attributes:
        members: names of the agents.
        followed: agents that tasks follow, one a member, by the names that the tasks have for them.
    """

    def __init__(
        self, members: Mapping[str, Guidance], steering: Steering, names: Sequence[str], aboard: Aboard
    ) -> None:
        self.members, self._each = tuple(members), tuple(members.values())
        self.followed: dict[str, list[str]] = {}
        n = len(aboard) // len(members)
        each = zip(*(guidance.steps for guidance in self._each), strict=True)
        steps = [Step(self._task([step.task for step in same], n), same[0].behind) for same in each]
        self._whole = Guidance(steps, steering, names, aboard)
        self._in_step = False

    def _task(self, tasks: Sequence[Task], n: int) -> Task:
        """A task of the members, n lanes each; whom they follow goes by one name."""
        task = together(tasks, n)
        followed = [one.agent for one in tasks if isinstance(one, FollowAgent)]
        if not isinstance(task, FollowAgent):
            return task
        name = " ".join(followed) if len(set(followed)) > 1 else followed[0]
        self.followed[name] = followed
        return replace(task, agent=name)

    @property
    def in_step(self) -> bool:
        """All members' steerings keep as much: some, which begin with their first command, keep nothing before."""
        if not self._in_step:  # and then for as long as there is this squad: who begins anew is in another
            sizes = [[len(values) for values in g.memory()["steering"].values()] for g in self._each]
            self._in_step = all(size == sizes[0] for size in sizes)
        return self._in_step

    def command(self, aboard: Aboard, truth: Aboard | None = None) -> dict[str, Floats]:
        """`(n, k)` set-points of each member, as its own guidance would give them; both of all lanes."""
        self._whole.recall(_joined([guidance.memory() for guidance in self._each]))
        found = self._by_member(self._whole.command(aboard, truth))
        memory = {name: self._parted(kept) for name, kept in self._whole.memory().items()}
        for i, guidance in enumerate(self._each):
            guidance.recall({name: _of(i, kept) for name, kept in memory.items()})
        return dict(zip(self.members, found, strict=True))

    def _by_member(self, values: NDArray[Any]) -> list[NDArray[Any]]:
        return list(values.reshape(len(self.members), -1, *values.shape[1:]))

    def _parted(self, kept: Any) -> Any:
        if isinstance(kept, dict):
            return {name: self._by_member(values) for name, values in kept.items()}
        return self._by_member(kept)


def shape_of(guidance: Guidance) -> Hashable:
    """The mission but for its places: those of one shape may be a squad."""
    return tuple((shape(step.task), step.behind) for step in guidance.steps)


def _joined(each: Sequence[Any]) -> Any:
    if isinstance(each[0], dict):
        return {name: _joined([one[name] for one in each]) for name in each[0]}
    return np.concatenate(each)


def _of(member: int, kept: Any) -> Any:
    """Its part of what was parted."""
    if isinstance(kept, dict):
        return {name: parts[member] for name, parts in kept.items()}
    return kept[member]
