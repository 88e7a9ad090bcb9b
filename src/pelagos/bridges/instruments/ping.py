"""Blue Robotics' ping protocol, as pure functions: frames, and the messages of Ping1D and Ping360.

Source: https://docs.bluerobotics.com/ping-protocol/ (version 1.0).
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from typing import Final

ACK, NACK, GENERAL_REQUEST = 1, 2, 6
DEVICE_INFORMATION, PROTOCOL_VERSION = 4, 5
SET_SPEED_OF_SOUND, SET_RANGE, SET_MODE_AUTO, SET_PING_INTERVAL, SET_GAIN, SET_PING_ENABLE = (
    1002, 1001, 1003, 1004, 1005, 1006,
)  # fmt: skip
SPEED_OF_SOUND, RANGE, MODE_AUTO, PING_INTERVAL, GAIN, GENERAL_INFO = 1203, 1204, 1205, 1206, 1207, 1210
DISTANCE_SIMPLE, DISTANCE, PING_ENABLE, PROFILE = 1211, 1212, 1215, 1300
SET_DEVICE_ID, FIRMWARE_VERSION, DEVICE_ID, VOLTAGE_5, TRANSMIT_DURATION = 1000, 1200, 1201, 1202, 1208
PROCESSOR_TEMPERATURE, BOARD_TEMPERATURE = 1213, 1214
CONTINUOUS_START, CONTINUOUS_STOP = 1400, 1401
DEVICE_DATA, TRANSDUCER, MOTOR_OFF = 2300, 2601, 2903
PING1D, PING360 = 1, 2
_HEAD: Final = struct.Struct("<2sHHBB")
LONGEST: Final = 4096
PULSE_US: Final = 50


def frame(message: int, payload: bytes, *, source: int = 1, destination: int = 0) -> bytes:
    """A message with its header and checksum."""
    raw = _HEAD.pack(b"BR", len(payload), message, source, destination) + payload
    return raw + struct.pack("<H", sum(raw) & 0xFFFF)


class Frames:
    """Finds messages in a stream of bytes.

    Attributes:
        bad: frames whose checksum was wrong, and bytes between frames, counted.
    """

    def __init__(self) -> None:
        self._waiting = bytearray()
        self.bad = 0

    def feed(self, raw: bytes) -> Iterator[tuple[int, bytes]]:
        """(message, payload) of each frame that is complete now."""
        waiting = self._waiting
        waiting += raw
        while len(waiting) >= _HEAD.size + 2:
            mark, length, message, _, _ = _HEAD.unpack_from(waiting)
            if mark != b"BR" or length > LONGEST:
                del waiting[0]
                self.bad += 1
                continue
            end = _HEAD.size + length
            if len(waiting) < end + 2:
                return
            good = sum(waiting[:end]) & 0xFFFF == int.from_bytes(waiting[end : end + 2], "little")
            payload = bytes(waiting[_HEAD.size : end])
            del waiting[: end + 2 if good else 1]
            if good:
                yield message, payload
            else:
                self.bad += 1


def device_information(kind: int) -> bytes:
    """Kind of device, revision and firmware 3.29."""
    return frame(DEVICE_INFORMATION, struct.pack("<6B", kind, 1, 3, 29, 0, 0))


def protocol_version() -> bytes:
    """Version 1.0.0."""
    return frame(PROTOCOL_VERSION, struct.pack("<4B", 1, 0, 0, 0))


def acknowledge(message: int) -> bytes:
    """Yes to a message."""
    return frame(ACK, struct.pack("<H", message))


def refuse(message: int, why: str) -> bytes:
    """No to a message."""
    return frame(NACK, struct.pack("<H", message) + why.encode("ascii")[:60] + b"\0")


def distance_simple(distance_mm: int, confidence: int) -> bytes:
    """Distance and confidence [%]."""
    return frame(DISTANCE_SIMPLE, struct.pack("<IB", distance_mm, confidence))


def distance(
    distance_mm: int,
    confidence: int,
    number: int,
    start_mm: int,
    length_mm: int,
    *,
    pulse_us: int = PULSE_US,
    gain: int = 3,
) -> bytes:
    """Distance with the scan that it was found in."""
    return frame(
        DISTANCE, struct.pack("<IHHIIII", distance_mm, confidence, pulse_us, number, start_mm, length_mm, gain)
    )


def profile(
    distance_mm: int, confidence: int, number: int, start_mm: int, length_mm: int, data: bytes, *,
    pulse_us: int = PULSE_US, gain: int = 3,
) -> bytes:  # fmt: skip
    """The echo trace, 8 bits a point."""
    head = struct.pack("<IHHIIIIH", distance_mm, confidence, pulse_us, number, start_mm, length_mm, gain, len(data))
    return frame(PROFILE, head + data)


def device_data(request: Sequence[int], data: bytes) -> bytes:
    """Ping360's answer to a request of `transducer_request`."""
    mode, gain, angle, duration, period, frequency, samples, _, _ = request
    head = struct.pack("<BBHHHHHH", mode, gain, angle, duration, period, frequency, samples, len(data))
    return frame(DEVICE_DATA, head + data, source=2)


def transducer_request(payload: bytes) -> tuple[int, ...] | None:
    """Mode, gain, angle [gradian], pulse [us], sample period [25 ns], frequency [kHz], samples, transmit, reserved."""
    return struct.unpack("<BBHHHHHBB", payload) if len(payload) == 14 else None
