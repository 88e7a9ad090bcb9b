"""A HoloOcean scenario as a native one: agents, sensors, tide, waves and light by their native keys."""

from __future__ import annotations

import math
import secrets
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pelagos.compat.holoocean.exceptions import HoloOceanException
from pelagos.compat.holoocean.frames import degrees_of, matrix_of, start_of
from pelagos.compat.holoocean.names import identifier
from pelagos.compat.holoocean.tides import cycle_of
from pelagos.vehicles.load import merged

if TYPE_CHECKING:
    from pelagos.compat.holoocean.agents import HoloOceanAgent
    from pelagos.compat.holoocean.environments import HoloOceanEnvironment
    from pelagos.compat.holoocean.sensor import HoloOceanSensor

SCENARIO_KEYS: Final = frozenset(
    {
        "name", "world", "package_name", "main_agent", "agents", "ticks_per_sec", "frames_per_sec", "env_min",
        "env_max", "octree_min", "octree_max", "window_width", "window_height", "lcm_provider", "weather",
        "tide_cycle", "tide", "time_cycle", "flashlight", "current", "fft_waves", "buoyancy", "legacy_dynamics",
    }
)  # fmt: skip
AGENT_KEYS: Final = frozenset(
    {
        "agent_name", "agent_type", "sensors", "control_scheme", "location", "rotation", "location_randomization",
        "rotation_randomization", "existing", "fossen_model", "control_mode", "dynamics", "actuator", "autopilot",
        "legacy_dynamics",
    }
)  # fmt: skip
SENSOR_KEYS: Final = frozenset(
    {
        "sensor_type", "sensor_name", "socket", "location", "rotation", "Hz", "configuration", "lcm_channel",
        "ros_publish", "existing", "tick_every",
    }
)  # fmt: skip
WIND_OF_SEA_STATE: Final = (0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 13.0, 16.0, 20.0, 30.0)
"""Of HoloOcean's sea states 0 to 9 [m/s]."""
WEATHERS: Final = (
    {"weather.cloud": 0.0, "weather.rain_mm_per_h": 0.0},
    {"weather.cloud": 0.9, "weather.rain_mm_per_h": 0.0},
    {"weather.cloud": 1.0, "weather.rain_mm_per_h": 10.0},
)
"""Sunny, cloudy, rain."""


def world_of(scenario: Mapping[str, Any]) -> dict[str, Any]:
    """The native keys `world` and `ocean` of a scenario's level.

    Raises:
        HoloOceanException: there is no such world.
    """
    from pelagos.compat.holoocean.worlds import native_world

    return native_world(str(scenario.get("package_name", "")), str(scenario["world"]))


def seed_of(env: HoloOceanEnvironment, agents: Iterable[HoloOceanAgent]) -> int:
    """The seed of the native streams: the environment's, mixed with every `RandomSeed` above 0 of a lidar."""
    given = (int(s.config.get("RandomSeed", 0)) for a in agents for s in a.sensors.values())
    chosen = [seed for seed in given if seed > 0]
    return int(np.random.SeedSequence([env.seed, *chosen]).generate_state(1)[0]) if chosen else env.seed


def drawn_seed(scenario: Mapping[str, Any]) -> int:
    """A seed where none was given: the operating system's; 0 where a lidar's `RandomSeed` asks for the same again."""
    sensors = (s for a in scenario["agents"] for s in a.get("sensors", ()))
    fixed = any(int((s.get("configuration") or {}).get("RandomSeed", 0)) > 0 for s in sensors)
    return 0 if fixed else secrets.randbits(31)


def native_scenario(env: HoloOceanEnvironment, agents: Iterable[HoloOceanAgent]) -> dict[str, Any]:
    """Scenario that the native simulation is loaded from."""
    scenario, agents = env._scenario, list(agents)
    found = world_of(scenario)
    ocean = merged(found.get("ocean", {}), _ocean(scenario, env._ticks_per_sec, env._lead))
    return {
        "name": identifier(str(scenario.get("name", "holoocean"))),
        "seed": seed_of(env, agents),
        "tick_rate_hz": float(env._ticks_per_sec),
        "world": found["world"],
        "ocean": ocean,
        "agents": {env.native_name(agent.name): _agent(env, agent) for agent in agents},
    }


