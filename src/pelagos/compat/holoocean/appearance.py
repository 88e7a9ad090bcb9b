"""Effects of HoloOcean's environment on water, air, light and the spectator's view."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np

from pelagos.compat.holoocean.exceptions import HoloOceanException, named, three
from pelagos.compat.holoocean.flashlight import Flashlights
from pelagos.compat.holoocean.frames import matrix_of, quaternion_of
from pelagos.compat.holoocean.names import identifier
from pelagos.compat.holoocean.native_scenario import WEATHERS, sun_of, waves_of
from pelagos.compat.holoocean.tides import TIDE_KEYS, TideController, cycle_of, level_of
from pelagos.compat.holoocean.time_cycle import TimeController
from pelagos.compat.holoocean.weather import WeatherController
from pelagos.sim.simulation import Simulation

if TYPE_CHECKING:
    from pelagos.compat.holoocean.environments import HoloOceanEnvironment
    from pelagos.compat.holoocean.sensor import HoloOceanSensor

_HEAVY_RAIN: Final = (10.0, 3000.0)  # [mm/h] of so many drops, HoloOcean's own number
_WATERS: Final = (("I", 3.0), ("II", 1.6), ("III", 1.0), ("3C", 0.75), ("5C", 0.55), ("7C", 0.4), ("9C", 0.0))
"""Jerlov types by the least ratio of blue to green that they stand for."""
_WAVES: Final = {"SeaState": "sea_state", "WindSpeed": "wind_speed", "WindDirection": "wind_direction"}
"""Keys of waves in HoloOcean's commands, and what scenarios call them."""


