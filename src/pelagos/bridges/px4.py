"""The door to PX4 by its hardware-in-the-loop messages: sensors out, actuators in, in lock-step.

The simulator is the TCP server, and the time in HIL_SENSOR is PX4's own clock.
Source: PX4 guide, "Simulation" (https://docs.px4.io/main/en/simulation/), SimulatorMavlink.cpp; MAVLink common.xml.
"""

from __future__ import annotations

import math
import socket
import time
from collections import Counter
from collections.abc import Mapping
from itertools import chain
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from pydantic import Field

from pelagos.bridges.autopilot import VehicleMotion, motion_of, outputs_of, the_agent
from pelagos.bridges.config import LOOPBACK, BridgeConfig, exposed, listening
from pelagos.bridges.extras import require
from pelagos.bridges.transport import BridgeError
from pelagos.math.constants import ATMOSPHERE_PA, GRAVITY
from pelagos.math.frames import flip_yz_np
from pelagos.math.geomagnetism import earth_field
from pelagos.math.so3 import rotate_back_np
from pelagos.sim.order import Order
from pelagos.sim.simulation import Simulation

if TYPE_CHECKING:
    from pelagos.bridges.exchange import Exchange

ALL_FIELDS: Final = 0x7 | 0x38 | 0x1C0 | 0x400 | 0x1A00
"""HIL_SENSOR.fields_updated: accelerometer, gyroscope, magnetometer, differential pressure, barometer; PX4 tests whole
groups, and the barometer's is pressure, altitude and temperature together."""
ARMED: Final = 128
GPS_HZ: Final = 10.0
WATER_KG_M3: Final = 1025.0
_LOOK_S: Final = 0.1
_UNKNOWN_COURSE: Final = 65535


class Px4Config(BridgeConfig):
    """PX4: SITL by hardware-in-the-loop messages, in lock-step."""

    type: Literal["px4"]
    agent: str = ""
    """The vehicle that it steers; may be left out where there is one only."""
    host: str = LOOPBACK
    """Address to listen at; the protocol has no passwords."""
    port: int = Field(default=4560, ge=1, le=65535)
    """TCP port; PX4's instance n connects to 4560 + n."""
    rate_hz: float = Field(default=250.0, gt=0)
    """HIL_SENSOR messages in a simulated second [Hz]."""
    outputs: dict[str, int] = Field(default_factory=dict)
    """Control, counted from 1, by actuator, negative where it turns the other way; known for bluerov2,
    bluerov2_heavy, wamv, otter and quadrotor."""
    answer_s: float = Field(default=1.0, gt=0)
    """How long an answer is waited for once outputs have begun [s]; without one the simulation goes on."""

    def check(self, sim: Simulation) -> None:
        """See `BridgeConfig`."""
        outputs_of(sim, the_agent(sim, self.agent, "px4"), self.outputs, "px4")

    def listens(self) -> str:
        """See `BridgeConfig`."""
        return listening("tcp", self.host, self.port)

    def attach(self, exchange: Exchange) -> str:
        """See `BridgeConfig`."""
        link = Px4Link(exchange, self)
        exchange.drive(link)
        note = "; open to the network, without passwords" if exposed(self.host) else ""
        return f"PX4 steers {link.agent}: waiting for it at TCP {self.host}:{self.port}{note}"


