"""MicroStrain inertial sensors: packets of the MIP protocol, as a pure function.

Source: MicroStrain by HBK, MIP protocol, "Packet format" and "Sensor data (0x80)": big-endian fields, Fletcher's
checksum of 16 bits. Axes forward, right, down; a level sensor at rest reads -1 g on z.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Final

from pelagos.math.constants import STANDARD_GRAVITY

SYNC: Final = b"ue"  # 0x75 0x65
SENSOR_DATA: Final = 0x80
SCALED_ACCELERATION, SCALED_RATE, REFERENCE_TIME = 0x04, 0x05, 0xD5


def inertial(t_ns: int, force: Sequence[float], rate: Sequence[float]) -> bytes:
    """Specific force (3,) [m/s^2], told in g, rate (3,) [rad/s], and the time since start-up [ns]."""
    return packet(
        SENSOR_DATA,
        field(SCALED_ACCELERATION, struct.pack(">3f", *(f / STANDARD_GRAVITY for f in force)))
        + field(SCALED_RATE, struct.pack(">3f", *rate))
        + field(REFERENCE_TIME, struct.pack(">Q", t_ns)),
    )


def field(descriptor: int, data: bytes) -> bytes:
    """A field: its length with its own two bytes, its descriptor, its data."""
    return bytes([len(data) + 2, descriptor]) + data


def packet(descriptor_set: int, fields: bytes) -> bytes:
    """Fields in a packet with its checksum."""
    raw = SYNC + bytes([descriptor_set, len(fields)]) + fields
    return raw + fletcher(raw)


def fletcher(raw: bytes) -> bytes:
    """Fletcher's checksum: two sums modulo 256, the plain one first."""
    first = second = 0
    for byte in raw:
        first = (first + byte) & 0xFF
        second = (second + first) & 0xFF
    return bytes([first, second])
