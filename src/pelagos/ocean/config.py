"""Configuration of the ocean, and the ocean that is built from it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import drjit as dr
import numpy as np
from pydantic import Field, field_validator, model_validator

from pelagos import jit
from pelagos.config.strict import Strict
from pelagos.errors import LookupFailed, ScenarioError
from pelagos.jit import Array
from pelagos.math.geodesy import GeoOrigin
from pelagos.ocean.analytic_current import (
    GyreCurrentConfig,
    JetCurrentConfig,
    ShearCurrentConfig,
    TidalCurrentConfig,
    VortexCurrentConfig,
)
from pelagos.ocean.current import Current, ProfileCurrentConfig, UniformCurrentConfig
from pelagos.ocean.function import PythonCurrentConfig
from pelagos.ocean.gridded import GriddedCurrentConfig
from pelagos.ocean.ocean import Ocean
from pelagos.ocean.plume import DriftingPlumeConfig
from pelagos.ocean.site import Site
from pelagos.ocean.sky import SunConfig, WeatherConfig
from pelagos.ocean.tide import TideConfig, make_tide
from pelagos.ocean.tracer import FieldConfig, FieldsConfig, ScalarField, UniformFieldConfig, components_of, given_for
from pelagos.ocean.turbulence import TurbulentCurrentConfig
from pelagos.ocean.water_column import ProfileConfig, WaterColumn, tabulate
from pelagos.ocean.water_mass import WaterMass, make_water
from pelagos.ocean.wave_system import WavesConfig
from pelagos.ocean.waves import Waves, make_waves
from pelagos.ocean.wind import WindConfig
from pelagos.optics.water import JERLOV_TYPES

if TYPE_CHECKING:
    from pelagos.world.world import World

CurrentConfig: TypeAlias = Annotated[
    UniformCurrentConfig
    | ProfileCurrentConfig
    | ShearCurrentConfig
    | TidalCurrentConfig
    | VortexCurrentConfig
    | JetCurrentConfig
    | GyreCurrentConfig
    | TurbulentCurrentConfig
    | GriddedCurrentConfig
    | PythonCurrentConfig,
    Field(discriminator="type"),
]


class OceanConfig(Strict):
    """Currents, waves, water masses and light."""

    currents: tuple[CurrentConfig, ...] = ()
    """Components of the current, summed; still water where there are none."""
    waves: tuple[WavesConfig, ...] = ()
    """Wave systems, summed (swell and wind sea, for example); a flat surface where there are none."""
    waves_depth_m: float | None = Field(default=None, gt=0)
    """Depth of water that the waves feel [m]; deep water where not given."""
    tide: tuple[TideConfig, ...] = ()
    """Constituents of the tide's level; their streams are currents of type `tidal`."""
    temperature_c: FieldsConfig = 12.0
    """Temperature in situ [degC]: a number, a table against depth, or a list of components that are summed."""
    salinity: FieldsConfig = 35.0
    """Practical salinity [1]: a number, a table against depth, or a list of components that are summed."""
    tracers: dict[str, FieldsConfig] = Field(default_factory=dict)
    """Further quantities by name, as temperature: oxygen [umol/kg], chlorophyll [mg/m^3], turbidity [NTU], ph, a
    dye.
    """
    water_type: str = "II"
    """Optical water type after Jerlov: I, IA, IB, II, III (open ocean), 1C, 3C, 5C, 7C, 9C (coast)."""
    turbidity: float = Field(default=1.0, ge=0, le=100)
    """Factor on the particles of the water type."""
    sun: SunConfig = SunConfig()
    """Where the sun stands."""
    weather: WeatherConfig = WeatherConfig()
    """Clouds, fog and rain."""
    wind: WindConfig = WindConfig()
    """Wind over the surface."""

    @model_validator(mode="before")
    @classmethod
    def _lists(cls, data: Any) -> Any:
        """One mapping stands for a list of one, where it says its type."""
        if isinstance(data, dict):
            for key in ("currents", "waves", "tide"):
                if isinstance(data.get(key), dict):
                    data = {**data, key: [data[key]]}
        return data

    @field_validator("water_type")
    @classmethod
    def _jerlov(cls, value: str) -> str:
        if value not in JERLOV_TYPES:
            raise ValueError(str(LookupFailed("Jerlov water type", value, JERLOV_TYPES)))
        return value

    @field_validator("temperature_c")
    @classmethod
    def _liquid(cls, value: FieldsConfig) -> FieldsConfig:
        return given_for(_between(value, -3, 45, "a temperature of sea water", "degC"), "temperature")

    @field_validator("salinity")
    @classmethod
    def _salty(cls, value: FieldsConfig) -> FieldsConfig:
        return given_for(_between(value, 0, 42, "a practical salinity", ""), "salinity")

    @field_validator("tracers")
    @classmethod
    def _named(cls, value: dict[str, FieldsConfig]) -> dict[str, FieldsConfig]:
        return {name: given_for(fields, name) for name, fields in value.items()}

    @model_validator(mode="after")
    def _shallow(self) -> OceanConfig:
        if self.waves_depth_m is None and any(w.type == "tma" for w in self.waves):
            raise ValueError("waves of type tma need waves_depth_m")
        return self


