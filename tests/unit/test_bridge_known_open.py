"""Open doors: what is announced to ROS 2 by rclpy, zenoh and DDS, what rosbridge and Foxglove say to their
clients, ports of instruments, recordings that are played, copied and repeated. Libraries are stand-ins that keep what
they are told."""

from __future__ import annotations

import json
import os
import socket
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from test_bridge_rclpy import Rclpy, Trigger, rclpy  # noqa: F401
from test_bridge_wire import filled

import pelagos as pl
from known import DOUBLE, EXACT, check, on_one_scale
from pelagos.bridges import zenoh_transport
from pelagos.bridges.clerk import Clerk
from pelagos.bridges.dds import DdsTransport
from pelagos.bridges.dds_graph import Graph
from pelagos.bridges.exchange import Exchange
from pelagos.bridges.foxglove_transport import FoxgloveTransport, _listener
from pelagos.bridges.instrument import InstrumentConfig
from pelagos.bridges.instruments.ports import open_port, parsed_port
from pelagos.bridges.journal import Repeat, recorded_orders
from pelagos.bridges.part import Part
from pelagos.bridges.playback import Playback
from pelagos.bridges.rclpy_transport import RclpyTransport
from pelagos.bridges.ros2 import Ros2Config
from pelagos.bridges.rosbag import write_rosbag
from pelagos.bridges.rosbridge import RosbridgeTransport
from pelagos.bridges.rosbridge_client import Client
from pelagos.bridges.transport import COMMAND, LATCHED, MemoryTransport, Qos, ros2_name
from pelagos.bridges.zenoh_transport import ZenohTransport
from pelagos.errors import PelagosError
from pelagos.messages.json_form import from_json, to_json
from pelagos.messages.store import deserialize, serialize
from pelagos.sim.order import Order

TEXT, TWIST, IMU = "std_msgs/msg/String", "geometry_msgs/msg/Twist", "sensor_msgs/msg/Imu"
SCENARIO: dict[str, Any] = {
    "seed": 3,
    "tick_rate_hz": 100,
    "world": {"type": "flat", "depth_m": 20.0},
    "agents": {
        "auv": {
            "vehicle": "remus100",
            "start": {"position_m": [3, -2], "depth_m": 5.0, "heading_deg": 35, "speed_mps": 1.5},
            "sensors": {
                "imu": {"type": "imu", "rate_hz": 50},
                "depth": {"type": "depth", "rate_hz": 10},
                "dvl": {"type": "dvl", "rate_hz": 10},
            },
        }
    },
}


def known(case: str, found: dict[str, Any], share: float = EXACT) -> None:
    check("open_doors", case, {name: on_one_scale(v) for name, v in found.items()}, share)


@pytest.fixture(scope="module")
def sim() -> pl.Simulation:
    return pl.Simulation.load(SCENARIO)


def settled(true: Callable[[], object]) -> None:
    end = time.monotonic() + 20.0
    while not true():
        assert time.monotonic() < end
        time.sleep(0.002)


def echo(kind: str) -> Callable[[bytes], bytes]:
    """Answers of a service of that type, all fields filled."""
    return lambda request: serialize(f"{kind}_Response", filled(f"{kind}_Response"))


QOS = (Qos(), LATCHED, COMMAND, Qos(depth=50, large=True), Qos(depth=3, reliable=False, latched=True))


def test_what_rclpy_is_told(rclpy: Rclpy) -> None:  # noqa: F811
    transport, got = RclpyTransport(domain=9, node="us"), list[bytes]()
    for k, qos in enumerate(QOS):
        transport.advertise(f"/said{k}", TEXT, qos=qos)(memoryview(serialize(TEXT, filled(TEXT))), 5 + k)
        transport.subscribe(f"/heard{k}", TEXT, got.append, qos=qos)
    transport.serve("/ask", "std_srvs/srv/Trigger", echo("std_srvs/srv/Trigger"))
    (node,) = rclpy.nodes
    for _, take, _ in node.subscriptions.values():
        take(serialize(TEXT, filled(TEXT)))
        take(b"\0\1\0\0")
    answer = node.services["/ask"][1](Trigger.Request(), Trigger.Response())
    transport.settle(0.0)
    found = {
        "said": [
            [t, p.sent, {k: int(v) for k, v in vars(p.qos).items()}, len(p.waited)] for t, p in node.publishers.items()
        ],
        "heard": [[t, {k: int(v) for k, v in vars(q).items()}] for t, (_, _, q) in node.subscriptions.items()],
        "got": [got, transport.readers(), answer.success, answer.message, node.name, rclpy.contexts[0].domain_id],
    }
    transport.close()
    known("rclpy", found)