class Px4Link:
    """One autopilot; see `Driver` for when its methods are called.

    Attributes:
        agent: the vehicle.
        steps: sensor messages that were sent.
        answered: those that were answered by outputs.
        troubles: what went wrong, counted.
    """

    name = "PX4"

    def __init__(self, exchange: Exchange, config: Px4Config) -> None:
        sim = exchange.sim
        self.rate_hz: float | None = config.rate_hz
        self.agent = the_agent(sim, config.agent, "px4")
        self._inbox, self._config = exchange.inbox, config
        self._outputs = outputs_of(sim, self.agent, config.outputs, "px4")
        dialect = require("pymavlink.dialects.v20.common", extra="mavlink", purpose="PX4")
        self._dialect = dialect
        self._mav = dialect.MAVLink(None, srcSystem=1, srcComponent=51)
        self._mav.robust_parsing = True
        origin = sim.world.origin
        self._origin = origin
        self._field = earth_field(origin.latitude, origin.longitude)  # (3,) NWU [T]
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            self._socket.bind((config.host, config.port))
        except OSError as error:
            self._socket.close()
            raise BridgeError(f"px4: TCP {config.host}:{config.port} cannot be used: {error.strerror}") from None
        self._socket.listen(1)
        self._socket.settimeout(_LOOK_S)
        self._peer: socket.socket | None = None
        self._begun = False
        self._next_gps_ns = 0
        self._values: list[float] | None = None
        self.steps = self.answered = 0
        self.troubles: Counter[str] = Counter()

    def answer(self, sim: Simulation) -> None:
        """Send what the sensors say; wait for PX4 to connect before the first."""
        while self._peer is None:
            if sim.gate.stopped:
                return
            self._accept()
        motion, t_us = motion_of(sim, self.agent), sim.time_ns // 1000
        if not all(map(math.isfinite, chain(*motion))):
            self.troubles["states that were not finite"] += 1
            return
        messages = [self._sensor(motion, t_us)]
        if sim.time_ns >= self._next_gps_ns:
            self._next_gps_ns = sim.time_ns + round(1e9 / GPS_HZ)
            messages += [self._gps(motion, t_us), self._truth(motion, t_us)]
        self.steps += 1
        self._send(b"".join(m.pack(self._mav) for m in messages))

    def wait(self, sim: Simulation) -> None:
        """The next outputs; before PX4's first ones, while it boots, sensors go out at the pace of the wall clock."""
        end = time.monotonic() + (self._config.answer_s if self._begun else 1.0 / self._config.rate_hz)
        while self._peer is not None and not sim.gate.stopped:
            if self._receive():
                self.answered += 1
                return
            if time.monotonic() >= end:
                self.troubles["sensor messages without an answer"] += self._begun
                return

    def report(self) -> Mapping[str, int]:
        """See `Door`."""
        return self.troubles

    def close(self) -> None:
        """See `Door`."""
        if self._peer is not None:
            self._peer.close()
        self._socket.close()

    # the wire

    def _accept(self) -> None:
        try:
            self._peer, _ = self._socket.accept()
        except TimeoutError:
            return
        self._peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._peer.settimeout(_LOOK_S)
        self._begun = False

    def _send(self, raw: bytes) -> None:
        assert self._peer is not None
        try:
            self._peer.sendall(raw)
        except OSError:
            self._lose()

    def _receive(self) -> bool:
        """Read what has come; whether outputs were among it."""
        assert self._peer is not None
        self._peer.settimeout(_LOOK_S if self._begun else 1.0 / self._config.rate_hz)
        try:
            raw = self._peer.recv(4096)
        except TimeoutError:
            return False
        except OSError:
            raw = b""
        if not raw:
            self._lose()
            return False
        return self.take(raw)

    def take(self, raw: bytes) -> bool:
        """Obey what came; whether outputs were among it."""
        got = False
        for message in self._mav.parse_buffer(raw) or ():
            kind = message.get_type()
            if kind == "HIL_ACTUATOR_CONTROLS":
                self._obey(message)
                got = self._begun = True
            elif kind == "BAD_DATA":
                self.troubles["malformed packets"] += 1
        return got

    def _lose(self) -> None:
        """PX4 has gone: it may come back, and is waited for."""
        assert self._peer is not None
        self.troubles["connections lost"] += 1
        self._peer.close()
        self._peer = None
        self._mav = self._dialect.MAVLink(None, srcSystem=1, srcComponent=51)
        self._mav.robust_parsing = True

    def _obey(self, message: Any) -> None:
        armed = bool(message.mode & ARMED)
        controls = message.controls
        if not all(math.isfinite(c) for c in controls):
            self.troubles["outputs that were not finite"] += 1
            return
        values = [o.value(self._level(float(controls[o.channel]), o.rests_at) if armed else o.rests_at)
                  for o in self._outputs]  # fmt: skip
        if values != self._values:
            self._values = values
            self._inbox.obey(Order("command", self.agent, {"values": values, "mode": "actuators"}, "px4"))

    @staticmethod
    def _level(control: float, rests_at: float) -> float:
        """-1 .. 1; what turns one way only is controlled from 0 to 1."""
        return control if rests_at == 0.0 else 2.0 * control - 1.0

    # the messages

    def _sensor(self, motion: VehicleMotion, t_us: int) -> Any:
        down = motion.position[2]
        field = rotate_back_np(np.array([motion.attitude]), flip_yz_np(self._field)[None])[0] * 1e4  # [gauss]
        a, g = motion.force, motion.gyro
        return self._dialect.MAVLink_hil_sensor_message(
            t_us, *a, *g, *field.tolist(), pressure_hpa(down), 0.0, -down, 15.0, ALL_FIELDS, 0
        )

    def _gps(self, motion: VehicleMotion, t_us: int) -> Any:
        north, east, down = motion.position
        latitude, longitude = (float(v) for v in self._origin.to_latlon(north, -east))
        v = motion.velocity
        speed = math.hypot(v[0], v[1])
        course = _UNKNOWN_COURSE if speed < 0.1 else round(math.degrees(math.atan2(v[1], v[0])) % 360 * 100) % 36000
        centimetres = [_short(100 * c) for c in v]
        fix, satellites = (3, 12) if down < 1.0 else (0, 0)  # a metre of water is the end of it
        return self._dialect.MAVLink_hil_gps_message(
            t_us, fix, round(latitude * 1e7), round(longitude * 1e7), round(-down * 1000), 100, 150,
            min(round(100 * speed), 65534), *centimetres, course, satellites, 0, 0,
        )  # fmt: skip

    def _truth(self, motion: VehicleMotion, t_us: int) -> Any:
        north, east, down = motion.position
        latitude, longitude = (float(v) for v in self._origin.to_latlon(north, -east))
        v = [_short(100 * c) for c in motion.velocity]
        a = [_short(1000 * c / GRAVITY) for c in motion.force]
        speed = min(round(100 * math.hypot(*motion.velocity)), 65535)
        return self._dialect.MAVLink_hil_state_quaternion_message(
            t_us, motion.attitude, *motion.gyro, round(latitude * 1e7), round(longitude * 1e7),
            round(-down * 1000), *v, speed, speed, *a,
        )  # fmt: skip


def pressure_hpa(down_m: float) -> float:
    """Reading of the autopilot's barometer [hPa]: ISO 2533 above the sea (to 11 km), sea water's weight below.

    Args:
        down_m: below the mean surface [m].
    """
    if down_m > 0:
        return (ATMOSPHERE_PA + WATER_KG_M3 * GRAVITY * down_m) / 100.0
    return ATMOSPHERE_PA / 100.0 * float((1.0 + 0.0065 * down_m / 288.15) ** 5.25588)


def _short(value: float) -> int:
    """Rounded into 16 bits."""
    return min(max(round(value), -32768), 32767)
