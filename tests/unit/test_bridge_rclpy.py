"""The rclpy transport against a stand-in with the signatures of rclpy's source (github.com/ros2/rclpy, branches jazzy
and rolling of 2026): what is called there exists, and takes what it is given. No ROS comes from a Python index."""

from __future__ import annotations

import enum
import struct
import sys
import threading
import warnings
from collections.abc import Callable
from importlib.machinery import ModuleSpec
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from pelagos.bridges.rclpy_transport import RclpyTransport
from pelagos.bridges.ros2 import Ros2Config, make_transport
from pelagos.bridges.transport import LATCHED, Qos
from pelagos.errors import PelagosWarning
from pelagos.messages.store import deserialize, make, serialize

TEXT = "std_msgs/msg/String"


class Policy(enum.IntEnum):
    KEEP_LAST = RELIABLE = TRANSIENT_LOCAL = 1
    BEST_EFFORT = VOLATILE = 2


class QoSProfile:
    """Jazzy's takes keywords alone, and no other than these."""

    def __init__(self, **kwargs: Any) -> None:
        assert set(kwargs) <= {"history", "depth", "reliability", "durability", "lifespan", "deadline", "liveliness"}
        self.__dict__.update(kwargs)


class Context:
    def __init__(self) -> None:
        self.domain_id: int | None = None
        self.up = False


class Duration:
    def __init__(self, *, seconds: float = 0, nanoseconds: int = 0) -> None:
        self.nanoseconds = int(seconds * 1e9) + nanoseconds


class Publisher:
    def __init__(self, kind: type, topic: str, qos: QoSProfile) -> None:
        self.kind, self.topic, self.qos, self.sent = kind, topic, qos, list[bytes]()
        self.waited: list[int] = []

    def publish(self, msg: Any) -> None:
        if not isinstance(msg, self.kind) and type(msg) is not bytes:  # rclpy takes no memoryview
            raise TypeError(f"Expected {self.kind}, got {type(msg)}")
        self.sent.append(msg)

    def get_subscription_count(self) -> int:
        return 2

    def wait_for_all_acked(self, timeout: Duration) -> bool:
        self.waited.append(timeout.nanoseconds)
        return False


class Node:
    def __init__(self, node_name: str, context: Context) -> None:
        assert context.up, "init comes first"
        self.name, self.context, self.destroyed = node_name, context, False
        self.publishers: dict[str, Publisher] = {}
        self.subscriptions: dict[str, tuple[type, Callable[[Any], None], QoSProfile]] = {}
        self.services: dict[str, tuple[type, Callable[[Any, Any], Any], Any]] = {}

    def create_publisher(self, msg_type: type, topic: str, qos_profile: QoSProfile) -> Publisher:
        return self.publishers.setdefault(topic, Publisher(msg_type, topic, qos_profile))

    def create_subscription(
        self,
        msg_type: type,
        topic: str,
        callback: Callable[[Any], None],
        qos_profile: QoSProfile,
        *,
        raw: bool = False,
    ) -> None:
        assert raw
        self.subscriptions[topic] = (msg_type, callback, qos_profile)

    def create_service(
        self, srv_type: type, srv_name: str, callback: Callable[[Any, Any], Any], *, callback_group: Any = None
    ) -> None:
        self.services[srv_name] = (srv_type, callback, callback_group)

    def destroy_node(self) -> None:
        self.destroyed = True


class MultiThreadedExecutor:
    def __init__(self, num_threads: int | None = None, *, context: Context) -> None:
        assert num_threads is not None
        assert num_threads >= 2
        self.nodes: list[Node] = []
        self.done, self.spinning = threading.Event(), threading.Event()

    def add_node(self, node: Node) -> bool:
        self.nodes.append(node)
        return True

    def spin(self) -> None:
        self.spinning.set()
        self.done.wait(20)

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        assert not any(node.destroyed for node in self.nodes), "the executor ends before its nodes"
        self.done.set()
        return True


class Text:
    """What std_msgs.msg.String is in a ROS installation."""

    def __init__(self, data: str = "") -> None:
        self.data = data


class Trigger:
    class Request:
        pass

    class Response:
        def __init__(self) -> None:
            self.success, self.message = False, ""


def serialize_message(message: Any) -> bytes:
    assert isinstance(message, Trigger.Request)
    kind = "std_srvs/srv/Trigger_Request"
    return serialize(kind, make(kind, structure_needs_at_least_one_member=0))


def deserialize_message(serialized_message: bytes, message_type: type) -> Any:
    assert type(serialized_message) is bytes
    assert message_type is Trigger.Response
    found = deserialize("std_srvs/srv/Trigger_Response", serialized_message)
    made = Trigger.Response()
    made.success, made.message = found.success, found.message
    return made


class Rclpy(SimpleNamespace):
    """What a test sees of the stand-in."""


