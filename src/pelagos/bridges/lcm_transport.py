"""The door to LCM: HoloOcean's structures for its sensors, and every topic of a run in a structure of our own."""

from __future__ import annotations

import struct
import threading
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from pelagos.bridges.config import BridgeConfig
from pelagos.bridges.extras import require
from pelagos.bridges.transport import Answer, BridgeError, Buffer, Qos, Receive, Unsupported, Write
from pelagos.math.so3 import rotate_np
from pelagos.messages.lcm import encode, fingerprint
from pelagos.sim.listeners import Subscription

if TYPE_CHECKING:
    from pelagos.bridges.exchange import Exchange
    from pelagos.bridges.tap import Message, Tap
    from pelagos.sim.simulation import Simulation

URL: Final = "udpm://239.255.76.67:7667?ttl=0"
"""LCM's usual multicast group; a time to live of 0 keeps it on this machine."""


class LcmConfig(BridgeConfig):
    """LCM: HoloOcean's structures, and every topic in a structure of our own."""

    type: Literal["lcm"]
    url: str = URL
    """LCM's provider; with `ttl=0` what is sent stays on this machine. What others send to the group on this network
    comes in, and LCM has no passwords."""
    holoocean: bool = True
    """Publish sensors in HoloOcean's structures, on channels `<agent>/<sensor>`."""
    topics: tuple[str, ...] = ()
    """Beginnings of the topics that are published as `pelagos.message_t` (CDR inside), on channels of their names; all
    where empty."""
    commands: bool = True
    """Obey commands: `pelagos.message_t` on the command topics of the ROS 2 door."""

    def attach(self, exchange: Exchange) -> str:
        """See `BridgeConfig`."""
        from pelagos.bridges.door import TopicDoor
        from pelagos.bridges.ros_commands import listen

        transport = LcmTransport(self.url)
        exchange.add(TopicDoor(transport, only=self.topics))
        if self.commands:
            listen(transport, exchange.sim, exchange.inbox)
        if self.holoocean:
            exchange.add(HoloOceanDoor(exchange.sim, transport))
        return f"LCM at {self.url}; its group is open to the network, without passwords"


class LcmTransport:
    """See `Transport`: channels are topics, messages are `pelagos.message_t`."""

    name = "LCM"
    blocks = True

    def __init__(self, url: str = URL) -> None:
        lcm = require("lcm", extra="lcm", purpose="LCM")
        try:
            self.lcm = lcm.LCM(url)
        except (OSError, RuntimeError) as error:
            raise BridgeError(f"lcm: {url} cannot be used: {error}") from None
        self._open = True
        self.troubles: Counter[str] = Counter()
        self._thread = threading.Thread(target=self._receive, name="pelagos-lcm", daemon=True)
        self._thread.start()

    def advertise(self, topic: str, type_name: str, *, qos: Qos) -> Write:
        """See `Transport`."""

        def write(cdr: Buffer, t_ns: int) -> None:
            raw = bytes(cdr)
            self.publish(topic, encode("message_t", {"t_ns": t_ns, "type": type_name, "size": len(raw), "cdr": raw}))

        return write

    def subscribe(self, topic: str, type_name: str, receive: Receive, *, qos: Qos) -> None:
        """See `Transport`."""

        def take(channel: str, raw: bytes) -> None:
            cdr = payload(raw, type_name)
            if cdr is None:
                self.troubles[f"{topic}: messages that are no pelagos.message_t of {type_name}"] += 1
            else:
                receive(cdr)

        self.lcm.subscribe(topic, take)

    def serve(self, service: str, type_name: str, answer: Answer) -> None:
        """See `Transport`."""
        raise Unsupported("LCM has no services")

    def publish(self, channel: str, raw: bytes) -> None:
        """Send bytes on a channel."""
        if self._open:
            self.lcm.publish(channel, raw)

    def close(self) -> None:
        """See `Transport`."""
        self._open = False
        self._thread.join(timeout=2.0)

    def _receive(self) -> None:
        while self._open:
            self.lcm.handle_timeout(100)


def payload(raw: bytes, type_name: str) -> bytes | None:
    """The CDR in a `pelagos.message_t` of the type that is expected; None where it is anything else."""
    if len(raw) < 20 or struct.unpack_from(">Q", raw)[0] != fingerprint("message_t"):
        return None
    length = struct.unpack_from(">i", raw, 16)[0]
    at = 20 + length
    if length < 1 or at + 4 > len(raw) or raw[20 : at - 1] != type_name.encode():
        return None
    size = struct.unpack_from(">i", raw, at)[0]
    return raw[at + 4 :] if size == len(raw) - at - 4 else None


