"""Types of the DDS wire, made from ROS message definitions: Cyclone checks every raw sample against them."""

from __future__ import annotations

import types
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

from pelagos.bridges.extras import require
from pelagos.messages.store import typestore

_OCTETS: Final = ("byte", "char")


def wire_type(name: str) -> str:
    """The DDS name of a ROS type: "sensor_msgs/msg/Imu" -> "sensor_msgs::msg::dds_::Imu_"."""
    package, kind, short = name.split("/")
    return f"{package}::{kind}::dds_::{short}_"


@cache
def idl_class(name: str, *, gid_bytes: int = 16, framed: bool = False) -> Any:
    """The IDL class of a ROS type.

    Args:
        name: "sensor_msgs/msg/Imu", "std_srvs/srv/Trigger_Request".
        gid_bytes: length of a participant's id; 24 in Humble.
        framed: put a service's header (client and sequence number) before the fields.
    """
    idl = require("cyclonedds.idl", extra="ros2", purpose="the DDS transport")
    fields = {"request_guid": idl.types.uint64, "request_seq": idl.types.int64} if framed else {}
    for field, node in typestore().fielddefs[name][1]:
        if name == "rmw_dds_common/msg/Gid" and field == "data":
            fields[field] = idl.types.array[idl.types.uint8, gid_bytes]
        else:
            fields[field] = _annotation(idl, node, gid_bytes)

    def body(namespace: dict[str, Any]) -> None:
        namespace["__annotations__"] = {**namespace.get("__annotations__", {}), **fields}
        namespace["__module__"] = __name__

    short = name.rpartition("/")[2]
    # the metaclass reads `typename` while it prepares the namespace: plain `type(...)` would lose it
    made = types.new_class(f"{short}_", (idl.IdlStruct,), {"typename": wire_type(name)}, body)
    return idl.annotations.final(dataclass(made))


def _annotation(idl: Any, node: Any, gid_bytes: int) -> Any:
    from rosbags.interfaces import Nodetype

    kind, inner = node
    if kind == Nodetype.NAME:
        return idl_class(inner, gid_bytes=gid_bytes)
    if kind == Nodetype.BASE:
        base, bound = inner
        if base == "string":
            return idl.types.bounded_str[bound] if bound else str
        if base == "bool":
            return bool
        return idl.types.uint8 if base in _OCTETS else getattr(idl.types, base)
    element, count = _annotation(idl, inner[0], gid_bytes), inner[1]
    if kind == Nodetype.ARRAY:
        return idl.types.array[element, count]
    return idl.types.sequence[element, count] if count else idl.types.sequence[element]
