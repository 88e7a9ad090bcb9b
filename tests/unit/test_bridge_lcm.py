"""LCM messages, decoded by the classes that lcm-gen makes of the same structures."""

from __future__ import annotations

import importlib
import math
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from test_bridge_messages import config_of, measurement, reading

import pelagos as pl
from pelagos.bridges.exchange import Exchange
from pelagos.messages.lcm import HOLOOCEAN, OWN, definition, encode
from pelagos.messages.store import deserialize, make, serialize, vector3

pytest.importorskip("lcm")

from pelagos.bridges.lcm_transport import STRUCTURES, LcmConfig, payload


@pytest.fixture(scope="module")
def classes(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Every structure, compiled by lcm-gen."""
    folder = tmp_path_factory.mktemp("lcm")
    files = []
    for name in (*HOLOOCEAN, *OWN):
        file = folder / f"{name}.lcm"
        file.write_text(
            definition(name).replace("package lcm;", "package made;").replace("package pelagos;", "package made;")
        )
        files.append(str(file))
    subprocess.run([str(Path(sys.executable).with_name("lcm-gen")), "-p", "--ppath", str(folder), *files], check=True)
    sys.path.insert(0, str(folder))
    try:
        yield importlib.import_module("made")
    finally:
        sys.path.remove(str(folder))


def values_of(name: str) -> dict[str, Any]:
    """Different numbers in every field."""
    sizes = {"bins_azimuth": 3, "bins_range": 2, "count": 4, "width": 3, "height": 2, "channels": 2, "size": 5}
    found: dict[str, Any] = {}
    at = 1.5
    for member in (HOLOOCEAN | OWN)[name]:
        if member.name in sizes:
            found[member.name] = sizes[member.name]
        elif member.type == "string":
            found[member.name] = "sensor_msgs/msg/Imu"
        elif member.type == "byte":
            found[member.name] = bytes([1, 2, 250, 4, 5])
        else:
            shape = tuple(sizes.get(s, s) if isinstance(s, str) else s for s in member.sizes)
            count = math.prod(shape)
            whole = member.type.startswith("int")
            array = (np.arange(count) * (7 if whole else 1.25) + (40 if whole else at)).reshape(shape)
            found[member.name] = array if shape else (int(array) if whole else float(array))
            at += 100.0
    return found


@pytest.mark.parametrize("name", sorted({**HOLOOCEAN, **OWN}))
def test_lcm_gens_own_classes_decode_every_field(classes: Any, name: str) -> None:
    values = values_of(name)
    found = getattr(classes, name).decode(encode(name, values))
    for member in (HOLOOCEAN | OWN)[name]:
        got = getattr(found, member.name)
        if member.type in ("string", "byte"):
            assert got == values[member.name]
        else:
            np.testing.assert_allclose(np.array(got, dtype=float), values[member.name], rtol=1e-6, err_msg=member.name)


@pytest.mark.parametrize("kind", sorted(STRUCTURES))
def test_every_sensor_with_a_structure_fills_it(classes: Any, kind: str) -> None:
    """Among them pictures of 8 bits, whose numbers are smaller than the structure's."""
    config = config_of(kind)
    found = reading(measurement(kind, config, 1))
    sim: Any = SimpleNamespace(world=SimpleNamespace(origin=SimpleNamespace(to_nwu=lambda place: 2.0 * place)))
    name, fields = STRUCTURES[kind](found, config, sim)
    got = getattr(classes, name).decode(encode(name, {"timestamp": 12, **fields}))
    assert got.timestamp == 12
    if kind == "camera":
        np.testing.assert_array_equal(np.array(got.image).reshape(found.data[0].shape), found.data[0])


def test_pictures_of_16_bits_are_cut_off_where_the_structure_ends(classes: Any) -> None:
    picture = np.array([[[3, 32_767], [32_768, 65_535]]], dtype=np.uint16)
    fields = STRUCTURES["camera"](SimpleNamespace(data=picture[None]), None, None)[1]
    assert fields["image"].ravel().tolist() == [3, 32_767, 32_767, 32_767]


def test_what_is_no_message_of_ours_is_left() -> None:
    twist = serialize("geometry_msgs/msg/Twist", make("geometry_msgs/msg/Twist", linear=vector3(1), angular=vector3()))
    good = encode("message_t", {"t_ns": 5, "type": "geometry_msgs/msg/Twist", "size": len(twist), "cdr": twist})
    assert payload(good, "geometry_msgs/msg/Twist") == twist
    assert payload(good, "sensor_msgs/msg/Imu") is None
    rng = np.random.Generator(np.random.PCG64(1))
    for cut in range(len(good)):
        assert payload(good[:cut], "geometry_msgs/msg/Twist") is None
    for _ in range(20_000):
        bad = bytearray(good)
        bad[int(rng.integers(0, 24))] ^= int(rng.integers(1, 256))
        found = payload(bytes(bad), "geometry_msgs/msg/Twist")
        assert found is None or found == twist


def test_a_run_speaks_lcm(classes: Any) -> None:
    """`memq` stays within one LCM object: the test listens and speaks on the door's own."""
    sim = pl.Simulation.load({
        "tick_rate_hz": 100, "world": {"type": "flat", "depth_m": 20.0},
        "agents": {"rov": {
            "vehicle": "bluerov2_heavy", "start": {"position_m": [3, -2], "depth_m": 5.0}, "control": "velocity",
            "sensors": {
                "imu": {"type": "imu", "rate_hz": 50}, "dvl": {"type": "dvl", "rate_hz": 10},
                "depth": {"type": "depth", "rate_hz": 10}, "pose": {"type": "pose", "rate_hz": 10},
            },
        }},
    })  # fmt: skip
    exchange = Exchange(sim)
    LcmConfig(type="lcm", url="memq://").attach(exchange)
    lcm = exchange.doors[0].transport.lcm  # type: ignore[attr-defined]
    got: dict[str, list[bytes]] = {}
    for channel in ("rov/imu", "rov/depth", "rov/pose", "rov/dvl", "/rov/imu/data_raw"):
        lcm.subscribe(channel, lambda name, raw: got.setdefault(name, []).append(bytes(raw)))
    twist = serialize(
        "geometry_msgs/msg/Twist", make("geometry_msgs/msg/Twist", linear=vector3(0.4), angular=vector3())
    )
    lcm.publish(
        "/rov/cmd_vel",
        encode("message_t", {"t_ns": 0, "type": "geometry_msgs/msg/Twist", "size": len(twist), "cdr": twist}),
    )
    lcm.publish("/rov/cmd_vel", b"rubbish")
    exchange.run(2.0)
    deadline = time.monotonic() + 20.0
    while len(got.get("rov/imu", ())) < 101 and time.monotonic() < deadline:
        time.sleep(0.01)  # the door's thread hands them over, until it is closed
    report = exchange.close()
    assert len(got["rov/imu"]) == 101
    imu = classes.IMUSensor.decode(got["rov/imu"][-1])
    assert imu.timestamp == 2000
    assert imu.acceleration[2] == pytest.approx(9.81, abs=0.5)
    pose = classes.PoseSensor.decode(got["rov/pose"][0])
    np.testing.assert_allclose(np.array(pose.matrix)[:3, 3], [3, -2, -5], atol=1e-5)
    depth = classes.DepthSensor.decode(got["rov/depth"][0]).depth
    assert depth == pytest.approx(-5.0, abs=1.5)  # HoloOcean: the height z, negative below the surface
    whole = classes.message_t.decode(got["/rov/imu/data_raw"][0])
    assert deserialize(whole.type, whole.cdr).header.frame_id == "rov/imu"
    assert sim.state["rov"].velocity[0, 0] > 0.2
    assert report["LCM: /rov/cmd_vel: messages that are no pelagos.message_t of geometry_msgs/msg/Twist"] == 1
    assert not any("dropped" in reason for reason in report)  # half a second of /clock leaves in one go
