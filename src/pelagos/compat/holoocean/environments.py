"""`HoloOceanEnvironment`: HoloOcean's environment, on a native simulation (`env.pelagos`)."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any, Self

from pelagos.compat.holoocean.advice import Advice
from pelagos.compat.holoocean.agents import AgentDefinition, HoloOceanAgent
from pelagos.compat.holoocean.appearance import Appearance
from pelagos.compat.holoocean.building import build, hand_over
from pelagos.compat.holoocean.drawing import Drawing
from pelagos.compat.holoocean.exceptions import HoloOceanException, named, three
from pelagos.compat.holoocean.messaging import Messaging
from pelagos.compat.holoocean.motion import AgentMotion
from pelagos.compat.holoocean.names import identifier
from pelagos.compat.holoocean.native_scenario import SCENARIO_KEYS, drawn_seed, native_sensor
from pelagos.compat.holoocean.octrees import leave_folder
from pelagos.compat.holoocean.sensor import HoloOceanSensor
from pelagos.compat.holoocean.sensors import SensorDefinition
from pelagos.compat.holoocean.settings import settings
from pelagos.sim.simulation import Simulation

State = dict[str, Any]
_SETTLING_TICKS = 3  # of a reset, before agents are made anew


class HoloOceanEnvironment(Appearance, Drawing, Messaging):
    """A world with agents in it, and the clock.

    Beside HoloOcean's arguments:
        seed: of every random stream; the same script with the same seed gives the same numbers. Without one it is
            drawn from the operating system, as HoloOcean's noise is; `env.seed` says it.
        legacy_dynamics: HoloOcean's own force model for its native agents.
        strict: unknown keys are errors.

    Attributes:
        pelagos: the native `Simulation`.
        seed: of every random stream: `make(..., seed=env.seed)` draws the same noise again.
        agents: by name.
        sea_level: height of the mean sea surface [m].
    """

    def __init__(
        self,
        agent_definitions: Sequence[AgentDefinition] | None = None,
        binary_path: str | None = None,
        window_size: Sequence[int] | None = None,
        start_world: bool = True,
        uuid: str = "",
        gl_version: int = 4,
        verbose: bool = False,
        pre_start_steps: int = 2,
        show_viewport: bool = True,
        ticks_per_sec: int | None = None,
        frames_per_sec: Any = None,
        copy_state: bool = True,
        scenario: dict[str, Any] | None = None,
        set_fps: Any = None,
        set_tps: int | None = None,
        *,
        seed: int | None = None,
        legacy_dynamics: bool | None = None,
        strict: bool | None = None,
    ) -> None:
        if scenario is None:
            raise HoloOceanException("an environment needs a scenario: holoocean.make(scenario_cfg={...})")
        chosen = settings()
        self.advice = Advice(strict=chosen.strict if strict is None else strict)
        self._scenario, self._copy_state = scenario, copy_state
        asked_seed = chosen.seed if seed is None else seed
        self.seed = drawn_seed(scenario) if asked_seed is None else int(asked_seed)
        self._random: Any = random if asked_seed is None else random.Random(self.seed)
        asked = legacy_dynamics if legacy_dynamics is not None else scenario.get("legacy_dynamics")
        self._legacy = chosen.legacy_dynamics if asked is None else bool(asked)
        self._pre_start_steps, self._show_viewport = int(pre_start_steps), show_viewport
        tps = (ticks_per_sec, set_tps, scenario.get("ticks_per_sec", 30))
        self._ticks_per_sec = self._checked_tps(next(given for given in tps if given is not None))
        self._frames_per_sec = frames_per_sec if frames_per_sec is not None else scenario.get("frames_per_sec", True)
        self.window_size = window_size
        self.agents: dict[str, HoloOceanAgent] = {}
        self.motions: dict[str, AgentMotion] = {}
        self.world_numbers: dict[str, float] = {}
        self._agent: HoloOceanAgent | None = None
        self._num_ticks = self._total_ticks = self._resets = self._lead = 0
        self._extra_agents = list(agent_definitions or [])
        self._native: dict[str, Any] | None = None
        self._sim: Simulation | None = None
        self._stale = True
        self._lcm: Any = None
        self._client = self
        self._begin_appearance()
        self._begin_drawing()
        self._begin_messaging()
        self.advice.unknown("scenario", scenario, SCENARIO_KEYS)
        self._reset(read=False)

    # the clock

    @property
    def pelagos(self) -> Simulation:
        """The native simulation: record, checkpoint, set, look about. It is another after sensors or agents change."""
        if self._sim is None or self._stale:
            build(self)
        assert self._sim is not None
        return self._sim

    @property
    def _dt(self) -> float:
        return 1.0 / self._ticks_per_sec

    def reset(self) -> State:
        """Everything from the start, with new random poses where the scenario asks; the count of ticks goes on."""
        return self._reset(read=True)

    def step(self, action: Any, ticks: int = 1, publish: bool = True) -> State:
        """Tell the main agent, and tick; the last state."""
        if self._agent is not None:
            self._agent.act(action)
        return self.tick(ticks, publish)

    def act(self, agent_name: str, action: Any) -> None:
        """Tell an agent; it holds until it is told otherwise, or reset.

        Raises:
            KeyError: no such agent.
        """
        named("agent", agent_name, self.agents).act(action)

    def tick(self, num_ticks: int = 1, publish: bool = True, tick_clock: bool = True) -> State:
        """Advance; the last state. Without `tick_clock` only the physics goes on, not time or sensors' phases."""
        state: State = {}
        count = int(num_ticks)
        while count > 0:
            skipped = self._skip(count - 1) if tick_clock else 0
            count -= skipped + 1
            state = self._tick(clock=tick_clock, publish=publish)
        return state

    def _skip(self, ticks: int) -> int:
        """Pass so many ticks in one native call, where nothing can happen in between; how many were passed."""
        eventful = self.media.flights or self.media.beams or self._cycles_run or self._lcm is not None or self._falling
        stepping = any(agent.kind.steps is not None for agent in self.agents.values())
        if ticks < 2 or eventful or stepping or self._fences:
            return 0
        passed = ticks - 1  # the last before a look is taken alone: differences need it
        hand_over(self)
        self.pelagos.step(ticks=passed)
        self._count(passed)
        self._move({})
        return passed

    def _tick(self, *, clock: bool, publish: bool) -> State:
        hand_over(self)
        readings = self.pelagos.step()
        self._move(self.motions)
        self.media.advance()
        self._total_ticks += 1
        state = self._state(readings)
        if clock:
            self._cycle()
            for agent in self.agents.values():
                for sensor in agent.sensors.values():
                    sensor.tick_count = (sensor.tick_count + 1) % sensor.tick_every
            self._num_ticks += 1
        self._fall()
        if publish and self._lcm is not None:
            self._publish(state)
        return state

    def _count(self, ticks: int) -> None:
        """Time goes on without a look."""
        self._num_ticks += ticks
        self._total_ticks += ticks
        for agent in self.agents.values():
            for sensor in agent.sensors.values():
                sensor.tick_count = (sensor.tick_count + ticks) % sensor.tick_every

    def _move(self, before: Mapping[str, AgentMotion]) -> None:
        """Every agent's motion now, from that of the tick before."""
        states = self.pelagos.state
        rows = dict(zip(states, states.motion, strict=True))
        self.motions = {n: AgentMotion(rows[a.native_name], before.get(n), self._dt) for n, a in self.agents.items()}

    # what is seen

    def _state(self, readings: Mapping[str, Mapping[str, Any]] | None) -> State:
        """Every agent's values: flat for a single one, with the time."""
        time = self._num_ticks / self._ticks_per_sec
        for agent in self.agents.values():
            agent.agent_state_dict = self._values(agent, {} if readings is None else readings[agent.native_name])
        if not self._copy_state:
            return self._get_single_state() if self._flat else self._get_full_state()
        if self._flat:
            state = self._agent.agent_state_dict if self._agent is not None else {}
            return {**state, "t": time}
        return {**{name: agent.agent_state_dict for name, agent in self.agents.items()}, "t": time}

    def _values(self, agent: HoloOceanAgent, readings: Mapping[str, Any]) -> State:
        sensors = agent.sensors.values()
        late = [s.native_name for s in sensors if s.is_native and s.tick_count == 0 and s.native_name not in readings]
        if late:
            readings = {**readings, **self.pelagos.read(agent.native_name, late)}
        motion, values = self.motions[agent.name], {}
        for sensor in sensors:
            if sensor.tick_count == 0 or sensor.every_tick:
                value = sensor.value(motion, readings.get(sensor.native_name) if sensor.is_native else None)
                if value is not None:
                    sensor.sensor_data = values[sensor.name] = value
            elif sensor.always:
                values[sensor.name] = sensor.idle()
        return values

    def _get_single_state(self) -> State:
        """The main agent's newest values, due or not."""
        return {} if self._agent is None else {n: s.sensor_data for n, s in self._agent.sensors.items()}

    def _get_full_state(self) -> State:
        """Every agent's newest values, due or not."""
        return {a: {n: s.sensor_data for n, s in agent.sensors.items()} for a, agent in self.agents.items()}

    def get_reward_terminal(self) -> tuple[Any, Any]:
        """Reward and end of the main agent's first task sensor, as it was last due; (None, None) without one."""
        sensors = {} if self._agent is None else self._agent.sensors
        task = next((s for s in sensors.values() if "Task" in s.sensor_type), None)
        return (None, None) if task is None else (float(task.sensor_data[0]), bool(task.sensor_data[1]))

    def info(self) -> str:
        """Agents and sensors, as text."""
        lines = ["Agents:\n"]
        for agent in self.agents.values():
            lines.append(f"\tName: {agent.name}\n\tType: {agent.kind.name}\n\tSensors:")
            lines += [f"\t\t{name}" for name in agent.sensors]
        return "\n".join(lines) + "\n"

    @property
    def action_space(self) -> Any:
        """Of the main agent."""
        assert self._agent is not None
        return self._agent.action_space

    def get_joint_constraints(self, agent_name: str, joint_name: str) -> None:
        """None: no agent of Pelagos has HoloOcean's joints."""
        return named("agent", agent_name, self.agents).get_joint_constraints(joint_name)

    # agents and sensors

    def add_agent(self, agent_def: AgentDefinition, is_main_agent: bool = False) -> None:
        """A further agent from the next tick on.

        Raises:
            HoloOceanException: the name is taken.
        """
        if agent_def.name in self.agents:
            raise HoloOceanException(f"there is an agent {agent_def.name!r} already")
        agent_def.legacy = self._legacy
        self._enter(agent_def)
        if is_main_agent or self._agent is None:
            self._agent = self.agents[agent_def.name]
        self._stale = True

    spawn_agent = add_agent

    def set_control_scheme(self, agent_name: str, control_scheme: int) -> None:
        """Another control scheme; an unknown agent is only told of."""
        if agent_name not in self.agents:
            print(f"No such agent {agent_name}")
            return
        self.agents[agent_name].set_control_scheme(control_scheme)

    def native_name(self, agent: str) -> str:
        """Name of an agent in `pelagos`."""
        return identifier(agent)

    def _enter(self, definition: AgentDefinition) -> HoloOceanAgent:
        """Make an agent with its sensors."""
        agent = self.agents[definition.name] = definition.type(self, definition)
        agent.scheme = definition.scheme or 0
        for one in definition.sensors:
            agent.sensors[one.sensor_name] = self._sensor(one)
        return agent

    def _sensor(self, definition: SensorDefinition) -> HoloOceanSensor:
        sensor = definition.type(self, definition, definition.agent_type)
        sensor.is_native = native_sensor(self, sensor) is not None
        if sensor.lcm_msg is not None and self._lcm is None:
            from pelagos.compat.holoocean.lcm import provider

            self._lcm = provider(str(self._scenario.get("lcm_provider", "")))
        return sensor

    def _add_sensors(self, agent: HoloOceanAgent, definitions: Sequence[SensorDefinition]) -> None:
        for one in definitions:
            agent.sensors[one.sensor_name] = self._sensor(one)
        self._stale = True

    def _remove_sensors(self, agent: HoloOceanAgent, definitions: Sequence[Any]) -> None:
        for one in definitions:
            agent.sensors.pop(one if isinstance(one, str) else one.sensor_name, None)
        self._stale = True

    def _rotate_sensor(self, sensor: HoloOceanSensor, rotation: Sequence[float]) -> None:
        from pelagos.compat.holoocean.frames import matrix_of

        roll, pitch, yaw = three(f"{sensor.agent_name}.{sensor.name}: a rotation", rotation)
        sensor.definition.twist = (roll, -pitch, -yaw)
        sensor.turned = matrix_of(sensor.definition.mount[1])
        self._stale = self._stale or sensor.is_native

    def _change_period(self, sensor: HoloOceanSensor, ticks: int) -> None:
        sensor.tick_every, sensor.tick_count, self._stale = ticks, 0, True

    # building

    def _reset(self, *, read: bool) -> State:
        from pelagos.compat.holoocean.definitions import definitions

        self.media.clear()
        self._stations.clear()
        self._props.clear()
        self.agents, self.motions, self._agent = {}, {}, None
        self._lcm = None
        wanted, main = definitions(self)
        for one in [*wanted, *self._extra_agents]:
            agent = self._enter(one)
            if one.name == main or one.is_main_agent:
                self._agent = agent
        if any(
            s.sensor_type in SensorDefinition._sonar_sensors for a in self.agents.values() for s in a.sensors.values()
        ):
            leave_folder(self._scenario)
        self._flat = len(self.agents) == 1
        self._begin_appearance()
        ticks = self._pre_start_steps + 1
        build(self, fresh=True, warm=ticks)
        hand_over(self)
        self.pelagos.step(ticks=ticks)
        self._total_ticks += ticks + (_SETTLING_TICKS if self._resets else 0)
        self._resets += 1
        self._move({})
        return self._state(None) if read else {}

    def set_ticks_per_sec(self, ticks_per_sec: int) -> None:
        """Another tick; sensors keep the number of ticks between their readings, as HoloOcean's do.

        Raises:
            HoloOceanException: no whole number above zero.
        """
        self._ticks_per_sec = self._checked_tps(ticks_per_sec)
        self._stale = True

    def set_fps(self, fps: Any) -> None:
        """Accepted: a simulation without a window runs as fast as it can."""
        self._frames_per_sec = fps

    set_frames_per_sec = set_fps

    @staticmethod
    def _checked_tps(tps: Any) -> int:
        if not isinstance(tps, int | float) or not tps > 0 or tps % 1:
            raise HoloOceanException(f"ticks_per_sec is a whole number above zero, not {tps!r}")
        return int(tps)

    def _publish(self, state: State) -> None:
        from pelagos.compat.holoocean.lcm import publish

        publish(self._lcm, self, state)

    def send_world_command(self, name: str, num_params: Any = None, string_params: Any = None) -> None:
        """A command to the level, by name: no level of Pelagos has one; props come by `spawn_prop`.

        Raises:
            HoloOceanException: always; HoloOcean's engine ends the process there.
        """
        raise HoloOceanException(f"the world knows no command {name!r}; use the environment's methods")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.__on_exit__()

    def __on_exit__(self) -> None:
        """Let the simulation go, and the connection to LCM, which writes to the end of its log then."""
        self._sim, self._stale, self._lcm = None, True, None
