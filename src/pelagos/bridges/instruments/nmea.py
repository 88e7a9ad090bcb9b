"""NMEA 0183 sentences, as pure functions.

Source: NMEA 0183 version 4.11; https://gpsd.gitlab.io/gpsd/NMEA.html describes each sentence. Angles are true,
positions WGS 84. A value that is unknown (None or not finite) leaves its field empty.
"""

from __future__ import annotations

import math
from datetime import UTC, datetime, timedelta

from pelagos.math.units import KNOT, LENGTHS


def sentence(body: str) -> bytes:
    """`$body*checksum`, with the end of line."""
    check = 0
    for byte in body.encode("ascii"):
        check ^= byte
    return f"${body}*{check:02X}\r\n".encode("ascii")


def clock(t_ns: int, epoch: datetime) -> datetime:
    """UTC at a simulation time."""
    return epoch.astimezone(UTC) + timedelta(microseconds=t_ns // 1000)


def gga(
    at: datetime,
    latitude_deg: float,
    longitude_deg: float,
    height_m: float,
    *,
    satellites: int = 12,
    talker: str = "GP",
) -> bytes:
    """Position fix; height above mean sea level [m]."""
    return sentence(
        f"{talker}GGA,{_time(at)},{_latitude(latitude_deg)},{_longitude(longitude_deg)},1,{satellites:02d},0.9,"
        f"{height_m:.2f},M,0.0,M,,"
    )


def no_fix(at: datetime, *, talker: str = "GP") -> bytes:
    """GGA and RMC of a receiver without a fix: quality 0, status V, no position."""
    return sentence(f"{talker}GGA,{_time(at)},,,,,0,00,,,M,,M,,") + sentence(
        f"{talker}RMC,{_time(at)},V,,,,,,,{at:%d%m%y},,,N"
    )


def rmc(
    at: datetime, latitude_deg: float, longitude_deg: float, speed_mps: float, course_deg: float, *, talker: str = "GP"
) -> bytes:
    """Position, speed and course over ground."""
    return sentence(
        f"{talker}RMC,{_time(at)},A,{_latitude(latitude_deg)},{_longitude(longitude_deg)},{speed_mps / KNOT:.3f},"
        f"{compass(course_deg)},{at:%d%m%y},,,A"
    )


def vtg(speed_mps: float, course_deg: float, *, talker: str = "GP") -> bytes:
    """Course and speed over ground."""
    return sentence(f"{talker}VTG,{compass(course_deg)},T,,M,{speed_mps / KNOT:.3f},N,{speed_mps * 3.6:.3f},K,A")


def hdt(heading_deg: float, *, talker: str = "HE") -> bytes:
    """True heading."""
    return sentence(f"{talker}HDT,{compass(heading_deg)},T")


def dbt(depth_m: float | None, *, talker: str = "SD") -> bytes:
    """Depth below the transducer."""
    if depth_m is None or not math.isfinite(depth_m):
        return sentence(f"{talker}DBT,,f,,M,,F")
    return sentence(f"{talker}DBT,{depth_m / LENGTHS['ft']:.2f},f,{depth_m:.2f},M,{depth_m / LENGTHS['fathom']:.2f},F")


def xdr_pressure(pressure_pa: float, *, name: str = "DEPTH", talker: str = "YX") -> bytes:
    """Pressure transducer [bar]."""
    return sentence(f"{talker}XDR,P,{pressure_pa / 1e5:.5f},B,{name}")


def _time(at: datetime) -> str:
    return f"{at:%H%M%S}.{at.microsecond // 10000:02d}"


def _latitude(degrees: float) -> str:
    return _angle(degrees, 2, "NS")


def _longitude(degrees: float) -> str:
    return _angle((degrees + 180.0) % 360.0 - 180.0, 3, "EW")


def compass(degrees: float) -> str:
    """A direction from 0.00 to 359.99: rounded before it is turned into that range."""
    return f"{round(degrees, 2) % 360:.2f}"


def _angle(degrees: float, width: int, halves: str) -> str:
    """Degrees and minutes to 1e-5 minutes (2 cm), rounded before they are split so that no minute reads 60."""
    units = round(abs(degrees) * 60 * 100_000)
    whole, rest = divmod(units, 60 * 100_000)
    return f"{whole:0{width}d}{rest / 100_000:08.5f},{halves[degrees < 0]}"
