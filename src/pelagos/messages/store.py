"""The message types in use, and their bytes: CDR as ROS 2 sends and records it."""

from __future__ import annotations

from functools import cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pelagos.messages import services
from pelagos.messages.definitions import PACKAGES

Message: TypeAlias = Any  # message classes are generated when the types are loaded


@cache
def typestore() -> Any:
    """The message types of ROS 2 Jazzy, which newer distributions share, and those of `definitions` and `services`."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    found: dict[str, Any] = {}
    for name, text in PACKAGES.items():
        found.update(get_types_from_msg(text, name))
    store.register(found | services.definitions())
    return store


def make(name: str, /, **fields: Any) -> Message:
    """A message of type `name` ("sensor_msgs/msg/Imu") with the given fields."""
    return typestore().types[name](**fields)


def serialize(name: str, message: Message) -> bytes:
    """CDR bytes, encapsulation header included."""
    return bytes(typestore().serialize_cdr(message, name))


def deserialize(name: str, raw: bytes | memoryview) -> Message:
    """The message in CDR bytes; arrays of numbers become NumPy arrays."""
    return typestore().deserialize_cdr(raw, name)


@cache
def schema(name: str) -> bytes:
    """The definition of a type and of all types within, as MCAP wants it (schema encoding "ros2msg")."""
    text: str = typestore().generate_msgdef(name, ros_version=2)[0]
    return text.encode()


def stamp(t_ns: int) -> Message:
    """builtin_interfaces/Time of a simulation time [ns]."""
    return make("builtin_interfaces/msg/Time", sec=t_ns // 1_000_000_000, nanosec=t_ns % 1_000_000_000)


def header(frame_id: str, t_ns: int = 0) -> Message:
    """std_msgs/Header."""
    return make("std_msgs/msg/Header", stamp=stamp(t_ns), frame_id=frame_id)


def vector3(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Message:
    """geometry_msgs/Vector3."""
    return make("geometry_msgs/msg/Vector3", x=float(x), y=float(y), z=float(z))


def quaternion(w: float = 1.0, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Message:
    """geometry_msgs/Quaternion, which stores w last."""
    return make("geometry_msgs/msg/Quaternion", x=float(x), y=float(y), z=float(z), w=float(w))


def diagonal(*variances: float) -> NDArray[np.float64]:
    """A row-major covariance matrix with independent components."""
    return np.diag(np.array(variances, dtype=np.float64)).ravel()
