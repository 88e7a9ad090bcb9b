"""A MAVLink vehicle without an autopilot: what a ground station or a companion computer expects to find.

Heartbeat, attitude, positions and system state go out; MANUAL_CONTROL and SET_POSITION_TARGET_LOCAL_NED come in. A
ground station's questions are answered, so that it does not wait: for parameters, of which two tell how sticks are
taken and none can be set, for missions, of which there are none, and commands, of which none is supported.
Source: MAVLink common.xml, and its parameter, mission and command protocols.
"""

from __future__ import annotations

import math
import socket
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, Literal

from pydantic import Field

from pelagos.bridges.autopilot import motion_of, the_agent
from pelagos.bridges.config import LOOPBACK, BridgeConfig, exposed
from pelagos.bridges.extras import require
from pelagos.bridges.pace import next_ns
from pelagos.bridges.tap import Message, Tap
from pelagos.bridges.transport import BridgeError
from pelagos.sim.order import Order
from pelagos.sim.simulation import Simulation

if TYPE_CHECKING:
    from pelagos.bridges.exchange import Exchange

_SUBMARINE, _GENERIC, _BOAT, _QUADROTOR = 12, 0, 11, 2
TYPES: Final = {"wamv": _BOAT, "otter": _BOAT, "surface_vessel": _BOAT, "quadrotor": _QUADROTOR}
_ACTIVE: Final = 4
_BEAT_HZ: Final = 1.0
_AUTOPILOT: Final = 0  # MAV_AUTOPILOT_GENERIC: ground stations take no vehicle from "invalid" (8)
_MANUAL_ARMED: Final = 64 | 128
_LOCAL_NED, _BODY_NED = 1, 8
_NO_AXIS: Final = 32767
_REAL32, _UNSUPPORTED = 9, 3  # MAV_PARAM_TYPE_REAL32; MAV_RESULT_UNSUPPORTED and MAV_MISSION_UNSUPPORTED


class MavlinkConfig(BridgeConfig):
    """MAVLink: a vehicle for ground stations and companion computers, without an autopilot."""

    type: Literal["mavlink"]
    agent: str = ""
    """The vehicle; may be left out where there is one only."""
    host: str = LOOPBACK
    """Address of the ground station; the protocol has no passwords."""
    port: int = Field(default=14550, ge=1, le=65535)
    """UDP port of the ground station."""
    system: int = Field(default=1, ge=1, le=255)
    """MAVLink's id of the vehicle."""
    rate_hz: float = Field(default=10.0, gt=0)
    """Attitudes and positions in a simulated second [Hz]."""
    speed_mps: float = Field(default=1.0, gt=0)
    """Speed that a full stick asks for [m/s]."""
    turn_deg_s: float = Field(default=30.0, gt=0)
    """Rate of turn that a full stick asks for [deg/s]."""

    def check(self, sim: Simulation) -> None:
        """See `BridgeConfig`."""
        the_agent(sim, self.agent, "mavlink")

    def attach(self, exchange: Exchange) -> str:
        """See `BridgeConfig`."""
        door = MavlinkDoor(exchange, self)
        exchange.add(door)
        note = "; open to the network, without passwords" if exposed(self.host) else ""
        return f"MAVLink vehicle {door.agent}: sends to UDP {self.host}:{self.port}{note}"


