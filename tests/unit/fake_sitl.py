"""A stand-in for ArduPilot's SITL: its packets, and its parser's rules, written from ArduPilot's documentation.

The parser looks for the text of a key, and reads numbers behind it by sscanf's rules; it takes the last whole line.
"""

from __future__ import annotations

import re
import socket
import struct
import time
from collections.abc import Sequence

NUMBER = r"([+-]?(?:\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+))"
_THREE = {key: re.compile(rf'"{key}":\[{NUMBER},\s*{NUMBER},\s*{NUMBER}\]') for key in
          ("gyro", "accel_body", "position", "velocity")}  # fmt: skip
_FOUR = re.compile(rf'"quaternion":\[{NUMBER},\s*{NUMBER},\s*{NUMBER},\s*{NUMBER}\]')
_TIME = re.compile(rf'"timestamp":{NUMBER}')
_RANGE = re.compile(rf'"rng_1":{NUMBER}')


class FakeSitl:
    """Sends outputs and reads states, one exchange a call."""

    def __init__(self, port: int, *, channels: int = 16, rate_hz: int = 1200) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.settimeout(5.0)
        self.address = ("127.0.0.1", port)
        self.count, self.rate_hz, self.channels = 0, rate_hz, channels

    def packet(self, pwm: Sequence[int]) -> bytes:
        magic = {16: 18458, 32: 29569}[self.channels]
        full = [*pwm, *[0] * (self.channels - len(pwm))]
        return struct.pack(f"<HHI{self.channels}H", magic, self.rate_hz, self.count, *full)

    def exchange(self, pwm: Sequence[int]) -> dict[str, list[float]]:
        """One frame: send it, and again after each second without an answer."""
        self.count += 1
        return self.again(pwm)

    def again(self, pwm: Sequence[int]) -> dict[str, list[float]]:
        packet = self.packet(pwm)
        for _ in range(30):
            self.socket.sendto(packet, self.address)
            try:
                return parse(self.socket.recvfrom(65536)[0])
            except TimeoutError:
                continue
            except ConnectionRefusedError:
                time.sleep(0.05)
        raise AssertionError("the simulator does not answer")

    def close(self) -> None:
        self.socket.close()


def parse(datagram: bytes) -> dict[str, list[float]]:
    """The state in a datagram, as SIM_JSON reads it."""
    assert datagram.startswith(b"\n")
    assert datagram.endswith(b"\n")
    line = datagram.rstrip(b"\n").rpartition(b"\n")[2].decode()
    found = {}
    for key, pattern in {**_THREE, "quaternion": _FOUR, "timestamp": _TIME, "rng_1": _RANGE}.items():
        at = line.find(f'"{key}":')
        if at < 0:
            assert key in ("rng_1",), f"Did not contain all mandatory fields: {key}"
            continue
        match = pattern.match(line, at)  # the first text match wins, whatever it belongs to
        assert match, f"Failed to parse {key}"
        found[key] = [float(x) for x in match.groups()]
    return found
