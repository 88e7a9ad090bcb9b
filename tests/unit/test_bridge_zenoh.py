"""ROS 2 over zenoh against zenoh-ros2-sdk, another implementation of rmw_zenoh's wire; and frozen keys."""

from __future__ import annotations

import logging
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pelagos.bridges.outbox import Outbox
from pelagos.bridges.transport import LATCHED, STREAM, Qos
from pelagos.messages.store import deserialize, make, serialize

pytest.importorskip("zenoh")
sdk = pytest.importorskip("zenoh_ros2_sdk")

from pelagos.bridges.rihs import type_hash  # noqa: E402
from pelagos.bridges.zenoh_transport import ZenohTransport, attachment, qos_text  # noqa: E402

STRING = "std_msgs/msg/String"
TEXT = "string data\n"


def until(condition: Callable[[], Any], seconds: float = 10.0) -> bool:
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    return bool(condition())


@pytest.fixture(scope="module")
def port() -> int:
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return int(s.getsockname()[1])


@pytest.fixture(scope="module")
def transport(port: int) -> Iterator[ZenohTransport]:
    logging.getLogger("zenoh_ros2_sdk").setLevel(logging.ERROR)
    made = ZenohTransport(domain=11, node="pelagos", router=f"tcp/127.0.0.1:{port}")
    yield made
    made.close()


def test_the_sdk_hears_us(transport: ZenohTransport, port: int) -> None:
    got: list[str] = []
    subscriber = sdk.ROS2Subscriber(
        "/chatter", STRING, lambda m: got.append(m.data), TEXT, domain_id=11, router_ip="127.0.0.1", router_port=port,
        type_hash=type_hash(STRING),
    )  # fmt: skip
    write = transport.advertise("/chatter", STRING, qos=STREAM)
    assert until(lambda: write(serialize(STRING, make(STRING, data="hello")), 5) or time.sleep(0.05) or got)
    assert set(got) == {"hello"}
    subscriber.close()


def test_we_hear_the_sdk(transport: ZenohTransport, port: int) -> None:
    got: list[str] = []
    transport.subscribe("/back", STRING, lambda raw: got.append(deserialize(STRING, raw).data), qos=STREAM)
    publisher = sdk.ROS2Publisher(
        "/back", STRING, TEXT, domain_id=11, router_ip="127.0.0.1", router_port=port, type_hash=type_hash(STRING)
    )
    assert until(lambda: publisher.publish(data="there") or time.sleep(0.05) or got)
    assert set(got) == {"there"}
    publisher.close()


def test_the_sdk_calls_a_service_of_ours(transport: ZenohTransport, port: int) -> None:
    kind = "std_srvs/srv/SetBool"

    def answer(raw: bytes) -> bytes:
        asked = deserialize(f"{kind}_Request", raw).data
        return serialize(f"{kind}_Response", make(f"{kind}_Response", success=asked, message="as you say"))

    transport.serve("/pelagos/set_paused", kind, answer)
    client = sdk.ROS2ServiceClient(
        "/pelagos/set_paused", kind, request_definition="bool data\n",
        response_definition="bool success\nstring message\n", domain_id=11, router_ip="127.0.0.1", router_port=port,
        type_hash=type_hash(kind),
    )  # fmt: skip
    found: list[Any] = []
    assert until(lambda: found.append(client.call(data=True)) or found[-1] is not None)
    assert (found[-1].success, found[-1].message) == (True, "as you say")
    client.close()


def test_a_late_joiner_gets_what_is_latched(transport: ZenohTransport, port: int) -> None:
    transport.advertise("/latched", STRING, qos=LATCHED)(serialize(STRING, make(STRING, data="kept")), 0)
    late = ZenohTransport(domain=11, node="late", router=f"tcp/127.0.0.1:{port}")
    got: list[str] = []
    late.subscribe("/latched", STRING, lambda raw: got.append(deserialize(STRING, raw).data), qos=LATCHED)
    assert until(lambda: got)
    assert got == ["kept"]
    late.close()


def test_keys_and_attachments_are_those_of_rmw_zenoh(transport: ZenohTransport) -> None:
    golden = "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b"
    imu = "sensor_msgs/msg/Imu"
    assert transport._key("/rov/imu", imu, imu) == f"11/rov/imu/sensor_msgs::msg::dds_::Imu_/{golden}"
    assert qos_text(Qos(depth=10)) == "::,10:,:,:,,"
    assert qos_text(LATCHED) == ":1:,1:,:,:,,"
    assert qos_text(Qos(depth=5, reliable=False)) == "2::,5:,:,:,,"
    raw = attachment(7, 9, b"g" * 16)
    assert raw == (7).to_bytes(8, "little") + (9).to_bytes(8, "little") + b"\x10" + b"g" * 16
    assert len(raw) == 33


PEER = """
import sys, time
from pelagos.bridges.transport import Qos
from pelagos.bridges.zenoh_transport import ZenohTransport
t = ZenohTransport(domain=11, node="peer", router=f"tcp/127.0.0.1:{sys.argv[1]}")
count = 0
def receive(raw):
    global count
    count += 1
t.subscribe("/big", "std_msgs/msg/String", receive, qos=Qos(depth=5))
while True:
    time.sleep(0.1)
    print(count, flush=True)
"""


@pytest.mark.parametrize("how", [signal.SIGSTOP, signal.SIGKILL])
def test_a_stopped_or_dead_subscriber_slows_nobody(transport: ZenohTransport, port: int, how: signal.Signals) -> None:
    """A subscriber in another process stops reading: writes still return, and what is lost is counted."""
    peer = subprocess.Popen([sys.executable, "-c", PEER, str(port)], stdout=subprocess.PIPE, text=True)
    assert peer.stdout is not None
    outbox = Outbox("zenoh")
    raw = serialize(STRING, make(STRING, data="x" * 1_000_000))
    write = outbox.lane("/big", transport.advertise("/big", STRING, qos=Qos(depth=5)), 5)

    def received() -> int:
        write(raw, 0)
        return int(peer.stdout.readline() or 0)  # type: ignore[union-attr]

    try:
        assert until(lambda: received() > 0, 60.0)
        peer.send_signal(how)
        for _ in range(400):  # 400 MB: far more than any buffer on the way holds
            write(raw, 0)
        assert outbox.dropped["/big"] > 0
        if how == signal.SIGSTOP:
            peer.send_signal(signal.SIGCONT)
            before = received()
            assert until(lambda: received() > before + 3, 60.0)
    finally:
        peer.kill()
        peer.wait()
        peer.stdout.close()
        outbox.close()
    assert not outbox.failed