def _agent(env: HoloOceanEnvironment, agent: HoloOceanAgent) -> dict[str, Any]:
    vehicle = dict(agent.kind.vehicle)
    if agent.legacy:
        vehicle["modes"] = {**vehicle.get("modes", {}), **agent.kind.legacy}
    sensors = {}
    for sensor in agent.sensors.values():
        keys = native_sensor(env, sensor)
        if keys is not None:
            sensors[identifier(sensor.name)] = keys
    d = agent.definition
    return {
        "vehicle": vehicle, "control": agent.mode, "start": start_of(d.starting_loc, d.starting_rot),
        "sensors": sensors,
    }  # fmt: skip


def native_sensor(env: HoloOceanEnvironment, sensor: HoloOceanSensor) -> dict[str, Any] | None:
    """Keys of a native sensor with its place and rate; None where it needs none."""
    keys = sensor.native()
    if keys is None:
        return None
    rate, fastest = env._ticks_per_sec / sensor.tick_every, sensor.fastest_hz
    if rate > fastest:  # asked for in between, it pings all the same
        rate /= math.ceil(rate / fastest)
    return {**keys, **placed(sensor), "rate_hz": rate}


def placed(sensor: HoloOceanSensor) -> dict[str, Any]:
    """Native place and turn of a sensor."""
    turned = degrees_of(sensor.turned @ matrix_of(sensor.extra))
    return {
        "position_m": [float(v) for v in sensor.offset],
        "orientation_deg": [float(v) for v in turned],
    }


def _ocean(scenario: Mapping[str, Any], ticks_per_sec: int, lead: int) -> dict[str, Any]:
    """Native keys of tide, waves, weather and time of day; `lead`: ticks of the native clock before HoloOcean's."""
    made: dict[str, Any] = {}
    amplitude, ticks, active = cycle_of(scenario, ticks_per_sec)
    if active:
        made["tide"] = [sine_tide(amplitude, ticks / ticks_per_sec, turned=(lead % ticks) / ticks)]
    waves = scenario.get("fft_waves")
    if waves:
        made |= waves_of(waves)
    weather = scenario.get("weather")
    if weather is not None:
        kind = weather.get("type")
        if kind not in (0, 1, 2):
            raise HoloOceanException(f"a weather's type is 0 (sunny), 1 (cloudy) or 2 (rain), not {kind!r}")
        made["weather"] = {k.removeprefix("weather."): v for k, v in WEATHERS[kind].items()}
    cycle = scenario.get("time_cycle")
    if cycle and not cycle.get("active"):
        made["sun"] = sun_of(float(cycle.get("hour", 12)))
    return made


def sine_tide(amplitude: float, period_s: float, *, turned: float = 0.0) -> dict[str, Any]:
    """A tide of A sin(2 pi (t / T - turned))."""
    phase = (90.0 if amplitude >= 0 else -90.0) + 360.0 * turned
    return {"amplitude_m": max(abs(amplitude), 1e-9), "period_h": period_s / 3600, "phase_deg": phase}


def sun_of(hour: float) -> dict[str, Any]:
    """The sun of HoloOcean's hour: up at 6, in the zenith at 12, down at 18."""
    elevation = 90.0 - 15.0 * abs((hour % 24.0) - 12.0)
    return {"elevation_deg": elevation, "azimuth_deg": 90.0 if hour % 24.0 < 12 else 270.0}


def waves_of(waves: Mapping[str, Any]) -> dict[str, Any]:
    """Native waves and wind of `fft_waves`: a fully developed sea of its wind, 0 degrees towards +y (west)."""
    state = waves.get("sea_state", waves.get("SeaState"))
    speed = float(waves.get("wind_speed", waves.get("WindSpeed", 0.0)))
    if state is not None:
        if state not in range(len(WIND_OF_SEA_STATE)):
            raise HoloOceanException(f"a sea state is 0 to 9, not {state!r}")
        speed = WIND_OF_SEA_STATE[int(state)]
    if not speed >= 0:
        raise HoloOceanException(f"the wind of waves is 0 m/s or more, not {speed:g}")
    if speed < 0.5:
        return {}
    towards = float(waves.get("wind_direction", waves.get("WindDirection", 0.0)))
    heading = (270.0 - towards) % 360.0
    return {
        "waves": [{"type": "pierson_moskowitz", "wind_mps": speed, "towards_deg": heading}],
        "wind": {"speed_mps": speed, "from_deg": (heading + 180.0) % 360.0},
    }


def lcm_of(values: Iterable[int]) -> int:
    """Least common multiple."""
    return math.lcm(*values) if values else 1
