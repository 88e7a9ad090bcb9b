"""The door to MOOS-IvP: a client of a MOOSDB, publishes navigation, obeys a helm's thrust, rudder and elevator."""

from __future__ import annotations

import math
import socket
import threading
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, Literal

from pydantic import Field

from pelagos.bridges.autopilot import motion_of, the_agent
from pelagos.bridges.config import LOOPBACK, BridgeConfig, exposed
from pelagos.bridges.moos_wire import DATA, HELLO, LONGEST, NOTIFY, NULL, POISON, REGISTER, MoosMessage, pack, unpack
from pelagos.bridges.pace import next_ns
from pelagos.bridges.tap import Message, Tap
from pelagos.bridges.transport import BridgeError, BridgeMismatch
from pelagos.sim.order import Order
from pelagos.sim.simulation import Simulation

if TYPE_CHECKING:
    from pelagos.bridges.exchange import Exchange

DESIRED: Final = ("DESIRED_THRUST", "DESIRED_RUDDER", "DESIRED_ELEVATOR")
_SHARE_S: Final = 0.05
_AGAIN_S: Final = 1.0


class MoosConfig(BridgeConfig):
    """MOOS-IvP: navigation to a MOOSDB, a helm's desired thrust, rudder and elevator from it."""

    type: Literal["moos"]
    agent: str = ""
    """The vehicle; may be left out where there is one only."""
    host: str = LOOPBACK
    """Address of the MOOSDB; MOOS has no passwords."""
    port: int = Field(default=9000, ge=1, le=65535)
    """TCP port of the MOOSDB."""
    name: str = "pelagos"
    """Name of the client."""
    rate_hz: float = Field(default=10.0, gt=0)
    """NAV_* messages in a simulated second [Hz]."""

    def check(self, sim: Simulation) -> None:
        """See `BridgeConfig`."""
        mixer_of(sim, the_agent(sim, self.agent, "moos"))

    def attach(self, exchange: Exchange) -> str:
        """See `BridgeConfig`."""
        door = MoosDoor(exchange, self)
        exchange.add(door)
        note = "; over the network, without passwords" if exposed(self.host) else ""
        return f"MOOS steers {door.agent}: client {self.name!r} of the MOOSDB at {self.host}:{self.port}{note}"


class MoosDoor:
    """See `Door`; a thread of its own talks to the MOOSDB, and comes back to it when it went away."""

    name = "MOOS"

    def __init__(self, exchange: Exchange, config: MoosConfig) -> None:
        sim = exchange.sim
        self.agent = the_agent(sim, config.agent, "moos")
        self._config, self._inbox = config, exchange.inbox
        self._mix = mixer_of(sim, self.agent)
        self._nav: dict[str, MoosMessage] = {}
        self._desired = dict.fromkeys(DESIRED, 0.0)
        self._lock, self._open = threading.Lock(), True
        self._next_ns = 0
        self.troubles: Counter[str] = Counter()
        exchange.at_least(config.rate_hz)
        self._thread = threading.Thread(target=self._work, name="pelagos-moos", daemon=True)
        self._thread.start()

    def open(self, sim: Simulation, tap: Tap) -> None:
        """See `Door`."""
        self._next_ns = 0

    def send(self, sim: Simulation, messages: Sequence[Message]) -> None:
        """See `Door`: only the newest of each variable waits for the database."""
        if sim.time_ns < self._next_ns:
            return
        self._next_ns = next_ns(sim.time_ns, self._config.rate_hz)
        values, now = nav_of(sim, self.agent), time.time()
        with self._lock:
            for key, value in values.items():
                self._nav[key] = MoosMessage(NOTIFY, key, value, source=self._config.name, time_s=now)

    def report(self) -> Mapping[str, int]:
        """See `Door`."""
        return self.troubles

    def close(self) -> None:
        """See `Door`."""
        self._open = False
        self._thread.join(timeout=3.0)

    def _work(self) -> None:
        while self._open:
            try:
                with socket.create_connection((self._config.host, self._config.port), timeout=2.0) as link:
                    self._talk(link)
            except (OSError, ValueError, BridgeError) as error:
                self.troubles[f"no talk with the MOOSDB: {error}"] += 1
                for _ in range(20):
                    if self._open:
                        time.sleep(_AGAIN_S / 20)

    def _talk(self, link: socket.socket) -> None:
        """Shake hands; then packets back and forth, one of ours for each of the database's."""
        name = self._config.name
        link.sendall(HELLO + pack([MoosMessage(DATA, text=name, source=name, is_text=True)]))
        for welcome in _read(link):
            if welcome.kind == POISON:
                raise BridgeError(f"the MOOSDB refuses us: {welcome.text}")
        out = [MoosMessage(REGISTER, key, 0.0, source=name, time_s=time.time()) for key in DESIRED]
        while self._open:
            with self._lock:
                out += self._nav.values()
                self._nav.clear()
            link.sendall(pack(out or [MoosMessage(NULL, source=name, time_s=time.time())]))
            out = []
            for message in _read(link):
                if message.kind == NOTIFY and message.key in self._desired and not message.is_text:
                    self._obey(message.key, message.value)
            time.sleep(_SHARE_S)

    def _obey(self, key: str, value: float) -> None:
        if not math.isfinite(value):
            self._inbox.refuse(f"{key} is {value}, not a finite number")
            return
        self._desired[key] = value
        values = self._mix(*(self._desired[k] for k in DESIRED))
        self._inbox.put(Order("command", self.agent, {"values": values, "mode": "actuators"}, key))


