"""Teledyne RD Instruments: the text format PD6 and the binary ensemble PD0 of a bottom-tracking DVL, as pure functions.

Source: Teledyne RDI, Workhorse Navigator manual, "Output data format". Ship coordinates: starboard, forward, up.
PD6 gives the ship's movement; PD0 gives the bottom's, as the instrument sees it: the same with the opposite sign.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from datetime import datetime
from typing import Final

from pelagos.bridges.instruments.dvl_velocity import DvlVelocity
from pelagos.bridges.instruments.nmea import clock, compass

BAD: Final = -32768
SHIP_COORDINATES: Final = 0b00010111
_SYSTEM: Final = 0b0100_0000_0000_1011  # 600 kHz, convex, four beams, looking down
_BEAM_ANGLES: Final = {15: 0, 20: 1, 30: 2}
_OTHER_ANGLE: Final = 3
_LONGEST_S: Final = 999.99  # what the field holds


@dataclass(frozen=True)
class Attitude:
    """Attitude of the instrument: heading, pitch (nose up), roll (starboard down) [deg], and depth [m]."""

    heading_deg: float
    pitch_deg: float
    roll_deg: float
    depth_m: float


@dataclass(frozen=True)
class MadeGood:
    """The way over ground of an instrument, added up from its own velocities.

    Attributes:
        distance_m: east, north, up [m].
        before_ns: time of the last velocity that was good [ns]; None before the first.
        since_s: time since then [s].
    """

    distance_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    before_ns: int | None = None
    since_s: float = 0.0

    def after(self, dvl: DvlVelocity, attitude: Attitude) -> MadeGood:
        """With another ping; one that is not good adds no way, and the next good one stands for the gap."""
        elapsed = 0.0 if self.before_ns is None else (dvl.t_ns - self.before_ns) * 1e-9
        if dvl.velocity is None:
            return MadeGood(self.distance_m, self.before_ns, elapsed)
        east, north, up = (
            d + v * elapsed for d, v in zip(self.distance_m, east_north_up(dvl.velocity, attitude), strict=True)
        )
        return MadeGood((east, north, up), dvl.t_ns, 0.0)


def east_north_up(velocity: tuple[float, float, float], attitude: Attitude) -> tuple[float, float, float]:
    """Of a velocity forward, right, down of the instrument: R = Rz(heading) Ry(pitch) Rx(roll)."""
    u, v, w = velocity
    angles = (attitude.heading_deg, attitude.pitch_deg, attitude.roll_deg)
    (sy, sp, sr), (cy, cp, cr) = ([f(math.radians(a)) for a in angles] for f in (math.sin, math.cos))
    north = cy * cp * u + (cy * sp * sr - sy * cr) * v + (cy * sp * cr + sy * sr) * w
    east = sy * cp * u + (sy * sp * sr + cy * cr) * v + (sy * sp * cr - cy * sr) * w
    return east, north, sp * u - cp * sr * v - cp * cr * w


def pd6(dvl: DvlVelocity, epoch: datetime, attitude: Attitude, sound_speed_mps: float, made_good: MadeGood) -> bytes:
    """Attitude, timing, bottom track in instrument, ship and earth coordinates, and distance."""
    at = clock(dvl.t_ns, epoch)
    x, y, z = dvl.velocity or (math.nan,) * 3
    flag = "A" if dvl.velocity is not None else "V"
    lost = (math.nan,) * 3
    east, north, up = lost if dvl.velocity is None else east_north_up(dvl.velocity, attitude)
    way = ",".join(f"{d:+012.2f}" for d in made_good.distance_m)
    height = 0.0 if dvl.altitude_m is None else dvl.altitude_m
    lines = [
        f":SA,{attitude.pitch_deg:+06.2f},{attitude.roll_deg:+06.2f},{compass(attitude.heading_deg):>06}",
        f":TS,{at:%y%m%d%H%M%S}{at.microsecond // 10000:02d},35.0,+15.0,{attitude.depth_m:06.1f},"
        f"{sound_speed_mps:06.1f},  0",
        f":BI,{_mm(y)},{_mm(x)},{_mm(-z)},{_mm(0.0 if dvl.velocity else math.nan)},{flag}",
        f":BS,{_mm(y)},{_mm(x)},{_mm(-z)},{flag}",
        f":BE,{_mm(east)},{_mm(north)},{_mm(up)},{flag}",
        f":BD,{way},{min(height, 9999.99):07.2f},{min(made_good.since_s, _LONGEST_S):06.2f}",
    ]
    return "".join(line + "\r\n" for line in lines).encode("ascii")


def _mm(mps: float) -> str:
    """[mm/s], signed, five digits; -32768 where unknown."""
    return f"{round(mps * 1000):+06d}" if math.isfinite(mps) else f"{BAD:+06d}"


def pd0(
    dvl: DvlVelocity, epoch: datetime, attitude: Attitude, sound_speed_mps: float, number: int,
    down: tuple[float, ...],
) -> bytes:  # fmt: skip
    """An ensemble of fixed leader, variable leader and bottom track.

    `down` is the downward part of each beam's direction. The ranges are the vertical ones of a level instrument:
    along the beam, times the cosine of the beam's angle.
    """
    parts = [
        _fixed_leader(down), _variable_leader(dvl, epoch, attitude, sound_speed_mps, number), _bottom_track(dvl, down),
    ]  # fmt: skip
    head = 6 + 2 * len(parts)
    offsets, at = [], head
    for part in parts:
        offsets.append(at)
        at += len(part)
    body = b"".join(parts) + b"\0\0"
    raw = struct.pack(f"<BBHBB{len(parts)}H", 0x7F, 0x7F, head + len(body), 0, len(parts), *offsets) + body
    return raw + struct.pack("<H", sum(raw) & 0xFFFF)


def _fixed_leader(down: tuple[float, ...]) -> bytes:
    raw = bytearray(59)
    angle = round(math.degrees(math.acos(sum(down) / len(down))))
    system = _SYSTEM | _BEAM_ANGLES.get(angle, _OTHER_ANGLE) << 8
    struct.pack_into("<HBBHBBBBH", raw, 0, 0x0000, 51, 40, system, 1, 0, 4, 1, 1)
    struct.pack_into("<HHB", raw, 12, 100, 100, 1)
    raw[25] = SHIP_COORDINATES
    raw[30:32] = bytes([0b01111101, 0b01111101])
    raw[58] = angle
    return bytes(raw)


def _variable_leader(
    dvl: DvlVelocity, epoch: datetime, attitude: Attitude, sound_speed_mps: float, number: int
) -> bytes:
    at = clock(dvl.t_ns, epoch)
    time = (at.month, at.day, at.hour, at.minute, at.second, at.microsecond // 10000)
    raw = bytearray(65)
    struct.pack_into("<HH7BB", raw, 0, 0x0080, number & 0xFFFF, at.year % 100, *time, (number >> 16) & 0xFF)
    struct.pack_into(
        "<HHHhhHh", raw, 14, round(sound_speed_mps), max(0, round(10 * attitude.depth_m)),
        round(100 * (attitude.heading_deg % 360)) % 36000, round(100 * attitude.pitch_deg),
        round(100 * attitude.roll_deg), 35, 1500,
    )  # fmt: skip
    struct.pack_into("<8B", raw, 57, at.year // 100, at.year % 100, *time)
    return bytes(raw)


def _bottom_track(dvl: DvlVelocity, down: tuple[float, ...]) -> bytes:
    raw = bytearray(81)
    struct.pack_into("<HHHBBBBH", raw, 0, 0x0600, 1, 0, 220, 30, 0, 7, 1000)
    centimetres = [
        min(round(100 * r * d), 0xFFFFFF) if good and math.isfinite(r) else 0
        for r, d, good in zip(dvl.ranges_m, down, dvl.beam_valid, strict=True)
    ]
    struct.pack_into("<4H", raw, 16, *(c & 0xFFFF for c in centimetres))
    if dvl.velocity is None:
        velocities = [BAD] * 4
    else:
        x, y, z = dvl.velocity
        velocities = [_clipped(-y), _clipped(-x), _clipped(z), 0]
    struct.pack_into("<4h", raw, 24, *velocities)
    good = [255 if g else 0 for g in dvl.beam_valid]
    struct.pack_into(
        "<12B", raw, 32, *good, *(120 if g else 20 for g in dvl.beam_valid), *(100 if g else 0 for g in good)
    )
    struct.pack_into("<4B", raw, 77, *(c >> 16 for c in centimetres))
    return bytes(raw)


def _clipped(mps: float) -> int:
    return min(max(round(1000 * mps), -32767), 32767)
