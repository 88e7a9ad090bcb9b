"""ROS 2 over DDS: every type, the wire's names, late joiners, stopped and killed peers; on loopback only."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from pelagos.bridges.transport import COMMAND, STREAM, Qos
from pelagos.messages.store import deserialize, make, serialize, typestore

cyclonedds = pytest.importorskip("cyclonedds")

from pelagos.bridges.dds import DdsTransport  # noqa: E402
from pelagos.bridges.dds_flow import LOOK_NS, PATIENCE_NS, RETRY_S, Flow  # noqa: E402
from pelagos.bridges.dds_graph import INFO, Graph  # noqa: E402
from pelagos.bridges.dds_types import idl_class, wire_type  # noqa: E402
from pelagos.bridges.rihs import type_hash  # noqa: E402
from pelagos.bridges.ros2 import Ros2Config, make_transport  # noqa: E402

DOMAIN = 20 + os.getpid() % 80  # so that tests that run side by side do not meet
STRING = "std_msgs/msg/String"


def text(value: str) -> bytes:
    return serialize(STRING, make(STRING, data=value))


def until(condition: Callable[[], Any], seconds: float = 5.0) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.01)
    return bool(condition())


@pytest.fixture
def pair() -> Iterator[tuple[DdsTransport, DdsTransport]]:
    a, b = DdsTransport(domain=DOMAIN, node="a"), DdsTransport(domain=DOMAIN, node="b")
    yield a, b
    a.close()
    b.close()


def default(name: str, depth: int = 0) -> Any:
    """A message of a type with numbers that are not zero and arrays that are not empty."""
    from rosbags.interfaces import Nodetype as T

    store = typestore()

    def value(node: Any) -> Any:
        kind, inner = node
        if kind == T.NAME:
            return default(inner, depth + 1)
        if kind == T.BASE:
            return {"string": "text", "wstring": "text", "bool": True}.get(inner[0], 3)
        element, count = inner
        size = count if kind == T.ARRAY else min(count or 2, 2)
        if element[0] == T.BASE and element[1][0] not in ("string", "wstring", "bool"):
            dtype = {"char": "uint8", "byte": "uint8", "octet": "uint8"}.get(element[1][0], element[1][0])
            return np.arange(1, size + 1).astype(dtype)
        if element[0] == T.BASE and element[1][0] == "bool":
            return np.ones(size, bool)
        return [value(element) for _ in range(size)]

    return store.types[name](**{field: value(node) for field, node in store.fielddefs[name][1]})


def test_the_library_still_has_what_is_called_privately() -> None:
    from cyclonedds import _clayer

    for name in ("ddspy_write", "ddspy_write_ts", "ddspy_take"):
        assert callable(getattr(_clayer, name))
    from cyclonedds.pub import DataWriter

    assert callable(DataWriter._wait_for_acks)


def test_every_type_is_accepted_by_its_own_class(pair: tuple[DdsTransport, DdsTransport]) -> None:
    """Cyclone checks raw samples against the class made of the definition: a wrong class refuses its own CDR."""
    a, _ = pair
    names = [n for n in typestore().fielddefs if "/srv/" not in n and "wstring" not in str(typestore().fielddefs[n])]
    assert len(names) > 150
    for i, name in enumerate(names):
        write = a.advertise(f"/every/t{i}", name, qos=STREAM)
        write(serialize(name, default(name)), 1)
    assert a.troubles == {}


@pytest.mark.parametrize(
    "name",
    ["sensor_msgs/msg/Imu", "sensor_msgs/msg/PointCloud2", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage",
     "marine_acoustic_msgs/msg/ProjectedSonarImage", "marine_acoustic_msgs/msg/Dvl", "sensor_msgs/msg/CameraInfo",
     "pelagos_msgs/msg/Ctd", "holoocean_interfaces/msg/AgentCommand", "simulation_interfaces/msg/EntityState"],
)  # fmt: skip
def test_messages_cross_unchanged(pair: tuple[DdsTransport, DdsTransport], name: str) -> None:
    a, b = pair
    got: list[bytes] = []
    b.subscribe("/x", name, got.append, qos=COMMAND)
    write = a.advertise("/x", name, qos=STREAM)
    sent = serialize(name, default(name))
    assert until(lambda: write(sent, 0) or got)
    assert repr(deserialize(name, got[0])) == repr(deserialize(name, sent))


def test_samples_carry_the_clock_on_the_wall(pair: tuple[DdsTransport, DdsTransport]) -> None:
    """As those of every ROS node do: simulation time is in the messages' own stamps."""
    a, b = pair
    got: list[bytes] = []
    write = a.advertise("/stamped", STRING, qos=STREAM)
    b.subscribe("/stamped", STRING, got.append, qos=STREAM)
    reader = b._readers[-1][0]
    b._readers = []  # the test takes the samples itself
    samples: list[Any] = []

    def arrived() -> bool:
        write(text("now"), 5_000_000_000)
        found = b._c.ddspy_take(reader._ref, 0x3 | 0xC | 0x70, 8)
        samples.extend(found if isinstance(found, list) else [])
        return bool(samples)

    before = time.time_ns()
    assert until(arrived)
    assert before <= samples[0][1].source_timestamp <= time.time_ns()


