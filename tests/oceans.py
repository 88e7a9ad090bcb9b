"""Oceans for sensors that are tested without a world."""

from __future__ import annotations

from typing import Any

from pelagos import jit
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.ocean import Ocean
from pelagos.optics.atmosphere import Weather


def lit_ocean(water: str, sun: float = 1.0, azimuth: float = 0.0, weather: Weather | None = None, **keys: Any) -> Ocean:
    """Of a Jerlov type, flat, the sun `sun` over the horizon at `azimuth` of the compass [rad]; `keys`: config."""
    sky = weather or Weather()
    return build_ocean(OceanConfig(water_type=water, **keys)).with_(
        sun_elevation=jit.Float(sun),
        sun_azimuth=jit.Float(azimuth),
        cloud=sky.cloud,
        visibility=sky.visibility,
        rain=sky.rain,
    )
