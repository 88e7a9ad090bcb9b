"""What a scenario says about the ocean, and how the ocean is made of it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, TypeAlias

import drjit as dr
from pydantic import Field, field_validator

from pelagos import jit
from pelagos.config.strict import Strict
from pelagos.errors import LookupFailed
from pelagos.math.geodesy import GeoOrigin
from pelagos.ocean.analytic_current import (
    GyreCurrentConfig,
    JetCurrentConfig,
    ShearCurrentConfig,
    TidalCurrentConfig,
    VortexCurrentConfig,
)
from pelagos.ocean.current import ProfileCurrentConfig, UniformCurrentConfig, components
from pelagos.ocean.ocean import Ocean
from pelagos.ocean.site import Site
from pelagos.ocean.water_column import ProfileConfig, tabulate
from pelagos.ocean.waves import WavesConfig, build_waves
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
    | GyreCurrentConfig,
    Field(discriminator="type"),
]


class SunConfig(Strict):
    """Where the sun stands."""

    elevation_deg: float = Field(default=45.0, ge=-90, le=90)
    """Above the horizon [deg]."""
    azimuth_deg: float = Field(default=180.0, ge=-360, le=360)
    """Compass direction of the sun [deg]: 90 east, 180 south."""


class WindConfig(Strict):
    """A steady wind."""

    speed_mps: float = Field(default=0.0, ge=0, le=100)
    """Mean speed 10 m above the surface [m/s]."""
    from_deg: float = Field(default=0.0, ge=-360, le=360)
    """Compass direction that the wind comes from [deg]: 270 is a west wind."""


class OceanConfig(Strict):
    """Currents, waves, water masses and light."""

    currents: tuple[CurrentConfig, ...] = ()
    """Components of the current, summed; still water where there are none."""
    waves: tuple[WavesConfig, ...] = ()
    """Wave systems, summed; a flat surface where there are none."""
    waves_depth_m: float | None = Field(default=None, gt=0)
    """Depth of water that the waves feel [m]; deep water where not given."""
    temperature_c: float | ProfileConfig = 12.0
    """Temperature in situ [degC]: a number, or a table against depth."""
    salinity: float | ProfileConfig = 35.0
    """Practical salinity [1]: a number, or a table against depth."""
    water_type: str = "II"
    """Optical water type after Jerlov: I, IA, IB, II, III (open ocean), 1C, 3C, 5C, 7C, 9C (coast)."""
    turbidity: float = Field(default=1.0, ge=0, le=100)
    """Factor on the particles of the water type."""
    sun: SunConfig = SunConfig()
    """Where the sun stands."""
    wind: WindConfig = WindConfig()
    """Wind over the surface."""

    @field_validator("water_type")
    @classmethod
    def _jerlov(cls, value: str) -> str:
        if value not in JERLOV_TYPES:
            raise ValueError(str(LookupFailed("Jerlov water type", value, JERLOV_TYPES)))
        return value

    @field_validator("temperature_c")
    @classmethod
    def _liquid(cls, value: float | ProfileConfig) -> float | ProfileConfig:
        return _between(value, -3, 45, "a temperature of sea water", "degC")

    @field_validator("salinity")
    @classmethod
    def _salty(cls, value: float | ProfileConfig) -> float | ProfileConfig:
        return _between(value, 0, 42, "a practical salinity", "")


def build_ocean(config: OceanConfig, world: World | None = None, *, seed: int = 0) -> Ocean:
    """The ocean on the device.

    Args:
        config: see `OceanConfig`.
        world: gives the place on Earth (gravity, composition of the salt); mid-latitude without it.
        seed: of the waves' phases.
    """
    site = _site(world, seed)
    profiles = tabulate(config.temperature_c, config.salinity, site)
    north, west = components(config.wind.speed_mps, config.wind.from_deg + 180.0)
    return Ocean(
        currents=[current.build(site) for current in config.currents],
        column=profiles.column(),
        waves=build_waves(config.waves, depth=config.waves_depth_m, seed=seed),
        sun_elevation=dr.opaque(jit.Float, math.radians(config.sun.elevation_deg)),
        sun_azimuth=dr.opaque(jit.Float, math.radians(config.sun.azimuth_deg)),
        wind=dr.opaque(jit.Array3f64, [north, west, 0.0]),
        water_type=config.water_type,
        turbidity=config.turbidity,
    )


def _site(world: World | None, seed: int) -> Site:
    if world is None:
        return Site(GeoOrigin(45.0, -30.0), seed=seed)
    bounds = getattr(world, "bounds", None)
    if bounds is None:
        return Site(world.origin, seed=seed)
    low, high = ((float(x), float(y), float(z)) for x, y, z in bounds)
    return Site(world.origin, (low, high), seed)


def _between(value: float | ProfileConfig, low: float, high: float, what: str, unit: str) -> float | ProfileConfig:
    for number in value.value if isinstance(value, ProfileConfig) else (value,):
        if not low <= number <= high:
            raise ValueError(f"{what} lies between {low} and {high} {unit}".rstrip() + f", not {number:g}")
    return value
