"""The face of a simulation that changes what is constant in a run: sensors, the ocean, the world; and looks about."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, cast

from pelagos.config.loader import load_scenario
from pelagos.errors import CommandError, LookupFailed
from pelagos.raycast.geometry import Geometry
from pelagos.sensors.camera.picture.boxes_3d import Box3d, box_of_body, boxes_3d
from pelagos.sensors.sensor import Reading
from pelagos.sim import checkpoint
from pelagos.sim.bodies import Body
from pelagos.sim.encounters import Encounters
from pelagos.sim.groups import one_agent
from pelagos.sim.lives import Lives, Observations
from pelagos.sim.model import Model, compile_model, encounters_of, with_changes
from pelagos.sim.observe import observe
from pelagos.sim.props import props_of
from pelagos.sim.sea import Sea
from pelagos.sim.step import Stepper
from pelagos.world.body import Prop

if TYPE_CHECKING:
    from pelagos.sim.simulation import Simulation

LAMP = "lamp"


class Changes(Lives):
    """Changes that need nothing built anew."""

    _lamps: dict[str, Mapping[str, Any]]

    @property
    def ocean(self) -> Sea:
        """The ocean, and what can be set of it: `sim.ocean.set(current=...)`."""
        return Sea(cast("Simulation", self))

    def observe(
        self,
        agent: str,
        position: object,
        attitude: object = (1.0, 0.0, 0.0, 0.0),
        *,
        velocity: object = (0.0, 0.0, 0.0),
        angular_velocity: object = (0.0, 0.0, 0.0),
        sensors: Iterable[str] | None = None,
        copy: int = 0,
        episode: int = 0,
    ) -> dict[str, Reading]:
        """Readings of an agent's sensors at given poses, at the present time, without a step.

        All poses go in one call; the next call with as many poses is the fastest. Other vehicles, movers and props are
        where they are. Nothing of the run changes. Every pose has noise of its own, named by its number, the time and
        `episode`.

        Args:
            agent: whose sensors.
            position: of the body, world NWU `(m, 3)` or `(3,)` [m].
            attitude: (w, x, y, z) body to world, `(m, 4)` or one for all.
            velocity, angular_velocity: body FLU, `(m, 3)` or one for all [m/s], [rad/s].
            sensors: their names; all where not given, but for those that need a run (modems, contact).
            copy: of the fleet, whose bodies are seen.
            episode: another draw of the noise.

        Returns:
            Readings by sensor, `(m, ...)`.

        Raises:
            CommandError: an unknown agent or sensor, a wrong shape, a value that is not finite, or within a step.
        """
        self.gate.refuse("observe")
        one_agent(self.model, agent)
        motion = (position, attitude, velocity, angular_velocity)
        sim = cast("Simulation", self)
        return observe(sim, agent, motion, sensors=sensors, copy=copy, episode=episode)

    def read(self, agent: str, sensors: Iterable[str] | None = None) -> Mapping[str, Reading]:
        """Readings of an agent's sensors now, due or not; the next step is as it would be without.

        Args:
            agent: whose sensors.
            sensors: their names; all where not given.

        Raises:
            CommandError: an unknown agent or sensor, or within a step.
        """
        self.gate.refuse("read")
        one_agent(self.model, agent)
        built = self.model.agents[agent].sensors
        chosen = list(built) if sensors is None else list(sensors)
        for name in chosen:
            if name not in built:
                raise CommandError(str(LookupFailed("sensor", name, built, where=agent)))
        stepper = cast("Simulation", self).stepper
        return stepper.observed(stepper.read_some(agent, chosen))[agent]

    def set(self, path: str, **keys: Any) -> None:
        """Change the configuration of a sensor while the run stands: `sim.set("auv0.camera", exposure_ev=1.0)`.

        `sim.set("auv0.lamp", on=False)` switches all lamps of an agent's cameras, and on again. The sensor is built
        anew, which takes as long as at load; all else goes on. `sim.scenario` has the change.

        Args:
            path: "agent.sensor", or "agent.lamp".
            keys: of the sensor's configuration; `on` of lamps.

        Raises:
            InputError: an unknown sensor or key, a value that is not allowed, or within a step.
        """
        self._refuse_within("set", in_recording=True)
        agent, _, name = path.partition(".")
        one_agent(self.model, agent)
        if agent not in self.model.scenario.agents:
            raise CommandError(f"{agent} is a member of a group; what it carries is set in the scenario's 'overrides'")
        known = self.model.agents[agent].sensors
        if name == LAMP and name not in known:
            self._change(self._switched(agent, **keys))
            return
        if name not in known:
            raise LookupFailed("sensor", path, [f"{agent}.{s}" for s in known])
        if not keys:
            raise CommandError(f"what is to be set of {path}? Give keys of its configuration")
        self._change({f"agents.{agent}.sensors.{name}.{key}": value for key, value in keys.items()})

    def _switched(self, agent: str, **keys: Any) -> dict[str, Any]:
        """Changes that switch the lamps of an agent's cameras."""
        if set(keys) != {"on"} or not isinstance(keys["on"], bool):
            raise CommandError(f"of {agent}.lamp, on=True or on=False can be set; given {keys}")
        lit = {s: m.config for s, m in self.model.agents[agent].sensors.items() if hasattr(m.config, "lamps")}
        for name, config in lit.items():
            if config.lamps:
                self._lamps[f"agents.{agent}.sensors.{name}.lamps"] = config.model_dump(mode="json")["lamps"]
        own = {k: v for k, v in self._lamps.items() if k.startswith(f"agents.{agent}.")}
        if not own:
            raise CommandError(f"{agent} has no camera with lamps")
        return {key: lamps if keys["on"] else [] for key, lamps in own.items()}

    def _change(self, overrides: Mapping[str, Any]) -> None:
        checked = load_scenario(self.model.scenario, overrides=overrides).agents
        agents = dict(self.model.scenario.agents)
        for _, agent, _, sensor, _ in (key.split(".", 4) for key in overrides):
            sensors = {**agents[agent].sensors, sensor: checked[agent].sensors[sensor]}
            agents[agent] = agents[agent].model_copy(update={"sensors": sensors})
        scenario = self.model.scenario.with_agents(agents)
        self.exchange(with_changes(self.model, scenario, self._encounters, seed=self.seed))

    @property
    def encounters(self) -> Encounters:
        """Encounters that sensors ask for while they read."""
        return self._encounters

    def exchange(self, model: Model) -> None:
        """Go on with a model whose sensors or ocean are others."""
        parts = checkpoint.parts_of(cast("Simulation", self))
        before = self._stepper
        self.model = model
        self._stepper = Stepper(model, self.bodies, self._encounters, self.listeners, like=before)
        self._stepper.logged, self._stepper.timings = before.logged, before.timings
        checkpoint.put_back(cast("Simulation", self), parts)

    def load_world(
        self, seed: int | None = None, *, overrides: Mapping[str, Any] | None = None, **keys: Any
    ) -> Observations:
        """Another world of the same kind, and the run from its start in it; vehicles and their kernels stay.

        Args:
            seed: of the world.
            overrides: keys of the scenario to change with it, by dotted path: of the world, the ocean and sensors.
            keys: other keys of the world.

        Returns:
            As `reset`.

        Raises:
            InputError: a key that the world does not have, a value that is not allowed, a start that is not free there.
        """
        self._refuse_within("load_world")
        changes = {f"world.{key}": value for key, value in keys.items()} | _with_world(overrides or {})
        if seed is not None:
            changes["world.seed"] = seed
        if not changes:
            raise CommandError("which other world? Give a seed, or keys of the world")
        changed = load_scenario(self.model.scenario, overrides=changes)
        if not overrides:
            changed = self.model.scenario.model_copy(update={"world": changed.world})
        asked: Encounters = encounters_of(changed)
        old = self.model
        model = compile_model(
            changed, asked, n=self.n, seed=self.seed, first_environment=old.first_environment, like=old, new_world=True
        )
        self.listeners.restart()
        cast("Simulation", self).stand(model, asked)
        self._tell_reset()
        return self._later(self._stepper.read_now)

    @property
    def props(self) -> Mapping[str, Body]:
        """Handles of the scenario's props in the world, by name; a reset puts them back, also what was removed."""
        return props_of(self.bodies)

    def spawn(self, prop: Prop, *, name: str | None = None) -> Body:
        """Put a body into the world; the next reading of every sensor sees it.

        Returns:
            A handle with `move` and `remove`.

        Raises:
            InputError: an unknown shape, material or label, or a name that is taken.
        """
        self.gate.settle()
        props = self.model.scenario.props
        taken = {*props, *(body.name for body in self.bodies.bodies)}
        if name in props and name not in self.props:
            raise CommandError(f"{name!r} is a prop of the scenario, which a reset puts back; take another name")
        self.bodies.spawned += 1
        while not name and f"{prop.shape}{self.bodies.spawned}" in taken:
            self.bodies.spawned += 1
        name = name or f"{prop.shape}{self.bodies.spawned}"
        geometry: Geometry = prop.geometry(instance=self.bodies.new_instance(), world=self.model.world)
        return self.bodies.add(name, geometry, prop.position, prop.attitude)

    def boxes_3d(self, copy: int = 0) -> dict[int, Box3d]:
        """Boxes in space around everything that stands in a copy of the world now, by instance id.

        Things of the world, movers, what was spawned, and the vehicles where there are several.
        """
        found = boxes_3d(self.model.world.geometries)
        self.bodies.follow(self._stepper.tick)
        states = self._stepper.states()
        for name, hull in self.bodies.hulls.items():
            found[hull.instance] = box_of_body(hull, states[name].position[copy], states[name].attitude[copy])
        for body in self.bodies.bodies:
            found[body.geometry.instance] = box_of_body(body.geometry, body.position[copy], body.attitude[copy])
        return found


def _with_world(overrides: Mapping[str, Any]) -> dict[str, Any]:
    """Overrides that may come with another world.

    Raises:
        CommandError: a key of something that stays.
    """
    for key in overrides:
        first, *more = key.split(".")
        if first not in ("world", "ocean") and not (first == "agents" and more[1:2] == ["sensors"]):
            raise CommandError(f"{key} stays when the world changes; keys of world, ocean and sensors may change")
    return dict(overrides)