def nav_of(sim: Simulation, agent: str) -> dict[str, float]:
    """NAV_* of an agent: local grid [m], geographic position [deg], compass heading [deg], yaw counter-clockwise from
    east and pitch [rad], speed over ground [m/s], depth [m]."""
    motion = motion_of(sim, agent)
    north, east, down = motion.position
    latitude, longitude = (float(v) for v in sim.world.origin.to_latlon(north, -east))
    _, pitch, yaw = motion.euler
    return {
        "NAV_X": east, "NAV_Y": north, "NAV_HEADING": math.degrees(yaw) % 360, "NAV_DEPTH": down,
        "NAV_SPEED": math.hypot(motion.velocity[0], motion.velocity[1]),
        "NAV_YAW": math.remainder(math.pi / 2 - yaw, math.tau),
        "NAV_LAT": latitude, "NAV_LONG": longitude, "NAV_PITCH": pitch,
    }  # fmt: skip


def _read(link: socket.socket) -> list[MoosMessage]:
    head = _exactly(link, 4)
    size = int.from_bytes(head, "little", signed=True)
    if not 9 <= size <= LONGEST:
        raise ValueError(f"a packet of {size} bytes")
    return unpack(head + _exactly(link, size - 4))


def _exactly(link: socket.socket, size: int) -> bytes:
    raw = b""
    while len(raw) < size:
        more = link.recv(size - len(raw))
        if not more:
            raise OSError("the MOOSDB hung up")
        raw += more
    return raw


def mixer_of(sim: Simulation, agent: str) -> Any:
    """Thrust [%], rudder and elevator [deg] to a vehicle's actuators; a positive rudder turns to starboard, a positive
    elevator dives.

    Raises:
        BridgeMismatch: the vehicle has neither a rudder and a propeller nor two thrusters.
    """
    vehicle = sim.model.agents[agent].vehicle
    lags: dict[str, Any] = {name: vehicle.model.actuators[name].lag for name in vehicle.actuator_names}
    names = list(lags)

    def share(name: str, percent: float) -> float:
        part = min(max(percent, -100.0), 100.0) / 100.0
        return part * float(lags[name].high if part > 0 else -lags[name].low)

    def angle(name: str, degrees: float) -> float:
        return min(max(math.radians(degrees), float(lags[name].low)), float(lags[name].high))

    left = next((n for n in names if n.startswith("left_")), None)
    right = next((n for n in names if n.startswith("right_")), None)
    if left and right and len(names) == 2:
        return lambda thrust, rudder, elevator: [share(n, thrust + (rudder if n == left else -rudder)) for n in names]
    if {"rudder", "stern_plane", "propeller"} == set(names):
        return lambda thrust, rudder, elevator: [
            share(n, thrust) if n == "propeller" else angle(n, _SENSE[n] * (rudder if n == "rudder" else elevator))
            for n in names
        ]
    raise BridgeMismatch(f"moos: {agent} has {', '.join(names)}; a helm needs a rudder, a stern_plane and a "
                         "propeller, or two thrusters left_ and right_")  # fmt: skip


_SENSE: Final = {"rudder": 1.0, "stern_plane": 1.0}