class Zenoh:
    """A session that keeps what is declared and put."""

    class ZError(Exception):
        pass

    CongestionControl = SimpleNamespace(DROP="drop")

    def __init__(self) -> None:
        self.kept: list[Any] = []
        self.takes: list[Any] = []
        self.opened: list[Any] = []

    class Config:
        def __init__(self) -> None:
            self.told: list[Any] = []

        def insert_json5(self, key: str, value: str) -> None:
            self.told.append([key, value])

    def open(self, config: Any) -> Any:
        self.opened.append(config.told)
        return self

    def zid(self) -> str:
        return "abc"

    def liveliness(self) -> Any:
        return SimpleNamespace(declare_token=lambda key: self.kept.append(["token", key]))

    def declare_publisher(self, key: str, **options: Any) -> Any:
        self.kept.append(["publisher", key, options])
        put = lambda raw, attachment: self.kept.append(["put", key, raw, attachment])
        return SimpleNamespace(put=put, matching_status=SimpleNamespace(matching=len(self.kept) % 2))

    def declare_advanced_publisher(self, session: Any, key: str, *, cache: Any, **options: Any) -> Any:
        return self.declare_publisher(key, cache=cache, **options)

    def declare_subscriber(self, key: str, take: Any, **options: Any) -> None:
        self.kept.append(["subscriber", key, options])
        self.takes.append(take)

    def declare_advanced_subscriber(self, session: Any, key: str, take: Any, **options: Any) -> None:
        self.declare_subscriber(key, take, **options)

    def declare_queryable(self, key: str, respond: Any, *, complete: bool) -> None:
        self.kept.append(["queryable", key, complete])
        self.takes.append(respond)

    CacheConfig = HistoryConfig = staticmethod(lambda *depth, **keys: [depth, keys])

    def close(self) -> None:
        self.kept.append("closed")


