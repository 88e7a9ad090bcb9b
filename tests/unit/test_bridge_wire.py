"""What every type looks like on the wire: its RIHS01 hash, and the CDR bytes of one message, frozen.

`bridge_wire.json` beside this file is made by `python tests/unit/test_bridge_wire.py`. Why it is believed: the hashes
are those that zenoh-ros2-sdk, which shares no code with ours, works out from the definitions' text (asked below, where
it is installed), and Imu's is that of a ROS 2 Jazzy installation; mcap_ros2 decodes bytes in `test_bridge_golden.py`.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
import time
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pelagos.bridges.rihs import type_hash
from pelagos.config import registry
from pelagos.messages.encoders import ENCODERS, encoder
from pelagos.messages.encoding import Site
from pelagos.messages.store import deserialize, schema, serialize, typestore

TABLE = Path(__file__).with_name("bridge_wire.json")
TYPES = (
    "builtin_interfaces/msg/Time", "diagnostic_msgs/msg/DiagnosticArray", "geometry_msgs/msg/PointStamped",
    "geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/PoseWithCovarianceStamped", "geometry_msgs/msg/Twist",
    "geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/TwistWithCovarianceStamped", "geometry_msgs/msg/WrenchStamped",
    "marine_acoustic_msgs/msg/Dvl", "marine_acoustic_msgs/msg/ProjectedSonarImage",
    "marine_acoustic_msgs/msg/RawSonarImage", "marine_acoustic_msgs/msg/SonarDetections",
    "marine_acoustic_msgs/msg/SonarRanges", "nav_msgs/msg/Odometry", "nav_msgs/msg/Path",
    "sensor_msgs/msg/BatteryState",
    "pelagos_msgs/msg/Ctd", "pelagos_msgs/msg/WaterProperty", "rosgraph_msgs/msg/Clock",
    "sensor_msgs/msg/CameraInfo", "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/FluidPressure",
    "sensor_msgs/msg/Image", "sensor_msgs/msg/Imu", "sensor_msgs/msg/JointState", "sensor_msgs/msg/MagneticField",
    "sensor_msgs/msg/NavSatFix", "sensor_msgs/msg/PointCloud2", "sensor_msgs/msg/Range", "sensor_msgs/msg/Temperature",
    "simulation_interfaces/msg/EntityState", "std_msgs/msg/Bool", "std_msgs/msg/Float64",
    "std_msgs/msg/Float64MultiArray", "std_msgs/msg/String", "std_msgs/msg/UInt8MultiArray", "tf2_msgs/msg/TFMessage",
)  # fmt: skip


def filled(name: str) -> Any:
    """A message whose numbers are counted up, with both signs where the type has them."""
    from rosbags.interfaces import Nodetype as T

    count = 0

    def number(kind: str) -> Any:
        nonlocal count
        count += 1
        if kind == "bool":
            return count % 2 == 1
        if kind in ("string", "wstring"):
            return f"text{count}"
        sign = -1 if count % 2 and not kind.startswith(("u", "byte", "octet", "char")) else 1
        return sign * (count + 0.25) if kind.startswith("float") else sign * (count % 100)

    def value(node: Any) -> Any:
        kind, inner = node
        if kind == T.NAME:
            return made(inner)
        if kind == T.BASE:
            return number(inner[0])
        element, size = inner
        size = size if kind == T.ARRAY else min(size or 2, 2)
        if element[0] == T.BASE and element[1][0] not in ("string", "wstring"):
            dtype = {"char": "uint8", "byte": "uint8", "octet": "uint8"}.get(element[1][0], element[1][0])
            return np.array([number(element[1][0]) for _ in range(size)]).astype(dtype)
        return [value(element) for _ in range(size)]

    def made(kind: str) -> Any:
        store = typestore()
        return store.types[kind](**{field: value(node) for field, node in store.fielddefs[kind][1]})

    return made(name)


@cache
def frozen() -> dict[str, dict[str, str]]:
    return dict(json.loads(TABLE.read_text()))


def look(name: str) -> dict[str, str]:
    raw = serialize(name, filled(name))
    cdr = raw.hex() if len(raw) <= 128 else f"sha256:{hashlib.sha256(raw).hexdigest()}"
    return {"hash": type_hash(name), "cdr": cdr}


@pytest.mark.parametrize("name", TYPES)
def test_the_wire_is_as_it_was(name: str) -> None:
    assert look(name) == frozen()[name]


def test_imus_hash_is_that_of_jazzy() -> None:
    assert frozen()["sensor_msgs/msg/Imu"]["hash"] == (
        "RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b"
    )


@pytest.mark.parametrize("name", TYPES)
def test_another_implementation_works_out_the_same_hash(name: str) -> None:
    """From the definitions' text alone."""
    if name == "marine_acoustic_msgs/msg/Dvl":
        pytest.skip("zenoh-ros2-sdk 0.1.8 takes a fixed array of messages for something else: Vector3[4] beam_unit_vec")
    other = pytest.importorskip("zenoh_ros2_sdk.utils")
    first, *rest = schema(name).decode().split("=" * 80 + "\n")
    below = dict(part.removeprefix("MSG: ").split("\n", 1) for part in rest)
    named = {k if "/msg/" in k else k.replace("/", "/msg/"): full(text) for k, text in below.items()}
    assert other.compute_type_hash_from_msg(name, full(first), named) == type_hash(name)


