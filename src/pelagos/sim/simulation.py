"""`Simulation`: a scenario that runs, a tick at a time or in one go."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from pelagos.config.loader import load_scenario, to_yaml
from pelagos.config.scenario import Scenario
from pelagos.errors import CommandError, LookupFailed
from pelagos.raycast.geometry import Geometry
from pelagos.sensors.comms.link.medium import SharedMedium
from pelagos.sensors.comms.link.packet import Kind
from pelagos.sim import groups, outbox, props
from pelagos.sim.bodies import Bodies, hull_of, rows
from pelagos.sim.changes import Changes
from pelagos.sim.cost import check_memory
from pelagos.sim.encounters import Encounters
from pelagos.sim.gate import Gate
from pelagos.sim.initial import start_states
from pelagos.sim.listeners import Listeners
from pelagos.sim.lives import Observations
from pelagos.sim.model import AgentModel, Model, compile_model, encounters_of
from pelagos.sim.mounts import warn_of_buried, warn_of_wrong_side
from pelagos.sim.movers import Movers
from pelagos.sim.navigator import External
from pelagos.sim.record import Recorder
from pelagos.sim.run import RunResult, run
from pelagos.sim.run_log import RunLog
from pelagos.sim.sampled import Sampled
from pelagos.sim.seed import seed_of
from pelagos.sim.state import States, checked_command, chosen, named_command
from pelagos.sim.step import Stepper
from pelagos.sim.watch import Watcher
from pelagos.world.world import World

Policy = Callable[[Observations], Mapping[str, Any]]


class Simulation(Changes):
    """A world with vehicles in it, for a fleet of `n` independent copies.

    Attributes:
        model: the constant part (`sim/model.py`).
        n: copies.
    """

    def __init__(self, model: Model, encounters: Encounters, *, seed: int, like: Simulation | None = None) -> None:
        self.n = model.n
        self.seed = seed
        self.listeners = Listeners()
        self.gate = Gate()
        self.logs: list[RunLog] = []
        self.watchers: list[Watcher] = []
        self._lamps = {}
        self._written: tuple[Scenario, str] | None = None
        self.stand(model, encounters, like)

    def stand(self, model: Model, encounters: Encounters, like: Simulation | None = None) -> None:
        """Begin with a model, or where a simulation of the same model stands."""
        self.model, self._encounters = model, encounters
        if like is None:
            self._begin = start_states(model)  # before any body stands in the scene that it asks
            kinds = {name: hull_of(batch.vehicle, model.world) for name, batch in model.batches.items()}
            hulls = {name: kinds[agent.batch.name] for name, agent in model.agents.items()}
            self.bodies = Bodies(model.scene, hulls, n=model.n, first_instance=model.world.next_instance)
        else:
            self._begin, self.bodies = like._begin, like.bodies.twin()
        if model.world.movers:
            self.bodies.script = Movers(model.world, self.bodies, dt_ns=model.clock.dt_ns).place
        shared = None if like is None else like.stepper
        self._stepper = Stepper(model, self.bodies, encounters, self.listeners, like=shared)
        if like is None:
            first = np.zeros(model.n, dtype=np.int64)
            props.put(model, self.bodies, self._stepper.variety, first == 0, first)
            self._stepper.start(self._stepper.variety.starts(self._begin, first == 0, first))
            self.bodies.follow(0)
            warn_of_buried(model, self._begin, self.bodies.hulls, self.bodies.bodies)
            warn_of_wrong_side(model)
        model.world.before_cast(self._show_now)

    @classmethod
    def load(
        cls,
        scenario: str | Path | Mapping[str, Any] | Scenario,
        n: int = 1,
        seed: int | None = None,
        *,
        environment: int = 0,
        overrides: Mapping[str, Any] | None = None,
        trust: bool = False,
        memory_limit: float | None = None,
    ) -> Self:
        """Build a simulation.

        Args:
            scenario: a YAML file, a mapping or a `Scenario`.
            n: copies of the whole scenario that run side by side, with noise of their own.
            seed: of every random stream; the scenario's own where not given.
            environment: index of the first copy: copy i of a fleet is the same, byte for byte, as a fleet of one with
                `environment=i`.
            overrides: values to change, by dotted key ("agents.auv0.sensors.imaging.range_max_m").
            trust: let the scenario name functions of Python to call ("module:function"): it is a program then.
            memory_limit: refuse what would take more than this [B]; four fifths of what is free where not given.

        Raises:
            InputError: with file, line and key of what is wrong.
            DeviceError: no usable LLVM or GPU.
        """
        if isinstance(n, bool) or not isinstance(n, int) or n < 1:
            raise CommandError(f"n is the number of copies, a whole number from 1 on; given {n!r}")
        checked = load_scenario(scenario, overrides=overrides, trust=trust)
        check_memory(checked, n, memory_limit)
        chosen = checked.seed if seed is None else seed
        encounters = encounters_of(checked)
        model = compile_model(checked, encounters, n=n, seed=seed_of(chosen), first_environment=environment)
        return cls(model, encounters, seed=chosen)

    @property
    def scenario(self) -> Scenario:
        """The scenario, resolved."""
        return self.model.scenario

    @property
    def written(self) -> str:
        """The scenario, resolved, as YAML."""
        if self._written is None or self._written[0] is not self.scenario:
            self._written = (self.scenario, to_yaml(self.scenario))
        return self._written[1]

    @property
    def world(self) -> World:
        """Geometry, materials, labels; `world.cast` sees what was spawned and what moves, where it is now."""
        return self.model.world

    @property
    def dt_ns(self) -> int:
        """The tick [ns]."""
        return self.model.clock.dt_ns

    @property
    def time_ns(self) -> int:
        """Simulation time [ns]."""
        return self._stepper.tick * self.dt_ns

    @property
    def state(self) -> States:
        """The true state of every agent, by name."""
        return self._stepper.states()

    @property
    def moving(self) -> Sequence[Geometry]:
        """Things in the moving scene now, each in its own frame: hulls that others can see, movers, props."""
        return (*self.bodies.hulls.values(), *(b.geometry for b in self.bodies.bodies))

    @property
    def medium(self) -> SharedMedium:
        """The water between modems, and who is in it."""
        return self._encounters.medium

    @property
    def stepper(self) -> Stepper:
        """The step loop, for those who want its timings."""
        return self._stepper

    def step(self, commands: Mapping[str, Any] | None = None, ticks: int = 1) -> Observations:
        """Advance by one tick or several.

        Args:
            commands: by agent, `(k,)` or `(n, k)` in the agent's control mode, or by group, also `(members, k)` and
                `(n, members, k)`; an agent that is left out keeps its last command, or goes on with its mission.
            ticks: how many, with the same commands.

        Returns:
            The newest reading of each sensor that was due, by agent and sensor.

        Raises:
            CommandError: an unknown agent, a wrong shape, a value that is not finite.
            SimulationError: a state is not finite any more.
        """
        if isinstance(ticks, bool) or not isinstance(ticks, int | np.integer) or ticks < 1:
            raise CommandError(f"ticks is a whole number from 1 on; given {ticks!r}")
        self.gate.enter("step")
        try:
            self.gate.act()
            if commands:
                self.command(commands)
            return self._stepper.observed(self._advance(int(ticks)))
        finally:
            self.gate.leave()

    def _advance(self, ticks: int) -> list[Sampled]:
        """Blocks up to so many ticks; each written down, then told."""
        stepper, sampled = self._stepper, []
        last = stepper.tick + ticks
        if stepper.tick == 0:
            self.tell_start()
            if self.listeners.any and not self.listeners.has_heard(0):
                self.listeners.tell(self, 0, stepper.read_now())
        while stepper.tick < last:
            for log in self.logs:
                log.look()
            block = stepper.advance(last)
            sampled += block
            for log in self.logs:
                log.readings(block)
                log.motion()
            self.tell_watchers(block)
            if self.listeners.any:
                self.listeners.tell(self, stepper.tick, block)
                self.gate.act()
                stepper = self._stepper  # another one, where the ocean was changed
        return sampled

    def command(self, commands: Mapping[str, Any]) -> None:
        """Set commands without advancing; an agent with a mission leaves it.

        `{"auv0": {"drop_weight": 1.0}}` names set-points, and the others stay; if they are all of what the vehicle
        carries (actuators that release, or flood), its mission goes on.

        While another thread steps or runs the simulation, they are checked at once, and enter at the next boundary of
        steps.
        """
        for name, values in groups.by_agent(commands, self.model, self.n).items():
            agent = self._agent(name)
            mode = self._stepper.mode(name)
            names, leave = tuple(agent.vehicle.command_names(mode)), True
            if isinstance(values, Mapping):
                leave = not values.keys() <= agent.vehicle.model.carriers.keys()
                values = named_command(values, self._stepper.command_values(name), names=names, agent=name)
            checked = checked_command(values, n=self.n, names=names, agent=name)
            if self.gate.elsewhere:
                self.gate.post(partial(self._stepper.set_command, name, checked, leave=leave))
            else:
                self._stepper.set_command(name, checked, leave=leave)

    def held_command(self, agent: str) -> NDArray[np.float64]:
        """`(n, k)` the command that an agent holds, in its present control mode; a mission's last set-points.

        That of a group is `(n, members, k)`.
        """
        return groups.held_command(self, agent)

    def send(
        self, agent: str, modem: str, payload: bytes | str, *, to: str = "*", kind: Kind = "data", tag: str = "",
        acknowledge: bool | None = None, where: Sequence[int] | None = None,
    ) -> int:  # fmt: skip
        """Give a packet to a modem, which sends it as its protocol allows.

        Args:
            agent, modem: who sends: the vehicle, and its sensor.
            payload: bytes, or text in UTF-8; at most what the device carries.
            to: "agent.modem", an agent with one modem, an address, or "*" for all.
            kind: `data`, or `request` for a response with the range.
            tag: text that goes along without taking time.
            acknowledge: whether an acknowledgement is asked for; as the modem is configured where not given.
            where: copies of the fleet; all where not given.

        Returns:
            in how many copies there was room in the queue.

        Raises:
            LookupFailed: no such agent or modem.
            CommandError: too long a payload, or a modem that is in the air.
        """
        return outbox.send(self, agent, modem, payload, to, kind, tag, acknowledge, where)

    def set_mode(self, agent: str, mode: str) -> None:
        """Change the control mode of an agent; it idles in the new mode until it is commanded.

        Raises:
            LookupFailed: the vehicle has no such mode.
        """
        for name in self.model.group(agent) or [agent]:
            vehicle = self._agent(name).vehicle
            if mode not in vehicle.modes:
                raise LookupFailed("control mode", mode, vehicle.modes, where=name)
            self._stepper.set_mode(name, mode)

    def run(
        self,
        seconds: float | None = None,
        policy: Policy | None = None,
        record: str | Path | Recorder | None = None,
        *,
        progress: Callable[[float, float], None] | None = None,
        realtime: bool | float = False,
    ) -> RunResult:
        """Run for a time, from where the simulation stands.

        Args:
            seconds: how long [s]; the scenario's duration where not given, or until every mission has ended.
            policy: asked every tick with the readings, answers with commands; without it, missions or last commands
                hold.
            record: an MCAP file to write.
            progress: called with (simulated seconds so far, seconds asked for).
            realtime: wait where the simulation is faster than the clock on the wall, or than so many times as fast.

        Raises:
            SimulationError: a state is not finite any more; the recording keeps everything until then.
            RecordingError: the recording cannot be written on.
        """
        return run(self, seconds, policy=policy, record=record, progress=progress, realtime=realtime)

    def view(self, *, drive: bool = False, host: str = "127.0.0.1", port: int | None = None) -> Any:
        """Open a page on which this simulation is seen; its address is the `url` of what is given back.

        In a notebook the last line of a cell shows the page itself. Close it, or use it as a context manager.

        Args:
            drive: a thread of the view steps the simulation from its start, and the page has all controls; otherwise
                the page shows what `step` and `run` do here.
            host: address to listen at; the page has a token either way.
            port: 8080, or a free one where that is taken, where not given; 0: a free one.

        Raises:
            InputError: the port is taken, or the extra `viewer` is not installed.
        """
        return import_module("pelagos.viewer.session").view_of(self, drive=drive, host=host, port=port)

    def set_state(
        self,
        agent: str,
        *,
        position: object = None,
        attitude: object = None,
        velocity: object = None,
        angular_velocity: object = None,
        where: object = None,
    ) -> None:
        """Place an agent anew: position NWU [m], attitude (w, x, y, z), velocities body FLU; `(k,)` or `(n, k)`.

        Of a group `(k,)`, `(members, k)` or `(n, members, k)`. Its actuators, command and mission go on; its
        controllers begin anew, and accelerations are 0 until the next step. With `where`, `(n,)` bool or indices, only
        in those copies: the others' bytes stay.

        Raises:
            CommandError: an unknown agent, a wrong shape, a value that is not finite.
        """
        mask = np.ones(self.n, dtype=bool) if where is None else chosen(where, self.n)
        given = {
            "position": position, "attitude": attitude, "velocity": velocity, "angular_velocity": angular_velocity
        }  # fmt: skip
        groups.place(self, agent, mask, given)

    def navigate(
        self, agent: str, *, position: object, heading_rad: object, velocity: object = (0.0, 0.0, 0.0)
    ) -> None:
        """Tell an agent with `navigation: external` where it is; its mission goes by this until it is told again.

        Args:
            agent: its name.
            position: world NWU `(3,)` or `(n, 3)` [m].
            heading_rad: of the compass, one number or `(n,)` [rad].
            velocity: over ground, world NWU `(3,)` or `(n, 3)` [m/s].

        Raises:
            CommandError: an unknown agent, one whose navigation is another, a wrong shape, a value that is not finite.
        """
        self._agent(agent)
        navigator = self._stepper.missions.navigators.get(agent)
        if not isinstance(navigator, External):
            raise CommandError(f"{agent} is not told where it is: give it `navigation: external` in the scenario")
        heading: object = [heading_rad] if np.ndim(heading_rad) == 0 else np.reshape(heading_rad, (-1, 1))  # type: ignore[arg-type, call-overload]
        navigator.tell(
            rows(position, self.n, 3, f"{agent}: position"),
            rows(heading, self.n, 1, f"{agent}: heading_rad")[:, 0],
            rows(velocity, self.n, 3, f"{agent}: velocity"),
        )

    def _repr_html_(self) -> str:
        return str(import_module("pelagos.drawing.notebook").simulation_html(self))

    def _show_now(self) -> None:
        """Put everything that moves where it is at the current time, for rays that somebody casts by hand."""
        if not self.model.scene.reading:  # then a sensor casts, and everything is there already
            self.bodies.follow(self._stepper.tick)
            self.bodies.show(self._stepper.states())

    def show_now(self, places: NDArray[np.float64]) -> None:
        """The same, and a streamed ground around places `(m, 3)` [m]."""
        self._show_now()
        self.model.scene.peek(places)

    def _agent(self, name: str) -> AgentModel:
        return groups.one_agent(self.model, name)
