"""ROS 2 topics through rclpy, where a ROS installation is sourced; messages go in and out as CDR bytes."""

from __future__ import annotations

import threading
import time
import warnings
from collections import Counter
from collections.abc import Callable
from importlib import import_module
from typing import Any, Final

from pelagos.bridges.extras import require
from pelagos.bridges.transport import Answer, Buffer, Qos, Receive, Write
from pelagos.errors import PelagosWarning

THREADS: Final = 8
"""For commands, and for services of which some may wait for a boundary of steps at the same time."""


class RclpyTransport:
    """A node of the sourced ROS installation.

    A topic whose message package is not installed there is skipped with one warning.
    """

    name = "rclpy"
    blocks = True
    reach = "wherever the sourced ROS reaches (ROS_AUTOMATIC_DISCOVERY_RANGE), without passwords"

    def __init__(self, *, domain: int = 0, node: str = "pelagos") -> None:
        self._rclpy = require("rclpy", extra="ros2", purpose="the rclpy transport")
        self._context = self._rclpy.Context()
        self._rclpy.init(context=self._context, domain_id=domain)
        self._node = self._rclpy.create_node(node, context=self._context)
        executors = import_module("rclpy.executors")
        self._executor = executors.MultiThreadedExecutor(THREADS, context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._executor.spin, name="pelagos-rclpy", daemon=True)
        self._thread.start()
        self._skipped: set[str] = set()
        self._publishers: list[Any] = []
        self.troubles: Counter[str] = Counter()

    def advertise(self, topic: str, type_name: str, *, qos: Qos) -> Write:
        """See `Transport`."""
        kind = self._kind(type_name)
        if kind is None:
            return lambda cdr, t_ns: None
        publisher = self._node.create_publisher(kind, topic, self._qos(qos))
        self._publishers.append(publisher)

        def write(cdr: Buffer, t_ns: int) -> None:
            publisher.publish(bytes(cdr))

        return write

    def readers(self) -> int:
        """See `Stage`."""
        return sum(int(publisher.get_subscription_count()) for publisher in self._publishers)

    def settle(self, wait_s: float) -> None:
        """See `Stage`."""
        duration, end = import_module("rclpy.duration").Duration, time.monotonic() + wait_s
        for publisher in self._publishers:
            publisher.wait_for_all_acked(duration(seconds=max(end - time.monotonic(), 0.0)))

    def subscribe(self, topic: str, type_name: str, receive: Receive, *, qos: Qos) -> None:
        """See `Transport`."""
        kind = self._kind(type_name)
        if kind is not None:
            self._node.create_subscription(kind, topic, _unless_empty(receive), self._qos(qos), raw=True)

    def serve(self, service: str, type_name: str, answer: Answer) -> None:
        """See `Transport`."""
        kind = self._kind(type_name)
        if kind is None:
            return
        serialization = import_module("rclpy.serialization")

        def respond(request: Any, response: Any) -> Any:
            raw = answer(serialization.serialize_message(request))
            return serialization.deserialize_message(raw, type(response))

        alone = import_module("rclpy.callback_groups").MutuallyExclusiveCallbackGroup()  # holds up nothing else
        self._node.create_service(kind, service, respond, callback_group=alone)

    def close(self) -> None:
        """See `Transport`."""
        self._executor.shutdown()
        self._node.destroy_node()
        self._rclpy.shutdown(context=self._context)

    def _kind(self, type_name: str) -> Any:
        package, part, short = type_name.split("/")
        try:
            return getattr(import_module(f"{package}.{part}"), short)
        except (ImportError, AttributeError):
            if package not in self._skipped:
                self._skipped.add(package)
                text = f"the sourced ROS has no package {package}: its topics are left out"
                warnings.warn(text, PelagosWarning, stacklevel=2)
            return None

    def _qos(self, qos: Qos) -> Any:
        found = import_module("rclpy.qos")
        return found.QoSProfile(
            depth=qos.depth,
            history=found.HistoryPolicy.KEEP_LAST,
            reliability=found.ReliabilityPolicy.RELIABLE if qos.reliable else found.ReliabilityPolicy.BEST_EFFORT,
            durability=found.DurabilityPolicy.TRANSIENT_LOCAL if qos.latched else found.DurabilityPolicy.VOLATILE,
        )


def _unless_empty(receive: Receive) -> Callable[[Any], None]:
    """Loss of parts of a large message has been seen to give an empty one."""

    def take(raw: Any) -> None:
        if len(raw) > 4:
            receive(bytes(raw))

    return take