def full(definition: str) -> str:
    """With "/msg/" in the names of types."""
    return re.sub(r"^(\w+)/(\w+)(?=[\[ ])", r"\1/msg/\2", definition, flags=re.MULTILINE)


ECHO = """
import sys
from pelagos.bridges.dds import DdsTransport
from pelagos.bridges.transport import Qos
t = DdsTransport(domain=int(sys.argv[1]), node="echo")
for i, name in enumerate(sys.argv[2:]):
    back = t.advertise(f"/back{i}", name, qos=Qos(depth=20))
    t.subscribe(f"/there{i}", name, lambda raw, back=back: back(raw, 0), qos=Qos(depth=20))
print("ready", flush=True)
sys.stdin.read()
t.close()
"""


def test_every_type_crosses_to_another_process_and_back() -> None:
    """By DDS, which reads every sample by the type's own layout at either end; all fields are non-zero and unequal."""
    pytest.importorskip("cyclonedds")
    from pelagos.bridges.dds import DdsTransport
    from pelagos.bridges.transport import Qos

    domain = 161 + os.getpid() % 30
    command = [sys.executable, "-c", ECHO, str(domain), *TYPES]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as peer:
        transport = DdsTransport(domain=domain, node="sim")
        try:
            assert peer.stdout is not None
            assert peer.stdout.readline().strip() == "ready"
            raws = {name: bytes(serialize(name, filled(name))) for name in TYPES}
            got: dict[str, bytes] = {}
            writes = {}
            for i, name in enumerate(TYPES):
                transport.subscribe(f"/back{i}", name, partial(got.__setitem__, name), qos=Qos(depth=20))
                writes[name] = transport.advertise(f"/there{i}", name, qos=Qos(depth=20))
            end = time.monotonic() + 60
            while len(got) < len(TYPES) and time.monotonic() < end:
                for name in TYPES:
                    if name not in got:
                        writes[name](raws[name], 0)
                time.sleep(0.1)
            for name in TYPES:
                assert serialize(name, deserialize(name, got[name])) == raws[name], name
        finally:
            transport.close()
            peer.kill()


@pytest.mark.parametrize("kind", sorted(ENCODERS))
def test_every_type_that_a_sensor_says_is_frozen(kind: str) -> None:
    needed = {"tracer": {"tracer": "dye"}}.get(kind, {})
    config = registry.find("sensor", kind).config.model_validate({"type": kind, "rate_hz": 5, **needed})
    assert {topic.type for topic in encoder(config, Site("auv0/here", 45.0, 12.5)).topics} <= set(TYPES)


if __name__ == "__main__":
    TABLE.write_text(json.dumps({name: look(name) for name in TYPES}, indent=1) + "\n")