class Appearance:
    """See the module."""

    viewport: tuple[Any, Any] | None
    viewport_on: bool
    viewport_shown: Any
    sea_level: float

    def _begin_appearance(self) -> None:
        env = cast("HoloOceanEnvironment", self)
        if not hasattr(self, "_ocean_keys"):
            self._ocean_keys: dict[str, Any] = {}
            self._turbidity: float | None = None
            self.sea_level = level_of(env._scenario)
            self._level_asked = self.sea_level != 0.0
            self.viewport, self.viewport_on, self.viewport_shown = None, True, None
            self._currents: dict[str, Any] = {}
            self._current_set = False
        self._currents = {}
        self._pending: dict[str, Any] = {}
        self._lit: set[str] = set()
        self.flashlights = Flashlights(env)
        self.weather = WeatherController(env, env._scenario.get("weather", {}).get("type"))
        cycle = env._scenario.get("time_cycle", {})
        self.time_cycle = TimeController(
            env, cycle.get("frequency", 0), cycle.get("hour", 12), cycle.get("active", False)
        )
        amplitude, ticks, active = cycle_of(env._scenario, env._ticks_per_sec)
        self.tide_cycle = TideController(env, amplitude, ticks, "TideNormal", active)
        tide = env._scenario.get("tide") or {}
        env.advice.unknown("tide", tide, TIDE_KEYS)
        if "max_rate" in tide:
            env.advice.once("tide: max_rate changes nothing: a level is there at once")
        self.tides = self.tide_cycle
        self.fftwaves = self

    # asked for by scripts; done at the next tick

    def change_weather(self, weather_type: int) -> None:
        """0 sunny, 1 cloudy, 2 rain.

        Raises:
            HoloOceanException: another number.
        """
        if weather_type not in (0, 1, 2):
            raise HoloOceanException(f"a weather is 0 (sunny), 1 (cloudy) or 2 (rain), not {weather_type!r}")
        self.weather.cur_weather = int(weather_type)
        self._pending |= WEATHERS[int(weather_type)]

    def set_rain_parameters(self, vel_x: float, vel_y: float, vel_z: float, spawnRate: float) -> None:
        """Set the rain: `spawnRate` of 3000 is 10 mm/h; drops fall as drops do, whatever velocity is given."""
        cast("HoloOceanEnvironment", self).advice.once(
            "drops of rain fall at their own speed here: vel_x, vel_y, vel_z change nothing"
        )
        self._pending["weather.rain_mm_per_h"] = min(float(spawnRate) * _HEAVY_RAIN[0] / _HEAVY_RAIN[1], 200.0)

    def change_time_of_day(self, hour: float) -> None:
        """Hour 0 to 24: the sun is up at 6, in the zenith at 12, down at 18."""
        self._pending |= {f"sun.{key}": value for key, value in sun_of(float(hour)).items()}

    def water_color(self, r: float, g: float, b: float) -> None:
        """The optical water type whose colour is nearest to this: by the ratio of blue to green."""
        ratio = float(b) / max(float(g), 1e-3)
        self._pending["water_type"] = next(name for name, least in _WATERS if ratio >= least)

    def water_fog(
        self,
        fogDensity: float,
        fogDepth: float = 3.0,
        color_R: float = 0.4,
        color_G: float = 0.6,
        color_B: float = 1.0,
    ) -> None:
        """Turbid water of a colour: `fogDensity` 0 to 10 multiplies its particles by up to 100; 0: the world's."""
        density = min(max(float(fogDensity), 0.0), 10.0)
        if density > 0:
            self._turbidity = 10.0 ** (0.2 * density)
            self.water_color(color_R, color_G, color_B)
            return
        own = (cast("HoloOceanEnvironment", self)._native or {}).get("ocean", {})
        self._turbidity = float(own.get("turbidity", 1.0))
        if "water_type" in own:
            self._pending["water_type"] = own["water_type"]

    def air_fog(
        self,
        fogDensity: float,
        fogDepth: float = 3.0,
        color_R: float = 0.45,
        color_G: float = 0.5,
        color_B: float = 0.6,
    ) -> None:
        """Fog over the water: `fogDensity` 0 to 10, a visibility from clear to 20 m."""
        density = min(max(float(fogDensity), 0.0), 10.0)
        self._pending["weather.visibility_m"] = None if density == 0 else 200.0 / density

    def tide(self, adjustment: float, absolute: Any = 1, *, choice: Any = None) -> None:
        """Set the level of the sea [m], or with `absolute` false shift it."""
        wanted = absolute if choice is None else choice
        self.sea_level = float(adjustment) + (0.0 if wanted else self.sea_level)
        self._level_asked = True

    def turn_on_flashlight(self, flashlight_name: str, *values: Any, agent_tag: str | None = None, **keys: Any) -> None:
        """A lamp on every vehicle, or on that of `agent_tag`; see `flashlight.Lamp`."""
        self.flashlights.turn_on(flashlight_name, values, keys, agent_tag)

    def turn_off_flashlight(self, flashlight_name: str, agent_tag: str | None = None) -> None:
        """Put it out."""
        self.flashlights.turn_off(flashlight_name, agent_tag)

    def set_ocean_currents(self, agent_name: str, vehicle_current: Sequence[float]) -> None:
        """The current about one agent, world [m/s], until it is set again or reset.

        Raises:
            KeyError: no such agent.
        """
        env = cast("HoloOceanEnvironment", self)
        agent = named("agent", agent_name, env.agents)
        x, y, z = three(f"{agent_name}: a current [m/s]", vehicle_current)
        velocity = (x, y, z)
        agent.current, agent.changed = velocity, agent.changed or agent.legacy
        if not agent.legacy:
            self._currents[agent_name] = velocity

    set_ocean_current = set_ocean_currents

    def fft_sea_state(self, sea_state: int) -> None:
        """Another sea state, 0 to 9; takes the time of a new start of the native simulation.

        Raises:
            HoloOceanException: another number.
        """
        self._change_waves({"sea_state": sea_state})

    def fft_wave_scalars(self, values: dict[str, Any]) -> None:
        """`WindSpeed` and `WindDirection` of the waves; other numbers shape HoloOcean's own spectra only.

        Raises:
            HoloOceanException: a wind below zero.
        """
        given = {_WAVES.get(k, k): v for k, v in values.items()}
        idle = [k for k in given if k not in ("wind_speed", "wind_direction")]
        if idle:
            cast("HoloOceanEnvironment", self).advice.once(
                f"{', '.join(idle)}: waves follow a measured spectrum here; these change nothing"
            )
        self._change_waves({"sea_state": None, **{k: v for k, v in given.items() if k not in idle}})

    def _change_waves(self, changes: dict[str, Any]) -> None:
        """Waves of the scenario as they are, but for some keys, from the next tick on."""
        env = cast("HoloOceanEnvironment", self)
        before = env._scenario.get("fft_waves") or {}
        after = {**{_WAVES.get(k, k): v for k, v in before.items()}, **changes}
        waves_of(after)  # refuses what cannot be before anything is changed
        env._scenario["fft_waves"], env._stale = after, True

    def fft_wave_cascades(self, values: dict[str, Any]) -> None:
        """Accepted: waves follow a measured spectrum here, without cascades."""
        cast("HoloOceanEnvironment", self).advice.once("waves follow a measured spectrum here; cascades change nothing")

    sea_state, wave_scalars, wave_cascades = fft_sea_state, fft_wave_scalars, fft_wave_cascades

    def change_buoyancy(self, buoyancy: int) -> None:
        """Accepted: buoyancy is that of the hull's own shape here, in both of HoloOcean's ways."""

    def enable_world_collisions(self, enabled: bool) -> None:
        """Accepted where true; without collisions there is nothing that Pelagos could do alike."""
        if not enabled:
            raise HoloOceanException("collisions with the world cannot be switched off in Pelagos")

    def debug_lines(self, name: str) -> None:
        """Accepted: lines are drawn in an engine's window, which is not there."""

    # the spectator

    def move_viewport(self, location: Sequence[float], rotation: Sequence[float]) -> None:
        """Put the spectator's camera somewhere: what `ViewportCapture` sees from then on."""
        self.viewport = (np.asarray(location, dtype=float), np.asarray(rotation, dtype=float))

    def should_render_viewport(self, render_viewport: bool) -> None:
        """Whether the spectator's picture is taken anew; off, the last stays."""
        self.viewport_on = bool(render_viewport)

    def set_render_quality(self, render_quality: int, should_keep_fps: bool = False) -> None:
        """Accepted: pictures have one quality; the native camera's `samples` smooths edges."""
        cast("HoloOceanEnvironment", self).advice.once(
            "render quality changes nothing here; env.pelagos.set('auv0.Camera', samples=4) smooths pictures"
        )

    def viewport_picture(self, sensor: HoloOceanSensor) -> Any:
        """Picture of the spectator's camera."""
        env = cast("HoloOceanEnvironment", self)
        assert self.viewport is not None
        location, rotation = self.viewport
        turned = matrix_of(rotation) @ sensor.turned.T  # of the body that would carry the camera there
        from pelagos.compat.holoocean.frames import degrees_of

        reading = env.pelagos.observe(
            env.native_name(sensor.agent_name), location - turned @ sensor.offset, quaternion_of(degrees_of(turned)),
            sensors=[identifier(sensor.name)],
        )[identifier(sensor.name)]  # fmt: skip
        return cast("Any", sensor).picture(reading.data[0])

    # handing it over

    @property
    def _cycles_run(self) -> bool:
        """Something of time or tide changes by itself at ticks."""
        return bool(self.time_cycle.active)

    def _cycle(self) -> None:
        if self.time_cycle.active:
            self.time_cycle.tick(cast("HoloOceanEnvironment", self)._num_ticks)
        self.tide_cycle.follow()

    def _change_surroundings(self, sim: Simulation) -> None:
        """Make the changes that were asked for since the last tick."""
        if self._pending:
            self._ocean_keys |= self._pending
            keys, self._pending = self._pending, {}
            now = sim.scenario.ocean.model_dump(mode="json")
            if any(_at(now, key) != value for key, value in keys.items()):
                sim.ocean.set(keys=keys)
        if self._turbidity is not None and self._turbidity != sim.scenario.ocean.turbidity:
            sim.ocean.set(turbidity=self._turbidity)
        if self._level_asked:
            sim.ocean.set(level_m=self.sea_level)
            self._level_asked = False
        if self._currents:
            self._set_currents(sim)
        if self._lit:
            self._relight(sim)

    def _set_currents(self, sim: Simulation) -> None:
        env = cast("HoloOceanEnvironment", self)
        asked, self._currents, self._current_set = self._currents, {}, True
        if len(env.agents) == 1:
            sim.ocean.set(current=next(iter(asked.values())))
            return
        for name, velocity in asked.items():
            sim.ocean.set(current=velocity, agent=env.native_name(name))

    def _relight(self, sim: Simulation) -> None:
        env = cast("HoloOceanEnvironment", self)
        names, self._lit = self._lit, set()
        for name in names:
            for sensor in env.agents[name].sensors.values():
                lamps = (sensor.native() or {}).get("lamps")
                if lamps is not None:
                    sim.set(f"{env.native_name(name)}.{identifier(sensor.name)}", lamps=lamps)

    def _restore_surroundings(self, *, fresh: bool) -> None:
        """After the native simulation was made anew: what had been changed."""
        env = cast("HoloOceanEnvironment", self)
        self._pending = {**self._ocean_keys, **self._pending}
        self._level_asked = self._level_asked or self.sea_level != 0.0
        if fresh:
            sim = env._sim
            if self._current_set and sim is not None and sim.stepper.own_current is not None:
                sim.ocean.set(current=(0.0, 0.0, 0.0))  # None would build all sensors anew
            self._current_set = False
        else:
            self._currents |= {n: a.current for n, a in env.agents.items() if a.current is not None and not a.legacy}
            env._restore_props()

    def lamps_of(self, agent: str) -> dict[str, Any]:
        """Keys of a native camera: the lamps that are lit on an agent."""
        return {"lamps": self.flashlights.native(agent)}


def _at(data: Any, path: str) -> Any:
    for key in path.split("."):
        data = data.get(key) if isinstance(data, dict) else None
    return data