@pytest.mark.parametrize("hashes", [True, False])
def test_what_zenoh_is_told(hashes: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Keys, liveliness tokens and attachments of rmw_zenoh."""
    monkeypatch.delenv("ZENOH_SESSION_CONFIG_URI", raising=False)
    monkeypatch.setenv("ZENOH_CONFIG_OVERRIDE", "a/b=3;c=[1]")
    session = Zenoh()
    monkeypatch.setattr(zenoh_transport, "require", lambda name, **about: session)
    monkeypatch.setattr(zenoh_transport.os, "urandom", lambda size: bytes(range(size)))
    monkeypatch.setattr(zenoh_transport.time, "time_ns", lambda: 1_700_000_000_123_456_789)
    transport = ZenohTransport(domain=4, node="us", hashes=hashes, loopback=hashes)
    got: list[Any] = []
    for k, qos in enumerate(QOS):
        write = transport.advertise(f"/said/it{k}", IMU if k else TEXT, qos=qos)
        write(b"abc", 5)
        write(memoryview(b"abcd"), 6)
        transport.subscribe(f"/heard{k}", TWIST, got.append, qos=qos)
        session.takes[-1](SimpleNamespace(payload=SimpleNamespace(to_bytes=lambda: b"taken")))
    transport.serve("/ask/it", "std_srvs/srv/SetBool", lambda raw: raw[::-1] if raw != b"bad" else b"" + 3)  # type: ignore[operator]
    for payload, attached in ((b"why", b"who"), (b"how", None), (b"bad", None), (None, None)):
        session.takes[-1](
            SimpleNamespace(
                payload=None if payload is None else SimpleNamespace(to_bytes=lambda p=payload: p),
                key_expr="k",
                attachment=None if attached is None else SimpleNamespace(to_bytes=lambda a=attached: a),
                reply=lambda key, told, attachment: got.append([key, told, attachment]),
            )
        )
    readers = transport.readers()
    transport.close()
    found = {
        "kept": session.kept,
        "opened": session.opened,
        "got": got,
        "troubles": transport.troubles,
        "about": [transport.reach, readers],
    }
    known(f"zenoh {'with' if hashes else 'without'} hashes", found)


@pytest.mark.parametrize("size", [16, 24])
def test_the_graph_of_dds(size: int) -> None:
    sent: list[Any] = []
    graph = Graph(bytes(range(3, 19)), "node", "/space", size, lambda raw, t_ns: sent.append([raw, t_ns]))
    for k in range(3):
        graph.add_reader(bytes([k] * 16))
        graph.add_writer(bytes([100 + k] * 16))
    known(f"graph of {size}", {"sent": sent, "lengths": [len(raw) for raw, _ in sent]})


ANSWERS = 23  # of rosbridge, to all that its client says below


def test_services_over_dds() -> None:
    """The header of a request, between the encapsulation and its fields, goes back with the answer."""
    door, sent, announced = object.__new__(DdsTransport), list[Any](), list[Any]()
    takes: list[Callable[[bytes], None]] = []
    door.troubles, door._clerks = Counter(), []
    door._graph = SimpleNamespace(add_writer=lambda guid: announced.append(guid))  # type: ignore[assignment]
    writer = SimpleNamespace(guid=SimpleNamespace(bytes=b"guid"))

    def written(topic: str, type_name: str, qos: Qos, *, framed: bool) -> Any:
        announced.append([topic, type_name, qos, framed])
        return writer

    def listened(topic: str, type_name: str, take: Any, qos: Qos, *, framed: bool) -> None:
        announced.append([topic, type_name, qos, framed])
        takes.append(take)

    door._writer, door._listen = written, listened  # type: ignore[method-assign,assignment]
    door._sender = lambda made: lambda raw, t_ns: sent.append([raw, t_ns])  # type: ignore[method-assign]
    door.serve("/ask", "std_srvs/srv/SetBool", lambda raw: raw[:4] + raw[4:][::-1] + b"!")
    takes[0](bytes(range(40)))
    settled(lambda: sent)
    door._clerks[0].close()
    known("services over DDS", {"sent": sent, "announced": announced})


def test_what_rosbridges_clients_are_told() -> None:
    pytest.importorskip("websockets")
    door = object.__new__(RosbridgeTransport)
    door._types, door._latched, door._receivers, door._services = {}, {}, {}, {}
    door._clients, door._origins, door.troubles = (), ("localhost", "lab.example.org"), Counter()
    said: list[Any] = []
    wire: Any = SimpleNamespace(
        send=lambda text: said.append(json.loads(text)), socket=SimpleNamespace(close=lambda: None)
    )
    client = Client(wire, door._operations(), door.troubles)
    door._clients, got = (client,), list[Any]()
    writes = {
        name: door.advertise(name, kind, qos=qos)
        for name, kind, qos in (("/imu", IMU, Qos()), ("/label", TEXT, LATCHED), ("/quiet", TEXT, Qos()))
    }
    door.subscribe("/cmd", TWIST, lambda cdr: got.append(deserialize(TWIST, cdr)), qos=COMMAND)
    door.serve("/ask", "std_srvs/srv/SetBool", echo("std_srvs/srv/SetBool"))
    writes["/label"](serialize(TEXT, filled(TEXT)), 3)
    twist = {"linear": {"x": 0.4, "y": -0.3}, "angular": {"z": 0.2}}
    for message in (
        {"op": "subscribe", "topic": "imu", "type": "sensor_msgs/Imu"},
        {"op": "subscribe", "topic": "/label"},
        {"op": "subscribe", "topic": "/none"},
        {"op": "subscribe", "topic": "/imu", "type": "x/Y"},
        {"op": "subscribe", "topic": "/quiet", "compression": "png"},
        {"op": "subscribe", "topic": "/quiet", "queue_length": -1},
        {"op": "subscribe", "topic": "/quiet", "throttle_rate": 1e9, "queue_length": 2.5},
        {"op": "subscribe"},
        {"op": "advertise", "topic": "/cmd", "type": "geometry_msgs/msg/Twist"},
        {"op": "advertise", "topic": "/cmb"},
        {"op": "publish", "topic": "cmd", "msg": twist},
        {"op": "publish", "topic": "/cmd", "msg": {"linear": {"x": "a"}}},
        {"op": "publish", "topic": "/cmd", "msg": {"lin": 3}},
        {"op": "unadvertise", "topic": "/cmd"},
        {"op": "fly"},
        [3],
        {"op": "call_service", "service": "/ask", "id": "i7", "args": {"data": True}},
        {"op": "call_service", "service": "/aks"},
        {"op": "call_service", "service": "/ask", "args": {"data": "x"}},
        {"op": "call_service", "service": "/rosapi/topics"},
        {"op": "call_service", "service": "/rosapi/topic_type", "args": {"topic": "/cmd"}, "id": 4},
        {"op": "call_service", "service": "/rosapi/services"},
        {"op": "call_service", "service": "/rosapi/service_type", "args": {"service": "/ask"}},
    ):
        count = len(said)
        client.take(json.dumps(message))
        if isinstance(message, dict) and message.get("op") == "call_service":
            settled(lambda n=count: len(said) > n)
        settled(lambda: not client._outbox.waiting)
    client.take(b"{rubbish")
    for k in range(3):
        writes["/imu"](serialize(IMU, filled(IMU)), k)
        writes["/quiet"](serialize(TEXT, filled(TEXT)), k)
    settled(lambda: len(said) >= ANSWERS)
    client.take(json.dumps({"op": "unsubscribe", "topic": "/imu"}))
    writes["/imu"](serialize(IMU, filled(IMU)), 9)
    time.sleep(0.05)
    welcomed = [
        door._welcome(
            SimpleNamespace(respond=lambda code, text: [code, text]),
            SimpleNamespace(headers={"Origin": o} if o else {}),
        )
        for o in (None, "http://localhost:80", "https://lab.example.org", "http://evil.example")
    ]
    client.close()
    for _, _, clerk in door._services.values():
        clerk.close()
    shown = [
        {k: v if k != "msg" or not isinstance(v, str) else v.partition(" (")[0] for k, v in s.items()} for s in said
    ]
    known(
        "rosbridge",
        {
            "said": shown,
            "got": got,
            "troubles": dict(door.troubles),
            "welcomed": welcomed,
            "names": [ros2_name(n) for n in ("geometry_msgs/Twist", "a/msg/B", "B")],
        },
    )


def test_what_foxgloves_library_is_told() -> None:
    kept: list[Any] = []

    class Channel:
        def __init__(self, topic: str, *, schema: Any, message_encoding: str, context: Any) -> None:
            kept.append(["channel", topic, schema.name, schema.encoding, message_encoding])
            self.topic = topic

        def id(self) -> int:
            return len(self.topic)

        def log(self, raw: bytes, *, log_time: int) -> None:
            kept.append([self.topic, raw, log_time])

    plain = lambda **keys: SimpleNamespace(**keys)
    ws = SimpleNamespace(MessageSchema=plain, ServiceSchema=plain, Service=plain, ServerListener=object)
    door = object.__new__(FoxgloveTransport)
    door._sdk, door._ws, door._context = SimpleNamespace(Channel=Channel, Schema=plain), ws, None
    door._receivers, door._latched, door._listening, door.troubles = {}, {}, set(), Counter()
    import threading

    door._lock = threading.Lock()
    door._server = SimpleNamespace(
        broadcast_time=lambda t_ns: kept.append(["time", t_ns]),
        add_services=lambda made: kept.append(made),
        stop=lambda: None,
    )
    for topic, kind, qos in (
        ("/clock", "rosgraph_msgs/msg/Clock", Qos()),
        ("/imu", IMU, Qos()),
        ("/labels", TEXT, LATCHED),
    ):
        door.advertise(topic, kind, qos=qos)(serialize(kind, filled(kind)), 1234)
    heard: list[Any] = []
    door.subscribe("/cmd", TWIST, heard.append, qos=COMMAND)
    door.serve("/ask", "std_srvs/srv/SetBool", lambda raw: raw[::-1])
    (service,) = kept.pop()
    kept.append(
        [
            service.name,
            service.schema.name,
            service.schema.request.schema.name,
            service.schema.response.encoding,
            service.handler(SimpleNamespace(payload=b"abc")),
        ]
    )
    listener, client = _listener(door, ws), SimpleNamespace(id=3)
    channel = lambda number, topic="/cmd", encoding="cdr", kind="geometry_msgs/Twist": SimpleNamespace(
        id=number, topic=topic, encoding=encoding, schema_name=kind
    )
    for number in (len("/labels"), len("/imu"), 99):
        listener.on_subscribe(client, channel(number))
    listener.on_unsubscribe(client, channel(99))
    for number, keys in enumerate(({}, {"topic": "/cmb"}, {"encoding": "json"}, {"kind": "a/B"})):
        listener.on_client_advertise(client, channel(number, **keys))
        listener.on_message_data(client, number, b"raw")
    listener.on_client_unadvertise(client, 0)
    listener.on_message_data(client, 0, b"raw")
    known("foxglove", {"kept": kept, "heard": heard, "troubles": dict(door.troubles), "readers": door.readers()})


def complaint(do: Callable[[], object]) -> str:
    try:
        return str(do())
    except PelagosError as error:
        return str(error)


PORTS = (
    "pty:/tmp/gps",
    "tcp:16171",
    "tcp:0.0.0.0:80",
    "udp:14551",
    "udp-server:host:9",
    "tpc:1",
    "tcp:70000",
    "tcp:",
    "udp:x",
)


def test_ports_of_instruments(sim: pl.Simulation, tmp_path: Path) -> None:
    """A driver on each kind of port reads what is written there, and asks."""
    found: dict[str, Any] = {"parsed": [complaint(lambda p=p: parsed_port(p)) for p in PORTS]}  # type: ignore[misc]
    sentence = b"$IT,1.5*00\r\n"
    tcp, listening = open_port("tcp:0"), socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    listening.bind(("127.0.0.1", 0))
    listening.settimeout(5)
    udp, asked = open_port(f"udp:{listening.getsockname()[1]}"), open_port("udp-server:0")
    pty = open_port(f"pty:{tmp_path / 'it'}")
    with socket.create_connection(("127.0.0.1", tcp.port), timeout=5) as driver:  # type: ignore[attr-defined]
        driver.sendall(b"who")
        heard: list[Any] = []
        settled(lambda: heard.extend(tcp.read()) or heard)
        tcp.write(sentence)
        tcp.reply(heard[0][0], b"me")
        found["tcp"] = [heard[0][1], driver.recv(len(sentence), socket.MSG_WAITALL), driver.recv(2, socket.MSG_WAITALL)]
    udp.write(sentence)
    found["udp"] = [listening.recv(100), udp.where.partition(":")[0], udp.read()]
    asked.write(b"nobody")
    listening.sendto(b"ask", ("127.0.0.1", asked.port))  # type: ignore[attr-defined]
    heard = []
    settled(lambda: heard.extend(asked.read()) or heard)
    asked.write(sentence)
    found["asked"] = [heard[0][1], listening.recv(100)]
    line = os.open(pty.where, os.O_RDWR | os.O_NOCTTY)
    pty.write(sentence)
    os.write(line, b"why")
    heard = []
    settled(lambda: heard.extend(pty.read()) or heard)
    found["pty"] = [os.read(line, 100), heard[0][1], dict(pty.troubles)]
    os.close(line)
    for port in (tcp, udp, asked, pty):
        port.close()
    listening.close()
    found["gone"] = [(tmp_path / "it").exists(), complaint(lambda: open_port("tcp:300.1.1.1:5"))[:20]]
    known("ports", found)


INSTRUMENTS: tuple[dict[str, Any], ...] = (
    {"protocol": "nmea", "sensors": ("depth",), "port": "tcp:0"},
    {"protocol": "pd6", "sensors": ("auv.dvl",), "port": "udp:5"},
    {"protocol": "mip", "sensors": ("imu",), "port": "udp-server:0.0.0.0:77"},
    {"protocol": "waterlinked", "sensors": ("dvl",), "port": "pty:/tmp/x"},
    {"protocol": "nmea", "sensors": ("imu",), "port": "tcp:0"},
    {"protocol": "nmea", "sensors": ("dpeth",), "port": "tcp:0"},
    {"protocol": "nmea", "sensors": ("depth",), "agent": "b", "port": "tcp:0"},
)


def test_an_instruments_door(sim: pl.Simulation) -> None:
    sim.reset()
    made = [InstrumentConfig(type="instrument", **keys) for keys in INSTRUMENTS]
    found: dict[str, Any] = {
        "listens": [c.listens() for c in made],
        "checked": [complaint(lambda c=c: c.check(sim)) for c in made],
    }
    exchange = Exchange(sim, rate_hz=20.0)
    said = InstrumentConfig(
        type="instrument", protocol="waterlinked_serial", sensors=("dvl",), port="udp-server:0"
    ).attach(exchange)
    door: Any = exchange.doors[0]
    driver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    driver.settimeout(5)
    driver.sendto(b"wcv\r\nbad\n", ("127.0.0.1", door.port.port))
    exchange.run(0.5)
    lines = b"".join(driver.recv(4096) for _ in range(2))
    found["said"] = [said.partition("udp")[0], door.spoken, door.name, lines[:9], lines.count(b"wrz") > 0]
    found["report"] = [exchange.close()]
    driver.close()
    known("an instrument's door", found)


@pytest.mark.parametrize("tf", ["truth", "mounts", "none"])
def test_what_ros2_opens(sim: pl.Simulation, tf: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    sim.reset()
    transport: Any = MemoryTransport()
    monkeypatch.setattr("pelagos.bridges.ros2.make_transport", lambda config: (transport, "as asked"))
    monkeypatch.setenv("ROS_DOMAIN_ID", "17")
    exchange = Exchange(sim, rate_hz=10.0)
    keys: dict[str, Any] = {
        "truth": {"holoocean": True},
        "mounts": {"commands": False, "services": False, "node": "us"},
        "none": {"clock": False, "topics": ("/auv/imu", "/labels"), "domain_id": 5},
    }[tf]
    said = Ros2Config(type="ros2", tf=tf, **keys).attach(exchange)
    exchange.run(0.2)
    found = {
        "said": said,
        "topics": [[t, transport.types.get(t), len(w)] for t, w in transport.written.items()],
        "taken": [sorted(transport._receivers), sorted(transport._services)],
    }
    exchange.close()
    known(f"ros2 {tf}", found)


def test_recordings_played_copied_and_repeated(sim: pl.Simulation, tmp_path: Path) -> None:
    sim.reset()
    path, exchange = tmp_path / "it.mcap", Exchange(sim, rate_hz=20.0)
    orders = iter(
        [
            Order("setpoint", "auv", {"depth": 7.5, "heading": -0.4}, "me"),
            Order("mode", "auv", {"mode": "actuators"}),
            Order("command", "auv", {"values": [0.1, -0.2, 900.0]}),
            Order("command", "b", {"values": [0.1]}),
        ]
    )
    telling = sim.on_tick(
        lambda s: s.time_ns and exchange.inbox.put(next(orders, Order("mode", "auv", {"mode": "x"}))), rate_hz=10
    )
    exchange.run(0.6, record=path)
    telling.cancel()
    refused = exchange.close()
    end = sim.state["auv"]
    found: dict[str, Any] = {
        "orders": [[tick, o.kind, o.target, o.data, o.source] for tick, o in recorded_orders(path)],
        "refused": sorted(refused.values()),
        "end": [end.position - [[3, -2, -5]], end.attitude, end.velocity],
    }
    sim.reset()
    again = Exchange(sim)
    Repeat(sim, path, note=again.note)
    again.run(0.6, record=tmp_path / "again.mcap")
    found["repeated"] = [
        sim.state["auv"].position - end.position,
        recorded_orders(tmp_path / "again.mcap") == recorded_orders(path),
    ]
    part = Part(path, start_s=0.1, end_s=0.45, only=("/auv/imu", "/tf", "/auv/depth"))
    playback, transport = Playback(part, rate=0.0), MemoryTransport()
    playback.add(transport)
    found["played"] = [playback.play(), playback.topics, part.first_ns, transport.order, len(part.legend) > 9]
    found["imu"] = [to_json(deserialize(IMU, raw)) for _, raw in transport.written["/auv/imu/data_raw"]]
    playback.close()
    count = write_rosbag(path, tmp_path / "bag", end_s=0.3, only=("/auv/imu", "/labels", "/tf_static"))
    from rosbags.rosbag2 import Reader

    with Reader(tmp_path / "bag") as bag:
        found["bag"] = [
            count,
            [[c.topic, t, len(raw)] for c, t, raw in bag.messages() if c.topic != "/labels"],
            [[c.topic, c.msgtype, c.msgcount] for c in bag.connections],
        ]
    found["wrong"] = [
        complaint(lambda k=k: Part(path, **k)).partition("it.mcap")[2]
        for k in (
            {"start_s": 5.0},
            {"only": ("/b",)},
        )
    ]
    known("recordings", found, DOUBLE)


def test_a_clerk_and_pace() -> None:
    from pelagos.bridges.pace import Pace

    troubles, done = Counter[str](), list[int]()
    clerk = Clerk("it", troubles)
    clerk.ask(lambda: done.append(1))
    clerk.ask(lambda: 1 / 0)
    clerk.ask(lambda: done.append(2))
    settled(lambda: len(done) == 2)
    clerk.close()
    pace = Pace(0.0)
    pace.keep(5)
    before = pace.jitter_ms()
    pace.late = [0.001, 0.002, 0.004]
    known("clerk and pace", {"done": done, "troubles": dict(troubles), "jitter": [before, pace.jitter_ms()]})


def test_empty_forms() -> None:
    """Left-out fields are 0 or empty; lists and bytes of both forms."""
    from pelagos.errors import InputError

    told = [
        (IMU, {}),
        (TWIST, {"linear": {"x": 3}}),
        ("std_msgs/msg/UInt8MultiArray", {"data": "AQL6"}),
        ("std_msgs/msg/UInt8MultiArray", {"data": [1, 250]}),
        (IMU, {"orientation_covariance": [1.0] * 9}),
        ("tf2_msgs/msg/TFMessage", {"transforms": [{"child_frame_id": "a"}, {}]}),
        ("std_msgs/msg/Bool", {"data": 1}),
    ]
    wrong = [
        (IMU, {"orientation_covariance": [1.0]}),
        (TWIST, {"linear": 3}),
        (TWIST, []),
        ("std_msgs/msg/UInt8MultiArray", {"data": "?"}),
        ("std_msgs/msg/UInt8MultiArray", {"data": [300]}),
        (TEXT, {"data": 3}),
        ("std_msgs/msg/Bool", {"data": "x"}),
        ("tf2_msgs/msg/TFMessage", {"transforms": 3}),
        (IMU, {"orientation_covariance": 3}),
        ("std_msgs/msg/Float64", {"data": True}),
    ]
    refused = []
    for name, data in wrong:
        with pytest.raises(InputError) as error:
            from_json(name, data)
        refused.append(str(error.value))
    known("forms", {"made": [serialize(name, from_json(name, data)) for name, data in told], "refused": refused})
