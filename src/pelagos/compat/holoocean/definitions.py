"""Agents and sensors of a scenario, checked, with HoloOcean's defaults, which are written back into it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from pelagos.compat.holoocean.agents import AgentDefinition, kind_of
from pelagos.compat.holoocean.exceptions import HoloOceanException, three
from pelagos.compat.holoocean.native_scenario import AGENT_KEYS, SENSOR_KEYS
from pelagos.compat.holoocean.sensors import SensorDefinition
from pelagos.errors import did_you_mean

if TYPE_CHECKING:
    from pelagos.compat.holoocean.environments import HoloOceanEnvironment


def definitions(env: HoloOceanEnvironment) -> tuple[list[AgentDefinition], str | None]:
    """The agents, and the name of the main one."""
    scenario = env._scenario
    found = [_agent(env, agent) for agent in scenario["agents"]]
    main = scenario.get("main_agent", found[0].name if found else None)
    known = [one.name for one in [*found, *env._extra_agents]]
    if known and main not in known and not any(one.is_main_agent for one in env._extra_agents):
        env.advice.name("scenario: main_agent", str(main), known, "there is no main agent then")
    return found, main


def _agent(env: HoloOceanEnvironment, agent: dict[str, Any]) -> AgentDefinition:
    name = agent["agent_name"]
    env.advice.unknown(f"agent {name}", agent, AGENT_KEYS)
    kind = kind_of(agent["agent_type"])
    sensors = [_sensor(env, name, kind.name, one) for one in agent["sensors"]]
    names = [one.sensor_name for one in sensors]
    twice = next((n for n in names if names.count(n) > 1), None)
    if twice is not None:
        raise HoloOceanException(f"{name}: two sensors are called {twice!r}; give them a sensor_name each")
    made = AgentDefinition(
        name, kind.name, sensors,
        _spread(env, agent, "location"), _spread(env, agent, "rotation"), bool(agent.get("existing", False)),
    )  # fmt: skip
    made.scheme = int(agent["control_scheme"]) % len(kind.schemes)
    made.legacy = bool(agent.get("legacy_dynamics", env._legacy))
    return made


def _spread(env: HoloOceanEnvironment, agent: Mapping[str, Any], key: str) -> list[float]:
    """A start, moved at random by at most `key`_randomization on each axis."""
    where, spread = f"agent {agent['agent_name']}: ", f"{key}_randomization"
    middle = three(where + key, agent.get(key, [0.0, 0.0, 0.0]))
    most = three(where + spread, agent.get(spread, [0.0, 0.0, 0.0]))
    return [m + (env._random.uniform(-r, r) if r else 0.0) for m, r in zip(middle, most, strict=True)]


def _sensor(env: HoloOceanEnvironment, agent: str, kind: str, sensor: dict[str, Any]) -> SensorDefinition:
    if "sensor_type" not in sensor:
        raise HoloOceanException(f"agent {agent}: a sensor has no sensor_type")
    name = sensor.get("sensor_name") or sensor["sensor_type"]
    env.advice.unknown(f"{agent}.{name}", sensor, SENSOR_KEYS)
    defaults = {
        "sensor_name": name, "socket": "", "location": [0, 0, 0], "rotation": [0, 0, 0], "Hz": env._ticks_per_sec,
        "configuration": None, "lcm_channel": None, "ros_publish": False, "existing": False,
    }  # fmt: skip
    for key, value in defaults.items():
        sensor.setdefault(key, value)
    for key in ("location", "rotation"):
        three(f"{agent}.{name}: {key}", sensor[key])
    rate = float(sensor["Hz"])
    if not rate > 0:
        raise ValueError(f"{agent}.{name}: Hz is above zero, not {sensor['Hz']!r}")
    if rate > env._ticks_per_sec:
        raise ValueError(f"{agent}.{name}: Hz of {rate:g} is above ticks_per_sec, {env._ticks_per_sec}")
    every = int(env._ticks_per_sec / rate)
    if abs(every * rate - env._ticks_per_sec) > 1e-6:
        env.advice.once(
            f"{agent}.{name}: {rate:g} Hz does not divide {env._ticks_per_sec} ticks per second; it reads every "
            f"{every} ticks, {env._ticks_per_sec / every:g} Hz"
        )
    sensor["tick_every"] = every
    sockets = kind_of(kind).sockets
    if sensor["socket"] and sensor["socket"] not in sockets:
        env.advice.once(
            f"{agent}.{name}: {kind} has no socket {sensor['socket']!r}{did_you_mean(str(sensor['socket']), sockets)}; "
            "the sensor is at its origin, as in HoloOcean"
        )
    config = sensor["configuration"] or {}
    if "socket" in config:
        env.advice.once(
            f"{agent}.{name}: 'socket' belongs beside 'configuration', not in it; it is ignored, as HoloOcean does"
        )
        config = {k: v for k, v in config.items() if k != "socket"}
    return SensorDefinition(
        agent, kind, name, sensor["sensor_type"], sensor["socket"], sensor["location"], sensor["rotation"], config,
        bool(sensor["existing"]), sensor["lcm_channel"], every,
    )  # fmt: skip