def check_files(config: OceanConfig, site: Site) -> None:
    """Read every file that the ocean needs, as a run would, without a device.

    Raises:
        ScenarioError: a file is missing, wrong, or does not cover the site although it must.
    """
    parts: list[tuple[str, Any]] = [(f"ocean.currents[{n}]", c) for n, c in enumerate(config.currents)]
    for key, fields in (("temperature_c", config.temperature_c), ("salinity", config.salinity), *(
        (f"tracers.{name}", fields) for name, fields in config.tracers.items()
    )):  # fmt: skip
        parts += [(f"ocean.{key}", c) for c in components_of(fields)]
    for where, part in parts:
        if part.type == "gridded":
            with _said_at(where):
                part.check(site)


def build_ocean(config: OceanConfig, world: World | None = None, *, seed: int = 0, duration_s: float = 0.0) -> Ocean:
    """The ocean on the device.

    Args:
        config: see `OceanConfig`.
        world: gives the place on Earth (gravity, composition of the salt) and its extent; mid-latitude without it.
        seed: of the waves, the gusts and the turbulence.
        duration_s: of the run, which files must cover [s].

    Raises:
        ScenarioError: a file or a function that the ocean needs is missing or wrong.
    """
    site = replace(site_of(world, seed), duration_s=duration_s)
    currents: list[Current] = []
    for number, current in enumerate(config.currents):
        with _said_at(f"ocean.currents[{number}]"):
            currents.append(current.build(site))
    waves = make_waves(config.waves, site, depth=config.waves_depth_m, wind=config.wind.speed_mps or None)
    build = partial(_build, currents=currents, site=site, waves=waves)
    tracers = {}
    for name, f in config.tracers.items():
        with _said_at(f"ocean.tracers.{name}"):
            tracers[name] = [build(c) for c in components_of(f)]
    with _said_at("ocean, temperature_c or salinity"):
        masses = make_water(config.temperature_c, config.salinity, site, build)
    elevation, azimuth = config.sun.angles(site.origin)
    weather = config.weather.weather()
    ocean = Ocean(
        currents=currents,
        masses=masses,
        ballast=_ballast(config, masses, site),
        tracers=tracers,
        waves=waves,
        tide=make_tide(config.tide),
        air=config.wind.build(site),
        sun_elevation=dr.opaque(jit.Float, elevation),
        sun_azimuth=dr.opaque(jit.Float, azimuth),
        water_type=config.water_type,
        turbidity=config.turbidity,
        cloud=weather.cloud,
        visibility=weather.visibility,
        rain=weather.rain,
    )
    return jit.without_constants(ocean)  # every frozen call has it among its arguments


def _ballast(config: OceanConfig, masses: WaterColumn | WaterMass, site: Site) -> Array | None:
    """Density by depth of the water at the surface of the origin, see `Ocean.heaviness`."""
    if not isinstance(config.temperature_c, ProfileConfig | tuple) and not isinstance(
        config.salinity, ProfileConfig | tuple
    ):
        return None
    here, start = jit.Array3f64(0.0, 0.0, 0.0), jit.Float64(0.0)
    t, s = (float(f(here, start)[0]) for f in (masses.temperature, masses.salinity))
    if not (math.isfinite(t) and math.isfinite(s)):
        raise ScenarioError("there is no temperature or salinity at the surface of the world's origin", where="ocean")
    table = jit.Float64(np.ascontiguousarray(tabulate(t, s, site).density))
    jit.align(table)
    return table


@contextmanager
def _said_at(where: str) -> Iterator[None]:
    """Give an error of a file or a function the key that asked for it."""
    try:
        yield
    except ScenarioError as error:
        raise error if error.where else ScenarioError(error.message, where=where) from error


def _build(component: FieldConfig, currents: list[Current], site: Site, waves: Waves | None) -> ScalarField:
    if isinstance(component, DriftingPlumeConfig):
        return component.carried(currents, site, waves)
    return component.build(site)


def site_of(world: World | None, seed: int) -> Site:
    """Site of an ocean in a world; mid-latitude without one."""
    if world is None:
        return Site(GeoOrigin(45.0, -30.0), seed=seed)
    bounds = getattr(world, "bounds", None)
    if bounds is None:
        return Site(world.origin, seed=seed)
    low, high = ((float(x), float(y), float(z)) for x, y, z in bounds)
    return Site(world.origin, (low, high), seed)


def _between(value: FieldsConfig, low: float, high: float, what: str, unit: str) -> FieldsConfig:
    if isinstance(value, tuple):
        numbers: tuple[float, ...] = tuple(c.value for c in value if isinstance(c, UniformFieldConfig))
        low, high = min(low, -100.0), max(high, 100.0)  # components are differences too
    else:
        numbers = value.value if isinstance(value, ProfileConfig) else (value,)
    for number in numbers:
        if not low <= number <= high:
            raise ValueError(f"{what} lies between {low:g} and {high:g} {unit}".rstrip() + f", not {number:g}")
    return value
