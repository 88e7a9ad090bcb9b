"""Configuration of the sun and the weather."""

from __future__ import annotations

import math
from datetime import datetime
from typing import Self

from pydantic import Field, model_validator

from pelagos.config.strict import Strict
from pelagos.math.geodesy import GeoOrigin
from pelagos.optics.atmosphere import Weather
from pelagos.optics.sun_position import sun_position


class SunConfig(Strict):
    """Place of the sun: as told, or by date and time at the world's origin."""

    elevation_deg: float = Field(default=45.0, ge=-90, le=90)
    """Above the horizon [deg]."""
    azimuth_deg: float = Field(default=180.0, ge=-360, le=360)
    """Compass direction of the sun [deg]: 90 east, 180 south."""
    time: datetime | None = None
    """Moment, ISO 8601 with its time zone (2026-06-21T12:00:00Z), instead of elevation and azimuth."""

    @model_validator(mode="after")
    def _either(self) -> Self:
        if self.time is not None:
            if self.model_fields_set & {"elevation_deg", "azimuth_deg"}:
                raise ValueError("give either time, or elevation_deg and azimuth_deg")
            if self.time.tzinfo is None:
                raise ValueError(f"time needs its time zone: {self.time.isoformat()}Z for UTC")
        return self

    def angles(self, origin: GeoOrigin) -> tuple[float, float]:
        """Elevation and compass azimuth [rad]."""
        if self.time is not None:
            return sun_position(self.time, origin.latitude, origin.longitude)
        return math.radians(self.elevation_deg), math.radians(self.azimuth_deg)


class WeatherConfig(Strict):
    """Clouds, fog and rain, for cameras and for laser scanners above water."""

    cloud: float = Field(default=0.0, ge=0, le=1)
    """Share of the sky that is covered: 0 clear, 1 overcast."""
    visibility_m: float | None = Field(default=None, ge=10)
    """Meteorological optical range [m]: 5 % of a beam are left over this way; below 1000 m it is fog. None is clear."""
    rain_mm_per_h: float = Field(default=0.0, ge=0, le=200)
    """Rate of rainfall [mm/h]: 2 is light, 10 heavy, 50 violent."""

    def weather(self) -> Weather:
        """As plain numbers."""
        seen = math.inf if self.visibility_m is None else self.visibility_m
        return Weather(self.cloud, seen, self.rain_mm_per_h)
