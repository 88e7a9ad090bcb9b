"""ROS 2 topics and services over zenoh, as rmw_zenoh writes them, with no ROS installed.

Keys, liveliness tokens and attachments: https://github.com/ros2/rmw_zenoh (docs/design.md), versions from February 2025
on. A router must answer at `tcp/localhost:7447`; where none does, one is opened in this process, on loopback.
"""

from __future__ import annotations

import json
import os
import struct
import threading
import time
from collections import Counter
from typing import Any, Final

from pelagos.bridges.dds_types import wire_type
from pelagos.bridges.extras import require
from pelagos.bridges.rihs import type_hash
from pelagos.bridges.transport import ONLY_HERE, Answer, BridgeError, Buffer, Qos, Receive, Write

ROUTER: Final = "tcp/localhost:7447"
OPEN_ROUTER: Final = "tcp/0.0.0.0:7447"
_GID: Final = 16
_NO_HASH: Final = "TypeHashNotSupported"


class ZenohTransport:
    """A zenoh session, seen by ROS 2 as a node.

    Args:
        domain: ROS domain id.
        node: name of the node.
        router: where the router listens; the session's own configuration (ZENOH_SESSION_CONFIG_URI) wins.
        hashes: keys carry type hashes; Humble's do not.
        loopback: a router that is opened here, because none answers, is for this machine only.

    Attributes:
        reach: who can reach it, in words.
    """

    name = "zenoh"
    blocks = True

    def __init__(
        self,
        *,
        domain: int = 0,
        node: str = "pelagos",
        router: str = ROUTER,
        hashes: bool = True,
        loopback: bool = True,
    ) -> None:
        self._zenoh = require("zenoh", extra="ros2", purpose="the zenoh transport")
        self._ext = require("zenoh.ext", extra="ros2", purpose="the zenoh transport")
        self._domain, self._node, self._hashes = domain, node, hashes
        self._router = _router(self._zenoh, router if loopback else OPEN_ROUTER)
        self.reach = ONLY_HERE if loopback else "open to the network, without passwords"
        if "ZENOH_SESSION_CONFIG_URI" in os.environ or "ZENOH_CONFIG_OVERRIDE" in os.environ:
            self.reach = "as ZENOH_SESSION_CONFIG_URI and ZENOH_CONFIG_OVERRIDE say"
        elif self._router is None:
            self.reach = "wherever the router that answers here is reached, without passwords"
        try:
            self._session = self._zenoh.open(_config(self._zenoh, router))
        except self._zenoh.ZError as error:
            raise BridgeError(f"no zenoh session: {error}") from None
        self._id = str(self._session.zid())
        self._entities = 0
        self.troubles: Counter[str] = Counter()
        self._kept: list[Any] = []
        self._plain: list[Any] = []  # publishers of topics that are not latched
        self._token(f"{self._domain}/{self._id}/0/0/NN/%/%/{node}")

    def advertise(self, topic: str, type_name: str, *, qos: Qos) -> Write:
        """See `Transport`."""
        key = self._key(topic, type_name, type_name)
        options: dict[str, Any] = {"congestion_control": self._zenoh.CongestionControl.DROP}
        if qos.latched:
            publisher = self._ext.declare_advanced_publisher(
                self._session, key, cache=self._ext.CacheConfig(qos.depth), publisher_detection=True, **options
            )
        else:
            publisher = self._session.declare_publisher(key, **options)
            self._plain.append(publisher)
        self._kept.append(publisher)
        self._announce("MP", topic, type_name, type_name, qos)
        gid, count = os.urandom(_GID), 0
        lock = threading.Lock()

        def write(cdr: Buffer, t_ns: int) -> None:
            nonlocal count
            with lock:
                count += 1
                number = count
            publisher.put(bytes(cdr), attachment=attachment(number, time.time_ns(), gid))

        return write

    def readers(self) -> int:
        """See `Stage`; of topics that are not latched."""
        return sum(bool(publisher.matching_status.matching) for publisher in self._plain)

    def settle(self, wait_s: float) -> None:
        """See `Stage`; a session that closes sends what it has."""

    def subscribe(self, topic: str, type_name: str, receive: Receive, *, qos: Qos) -> None:
        """See `Transport`."""
        key = self._key(topic, type_name, type_name)

        def take(sample: Any) -> None:
            receive(sample.payload.to_bytes())

        if qos.latched:
            made = self._ext.declare_advanced_subscriber(
                self._session, key, take, history=self._ext.HistoryConfig(detect_late_publishers=True)
            )
        else:
            made = self._session.declare_subscriber(key, take)
        self._kept.append(made)
        self._announce("MS", topic, type_name, type_name, qos)

    def serve(self, service: str, type_name: str, answer: Answer) -> None:
        """See `Transport`."""
        key = self._key(service, type_name, type_name)

        def respond(query: Any) -> None:
            request = query.payload
            if request is None:
                return
            attached = None if query.attachment is None else query.attachment.to_bytes()
            try:
                told = answer(request.to_bytes())
            except Exception as error:  # bytes from a network: anything may be wrong with them
                self.troubles[f"requests without an answer ({type(error).__name__})"] += 1
                return
            query.reply(query.key_expr, told, attachment=attached)

        self._kept.append(self._session.declare_queryable(key, respond, complete=True))
        self._announce("SS", service, type_name, type_name, Qos(depth=10))

    def close(self) -> None:
        """See `Transport`."""
        self._kept.clear()
        self._plain.clear()
        self._session.close()
        if self._router is not None:
            self._router.close()

    def _key(self, name: str, type_name: str, hashed: str) -> str:
        text = type_hash(hashed) if self._hashes else _NO_HASH
        return f"{self._domain}/{name.strip('/')}/{wire_type(type_name)}/{text}"

    def _announce(self, kind: str, name: str, type_name: str, hashed: str, qos: Qos) -> None:
        self._entities += 1
        text = type_hash(hashed) if self._hashes else _NO_HASH
        mangled = name.replace("/", "%")
        self._token(
            f"{self._domain}/{self._id}/0/{self._entities}/{kind}/%/%/{self._node}/{mangled}/{wire_type(type_name)}/"
            f"{text}/{qos_text(qos)}"
        )

    def _token(self, key: str) -> None:
        self._kept.append(self._session.liveliness().declare_token(f"@ros2_lv/{key}"))


