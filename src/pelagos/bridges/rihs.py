"""Type hashes (RIHS01) of message and service types, as ROS 2 announces them since Iron.

rosbags numbers the field type `char` apart from `uint8`; ROS hashes both as `uint8`, so hashes are taken of types in
which the one is replaced by the other. Format: REP-2016 and rosidl's type description.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from pelagos.messages.store import typestore


@cache
def _hashing_store() -> Any:
    """A store of its own, in which `char` is `uint8`, with every type of the one in use."""
    from rosbags.typesys import Stores, get_typestore

    source, store = typestore(), get_typestore(Stores.EMPTY)
    store.register({name: (constants, _plain(fields)) for name, (constants, fields) in source.fielddefs.items()})
    return store


def _plain(fields: Any) -> Any:
    return [(name, _plain_node(node)) for name, node in fields]


def _plain_node(node: Any) -> Any:
    kind, inner = node
    if isinstance(inner, tuple) and inner[0] == "char":
        return kind, ("uint8", *inner[1:])
    if isinstance(inner, tuple) and isinstance(inner[0], tuple):
        return kind, (_plain_node(inner[0]), *inner[1:])
    return node


@cache
def type_hash(name: str) -> str:
    """Hash of a message type ("sensor_msgs/msg/Imu") or service type ("std_srvs/srv/Trigger")."""
    store = _hashing_store()
    if "/srv/" in name and name not in store.fielddefs:
        _register_service(store, name)
    text: str = store.hash_rihs01(name)
    return text if text.startswith("RIHS01_") else f"RIHS01_{text}"


def _register_service(store: Any, name: str) -> None:
    """A service is hashed as a type of its request, response and event."""
    from rosbags.interfaces import Nodetype as T

    halves = {half: (T.NAME, f"{name}_{half.capitalize()}") for half in ("request", "response", "event")}
    event = [
        ("info", (T.NAME, "service_msgs/msg/ServiceEventInfo")),
        ("request", (T.SEQUENCE, (halves["request"], 1))),
        ("response", (T.SEQUENCE, (halves["response"], 1))),
    ]
    store.register({
        f"{name}_Event": ([], event),
        name: ([], [(f"{half}_message", node) for half, node in halves.items()]),
    })  # fmt: skip