class HoloOceanDoor:
    """Sensors as HoloOcean publishes them; see `Door`."""

    name = "LCM (HoloOcean)"

    def __init__(self, sim: Simulation, transport: LcmTransport) -> None:
        self._transport = transport
        self._waiting: list[tuple[str, bytes]] = []
        self._heard: list[Subscription] = []
        for agent in sim.model.agents.values():
            for name, sensor in agent.sensors.items():
                if sensor.config.type in STRUCTURES:
                    hear = partial(self._hear, sim, f"{agent.name}/{name}", sensor.config)
                    self._heard.append(sim.subscribe(f"{agent.name}.{name}", hear))

    def open(self, sim: Simulation, tap: Tap) -> None:
        """See `Door`."""
        self._waiting.clear()

    def send(self, sim: Simulation, messages: Sequence[Message]) -> None:
        """See `Door`."""
        waiting, self._waiting = self._waiting, []
        for channel, raw in waiting:
            self._transport.publish(channel, raw)

    def report(self) -> Mapping[str, int]:
        """See `Door`."""
        return {}

    def close(self) -> None:
        """See `Door`: the transport's own door closes that."""
        for subscription in self._heard:
            subscription.cancel()

    def _hear(self, sim: Simulation, channel: str, config: Any, reading: Any) -> None:
        name, fields = STRUCTURES[config.type](reading, config, sim)
        self._waiting.append((channel, encode(name, {"timestamp": reading.t_ns // 1_000_000, **fields})))


def _dvl(r: Any, config: Any, sim: Any) -> tuple[str, dict[str, Any]]:
    return "DVLSensor", {"velocity": r.data[0], "range": np.asarray(r.extras["ranges"][0])}


def _imu(r: Any, config: Any, sim: Any) -> tuple[str, dict[str, Any]]:
    unknown = [float("nan")] * 3
    return "IMUSensor", {
        "acceleration": r.data[0, :3], "angular_velocity": r.data[0, 3:], "acceleration_bias": unknown,
        "angular_velocity_bias": unknown,
    }  # fmt: skip


def _gps(r: Any, config: Any, sim: Any) -> tuple[str, dict[str, Any]]:
    return "GPSSensor", {"position": sim.world.origin.to_nwu(np.asarray(r.data[0], dtype=np.float64))}


def _pose(r: Any, config: Any, sim: Any) -> tuple[str, dict[str, Any]]:
    matrix = np.eye(4)
    q = np.asarray(r.data[0, 3:], dtype=np.float64)
    matrix[:3, :3] = rotate_np(np.tile(q, (3, 1)), np.eye(3)).T
    matrix[:3, 3] = r.data[0, :3]
    return "PoseSensor", {"matrix": matrix}


def _sonar(r: Any, config: Any, sim: Any) -> tuple[str, dict[str, Any]]:
    image = np.asarray(r.data[0], dtype=np.float64).T  # (bins, beams)
    return "ImagingSonar", {"bins_azimuth": image.shape[1], "bins_range": image.shape[0], "image": image}


def _camera(r: Any, config: Any, sim: Any) -> tuple[str, dict[str, Any]]:
    picture = np.asarray(r.data[0])
    height, width = picture.shape[:2]
    channels = 1 if picture.ndim == 2 else picture.shape[2]
    clipped = np.minimum(picture.astype(np.float64), np.iinfo(np.int16).max).astype(np.int16)
    return "RGBCamera", {"width": width, "height": height, "channels": channels, "image": clipped}


def _altimeter(r: Any, config: Any, sim: Any) -> tuple[str, dict[str, Any]]:
    return "RangeFinderSensor", {"count": 1, "distances": [float(r.data[0])], "angles": [0.0]}


STRUCTURES: Final[Mapping[str, Any]] = {
    "dvl": _dvl, "imu": _imu, "gps": _gps, "pose": _pose, "imaging_sonar": _sonar, "profiling_sonar": _sonar,
    "camera": _camera, "altimeter": _altimeter,
    "depth": lambda r, config, sim: ("DepthSensor", {"depth": -float(r.data[0])}),  # z: negative below the surface
    "velocity": lambda r, config, sim: ("VelocitySensor", {"velocity": r.data[0]}),
}  # fmt: skip
"""By type of sensor: the structure and its fields. World NWU, body FLU, as HoloOcean has them."""
