"""LCM messages as bytes: HoloOcean's structures, and one of our own that carries any message in CDR.

An LCM message is 8 bytes of fingerprint (a hash of the structure) and the fields, big-endian.
Source of the hash and the layout: lcm-gen (https://lcm-proj.github.io/lcm/, "LCM type specification").
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

_PRIMITIVES: Final = {
    "int8_t": "b", "int16_t": "h", "int32_t": "i", "int64_t": "q", "float": "f", "double": "d", "byte": "B",
    "boolean": "b",
}  # fmt: skip
_MASK: Final = (1 << 64) - 1


@dataclass(frozen=True)
class Member:
    """One field: type, name and the sizes of its dimensions (numbers, or names of fields that say them)."""

    type: str
    name: str
    sizes: tuple[int | str, ...] = ()


HOLOOCEAN: Final[Mapping[str, tuple[Member, ...]]] = {
    "DVLSensor": (
        Member("int64_t", "timestamp"), Member("float", "velocity", (3,)), Member("float", "range", (4,)),
    ),
    "IMUSensor": (
        Member("int64_t", "timestamp"), Member("float", "acceleration", (3,)),
        Member("float", "angular_velocity", (3,)), Member("float", "acceleration_bias", (3,)),
        Member("float", "angular_velocity_bias", (3,)),
    ),
    "GPSSensor": (Member("int64_t", "timestamp"), Member("float", "position", (3,))),
    "LocationSensor": (Member("int64_t", "timestamp"), Member("float", "position", (3,))),
    "VelocitySensor": (Member("int64_t", "timestamp"), Member("float", "velocity", (3,))),
    "RotationSensor": (
        Member("int64_t", "timestamp"), Member("float", "roll"), Member("float", "pitch"), Member("float", "yaw"),
    ),
    "OrientationSensor": (Member("int64_t", "timestamp"), Member("float", "matrix", (3, 3))),
    "PoseSensor": (Member("int64_t", "timestamp"), Member("float", "matrix", (4, 4))),
    "DepthSensor": (Member("int64_t", "timestamp"), Member("float", "depth")),
    "AcousticBeaconSensor": (
        Member("int64_t", "timestamp"), Member("string", "msg_type"), Member("int32_t", "from_beacon"),
        Member("float", "azimuth"), Member("float", "elevation"), Member("float", "range"), Member("float", "z"),
    ),
    "ImagingSonar": (
        Member("int64_t", "timestamp"), Member("int32_t", "bins_azimuth"), Member("int32_t", "bins_range"),
        Member("float", "image", ("bins_range", "bins_azimuth")),
    ),
    "RangeFinderSensor": (
        Member("int64_t", "timestamp"), Member("int32_t", "count"), Member("float", "distances", ("count",)),
        Member("float", "angles", ("count",)),
    ),
    "RGBCamera": (
        Member("int64_t", "timestamp"), Member("int32_t", "width"), Member("int32_t", "height"),
        Member("int32_t", "channels"), Member("int16_t", "image", ("height", "width", "channels")),
    ),
}  # fmt: skip
"""HoloOcean's structures (package `lcm`); `timestamp` is milliseconds of simulation."""
OWN: Final[Mapping[str, tuple[Member, ...]]] = {
    "message_t": (
        Member("int64_t", "t_ns"), Member("string", "type"), Member("int32_t", "size"),
        Member("byte", "cdr", ("size",)),
    ),
}  # fmt: skip
"""Package `pelagos`: a ROS 2 message in CDR, its type's name and its simulation time [ns]."""


@cache
def fingerprint(name: str) -> int:
    """The hash of a structure, as lcm-gen makes it: of its members, not of its name."""
    value = 0x12345678
    for member in _members(name):
        value = _hash_text(value, member.name)
        value = _hash_text(value, member.type)  # every member is of a primitive type
        value = _update(value, len(member.sizes))
        for size in member.sizes:
            value = _update(value, 1 if isinstance(size, str) else 0)
            value = _hash_text(value, str(size))
    return ((value << 1) & _MASK) + (value >> 63) & _MASK


def encode(name: str, values: Mapping[str, Any]) -> bytes:
    """A message; arrays of any shape are written row by row."""
    out = struct.pack(">Q", fingerprint(name))
    for member in _members(name):
        value = values[member.name]
        if member.type == "string":
            raw = str(value).encode() + b"\0"
            out += struct.pack(">i", len(raw)) + raw
        elif member.type == "byte":
            out += bytes(value)
        else:
            flat = _flat(value)
            out += struct.pack(f">{len(flat)}{_PRIMITIVES[member.type]}", *flat)
    return out


def definition(name: str) -> str:
    """The structure as lcm-gen reads it."""
    package = "lcm" if name in HOLOOCEAN else "pelagos"
    lines = [f"  {m.type} {m.name}{''.join(f'[{size}]' for size in m.sizes)};" for m in _members(name)]
    return f"package {package};\n\nstruct {name} {{\n" + "\n".join(lines) + "\n}\n"


def _members(name: str) -> Sequence[Member]:
    return HOLOOCEAN[name] if name in HOLOOCEAN else OWN[name]


def _flat(value: Any) -> list[Any]:
    if hasattr(value, "ravel"):
        found: list[Any] = value.ravel().tolist()
        return found
    return list(value) if isinstance(value, list | tuple) else [value]


def _update(value: int, byte: int) -> int:
    """One step of lcm-gen's hash, in signed 64 bits: shifts to the right keep the sign."""
    signed = value - (1 << 64) if value >> 63 else value
    return (((value << 8) & _MASK) ^ ((signed >> 55) & _MASK)) + byte & _MASK


def _hash_text(value: int, text: str) -> int:
    value = _update(value, len(text))
    for byte in text.encode():
        value = _update(value, byte)
    return value
