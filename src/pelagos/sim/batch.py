"""Batches: agents of one vehicle and one set of sensors, moved and asked in one call.

Rows of a batch go member by member, and copy by copy within: row = member * n + copy. Every array that the step loop,
the sensors and the control laws see has these rows for lanes. A batch of one agent is what an agent always was.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pelagos.config import registry
from pelagos.config.agent import Agent
from pelagos.sensors.noise import KeyTable
from pelagos.sensors.sensor import Sensor, SensorConfig
from pelagos.sim.driver import Driver
from pelagos.vehicles.vehicle import Vehicle


@dataclass(frozen=True)
class SensorModel:
    """A built sensor and its place in the schedule.

    Attributes:
        name: as in the scenario.
        config: its configuration.
        sensor: what reads.
        period: ticks between two readings.
        sees: it is asked at its own tick, with every body where it is then.
        casts: it asks the moving scene, which has to be up to date.
        waits: its readings are small enough for those of several blocks to be read in one call, where nothing asks for
            them before and nothing that it sees moves.
    """

    name: str
    config: SensorConfig
    sensor: Sensor
    period: int
    sees: bool
    casts: bool
    waits: bool

    @property
    def events(self) -> bool:
        """It is asked when it is due alone (see `Sensor`)."""
        return bool(getattr(self.sensor, "EVENTS", False))

    @property
    def fixes(self) -> bool:
        """A valid reading is a fix of the place (see `Sensor`)."""
        return bool(getattr(self.sensor, "FIXES", False))


@dataclass(frozen=True)
class Batch:
    """Agents that are alike but for where they start and what they are to do.

    Attributes:
        name: of the first of them.
        members: names of all.
        n: copies.
        vehicle: what moves.
        mode: control mode at the start.
        driver: moves all rows through blocks of ticks.
        sensors: by name, in the scenario's order; each reads for all rows.
        streams: tables of random streams of the sensors, where several members share them.
    """

    name: str
    members: tuple[str, ...]
    n: int
    vehicle: Vehicle
    mode: str
    driver: Driver
    sensors: Mapping[str, SensorModel]
    streams: Sequence[KeyTable] = ()

    @property
    def rows(self) -> int:
        """Members times copies."""
        return self.n * len(self.members)

    def rows_of(self, member: int) -> slice:
        """Rows of a member's copies."""
        return slice(member * self.n, (member + 1) * self.n)


def alike(members: Mapping[str, Agent], modes: Mapping[str, str]) -> list[list[str]]:
    """Names of the agents that go into one batch each, in the order of the first of them.

    Agents of a group share their configurations, so that most of them are compared by identity.
    """
    kinds: list[tuple[Agent, str, list[str]]] = []
    known: dict[tuple[int, int, str], list[str]] = {}
    for name, agent in members.items():
        key = (id(agent.vehicle), id(agent.sensors), modes[name])
        if key not in known:
            shared = _shareable(agent)
            group = next((g for a, m, g in kinds if shared and _same((a, m), (agent, modes[name]))), None)
            if group is None:
                group = []
                kinds.append((agent, modes[name], group))
            if shared:
                known[key] = group
            group.append(name)
        else:
            known[key].append(name)
    return [group for _, _, group in kinds]


def _same(one: tuple[Agent, str], other: tuple[Agent, str]) -> bool:
    (a, mode), (b, other_mode) = one, other
    return (
        mode == other_mode
        and (a.vehicle is b.vehicle or (a.vehicle.type == b.vehicle.type and a.vehicle == b.vehicle))
        and list(a.sensors) == list(b.sensors)
        and all(config is b.sensors[name] or config == b.sensors[name] for name, config in a.sensors.items())
    )


def _shareable(agent: Agent) -> bool:
    """Whether every sensor can read for many vehicles: all that ship with Pelagos, but for those that say otherwise."""
    kinds = [registry.find("sensor", config.type).load() for config in agent.sensors.values()]
    return all(
        kind.__module__.startswith("pelagos.sensors.") and not getattr(kind, "ONE_VEHICLE", False) for kind in kinds
    )
