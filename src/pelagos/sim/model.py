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
from pelagos.config.swarm import member_names
from pelagos.config.vary import CURRENTS, TURBIDITY, WAVES, parse, turbidities
from pelagos.errors import LookupFailed, ScenarioError, WorldError
from pelagos.ocean.config import build_ocean
from pelagos.ocean.ocean import Ocean
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.comms.link.medium import SharedMedium
from pelagos.sensors.navigation.collision import Blows
from pelagos.sensors.noise import BatchPath, KeyTable
from pelagos.sensors.schedule import period_ticks
from pelagos.sensors.sensor import SensorContext
from pelagos.sensors.sonar.keys.ping_keys import PingConfig
from pelagos.sensors.sonar.keys.radiated import noise_sources
from pelagos.sensors.sonar.multibeam import MultibeamConfig
from pelagos.sensors.sonar.ping.interference import Neighbours
from pelagos.sim.batch import Batch, SensorModel, alike
from pelagos.sim.bodies import hull_rows
from pelagos.sim.clock import Clock
from pelagos.sim.control import family_of, first_mode
from pelagos.sim.driver import Driver
from pelagos.sim.encounters import Encounters
from pelagos.sim.guidance.guidance import Step
from pelagos.sim.guidance.plan import Planner
from pelagos.sim.set_points import vectors
from pelagos.sim.varied_sea import written_by_copy
from pelagos.sim.varied_sensors import check_sensors
from pelagos.vehicles.varied import check_names
from pelagos.vehicles.vehicle import Vehicle
from pelagos.world.build import build_world
from pelagos.world.world import World


@dataclass(frozen=True)
class AgentModel:
    """One agent of a scenario.

    Attributes:
        name: as in the scenario.
        config: its configuration.
        tasks: its mission; empty without one.
        batch: the agents that move with it.
        member: its place among them.
    """

    name: str
    config: Agent
    tasks: list[Step]
    batch: Batch
    member: int

    @property
    def vehicle(self) -> Vehicle:
        """Vehicle that moves."""
        return self.batch.vehicle

    @property
    def mode(self) -> str:
        """Control mode at the start."""
        return self.batch.mode

    @property
    def sensors(self) -> Mapping[str, SensorModel]:
        """By name, in the scenario's order; they read for all rows of its batch."""
        return self.batch.sensors

    @property
    def rows(self) -> slice:
        """Its rows among those of its batch."""
        return self.batch.rows_of(self.member)


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
        batches: those that move and read together, by the name of their first.
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
    batches: Mapping[str, Batch]

    @property
    def groups(self) -> Mapping[str, int]:
        """The scenario's groups of agents, and how many members each has."""
        return {name: agent.count for name, agent in self.scenario.agents.items() if agent.count is not None}

    def group(self, name: str) -> list[str] | None:
        """Names of a group's members; None where there is no such group."""
        count = self.groups.get(name)
        return None if count is None else member_names(name, count)


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
    members = scenario.members
    vehicles = vehicles_of(scenario) if like is None else {name: a.vehicle for name, a in like.agents.items()}
    modes = {name: first_mode(scenario, name, vehicle) for name, vehicle in vehicles.items()}
    groups = alike(members, _apart(scenario, modes))
    world = _world(scenario) if like is None or new_world else like.world
    scene = world.scene(n) if like is None or new_world else like.scene
    ocean = build_ocean(scenario.ocean, world, seed=seed, duration_s=scenario.duration_s)
    if any(key in scenario.vary for key in CURRENTS):
        ocean = ocean.with_(own=vectors(np.zeros((n, 3))))  # the step loop sets what is drawn
    if TURBIDITY in scenario.vary:
        ocean = ocean.with_(turbidities=turbidities(scenario.vary[TURBIDITY]))
    if any(parse(key).group == WAVES for key in scenario.vary):
        ocean = ocean.with_(own_waves=written_by_copy(scenario.ocean, world, seed=seed, n=n))  # likewise
    model = Model(scenario, clock, n, seed, first_environment, world, scene, ocean, {}, {})
    batches = {}
    for names in groups:
        first, vehicle = names[0], vehicles[names[0]]
        context = _context_of(model, scenario, names, encounters, seed=seed)
        driver = _driver(like, names) if like is not None else _first_driver(model, vehicle, names)
        sensors = {s: context.build(s, c) for s, c in members[first].sensors.items()}
        check_sensors(scenario, first, sensors)
        batches[first] = Batch(first, tuple(names), n, vehicle, modes[first], driver, sensors, context.streams)
    place = _places(batches)
    agents = {
        name: AgentModel(name, config, _plan(scenario, name, vehicles[name], modes[name], world), *place[name])
        for name, config in members.items()
    }
    encounters.medium.check_names()
    return replace(model, agents=agents, batches=batches)


def _context_of(
    model: Model, scenario: Scenario, names: list[str], encounters: Encounters, *, seed: int, ocean: Ocean | None = None
) -> _Context:
    """Context that the sensors of a batch are built with."""
    order = {name: index for index, name in enumerate(scenario.members)}
    alone = np.full(model.n, NO_BODY, dtype=np.uint32)
    own = [hull_rows(order[name], model.n) if len(order) > 1 else alone for name in names]
    first = model.first_environment
    return _Context(
        seed=seed, clock=model.clock, scene=model.scene, world=model.world,
        ocean=model.ocean if ocean is None else ocean, own_body=np.concatenate(own), agents=tuple(names),
        environments=range(first, first + model.n), encounters=encounters, streams=[],
    )  # fmt: skip


