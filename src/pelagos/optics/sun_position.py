"""Position of the sun at a moment and place on Earth.

The Astronomical Almanac's approximation (J. J. Michalsky, Solar Energy 40:227, 1988, doi
10.1016/0038-092X(88)90045-X): within 0.01 deg from 1950 to 2050, with refraction by the air.
"""

from __future__ import annotations

import math
from datetime import UTC, datetime

_EPOCH = datetime(2000, 1, 1, 12, tzinfo=UTC)


def sun_position(moment: datetime, latitude: float, longitude: float) -> tuple[float, float]:
    """Elevation over the horizon, with refraction, and compass azimuth [rad].

    Args:
        moment: with its time zone.
        latitude, longitude: [deg], north and east positive.
    """
    days = (moment - _EPOCH).total_seconds() / 86_400.0
    mean_longitude = math.radians((280.460 + 0.9856474 * days) % 360)
    anomaly = math.radians((357.528 + 0.9856003 * days) % 360)
    ecliptic = mean_longitude + math.radians(1.915 * math.sin(anomaly) + 0.020 * math.sin(2 * anomaly))
    obliquity = math.radians(23.439 - 4e-7 * days)
    ascension = math.atan2(math.cos(obliquity) * math.sin(ecliptic), math.cos(ecliptic))
    declination = math.asin(math.sin(obliquity) * math.sin(ecliptic))
    utc = moment.astimezone(UTC)
    hours = utc.hour + utc.minute / 60 + (utc.second + utc.microsecond * 1e-6) / 3600
    sidereal = math.radians((6.697375 + 0.0657098242 * days + hours) % 24 * 15 + longitude)
    hour_angle = sidereal - ascension
    lat = math.radians(latitude)
    sine = math.sin(declination) * math.sin(lat) + math.cos(declination) * math.cos(lat) * math.cos(hour_angle)
    elevation = math.asin(max(-1.0, min(1.0, sine)))
    azimuth = math.atan2(
        -math.sin(hour_angle), math.tan(declination) * math.cos(lat) - math.sin(lat) * math.cos(hour_angle)
    )
    return elevation + refraction(elevation), azimuth % (2 * math.pi)


def refraction(elevation: float) -> float:
    """By how much the air lifts the sun [rad], standard atmosphere (Michalsky 1988, Eq. for the Almanac, which holds
    from -0.56 degrees on); not at all a sun that has set.
    """
    degrees = math.degrees(elevation)
    if degrees <= -0.56:
        return 0.0
    lifted = 3.51561 * (0.1594 + 0.0196 * degrees + 2e-5 * degrees**2) / (1 + 0.505 * degrees + 0.0845 * degrees**2)
    return math.radians(lifted)
