"""The door to ArduPilot (ArduSub, Rover, ArduCopter) by its JSON interface, in lock-step.

The autopilot sends its outputs and waits; the simulation takes one step with them and answers with the motion.
"""

from __future__ import annotations

import os
import socket
import struct
import sys
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from pydantic import Field

from pelagos.bridges.ardupilot_json import ServoFrame, level, parse_servos, state_text
from pelagos.bridges.autopilot import Output, VehicleMotion, motion_of, outputs_of, the_agent
from pelagos.bridges.config import LOOPBACK, BridgeConfig, exposed, listening
from pelagos.bridges.transport import BridgeError, BridgeMismatch
from pelagos.errors import LookupFailed
from pelagos.sim.listeners import Subscription
from pelagos.sim.order import Order
from pelagos.sim.simulation import Simulation

if TYPE_CHECKING:
    from pelagos.bridges.exchange import Exchange

_LOOK_S: Final = 0.1
SPIN_S: Final = 0.0003
"""An autopilot that answered within this is first looked for without sleeping: to be woken up takes as long as a step
of the simulation [s]."""
PACKET: Final = 1024
_AT_ONCE: Final = getattr(socket, "MSG_DONTWAIT", None)


class ArdupilotConfig(BridgeConfig):
    """ArduPilot: ArduSub, Rover and ArduCopter SITL by JSON, in lock-step."""

    type: Literal["ardupilot"]
    agent: str = ""
    """The vehicle that it steers; may be left out where there is one only."""
    host: str = LOOPBACK
    """Address to listen at; the protocol has no passwords."""
    port: int = Field(default=9002, ge=1, le=65535)
    """UDP port; SITL's instance n uses 9002 + 10 n."""
    outputs: dict[str, int] = Field(default_factory=dict)
    """Servo output, counted from 1, by actuator, negative where it turns the other way; known for bluerov2,
    bluerov2_heavy, wamv, otter and quadrotor."""
    low_us: float = 1100.0
    """Pulse at one end of an actuator [us]; of a quadrotor 1000 unless given."""
    high_us: float = 1900.0
    """Pulse at the other end [us]; of a quadrotor 2000 unless given."""
    rangefinder: str = ""
    """An altimeter of the agent, sent as its first range finder."""
    patience_s: float = Field(default=30.0, gt=0)
    """The run ends when the autopilot has said nothing for so long [s]; it may take as long as it likes to begin."""

    def check(self, sim: Simulation) -> None:
        """See `BridgeConfig`."""
        agent = the_agent(sim, self.agent, "ardupilot")
        outputs_of(sim, agent, self.outputs, "ardupilot")
        sensors = sim.model.agents[agent].sensors
        if self.rangefinder and self.rangefinder not in sensors:
            raise BridgeMismatch(str(LookupFailed("sensor", self.rangefinder, sensors, where="ardupilot: rangefinder")))

    def listens(self) -> str:
        """See `BridgeConfig`."""
        return listening("udp", self.host, self.port)

    def attach(self, exchange: Exchange) -> str:
        """See `BridgeConfig`."""
        link = ArdupilotLink(exchange, self)
        exchange.drive(link)
        note = "; open to the network, without passwords" if exposed(self.host) else ""
        return f"ArduPilot steers {link.agent}: waiting for SITL at UDP {self.host}:{link.port}{note}"