def _apart(scenario: Scenario, modes: Mapping[str, str]) -> dict[str, str]:
    """Traits that agents must share to be moved together: the mode, and that none has factors or sensors of its own."""
    own = {k.agent for k in map(parse, scenario.vary) if k.group in ("factors", "sensors")}
    return {name: f"{mode} of {name}" if name in own else mode for name, mode in modes.items()}


def _first_driver(model: Model, vehicle: Vehicle, names: list[str]) -> Driver:
    """A driver, whose lanes differ where the scenario says so.

    Raises:
        LookupFailed: a factor on what the vehicle does not have.
    """
    keys = [parse(key) for key in model.scenario.vary]
    factors = tuple(k.number for k in keys if k.agent in names and k.group == "factors")
    check_names(vehicle, factors, model.scenario.where("vary"))
    tells = model.scenario.record.commands
    return Driver(vehicle, n=model.n * len(names), dt_ns=model.clock.dt_ns, vary=factors, tells=tells)


def _driver(like: Model, names: list[str]) -> Driver:
    """That of the same agents, recorded already; another where they are others."""
    before = like.agents[names[0]].batch
    if before.members == tuple(names):
        return before.driver
    tells = before.driver.tells
    return Driver(before.vehicle, n=like.n * len(names), dt_ns=like.clock.dt_ns, tells=tells)


def _places(batches: Mapping[str, Batch]) -> dict[str, tuple[Batch, int]]:
    """Batch and number in it, by agent."""
    return {name: (batch, i) for batch in batches.values() for i, name in enumerate(batch.members)}


def vehicles_of(scenario: Scenario) -> dict[str, Vehicle]:
    """By agent; those that are configured alike share one."""
    made: dict[int, Vehicle] = {}
    known: list[tuple[Any, Vehicle]] = []
    found = {}
    for name, agent in scenario.members.items():
        key = id(agent.vehicle)
        if key not in made:
            same = next((vehicle for config, vehicle in known if config == agent.vehicle), None)
            made[key] = Vehicle.from_config(agent.vehicle) if same is None else same
            known.append((agent.vehicle, made[key]))
        found[name] = made[key]
    return found


def with_changes(
    old: Model, scenario: Scenario, encounters: Encounters, *, seed: int, ocean: Ocean | None = None
) -> Model:
    """The same model with other configurations of some sensors, or another ocean; only what changes is built anew.

    Raises:
        InputError: a sensor cannot be built so.
    """
    batches = {}
    for names in alike(scenario.members, _apart(scenario, {name: agent.mode for name, agent in old.agents.items()})):
        before = old.agents[names[0]].batch
        context = _context_of(old, scenario, names, encounters, seed=seed, ocean=ocean)
        same, config = ocean is None and before.members == tuple(names), scenario.members[names[0]]
        context.streams.extend(before.streams if same else ())
        sensors = {
            s: before.sensors[s] if same and before.sensors[s].config == c else context.build(s, c)
            for s, c in config.sensors.items()
        }
        driver = _driver(old, names)
        batches[names[0]] = replace(
            before, name=names[0], members=tuple(names), driver=driver, sensors=sensors, streams=context.streams
        )
    place = _places(batches)
    agents = {
        name: AgentModel(name, scenario.members[name], agent.tasks, *place[name]) for name, agent in old.agents.items()
    }
    encounters.medium.check_names()
    ocean = old.ocean if ocean is None else ocean
    return replace(old, scenario=scenario, ocean=ocean, agents=agents, batches=batches)


def encounters_of(scenario: Scenario) -> Encounters:
    """For the sensors of a scenario, none of them built yet."""
    neighbours = Neighbours(audible(scenario), noises=noise_sources(scenario.members))
    return Encounters(neighbours, Blows(), SharedMedium(tuple(scenario.members), sonars=lambda: neighbours.emitters))


def _plan(scenario: Scenario, name: str, vehicle: Vehicle, mode: str, world: World) -> list[Step]:
    """The mission of an agent."""
    config = scenario.members[name]
    if not config.mission:
        return []
    x, y = config.start.position_m[:2]
    return Planner(
        name=name,
        vehicle=vehicle.name,
        family=family_of(vehicle, mode),
        envelope=vehicle.config.envelope,
        sensors=config.sensors,
        agents=tuple(scenario.members),
        world=world,
        start=(float(x), float(y)),
        where=lambda number: scenario.where("agents", name, "mission", number),
    ).plan(config.mission)


def audible(scenario: Scenario) -> list[str]:
    """ "agent.sensor" of every sensor whose pings others can hear."""
    return [
        f"{agent}.{name}"
        for agent, config in scenario.members.items()
        for name, sensor in config.sensors.items()
        if isinstance(sensor, PingConfig | MultibeamConfig)
    ]


def check_hearing(scenario: Scenario) -> None:
    """Check that there is what sonars are to hear.

    Raises:
        LookupFailed: a sonar's `hears` names one that is not in the scenario, or that cannot be heard.
    """
    known = audible(scenario)
    for agent, config in scenario.members.items():
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
    agents: tuple[str, ...]
    environments: range
    streams: list[KeyTable]
    encounters: Encounters

    def build(self, name: str, config: Any) -> SensorModel:
        cls = registry.find("sensor", config.type).load()
        where = f"agents.{self.agents[0]}.sensors.{name}"
        period = period_ticks(config.rate_hz, self.clock.dt_ns, where=where)
        context = SensorContext(
            path=self._path(name),
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
        casts = sees and getattr(cls, "ASKS_SCENE", True)
        return SensorModel(name, config, sensor, period, sees, casts, waits=getattr(cls, "WAITS", not sees))

    def _path(self, name: str) -> str:
        paths = tuple(f"{agent}.{name}" for agent in self.agents)
        return paths[0] if len(paths) == 1 else BatchPath.of(paths, self.environments, self.streams)
