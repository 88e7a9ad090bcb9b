"""The constant part of a run: a scenario, compiled for a fleet of `n` copies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pelagos.config import registry
from pelagos.config.agent import Agent
from pelagos.config.scenario import Scenario
from pelagos.errors import LookupFailed, ScenarioError, WorldError
from pelagos.ocean.config import build_ocean
from pelagos.ocean.ocean import Ocean
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.comms.link.medium import Medium
from pelagos.sensors.navigation.collision import Blows
from pelagos.sensors.schedule import period_ticks
from pelagos.sensors.sensor import Sensor, SensorConfig, SensorContext
from pelagos.sensors.sonar.keys.ping_keys import PingConfig
from pelagos.sensors.sonar.multibeam import MultibeamConfig
from pelagos.sensors.sonar.ping.interference import Neighbours
from pelagos.sim.bodies import hull_rows
from pelagos.sim.clock import Clock
from pelagos.sim.control import family_of, first_mode
from pelagos.sim.driver import Driver
from pelagos.sim.encounters import Encounters
from pelagos.sim.guidance.guidance import Step
from pelagos.sim.guidance.plan import Planner
from pelagos.vehicles.vehicle import Vehicle
from pelagos.world.build import build_world
from pelagos.world.world import World


@dataclass(frozen=True)
class SensorModel:
    """A built sensor and its place in the schedule.

    Attributes:
        name: as in the scenario.
        config: its configuration.
        sensor: what reads.
        period: ticks between two readings.
        sees: it casts rays, so it is asked at its own tick, with every body where it is then.
        waits: its readings are small enough for those of several blocks to be read in one call, where nothing asks for
            them before and nothing that it sees moves.
    """

    name: str
    config: SensorConfig
    sensor: Sensor
    period: int
    sees: bool
    waits: bool


@dataclass(frozen=True)
class AgentModel:
    """One agent of a scenario.

    Attributes:
        name: as in the scenario.
        config: its configuration.
        vehicle: what moves.
        mode: control mode at the start.
        driver: moves it through blocks of ticks.
        sensors: by name, in the scenario's order.
        tasks: its mission; empty without one.
    """

    name: str
    config: Agent
    vehicle: Vehicle
    mode: str
    driver: Driver
    sensors: Mapping[str, SensorModel]
    tasks: list[Step]


@dataclass(frozen=True)
class Model:
    """Everything that does not change while a run goes on.

    Attributes:
        scenario: resolved.
        clock: tick.
        n: copies.
        seed: of every random stream.
        first_environment: index of the first copy among all environments of a study.
        world, scene, ocean: where.
        agents: by name.
    """

    scenario: Scenario
    clock: Clock
    n: int
    seed: int
    first_environment: int
    world: World
    scene: Scene
    ocean: Ocean
    agents: Mapping[str, AgentModel]


def compile_model(
    scenario: Scenario,
    encounters: Encounters,
    *,
    n: int,
    seed: int,
    first_environment: int,
    like: Model | None = None,
    new_world: bool = False,
) -> Model:
    """Build the world, the vehicles and the sensors of a scenario.

    Args:
        scenario: what to build.
        encounters: what sensors ask while they read; see `encounters_of`.
        n: copies.
        seed: of every random stream.
        first_environment: index of the first copy.
        like: a model of the same scenario and size, whose world and vehicles are taken over.
        new_world: the world is built all the same.

    Raises:
        InputError: the scenario asks for something that cannot be.
    """
    clock = Clock(scenario.tick_rate_hz)
    check_hearing(scenario)
    vehicles = {
        name: Vehicle.from_config(config.vehicle) if like is None else like.agents[name].vehicle
        for name, config in scenario.agents.items()
    }
    modes = {name: first_mode(scenario, name, vehicle) for name, vehicle in vehicles.items()}
    world = _world(scenario) if like is None or new_world else like.world
    scene = world.scene(n, first_environment=first_environment) if like is None or new_world else like.scene
    ocean = build_ocean(scenario.ocean, world, seed=seed, duration_s=scenario.duration_s)
    agents = {}
    crowded = len(scenario.agents) > 1
    for index, (name, config) in enumerate(scenario.agents.items()):
        vehicle = vehicles[name]
        own = hull_rows(index, n) if crowded else np.full(n, NO_BODY, dtype=np.uint32)
        context = _Context(
            seed=seed, clock=clock, scene=scene, world=world, ocean=ocean, own_body=own, agent=name,
            encounters=encounters,
        )  # fmt: skip
        agents[name] = AgentModel(
            name=name,
            config=config,
            vehicle=vehicle,
            mode=modes[name],
            driver=Driver(vehicle, n=n, dt_ns=clock.dt_ns) if like is None else like.agents[name].driver,
            sensors={s: context.build(s, c) for s, c in config.sensors.items()},
            tasks=_plan(scenario, name, vehicle, modes[name], world),
        )
    return Model(scenario, clock, n, seed, first_environment, world, scene, ocean, agents)


def with_changes(
    old: Model, scenario: Scenario, encounters: Encounters, *, seed: int, ocean: Ocean | None = None
) -> Model:
    """The same model with other configurations of some sensors, or another ocean; only what changes is built anew.

    Raises:
        InputError: a sensor cannot be built so.
    """
    agents, crowded = {}, len(scenario.agents) > 1
    for index, (name, agent) in enumerate(old.agents.items()):
        own = hull_rows(index, old.n) if crowded else np.full(old.n, NO_BODY, dtype=np.uint32)
        context = _Context(
            seed=seed, clock=old.clock, scene=old.scene, world=old.world, ocean=old.ocean if ocean is None else ocean,
            own_body=own, agent=name, encounters=encounters,
        )  # fmt: skip
        config = scenario.agents[name]
        sensors = {
            s: agent.sensors[s] if ocean is None and agent.sensors[s].config == c else context.build(s, c)
            for s, c in config.sensors.items()
        }
        agents[name] = replace(agent, config=config, sensors=sensors)
    return replace(old, scenario=scenario, ocean=old.ocean if ocean is None else ocean, agents=agents)


def encounters_of(scenario: Scenario) -> Encounters:
    """For the sensors of a scenario, none of them built yet."""
    neighbours = Neighbours(audible(scenario))
    return Encounters(neighbours, Blows(), Medium(sonars=lambda: neighbours.emitters))


def _plan(scenario: Scenario, name: str, vehicle: Vehicle, mode: str, world: World) -> list[Step]:
    """The mission of an agent."""
    config = scenario.agents[name]
    if not config.mission:
        return []
    x, y = config.start.position_m[:2]
    return Planner(
        name=name,
        vehicle=vehicle.name,
        family=family_of(vehicle, mode),
        envelope=vehicle.config.envelope,
        sensors=config.sensors,
        agents=tuple(scenario.agents),
        world=world,
        start=(float(x), float(y)),
        where=lambda number: scenario.where("agents", name, "mission", number),
    ).plan(config.mission)


def audible(scenario: Scenario) -> list[str]:
    """ "agent.sensor" of every sensor whose pings others can hear."""
    return [
        f"{agent}.{name}"
        for agent, config in scenario.agents.items()
        for name, sensor in config.sensors.items()
        if isinstance(sensor, PingConfig | MultibeamConfig)
    ]


def check_hearing(scenario: Scenario) -> None:
    """Check that there is what sonars are to hear.

    Raises:
        LookupFailed: a sonar's `hears` names one that is not in the scenario, or that cannot be heard.
    """
    known = audible(scenario)
    for agent, config in scenario.agents.items():
        for name, sensor in config.sensors.items():
            for path in sensor.hears if isinstance(sensor, PingConfig) and not isinstance(sensor.hears, str) else ():
                if path not in known:
                    where = scenario.where("agents", agent, "sensors", name, "hears")
                    raise LookupFailed("sonar that can be heard", path, known, where=where)


def _world(scenario: Scenario) -> World:
    try:
        return build_world(scenario.located_world)
    except WorldError as error:
        where = scenario.where("world")
        raise WorldError(f"{where}: {error}") from error


@dataclass(frozen=True)
class _Context:
    seed: int
    clock: Clock
    scene: Scene
    world: World
    ocean: Ocean
    own_body: NDArray[np.uint32]
    agent: str
    encounters: Encounters

    def build(self, name: str, config: Any) -> SensorModel:
        cls = registry.find("sensor", config.type).load()
        where = f"agents.{self.agent}.sensors.{name}"
        period = period_ticks(config.rate_hz, self.clock.dt_ns, where=where)
        context = SensorContext(
            path=f"{self.agent}.{name}",
            seed=self.seed,
            dt_ns=self.clock.dt_ns,
            scene=self.scene,
            world=self.world,
            ocean=self.ocean,
            own_body=self.own_body,
            neighbours=self.encounters.neighbours,
            blows=self.encounters.blows,
            medium=self.encounters.medium,
        )
        try:
            sensor = cls(config, context)
        except ScenarioError as error:
            raise error if error.where else ScenarioError(error.message, where=where) from None
        sees = getattr(cls, "SEES_SCENE", True)
        return SensorModel(name, config, sensor, period, sees, waits=getattr(cls, "WAITS", not sees))
