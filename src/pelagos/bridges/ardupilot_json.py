"""The packets of ArduPilot's JSON interface, as pure functions.

Source: ArduPilot, libraries/SITL/examples/JSON/readme.md and SIM_JSON.cpp. Its parser looks for the text of a key and
reads on with sscanf: there must be no space behind a colon, and what comes first wins, so mandatory keys come first.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from pelagos.bridges.autopilot import VehicleMotion

MAGIC: Final = {18458: 16, 29569: 32}
_HEAD: Final = struct.Struct("<HHI")
_SERVOS: Final = {magic: struct.Struct(f"<HHI{channels}H") for magic, channels in MAGIC.items()}
_STATE: Final = (
    '\n{"timestamp":%r,"imu":{"gyro":[%r,%r,%r],"accel_body":[%r,%r,%r]},"position":[%r,%r,%r],'
    '"velocity":[%r,%r,%r],"quaternion":[%r,%r,%r,%r]'
)
"""JSON as `json.dumps` writes it, in a seventh of its time: `repr` of a float is what JSON takes."""


@dataclass(frozen=True)
class ServoFrame:
    """Outputs that the autopilot sends each step.

    Attributes:
        rate_hz: at which it would like to be answered.
        count: of frames; again the same where it waits for an answer, back to 0 where it began anew.
        pwm: pulse widths [us], 16 or 32; 0 where an output is off.
    """

    rate_hz: int
    count: int
    pwm: tuple[int, ...]


def parse_servos(packet: bytes) -> ServoFrame | None:
    """The frame in a packet; None where it is none."""
    if len(packet) < _HEAD.size:
        return None
    layout = _SERVOS.get(packet[0] | packet[1] << 8)
    if layout is None or len(packet) != layout.size:
        return None
    _, rate, count, *pwm = layout.unpack(packet)
    return ServoFrame(rate, count, tuple(pwm))


def level(pulse_us: int, rests_at: float, *, low_us: float = 1100.0, high_us: float = 1900.0) -> float:
    """-1 .. 1 of a pulse; an output that is off rests."""
    if pulse_us == 0:
        return rests_at
    return (pulse_us - 0.5 * (low_us + high_us)) / (0.5 * (high_us - low_us))


def state_text(t_s: float, motion: VehicleMotion, extras: Mapping[str, Any] | None = None) -> bytes | None:
    """The answer to a frame; None where a number is not finite, which the parser would believe.

    Args:
        t_s: simulation time [s].
        motion: of the vehicle.
        extras: optional keys, such as `rng_1` [m].
    """
    numbers = (t_s, *motion.gyro, *motion.force, *motion.position, *motion.velocity, *motion.attitude)
    if not math.isfinite(sum(numbers)):  # a sum of finite numbers of this size is finite
        return None
    said = {k: v for k, v in (extras or {}).items() if not (isinstance(v, float) and not math.isfinite(v))}
    rest = json.dumps(said, separators=(",", ":"), allow_nan=False)[1:-1] if said else ""
    return (_STATE % numbers + ("," + rest if rest else "") + "}\n").encode()