@pytest.fixture
def rclpy(monkeypatch: pytest.MonkeyPatch) -> Rclpy:
    seen = Rclpy(nodes=[], contexts=[], down=[])

    def init(*, args: Any = None, context: Context, domain_id: int | None = None) -> None:
        context.domain_id, context.up = domain_id, True
        seen.contexts.append(context)

    def create_node(node_name: str, *, context: Context) -> Node:
        seen.nodes.append(Node(node_name, context))
        return seen.nodes[-1]

    def shutdown(*, context: Context, uninstall_handlers: bool | None = None) -> None:
        seen.down.append(context)

    modules: dict[str, dict[str, Any]] = {
        "rclpy": {"init": init, "create_node": create_node, "shutdown": shutdown, "Context": Context},
        "rclpy.executors": {"MultiThreadedExecutor": MultiThreadedExecutor},
        "rclpy.duration": {"Duration": Duration},
        "rclpy.callback_groups": {"MutuallyExclusiveCallbackGroup": type("MutuallyExclusiveCallbackGroup", (), {})},
        "rclpy.serialization": {
            "serialize_message": serialize_message, "deserialize_message": deserialize_message},
        "rclpy.qos": {
            "QoSProfile": QoSProfile, "HistoryPolicy": Policy, "ReliabilityPolicy": Policy, "DurabilityPolicy": Policy},
        "std_msgs": {}, "std_msgs.msg": {"String": Text}, "std_srvs": {}, "std_srvs.srv": {"Trigger": Trigger},
    }  # fmt: skip
    for name, names in modules.items():
        module = ModuleType(name)
        module.__spec__ = ModuleSpec(name, None, is_package=True)
        module.__path__ = []
        module.__dict__.update(names)
        monkeypatch.setitem(sys.modules, name, module)
    return seen


def text(said: str) -> bytes:
    return serialize(TEXT, make(TEXT, data=said))


def test_bytes_go_out_as_they_are(rclpy: Rclpy) -> None:
    transport = RclpyTransport(domain=7, node="sim")
    write = transport.advertise("/labels", TEXT, qos=LATCHED)
    raw = text("rock")
    write(memoryview(raw), 5)
    (node,), publisher = rclpy.nodes, rclpy.nodes[0].publishers["/labels"]
    assert (node.name, rclpy.contexts[0].domain_id, publisher.sent) == ("sim", 7, [raw])
    assert publisher.qos.__dict__ == {
        "depth": 1, "history": Policy.KEEP_LAST, "reliability": Policy.RELIABLE, "durability": Policy.TRANSIENT_LOCAL
    }  # fmt: skip
    transport.advertise("/rov/mode", TEXT, qos=Qos(depth=4, reliable=False))
    other = node.publishers["/rov/mode"].qos
    assert (other.depth, other.reliability, other.durability) == (4, Policy.BEST_EFFORT, Policy.VOLATILE)
    assert transport.readers() == 4
    transport.settle(0.25)
    assert 0 < publisher.waited[0] <= 250_000_000
    transport.close()
    assert node.destroyed
    assert rclpy.down == rclpy.contexts


def test_bytes_come_in_as_they_are_and_empty_ones_do_not(rclpy: Rclpy) -> None:
    """Large messages that were lost in part came as 4 empty bytes of encapsulation."""
    transport = RclpyTransport()
    got: list[bytes] = []
    transport.subscribe("/rov/cmd_mode", TEXT, got.append, qos=Qos())
    kind, take, _ = rclpy.nodes[0].subscriptions["/rov/cmd_mode"]
    for raw in (text("velocity"), b"\0\1\0\0", b""):
        take(raw)
    assert (kind, got) == (Text, [text("velocity")])
    transport.close()


def test_a_service_answers_by_messages_of_the_installation(rclpy: Rclpy) -> None:
    transport = RclpyTransport()
    asked: list[bytes] = []

    def answer(request: bytes) -> bytes:
        asked.append(request)
        kind = "std_srvs/srv/Trigger_Response"
        return serialize(kind, make(kind, success=True, message="done"))

    for name in ("/pelagos/reset", "/pelagos/again"):
        transport.serve(name, "std_srvs/srv/Trigger", answer)
    services = rclpy.nodes[0].services
    kind, respond, group = services["/pelagos/reset"]
    found = respond(Trigger.Request(), Trigger.Response())
    assert (kind, found.success, found.message) == (Trigger, True, "done")
    assert asked == [struct.pack("<4sB", b"\0\1\0\0", 0)]
    assert group is not services["/pelagos/again"][2]  # one that waits holds up no other
    transport.close()


def test_a_package_that_the_installation_lacks_is_left_out_with_one_warning(rclpy: Rclpy) -> None:
    transport = RclpyTransport()
    with pytest.warns(PelagosWarning, match="no package marine_acoustic_msgs: its topics are left out"):
        transport.advertise("/rov/sonar", "marine_acoustic_msgs/msg/ProjectedSonarImage", qos=Qos())(b"x", 0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        transport.advertise("/rov/dvl", "marine_acoustic_msgs/msg/Dvl", qos=Qos())(b"x", 0)
        transport.subscribe("/rov/x", "marine_acoustic_msgs/msg/Dvl", lambda raw: None, qos=Qos())
        transport.serve("/x", "marine_acoustic_msgs/srv/X", lambda raw: raw)
    assert not rclpy.nodes[0].publishers
    transport.close()


def test_a_sourced_ros_is_chosen_and_says_where_it_reaches(rclpy: Rclpy, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "23")
    transport, why = make_transport(Ros2Config(type="ros2"))
    assert (transport.name, why, rclpy.contexts[0].domain_id) == ("rclpy", "ROS is sourced", 23)
    assert "without passwords" in transport.reach
    transport.close()
