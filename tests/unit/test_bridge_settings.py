"""Keys of doors that carry topics reach what they are for: transports, and who serves on them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from pelagos.bridges.foxglove_transport import FoxgloveConfig
from pelagos.bridges.lcm_transport import LcmConfig
from pelagos.bridges.ros2 import Ros2Config, make_transport
from pelagos.bridges.rosbridge import RosbridgeConfig


@pytest.mark.parametrize(
    ("transport", "keys", "told"),
    [
        ("dds", {}, {"domain": 0, "node": "pelagos", "loopback": True, "announce": True, "gid_bytes": 16}),
        ("dds", {"domain_id": 7, "node": "us", "network": "open", "announce": False, "distro": "humble"},
         {"domain": 7, "node": "us", "loopback": False, "announce": False, "gid_bytes": 24}),
        ("zenoh", {}, {"domain": 0, "node": "pelagos", "hashes": True, "loopback": True}),
        ("zenoh", {"domain_id": 7, "node": "us", "network": "open", "distro": "humble"},
         {"domain": 7, "node": "us", "hashes": False, "loopback": False}),
        ("zenoh", {"distro": "iron"}, {"domain": 0, "node": "pelagos", "hashes": True, "loopback": True}),
        ("rclpy", {"domain_id": 0, "node": "us"}, {"domain": 0, "node": "us"}),
    ],
)  # fmt: skip
def test_ros2_opens_a_transport_as_it_is_asked(
    transport: Any, keys: dict[str, Any], told: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    if keys.get("domain_id") == 0:
        monkeypatch.setenv("ROS_DOMAIN_ID", "9")  # what the scenario says wins
    for module, name in (("dds", "Dds"), ("zenoh_transport", "Zenoh"), ("rclpy_transport", "Rclpy")):
        monkeypatch.setattr(f"pelagos.bridges.{module}.{name}Transport", lambda name=name, **given: (name, given))
    made, why = make_transport(Ros2Config(type="ros2", transport=transport, **keys))
    assert (made, why) == ((transport.capitalize(), told), "as asked")


@pytest.mark.parametrize(
    ("config", "where"), [(RosbridgeConfig, "rosbridge.Rosbridge"), (FoxgloveConfig, "foxglove_transport.Foxglove")]
)
@pytest.mark.parametrize("given", [False, True])
def test_a_door_of_web_pages_serves_what_it_is_asked(
    config: Any, where: str, given: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    kind = where.partition(".")[2].lower()
    opened: list[dict[str, Any]] = []
    served: list[Any] = []

    def open_(**keys: Any) -> Any:
        opened.append(keys)
        return SimpleNamespace(port=4711, reach="open to the network, without passwords")

    monkeypatch.setattr(f"pelagos.bridges.{where}Transport", open_)
    monkeypatch.setattr("pelagos.bridges.services.serve_topics", lambda *args, **keys: served.append((args, keys)))
    keys = {"host": "0.0.0.0", "port": 77, "topics": ["/a"], "commands": False, "services": True} if given else {}
    if given and kind == "rosbridge":
        keys["origins"] = ["lab.example.org"]
    said = config.model_validate({"type": kind, **keys}).attach("run")
    port = {"rosbridge": 9090, "foxglove": 8765}[kind]
    asked = {"host": keys.get("host", "127.0.0.1"), "port": keys.get("port", port)}
    if kind == "rosbridge":
        asked["origins"] = tuple(keys.get("origins", ()))
    assert opened == [asked]
    (((exchange, transport), options),) = served
    assert (exchange, transport.port) == ("run", 4711)
    assert {name: options[name] for name in ("only", "commands", "services")} == (
        {"only": ("/a",), "commands": False, "services": True} if given
        else {"only": (), "commands": True, "services": True}
    )  # fmt: skip
    assert options.get("clock", True)
    assert (":4711" in said, "without passwords" in said) == (True, given)


@pytest.mark.parametrize("holoocean", [True, False])
def test_lcm_carries_topics_and_holooceans_structures_beside(holoocean: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of commands the other way round, so that each key alone is seen."""
    listened: list[Any] = []
    transport = SimpleNamespace(name="LCM", blocks=False, troubles={})
    monkeypatch.setattr(
        "pelagos.bridges.lcm_transport.LcmTransport", lambda url: setattr(transport, "url", url) or transport
    )
    monkeypatch.setattr(
        "pelagos.bridges.lcm_transport.HoloOceanDoor", lambda sim, carrier: ("structures", sim, carrier)
    )
    monkeypatch.setattr("pelagos.bridges.ros_commands.listen", lambda *args: listened.append(args))
    doors: list[Any] = []
    exchange: Any = SimpleNamespace(sim="sim", inbox="inbox", add=doors.append)
    keys: dict[str, Any] = {"url": "memq://", "topics": ("/a",)} if holoocean else {}
    said = LcmConfig(type="lcm", holoocean=holoocean, commands=not holoocean, **keys).attach(exchange)
    assert transport.url == ("memq://" if holoocean else "udpm://239.255.76.67:7667?ttl=0")
    assert transport.url in said
    assert (doors[0].transport, doors[0]._only) == (transport, ("/a",) if holoocean else ())
    assert doors[1:] == ([("structures", "sim", transport)] if holoocean else [])
    assert listened == ([] if holoocean else [(transport, "sim", "inbox")])
