"""Observations that a step returns: the newest readings, by agent and sensor, and of a group together.

Readings of many vehicles come in one piece from one call. They are cut up for those agents that somebody asks about.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import NoReading, UnknownKey
from pelagos.sensors.lazy import promised
from pelagos.sensors.sensor import Reading
from pelagos.sim.sampled import Sampled

if TYPE_CHECKING:
    from pelagos.sim.model import AgentModel, Model


class Newest(dict[str, Reading]):
    """The newest reading by sensor of an agent or a group; absent where there is none.

    Args:
        found: the readings.
        agent: whose.
        sensors: names all that it has.
    """

    def __init__(self, found: Mapping[str, Reading], agent: str, sensors: Callable[[], Iterable[str]]) -> None:
        super().__init__(found)
        self._about = agent, sensors

    def __missing__(self, sensor: object) -> Reading:
        agent, sensors = self._about
        if sensor in (known := list(sensors())):
            raise NoReading(
                f"{agent}.{sensor} has no reading in this step; those with one: {', '.join(self) or 'none'}"
            )
        raise UnknownKey("sensor", sensor, known, where=agent)

    def __reduce__(self) -> tuple[type[dict[str, Reading]], tuple[dict[str, Reading]]]:
        return dict, (dict(self),)


class Readings(Mapping[str, Reading]):
    """The newest reading of each sensor of one agent; absent where there is none."""

    def __init__(self, sampled: Sequence[Sampled], agent: AgentModel, n: int, dt_ns: int) -> None:
        self._parts = sampled, agent, n, dt_ns
        self._found: dict[str, Reading] | None = None

    @property
    def all(self) -> dict[str, Reading]:
        """All of them, cut now."""
        if self._found is None:
            sampled, agent, n, dt_ns = self._parts
            found = {}
            for one in sampled:
                reading = one.of(agent.member, n).newest(n, dt_ns)
                if reading is not None:
                    found[one.model.name] = reading
            self._found = Newest(found, agent.name, agent.sensors.keys)
        return self._found

    def __getitem__(self, sensor: str) -> Reading:
        return self.all[sensor]

    def __iter__(self) -> Iterator[str]:
        return iter(self.all)

    def __len__(self) -> int:
        return len(self.all)

    def __repr__(self) -> str:
        return repr(self.all)


class Observed(Mapping[str, Mapping[str, Reading]]):
    """Readings by agent; the name of a group gives those of its members together, `(n, members, ...)`.

    Iteration goes over single agents. A group's reading of a sensor is of the latest time at which a member has one:
    members whose newest is older are zero there, and not valid (`reading.valid`, `(n, members)`).
    """

    def __init__(self, model: Model, sampled: Sequence[Sampled] = ()) -> None:
        self._model = model
        self._by_batch: dict[str, list[Sampled]] = {name: [] for name in model.batches}
        for one in sampled:
            self._by_batch[one.members[0]].append(one)
        self._read: dict[str, Mapping[str, Reading]] = {}

    def __iter__(self) -> Iterator[str]:
        return iter(self._model.agents)

    def __len__(self) -> int:
        return len(self._model.agents)

    def __contains__(self, name: object) -> bool:
        return name in self._model.agents or name in self._model.groups

    def __reduce__(self) -> tuple[type[dict[str, dict[str, Reading]]], tuple[dict[str, dict[str, Reading]]]]:
        return dict, ({name: dict(readings) for name, readings in self.items()},)

    def __repr__(self) -> str:
        return repr(dict(self))

    def __getitem__(self, name: str) -> Mapping[str, Reading]:
        if not isinstance(name, str):
            raise UnknownKey("agent", name, [*self, *self._model.groups])
        if name not in self._read:
            agent = self._model.agents.get(name)
            if agent is None:
                self._read[name] = Newest(self._group(name), name, partial(self._carried, name))
            else:
                parts = self._by_batch[agent.batch.name]
                cut = Readings(parts, agent, self._model.n, self._model.clock.dt_ns)
                self._read[name] = cut if len(agent.batch.members) > 1 else cut.all
        return self._read[name]

    def _carried(self, group: str) -> Iterable[str]:
        """Names of the sensors that any member carries."""
        agents = self._model.agents
        return dict.fromkeys(s for member in self._model.group(group) or () for s in agents[member].sensors)

    def _group(self, name: str) -> Mapping[str, Reading]:
        """Readings of a group's members together."""
        count = self._model.groups.get(name)
        if count is None:
            raise UnknownKey("agent", name, [*self, *self._model.groups])
        first = self._model.agents[f"{name}[0]"]
        block, parts = slice(first.member, first.member + count), self._by_batch[first.batch.name]
        # members follow one another in the scenario, and so in their batch: where the last is at its place, all are
        whole = first.batch.members[first.member + count - 1 : first.member + count] == (f"{name}[{count - 1}]",)
        if whole and len({one.model.name for one in parts}) == len(parts):
            n, dt_ns = self._model.n, self._model.clock.dt_ns
            read = {one.model.name: one.newest_of(block, n, dt_ns, name) for one in parts}
            return {sensor: reading for sensor, reading in read.items() if reading is not None}
        return self._gathered(name)

    def _gathered(self, name: str) -> Mapping[str, Reading]:
        """Readings of a group whose members are not all read for by the same sensors."""
        members = self._model.group(name) or []
        sensors = dict.fromkeys(sensor for member in members for sensor in self[member])
        found = {sensor: _together(sensor, [self[m].get(sensor) for m in members], name) for sensor in sensors}
        return {sensor: reading for sensor, reading in found.items() if reading is not None}


def _together(sensor: str, readings: Sequence[Reading | None], group: str) -> Reading | None:
    """Readings of a group's members, of the latest time that one of them has, as one.

    Data of members without a reading are zero, and not valid; None where members' readings have different shapes.
    """
    there = [r for r in readings if r is not None]
    t_ns = max(r.t_ns for r in there)
    first = next(r for r in there if r.t_ns == t_ns)
    chosen = [r if r is not None and r.t_ns == t_ns else None for r in readings]
    if any(r is not None and r.data.shape != first.data.shape for r in chosen):
        return None

    def stacked(part: str) -> NDArray[np.generic]:
        values = [None if r is None else getattr(r, part) for r in chosen]
        return _stacked(values, getattr(first, part))

    extras = {}
    for name, values in first.extras.items():
        if np.ndim(values) and len(values) == len(first.valid) and not _same_for_all(name, chosen):
            extras[name] = _stacked([None if r is None else r.extras[name] for r in chosen], values)
        else:
            extras[name] = values
    valid = np.stack([np.zeros_like(first.valid) if r is None else r.valid for r in chosen], axis=1)
    return Reading(
        stacked("data"), promised(lambda: stacked("truth")), t_ns, f"{group}/{sensor}", valid, extras, first.kind
    )


def _stacked(values: Sequence[NDArray[np.generic] | None], like: NDArray[np.generic]) -> NDArray[np.generic]:
    return np.stack([np.zeros_like(like) if v is None else v for v in values], axis=1)


def _same_for_all(name: str, readings: Sequence[Reading | None]) -> bool:
    """Whether an extra is one table that all readings share."""
    tables = {id(r.extras[name]) for r in readings if r is not None}
    return len(tables) == 1 and sum(r is not None for r in readings) > 1