def attachment(number: int, t_ns: int, gid: bytes) -> bytes:
    """Attachment of every sample: number, wall-clock time of writing [ns], the publisher's id behind its length."""
    return struct.pack("<qqB", number, t_ns, len(gid)) + gid


def qos_text(qos: Qos) -> str:
    """Quality of service as rmw_zenoh writes it; what is the default is left out."""
    reliability = "" if qos.reliable else "2"
    durability = "1" if qos.latched else ""
    return f"{reliability}:{durability}:,{qos.depth}:,:,:,,"


def _config(zenoh: Any, router: str) -> Any:
    given = os.environ.get("ZENOH_SESSION_CONFIG_URI")
    config = zenoh.Config.from_file(given) if given else zenoh.Config()
    if not given:
        for key, value in (
            ("mode", "peer"),
            ("connect/endpoints", [router]),
            ("listen/endpoints", ["tcp/localhost:0"]),
            ("scouting/multicast/enabled", False),
            ("scouting/gossip/enabled", True),
            ("timestamping/enabled", True),
        ):
            config.insert_json5(key, json.dumps(value))
    for change in filter(None, os.environ.get("ZENOH_CONFIG_OVERRIDE", "").split(";")):
        key, _, value = change.partition("=")
        config.insert_json5(key, value)
    return config


def _router(zenoh: Any, endpoint: str) -> Any:
    """A router in this process, on loopback, where none answers; None where one does."""
    if os.environ.get("ZENOH_SESSION_CONFIG_URI"):
        return None
    config = zenoh.Config()
    for key, value in (
        ("mode", "router"),
        ("listen/endpoints", [endpoint]),
        ("scouting/multicast/enabled", False),
        ("timestamping/enabled", True),
    ):
        config.insert_json5(key, json.dumps(value))
    try:
        return zenoh.open(config)
    except zenoh.ZError:
        return None  # the address is taken: a router stands there