class ArdupilotLink:
    """One autopilot; see `Driver` for when its methods are called.

    Attributes:
        agent: the vehicle.
        port: where it listens.
        steps: frames that were answered with a step.
        troubles: malformed packets, repeated frames and the like, counted.
    """

    name = "ArduPilot"
    rate_hz: float | None = None

    def __init__(self, exchange: Exchange, config: ArdupilotConfig) -> None:
        sim = exchange.sim
        self.agent = the_agent(sim, config.agent, "ardupilot")
        self._inbox, self._config = exchange.inbox, config
        self._outputs: list[Output] = outputs_of(sim, self.agent, config.outputs, "ardupilot")
        copter = all(o.rests_at for o in self._outputs) and not {"low_us", "high_us"} & config.model_fields_set
        self._ends = (1000.0, 2000.0) if copter else (config.low_us, config.high_us)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((config.host, config.port))
        except OSError as error:
            self._socket.close()
            raise BridgeError(f"ardupilot: UDP {config.host}:{config.port} cannot be used: {error.strerror}") from None
        self.port = config.port
        _wait_at_most(self._socket, _LOOK_S)
        self._commands = [(output.channel, _Commands(output, self._ends)) for output in self._outputs]
        self._peer: Any = None
        self._last: ServoFrame | None = None
        self._answer: bytes | None = None
        self._soon = self._spins = _AT_ONCE is not None and _processors() > 1
        self._range_m = float("inf")
        self._heard: Subscription | None = None
        self._start = motion_of(sim, self.agent)
        self.steps = 0
        self.troubles: Counter[str] = Counter()
        if config.rangefinder:
            self._heard = sim.subscribe(f"{self.agent}.{config.rangefinder}", self._hear)

    def answer(self, sim: Simulation) -> None:
        """Say where the vehicle is, to who asked."""
        if self._peer is None:
            return
        extras = {"rng_1": self._range_m} if self._config.rangefinder else None
        self._answer = state_text(sim.time_ns * 1e-9, motion_of(sim, self.agent), extras)
        self._send()

    def wait(self, sim: Simulation) -> None:
        """The next outputs, into the vehicle's actuators."""
        began = time.monotonic()
        while not sim.gate.stopped:
            try:
                packet, peer = self._receive()
            except (TimeoutError, BlockingIOError):
                if self._last is not None and time.monotonic() - began > self._config.patience_s:
                    self.troubles[f"silent for {self._config.patience_s:g} s: the run was ended"] += 1
                    sim.stop()
                    return
                continue
            except OSError:  # the peer's port is closed: it will come back, or not
                continue
            frame = parse_servos(packet)
            if frame is None:
                self.troubles["malformed packets"] += 1
            elif self._last is not None and frame.count == self._last.count and peer == self._peer:
                self.troubles["frames sent again"] += 1
                self._send()
            else:
                self._take(frame, peer)
                return

    def report(self) -> Mapping[str, int]:
        """See `Door`."""
        return self.troubles

    def close(self) -> None:
        """See `Door`."""
        if self._heard is not None:
            self._heard.cancel()
        self._socket.close()

    def _receive(self) -> tuple[bytes, Any]:
        """The next packet; what was steered is written down while the autopilot thinks."""
        began = time.perf_counter()
        while self._soon and time.perf_counter() - began < SPIN_S:
            try:
                found: tuple[bytes, Any] = self._socket.recvfrom(PACKET, _AT_ONCE or 0)
            except BlockingIOError:
                self._inbox.write_down()
            else:
                return found
        self._inbox.write_down()
        self._soon = False
        found = self._socket.recvfrom(PACKET)
        self._soon = self._spins and time.perf_counter() - began < SPIN_S
        return found

    def _take(self, frame: ServoFrame, peer: Any) -> None:
        before, self._last, self._peer = self._last, frame, peer
        if before is not None and frame.count < before.count:
            self.troubles["restarts of the autopilot"] += 1
            self._inbox.obey(_back_to(self._start, self.agent))
        self.steps += 1
        if before is None or frame.pwm != before.pwm or frame.count < before.count:
            self._inbox.steer(self.agent, self._values(frame.pwm), "ardupilot")

    def _values(self, pwm: Sequence[int]) -> list[float]:
        """The actuators' commands."""
        count = len(pwm)
        return [known[pwm[channel] if channel < count else 0] for channel, known in self._commands]

    def _send(self) -> None:
        if self._answer is None:
            self.troubles["answers that were not finite"] += self._peer is not None and self.steps > 1
            return
        try:
            self._socket.sendto(self._answer, self._peer)
        except OSError:
            self.troubles["answers that could not be sent"] += 1

    def _hear(self, reading: Any) -> None:
        self._range_m = float(np.asarray(reading.data).ravel()[0])


class _Commands(dict[int, float]):
    """Commands of one actuator by pulse [us], worked out once each; `ends_us` are the pulses at its ends."""

    def __init__(self, output: Output, ends_us: tuple[float, float]) -> None:
        self._output, self._ends_us = output, ends_us

    def __missing__(self, pulse_us: int) -> float:
        low_us, high_us = self._ends_us
        value = self[pulse_us] = self._output.value(
            level(pulse_us, self._output.rests_at, low_us=low_us, high_us=high_us)
        )
        return value


def _processors() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _wait_at_most(link: socket.socket, seconds: float) -> None:
    """Let `recvfrom` give up after so long; by the system, where `settimeout` would poll before every receipt."""
    if sys.platform == "win32":
        link.settimeout(seconds)
    else:
        link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, struct.pack("ll", 0, round(1e6 * seconds)))


def _back_to(start: VehicleMotion, agent: str) -> Order:
    """At the start again, at rest: where a rebooted autopilot believes to be."""
    x, y, z = start.position
    w, i, j, k = start.attitude
    still = [0.0, 0.0, 0.0]
    data = {"position": [x, -y, -z], "attitude": [w, i, -j, -k], "velocity": still, "angular_velocity": still}
    return Order("state", agent, data, "ardupilot")