def test_a_request_that_is_no_message_is_counted(pair: tuple[DdsTransport, DdsTransport]) -> None:
    """The thread that receives for all topics goes on."""
    a, b = pair
    got: list[bytes] = []

    def spoilt(raw: bytes) -> None:
        got.append(raw)
        raise ValueError("no message")

    b.subscribe("/spoilt", STRING, spoilt, qos=STREAM)
    write = a.advertise("/spoilt", STRING, qos=STREAM)
    assert until(lambda: write(text("x"), 0) or len(got) > 2)
    assert until(lambda: b.troubles["requests without an answer (ValueError)"] == len(got))


def test_a_latched_message_reaches_who_comes_late(pair: tuple[DdsTransport, DdsTransport]) -> None:
    a, b = pair
    write = a.advertise("/l", STRING, qos=Qos(depth=3, latched=True))
    for i in range(5):
        write(text(f"{i}"), 0)
    got: list[str] = []
    b.subscribe("/l", STRING, lambda raw: got.append(deserialize(STRING, raw).data), qos=Qos(depth=10, latched=True))
    assert until(lambda: len(got) >= 3)
    assert got == ["2", "3", "4"]


def test_a_service_answers_who_asked(pair: tuple[DdsTransport, DdsTransport]) -> None:
    """The client is built from rmw_cyclonedds's layout: a header of client id and sequence number, echoed."""
    a, b = pair
    kind = "std_srvs/srv/SetBool"

    def answer(raw: bytes) -> bytes:
        asked = deserialize(f"{kind}_Request", raw).data
        return serialize(f"{kind}_Response", make(f"{kind}_Response", success=asked, message="yes" if asked else "no"))

    a.serve("/sim/set_paused", kind, answer)
    got: list[bytes] = []
    b._listen("rr/sim/set_pausedReply", f"{kind}_Response", got.append, Qos(), framed=True)
    send = b._sender(b._writer("rq/sim/set_pausedRequest", f"{kind}_Request", Qos(), framed=True))
    head = (0x1122334455667788).to_bytes(8, "little") + (42).to_bytes(8, "little")
    assert until(lambda: send(b"\0\1\0\0" + head + b"\1", 0) or time.sleep(0.05) or got)
    assert got[0][4:20] == head
    response = deserialize(f"{kind}_Response", got[0][:4] + got[0][20:])
    assert (response.success, response.message) == (True, "yes")


def test_a_long_answer_holds_up_no_command(pair: tuple[DdsTransport, DdsTransport]) -> None:
    a, b = pair
    kind, begun, gate, got = "std_srvs/srv/Trigger", threading.Event(), threading.Event(), threading.Event()

    def answer(raw: bytes) -> bytes:
        begun.set()
        gate.wait(30)
        return serialize(f"{kind}_Response", make(f"{kind}_Response", success=True, message=""))

    a.serve("/sim/long", kind, answer)
    a.subscribe("/held_up", STRING, lambda raw: got.set(), qos=STREAM)
    ask = b._sender(b._writer("rq/sim/longRequest", f"{kind}_Request", Qos(), framed=True))
    say = b.advertise("/held_up", STRING, qos=STREAM)
    assert until(lambda: ask(b"\0\1\0\0" + bytes(range(16)) + b"\0", 0) or begun.wait(0.05))
    assert until(lambda: say(text("stop"), 0) or got.wait(0.05))
    gate.set()


def test_names_and_hashes_on_the_wire(pair: tuple[DdsTransport, DdsTransport]) -> None:
    """Read by Cyclone's own discovery topics, as `ros2 topic info -v` does."""
    from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication

    a, b = pair
    a.advertise("/rov/imu", "sensor_msgs/msg/Imu", qos=STREAM)
    reader = BuiltinDataReader(b._participant, BuiltinTopicDcpsPublication)
    seen: dict[str, Any] = {}

    def look() -> bool:
        for sample in reader.take(100):
            seen[sample.topic_name] = sample
        return "rt/rov/imu" in seen

    assert until(look)
    found = seen["rt/rov/imu"]
    assert found.type_name == "sensor_msgs::msg::dds_::Imu_"
    user_data = next(p for p in found.qos if type(p).__name__ == "Userdata")
    golden = "7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b"
    assert user_data.data == f"typehash=RIHS01_{golden};".encode()


