"""Water Linked DVL A50: its JSON over TCP (port 16171) and its serial protocol, as pure functions.

Source: https://docs.waterlinked.com/dvl/dvl-protocol/ (JSON v3.1, serial v2.5). Velocities x forward, y right, z down.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any, Final

from pelagos.bridges.instruments.dvl_velocity import DvlVelocity
from pelagos.bridges.instruments.reckoning import Reckoning

POLYNOMIAL: Final = 0x07


def report(dvl: DvlVelocity, before_ns: int) -> bytes:
    """A velocity report in JSON, a line; `before_ns` is the time of the report before."""
    velocity = dvl.velocity or (0.0, 0.0, 0.0)
    body = {
        "time": (dvl.t_ns - before_ns) * 1e-6, "vx": velocity[0], "vy": velocity[1], "vz": velocity[2],
        "fom": dvl.merit_mps, "covariance": [list(row) for row in dvl.covariance],
        "altitude": -1.0 if dvl.altitude_m is None else dvl.altitude_m,
        "transducers": [
            {"id": i, "velocity": v if good and math.isfinite(v) else 0.0,
             "distance": r if good and math.isfinite(r) else -1.0, "rssi": -40 if good else -90,
             "nsd": -95, "beam_valid": good}
            for i, (v, r, good) in enumerate(zip(dvl.beam_velocity_mps, dvl.ranges_m, dvl.beam_valid, strict=True))
        ],
        "velocity_valid": dvl.velocity is not None, "status": 0, "format": "json_v3.1", "type": "velocity",
        "time_of_validity": dvl.t_ns // 1000, "time_of_transmission": dvl.t_ns // 1000,
    }  # fmt: skip
    return json.dumps(body, allow_nan=False).encode() + b"\r\n"


def position(way: Reckoning) -> bytes:
    """A dead-reckoning report in JSON, a line."""
    roll, pitch, yaw = (math.degrees(a) for a in way.euler)
    x, y, z = way.position
    body = {
        "ts": way.t_ns / 1e9, "x": x, "y": y, "z": z, "std": way.std_m, "roll": roll, "pitch": pitch, "yaw": yaw,
        "type": "position_local", "status": int(not way.locked), "format": "json_v3.1",
    }  # fmt: skip
    return json.dumps(body, allow_nan=False).encode() + b"\r\n"


def response(command: str, *, result: Mapping[str, Any] | None = None, trouble: str = "") -> bytes:
    """Answer to a command in JSON, a line; it has failed where there is a `trouble`."""
    body = {
        "response_to": command, "success": not trouble, "error_message": trouble, "result": result,
        "format": "json_v3.1", "type": "response",
    }  # fmt: skip
    return json.dumps(body).encode() + b"\r\n"


def objects(raw: bytes) -> tuple[list[bytes], bytes]:
    """Commands in a stream of bytes, and its end that is none yet: drivers end them by a line, or by nothing at all."""
    *lines, rest = raw.replace(b"\r", b"\n").split(b"\n")
    found = [line for line in lines if line.strip()]
    try:
        if rest.strip():
            json.loads(rest)
            return [*found, rest], b""
    except (ValueError, RecursionError):
        pass
    return found, rest


def serial_report(dvl: DvlVelocity, before_ns: int) -> bytes:
    """The sentence `wrz` of the serial protocol."""
    x, y, z = dvl.velocity or (0.0, 0.0, 0.0)
    valid, altitude = "y" if dvl.velocity is not None else "n", -1.0 if dvl.altitude_m is None else dvl.altitude_m
    spread = ";".join(f"{v:.6g}" for row in dvl.covariance for v in row)
    t_us = dvl.t_ns // 1000
    elapsed = (dvl.t_ns - before_ns) * 1e-6
    return serial_sentence(
        f"wrz,{x:.3f},{y:.3f},{z:.3f},{valid},{altitude:.2f},{dvl.merit_mps:.3f},{spread},{t_us},{t_us},{elapsed:.2f},0"
    )


def serial_transducers(dvl: DvlVelocity) -> bytes:
    """The sentences `wru`, one for each beam."""
    out = b""
    for i, (v, r, good) in enumerate(zip(dvl.beam_velocity_mps, dvl.ranges_m, dvl.beam_valid, strict=True)):
        velocity = v if good and math.isfinite(v) else 0.0
        distance = r if good and math.isfinite(r) else -1.0
        out += serial_sentence(f"wru,{i},{velocity:.3f},{distance:.2f},{-40 if good else -90},-95")
    return out


def serial_position(way: Reckoning) -> bytes:
    """The sentence `wrp`."""
    x, y, z = way.position
    roll, pitch, yaw = (math.degrees(a) for a in way.euler)
    return serial_sentence(
        f"wrp,{way.t_ns / 1e9:.3f},{x:.3f},{y:.3f},{z:.3f},{way.std_m:.3f},{roll:.2f},{pitch:.2f},{yaw:.2f},"
        f"{int(not way.locked)}"
    )


def serial_sentence(body: str) -> bytes:
    """A sentence with its CRC-8."""
    return f"{body}*{crc8(body.encode('ascii')):02x}\r\n".encode("ascii")


def crc8(data: bytes) -> int:
    """CRC-8, polynomial x^8 + x^2 + x + 1, from 0."""
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = ((crc << 1) ^ POLYNOMIAL) & 0xFF if crc & 0x80 else (crc << 1) & 0xFF
    return crc
