"""VectorNav IMUs: the text message $VNIMU and the binary output, as pure functions.

Source: VectorNav, VN-100 user manual (UM001), "User configurable binary output messages". Axes forward, right, down; a
level sensor at rest reads an acceleration of -9.81 on z.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Final

from pelagos.bridges.instruments.nmea import sentence

SYNC: Final = 0xFA
GROUP: Final = 0x01  # common
FIELDS: Final = 1 << 0 | 1 << 5 | 1 << 8  # time since start-up, angular rate, acceleration


def text(force: Sequence[float], rate: Sequence[float], *, temperature_c: float = 15.0) -> bytes:
    """$VNIMU without a magnetometer: zeros, acceleration [m/s^2], rate [rad/s], temperature [deg C], pressure [kPa]."""
    a, g = (",".join(f"{v:+0{w}.{d}f}" for v in values) for values, w, d in ((force, 7, 3), (rate, 10, 6)))
    return sentence(f"VNIMU,+00.0000,+00.0000,+00.0000,{a},{g},{temperature_c:+05.1f},+101.325")


def binary(t_ns: int, force: Sequence[float], rate: Sequence[float]) -> bytes:
    """Time [ns], angular rate [rad/s], acceleration [m/s^2]."""
    body = struct.pack("<BHQ3f3f", GROUP, FIELDS, t_ns, *rate, *force)
    return bytes([SYNC]) + body + struct.pack(">H", crc16(body))


def crc16(data: bytes) -> int:
    """CRC-16 CCITT from 0; that of a message with its CRC is 0."""
    crc = 0
    for byte in data:
        crc = (crc >> 8 | crc << 8) & 0xFFFF
        crc ^= byte
        crc ^= (crc & 0xFF) >> 4
        crc ^= crc << 12 & 0xFFFF
        crc ^= (crc & 0xFF) << 5
    return crc