def test_hashes_are_those_of_ros() -> None:
    """From `ros2 interface` and rosidl of Jazzy."""
    assert type_hash("std_srvs/srv/SetBool").startswith("RIHS01_abe9e4bb")
    assert type_hash("std_srvs/srv/Trigger").startswith("RIHS01_eeff2cd6")
    assert type_hash("std_srvs/srv/Empty").startswith("RIHS01_5888399d")
    assert wire_type("std_srvs/srv/Empty_Request") == "std_srvs::srv::dds_::Empty_Request_"


def test_the_graph_names_the_node(pair: tuple[DdsTransport, DdsTransport]) -> None:
    a, b = pair
    a.advertise("/one", STRING, qos=STREAM)
    got: list[bytes] = []
    kind = b._topic.Topic(b._participant, "ros_discovery_info", idl_class(INFO))
    reader = b._sub.DataReader(b._participant, kind, qos=b._qos(Qos(depth=50, latched=True), INFO))

    def nodes() -> dict[str, int]:
        for raw, info in b._c.ddspy_take(reader._ref, 0x7F, 10) or ():
            if info.valid_data:
                got.append(bytes(raw))
        found = [deserialize(INFO, raw).node_entities_info_seq[0] for raw in got]
        return {node.node_name: len(node.writer_gid_seq) for node in found}

    assert until(lambda: nodes().get("a") == 1)


def test_humbles_graph_has_longer_ids() -> None:
    sent: list[bytes] = []
    graph = Graph(b"p" * 16, "node", "/", 24, lambda raw, t: sent.append(raw))
    graph.add_writer(b"w" * 16)
    raw = sent[-1]
    assert raw[4:28] == b"p" * 16 + b"\0" * 8
    assert raw.endswith(b"w" * 16 + b"\0" * 8)
    assert Graph(b"p" * 16, "node", "/", 16, lambda raw, t: None).message()[4:20] == b"p" * 16


PEER = """
import sys, time
from pelagos.bridges.dds import DdsTransport
from pelagos.bridges.transport import Qos
t = DdsTransport(domain=int(sys.argv[1]), node="peer")
count = 0
def receive(raw):
    global count
    count += 1
    if count == 1:
        print("first", flush=True)
t.subscribe("/big", "sensor_msgs/msg/Image", receive, qos=Qos(depth=5))
print("ready", flush=True)
while True:
    time.sleep(0.2)
    print(count, flush=True)
"""


@pytest.mark.parametrize(("how", "large"), [(signal.SIGSTOP, True), (signal.SIGKILL, False)])
def test_a_stopped_or_dead_subscriber_slows_nobody(how: signal.Signals, large: bool) -> None:
    """A reliable subscriber in another process stops reading: every write of 1 MB still returns at once."""
    peer = subprocess.Popen([sys.executable, "-c", PEER, str(DOMAIN)], stdout=subprocess.PIPE, text=True)
    transport = DdsTransport(domain=DOMAIN, node="sim")
    try:
        assert peer.stdout is not None
        assert peer.stdout.readline().strip() == "ready"
        image = make("sensor_msgs/msg/Image", header=default("std_msgs/msg/Header"), height=512, width=2048,
                     encoding="mono8", is_bigendian=0, step=2048, data=np.ones(1 << 20, np.uint8))  # fmt: skip
        raw = serialize("sensor_msgs/msg/Image", image)
        write = transport.advertise("/big", "sensor_msgs/msg/Image", qos=Qos(depth=5, large=large))
        got = [False]

        def first() -> bool:
            write(raw, 0)
            time.sleep(0.05)
            return _said(peer, "first", got)

        assert until(first, 20.0)
        peer.send_signal(how)
        for _ in range(60):
            write(raw, 0)
            time.sleep(0.002)
        # a write that waited would have come back with "timeout"; what waits in the queue is dropped and counted
        assert set(transport.troubles) <= {"/big: dropped"}
        if how == signal.SIGSTOP:
            started = time.monotonic()
            transport.settle(0.3)  # a reader that does not answer is given up when the time is over, and nothing else
            assert 0.25 < time.monotonic() - started < 3.0
        if how == signal.SIGSTOP:
            peer.send_signal(signal.SIGCONT)
            before = _count(peer)
            assert until(lambda: write(raw, 0) or _count(peer) > before + 3, 20.0)
    finally:
        peer.kill()
        peer.wait()
        assert peer.stdout is not None
        peer.stdout.close()
        transport.close()