class MavlinkDoor:
    """See the module's docstring."""

    name = "MAVLink"

    def __init__(self, exchange: Exchange, config: MavlinkConfig) -> None:
        self._dialect = require("pymavlink.dialects.v20.common", extra="mavlink", purpose="the MAVLink vehicle")
        self.agent = the_agent(exchange.sim, config.agent, "mavlink")
        self._config, self._inbox = config, exchange.inbox
        self._mav = self._dialect.MAVLink(None, srcSystem=config.system, srcComponent=1)
        self._mav.robust_parsing = True
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.connect((config.host, config.port))
        except OSError as error:
            self._socket.close()
            raise BridgeError(f"mavlink: UDP {config.host}:{config.port}: {error.strerror}") from None
        self._socket.setblocking(False)
        self._next_ns = self._next_beat_ns = 0
        self._parameters = {b"SPEED_MPS": config.speed_mps, b"TURN_DEG_S": config.turn_deg_s}
        self.troubles: Counter[str] = Counter()
        exchange.at_least(config.rate_hz)

    def open(self, sim: Simulation, tap: Tap) -> None:
        """See `Door`."""
        self._next_ns = self._next_beat_ns = 0

    def send(self, sim: Simulation, messages: Sequence[Message]) -> None:
        """See `Door`."""
        self._hear()
        out = []
        if sim.time_ns >= self._next_beat_ns:
            self._next_beat_ns = next_ns(sim.time_ns, _BEAT_HZ)
            kind = TYPES.get(sim.model.agents[self.agent].config.vehicle.type, _SUBMARINE)
            out.append(self._dialect.MAVLink_heartbeat_message(kind, _AUTOPILOT, _MANUAL_ARMED, 0, _ACTIVE, 3))
            out.append(self._dialect.MAVLink_sys_status_message(0, 0, 0, 0, 16000, -1, -1, 0, 0, 0, 0, 0, 0))
        if sim.time_ns >= self._next_ns:
            self._next_ns = next_ns(sim.time_ns, self._config.rate_hz)
            out += self._state(sim)
        for message in out:
            self._say(message.pack(self._mav))

    def report(self) -> Mapping[str, int]:
        """See `Door`."""
        return self.troubles

    def close(self) -> None:
        """See `Door`."""
        self._socket.close()

    def _state(self, sim: Simulation) -> list[Any]:
        motion, t_ms = motion_of(sim, self.agent), sim.time_ns // 1_000_000
        north, east, down = motion.position
        velocity = motion.velocity
        latitude, longitude = (float(v) for v in sim.world.origin.to_latlon(north, -east))
        roll, pitch, yaw = motion.euler
        heading = math.degrees(yaw) % 360
        d = self._dialect
        return [
            d.MAVLink_attitude_message(t_ms, roll, pitch, yaw, *motion.gyro),
            d.MAVLink_local_position_ned_message(t_ms, north, east, down, *velocity),
            d.MAVLink_global_position_int_message(
                t_ms, round(latitude * 1e7), round(longitude * 1e7), round(-down * 1000), round(-down * 1000),
                *(round(100 * v) for v in velocity), round(100 * heading) % 36000,
            ),
            d.MAVLink_vfr_hud_message(
                0.0, math.hypot(velocity[0], velocity[1]), round(heading) % 360, 0, -down, -velocity[2]
            ),
        ]  # fmt: skip

    def _say(self, raw: bytes) -> None:
        try:
            try:
                self._socket.send(raw)
            except ConnectionRefusedError:  # told about the one before, which found nobody; this one has not been sent
                self.troubles["messages that nobody took"] += 1
                self._socket.send(raw)
        except OSError:
            self.troubles["messages that nobody took"] += 1

    def _hear(self) -> None:
        for _ in range(100):
            try:
                raw = self._socket.recv(2048)
            except ConnectionRefusedError:
                self.troubles["messages that nobody took"] += 1
                continue
            except OSError:
                return
            self.take(raw)

    def take(self, raw: bytes) -> None:
        """Obey or answer what came in a datagram; what is no message is counted."""
        for message in self._mav.parse_buffer(raw) or ():
            kind = message.get_type()
            if kind == "BAD_DATA":
                self.troubles["malformed packets"] += 1
            elif kind == "MANUAL_CONTROL" and message.target == self._config.system:
                self._stick(message)
            elif getattr(message, "target_system", None) == self._config.system:
                if kind == "SET_POSITION_TARGET_LOCAL_NED":
                    self._target(message)
                else:
                    for answer in self._answers(kind, message):
                        self._say(answer.pack(self._mav))

    def _answers(self, kind: str, m: Any) -> list[Any]:
        """To a ground station's questions."""
        d, names = self._dialect, list(self._parameters)
        asker = m.get_srcSystem(), m.get_srcComponent()
        if kind == "PARAM_REQUEST_LIST":
            return [self._parameter(name) for name in names]
        if kind == "PARAM_REQUEST_READ" and 0 <= m.param_index < len(names):
            return [self._parameter(names[m.param_index])]
        if kind in ("PARAM_REQUEST_READ", "PARAM_SET"):  # what is set is answered with what stands
            name = m.param_id.encode()
            if kind == "PARAM_SET":
                self._inbox.refuse(f"PARAM_SET: {m.param_id} cannot be set; it is a key of the bridge")
            return [self._parameter(name)] if name in names else []
        if kind == "MISSION_REQUEST_LIST":
            return [d.MAVLink_mission_count_message(*asker, 0, m.mission_type)]
        if kind == "MISSION_COUNT":
            self._inbox.refuse("MISSION_COUNT: this vehicle takes no missions")
            return [d.MAVLink_mission_ack_message(*asker, _UNSUPPORTED, m.mission_type)]
        if kind in ("COMMAND_LONG", "COMMAND_INT"):
            self._inbox.refuse(f"{kind}: this vehicle takes no commands ({m.command})")
            return [d.MAVLink_command_ack_message(m.command, _UNSUPPORTED, 0, 0, *asker)]
        return []

    def _parameter(self, name: bytes) -> Any:
        place, count = list(self._parameters).index(name), len(self._parameters)
        return self._dialect.MAVLink_param_value_message(name, self._parameters[name], _REAL32, count, place)

    def _stick(self, m: Any) -> None:
        """MANUAL_CONTROL: x ahead, y to the right, r turns right, -1000 .. 1000; z up, 500 is the middle.

        An axis of 32767 is one that the ground station does not have.
        """
        v, w = self._config.speed_mps / 1000, math.radians(self._config.turn_deg_s) / 1000
        ahead, right, turn = (0 if axis == _NO_AXIS else axis for axis in (m.x, m.y, m.r))
        up = 0 if m.z == _NO_AXIS else (m.z - 500) * 2
        if not all(-1000 <= axis <= 1000 for axis in (ahead, right, turn, up)):
            self._inbox.refuse("MANUAL_CONTROL: x, y or r is not between -1000 and 1000, or z not between 0 and 1000")
            return
        values = [ahead * v, -right * v, up * v, 0.0, 0.0, -turn * w]
        self._inbox.put(Order("velocity", self.agent, {"values": values}, "MANUAL_CONTROL"))

    def _target(self, m: Any) -> None:
        """Positions in the local frame, or velocities of the body, by the mask of what is to be ignored."""
        uses_position, uses_velocity = m.type_mask & 7 == 0, m.type_mask & 56 == 0
        if uses_position and m.coordinate_frame == _LOCAL_NED:
            self._inbox.put(
                Order("waypoint", self.agent, {"values": [m.x, -m.y, -m.z]}, "SET_POSITION_TARGET_LOCAL_NED")
            )
        elif uses_velocity and m.coordinate_frame == _BODY_NED:
            rate = 0.0 if m.type_mask & 2048 else -m.yaw_rate
            values = [m.vx, -m.vy, -m.vz, 0.0, 0.0, rate]
            self._inbox.put(Order("velocity", self.agent, {"values": values}, "SET_POSITION_TARGET_LOCAL_NED"))
        else:
            self._inbox.refuse("SET_POSITION_TARGET_LOCAL_NED: give a position in LOCAL_NED or a velocity in BODY_NED")