def _said(peer: Any, word: str, got: list[bool]) -> bool:
    import select

    while not got[0] and select.select([peer.stdout], [], [], 0)[0]:
        got[0] = peer.stdout.readline().strip() == word
    return got[0]


def _count(peer: Any) -> int:
    return int(peer.stdout.readline() or 0)


def test_a_burst_of_large_messages_arrives_whole(pair: tuple[DdsTransport, DdsTransport]) -> None:
    """Six times as many as the writer keeps, written at once: a writer alone would replace most of them unread."""
    a, b = pair
    kind = "std_msgs/msg/UInt8MultiArray"
    layout = make("std_msgs/msg/MultiArrayLayout", dim=[], data_offset=0)
    raws = [serialize(kind, make(kind, layout=layout, data=np.full(1 << 20, i + 1, dtype=np.uint8))) for i in range(30)]
    got: list[int] = []
    b.subscribe("/burst", kind, lambda raw: got.append(raw[-1]), qos=Qos(depth=40))
    write = a.advertise("/burst", kind, qos=Qos(depth=5, large=True))
    assert until(lambda: write(raws[0], 0) or time.sleep(0.05) or got)  # they have met
    until(lambda: not a.waiting)
    got.clear()
    for raw in raws[1:]:
        write(raw, 0)
    assert until(lambda: 30 in got)
    assert [i for i in got if i > 1] == list(range(2, 31))


TIMEOUT = -10  # DDS_RETCODE_TIMEOUT, as cyclonedds returns it


class _Readers:
    """A writer's readers, as cyclonedds tells of them."""

    def __init__(self, *answers: bool) -> None:
        self.answers = list(answers)
        self.asked = 0
        self.waited_ns: list[int] = []

    _ref = 7

    def _wait_for_acks(self, ref: int, timeout_ns: int) -> int:
        assert ref == self._ref
        self.asked += 1
        self.waited_ns.append(timeout_ns)
        return 0 if self.answers.pop(0) else TIMEOUT


def test_a_reader_that_does_not_answer_is_waited_for_once() -> None:
    """Twelve messages at a depth of two: six times to wait, if all is well; after a refusal nobody is asked for 1 s."""
    sent: list[int] = []
    now = [5.0]
    slow, quick = _Readers(True, False, True), _Readers(*[True] * 6)
    for readers in (slow, quick):
        flow = Flow(readers, lambda raw, t: sent.append(t), 2, clock=lambda: now[0])
        for i in range(12):
            flow.write(b"x", i)
    assert sent == [*range(12), *range(12)]
    assert (slow.asked, quick.asked) == (2, 6)
    flow = Flow(_Readers(False), lambda raw, t: None, 1, clock=lambda: now[0])
    flow.write(b"x", 0)
    now[0] += RETRY_S
    with pytest.raises(IndexError):  # asks again, and the list of answers is empty
        flow.write(b"x", 1)


def test_readers_take_two_megabytes_before_more_follow() -> None:
    """1.2 MB each at a depth of 5: every second one is waited for; one that was too slow gets a short look, until it
    answers again."""
    readers, now = _Readers(True, False, False, True, True), [1.0]
    flow = Flow(readers, lambda raw, t: None, 5, clock=lambda: now[0])
    raw = memoryview(bytes(1_200_000))
    for i in range(10):
        flow.write(raw, i)
        now[0] += 1.01 * RETRY_S / 2
    assert readers.asked == 5
    assert readers.waited_ns == [PATIENCE_NS, PATIENCE_NS, LOOK_NS, LOOK_NS, PATIENCE_NS]


@pytest.mark.parametrize(
    ("distro", "octets"), [("humble", 24), ("iron", 16), ("jazzy", 16), ("kilted", 16), ("lyrical", 16)]
)
def test_ids_of_the_graph_are_those_of_the_distribution(distro, octets, monkeypatch):
    """RMW_GID_STORAGE_SIZE of rmw: 24 in Humble, 16 from Iron on."""
    asked: dict[str, Any] = {}
    monkeypatch.setattr("pelagos.bridges.dds.DdsTransport", lambda **keys: asked.update(keys))
    make_transport(Ros2Config(type="ros2", transport="dds", distro=distro))
    assert asked["gid_bytes"] == octets


def test_messages_go_in_the_representation_that_ros_reads(pair: tuple[DdsTransport, DdsTransport]) -> None:
    """ROS 2's middlewares write and read XCDR version 1, `CDR` of DDS-XTypes 1.3, Section 7.6.3.1.1."""
    a, _ = pair
    for qos in (STREAM, COMMAND):
        asked = {type(p).__qualname__: p for p in a._qos(qos, STRING)}
        assert asked["Policy.DataRepresentation"] == a._policy.DataRepresentation(use_cdrv0_representation=True)
