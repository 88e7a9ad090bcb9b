"""The door for hardware in the loop: a sensor speaks its instrument's own language on a serial port, TCP or UDP."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

from pydantic import Field

from pelagos.bridges.autopilot import the_agent
from pelagos.bridges.config import BridgeConfig, listening
from pelagos.bridges.instruments.ports import Port, open_port, parsed_port
from pelagos.bridges.instruments.speaker import Place, Speaker
from pelagos.bridges.instruments.speakers import SPEAKERS
from pelagos.bridges.tap import Message, Tap
from pelagos.bridges.transport import BridgeMismatch
from pelagos.errors import LookupFailed
from pelagos.sim.listeners import Subscription
from pelagos.sim.simulation import Simulation

if TYPE_CHECKING:
    from pelagos.bridges.exchange import Exchange

Protocol = Literal[
    "nmea", "pd0", "pd6", "nortek", "waterlinked", "waterlinked_serial", "ping1d", "ping360", "vectornav",
    "vectornav_binary", "mip",
]  # fmt: skip
ANSWER_HZ = 50.0
A50_TILT_DEG = 22.5  # Water Linked, DVL A50 documentation


class InstrumentConfig(BridgeConfig):
    """Instrument: a sensor speaks its maker's language on a serial port (pty), TCP or UDP, for hardware in the loop."""

    type: Literal["instrument"]
    protocol: Protocol
    """The language: `nmea` (gps: GGA, RMC, VTG, HDT; altimeter: DBT; depth: XDR), `pd0`, `pd6`, `nortek`,
    `waterlinked`, `waterlinked_serial` (dvl), `ping1d` (altimeter, singlebeam), `ping360`
    (mechanical_scanning_sonar), `vectornav`, `vectornav_binary`, `mip` (imu)."""
    agent: str = ""
    """The vehicle; may be left out where there is one only."""
    sensors: tuple[str, ...] = Field(min_length=1)
    """The sensors that speak on this port, by their names in the scenario (`dvl`, or `rov.dvl`)."""
    port: str
    """`pty:PATH` (a serial port under that name), `tcp:[HOST:]PORT` (a server), `udp:[HOST:]PORT` (sends there),
    `udp-server:[HOST:]PORT` (answers who asks); hosts are 127.0.0.1 unless given. No protocol has passwords."""
    start_utc: datetime = datetime(2026, 6, 1, 12, 0, 0, tzinfo=UTC)
    """Date and time at the beginning of the simulation, for clocks in messages."""

    def speaking(self, sim: Simulation) -> tuple[str, dict[str, Any]]:
        """The agent, and its sensors' configurations by the names that were asked for.

        Raises:
            BridgeMismatch: there is no such agent or sensor, or the sensor does not speak this protocol.
        """
        agent = the_agent(sim, self.agent, "instrument")
        sensors, by_type = sim.model.agents[agent].sensors, SPEAKERS[self.protocol]
        found = {}
        for given in self.sensors:
            name = given.removeprefix(f"{agent}.")
            if name not in sensors:
                raise BridgeMismatch(str(LookupFailed("sensor", given, sensors, where=f"instrument of {agent}")))
            config = sensors[name].config
            if config.type not in by_type:
                raise BridgeMismatch(
                    f"instrument: {self.protocol!r} is spoken by {', '.join(by_type)}, not by {name!r} ({config.type})"
                )
            found[name] = config
        return agent, found

    def check(self, sim: Simulation) -> None:
        """See `BridgeConfig`."""
        self.speaking(sim)
        parsed_port(self.port)

    def listens(self) -> str:
        """See `BridgeConfig`."""
        kind, host, number = parsed_port(self.port)
        if kind == "pty":
            return f"pty {host}" if host else ""
        return "" if kind == "udp" else listening(kind.removesuffix("-server"), host, number)

    def attach(self, exchange: Exchange) -> str:
        """See `BridgeConfig`."""
        door = InstrumentDoor(exchange, self)
        exchange.add(door)
        other = "".join(
            f"; {name} has beams at {c.beam_tilt_deg:g} degrees, an A50 at {A50_TILT_DEG:g} (device: waterlinked_a50)"
            for name, c in self.speaking(exchange.sim)[1].items()
            if self.protocol.startswith("waterlinked") and c.beam_tilt_deg != A50_TILT_DEG
        )
        return f"{self.protocol} of {', '.join(self.sensors)}: {door.port.where}{other}"


class InstrumentDoor:
    """See `Door`.

    Attributes:
        port: where it speaks.
        spoken: messages that were written.
    """

    def __init__(self, exchange: Exchange, config: InstrumentConfig) -> None:
        sim = exchange.sim
        self.name = f"{config.protocol} {'+'.join(config.sensors)}"
        agent, sensors = config.speaking(sim)
        epoch = config.start_utc if config.start_utc.tzinfo is not None else config.start_utc.replace(tzinfo=UTC)
        by_type = SPEAKERS[config.protocol]
        self._speakers: list[Speaker] = [by_type[c.type](Place(sim, agent, c, epoch)) for c in sensors.values()]
        self.port: Port = open_port(config.port)
        self._waiting: list[bytes] = []
        self.spoken = 0
        self._heard: list[Subscription] = []
        for name, speaker in zip(sensors, self._speakers, strict=True):
            hear = partial(self._hear, speaker)
            self._heard.append(sim.subscribe(f"{agent}.{name}", hear, invalid=speaker.tells_loss))
            exchange.at_least(min(ANSWER_HZ, 1e9 / sim.dt_ns))

    def open(self, sim: Simulation, tap: Tap) -> None:
        """See `Door`."""
        self._waiting.clear()
        for speaker in self._speakers:
            speaker.begin()

    def send(self, sim: Simulation, messages: Sequence[Message]) -> None:
        """See `Door`."""
        for peer, raw in self.port.read():
            for speaker in self._speakers:
                out = speaker.answer(raw)
                if out:
                    self.port.reply(peer, out)
        waiting, self._waiting = self._waiting, []
        for raw in waiting:
            self.port.write(raw)
            self.spoken += 1

    def report(self) -> Mapping[str, int]:
        """See `Door`."""
        found = Counter(self.port.troubles)
        for speaker in self._speakers:
            found["bytes that were no request"] += getattr(speaker, "bad", 0)
        return found

    def close(self) -> None:
        """See `Door`."""
        for subscription in self._heard:
            subscription.cancel()
        self.port.close()

    def _hear(self, speaker: Speaker, reading: Any) -> None:
        raw = speaker.hear(reading)
        if raw:
            self._waiting.append(raw)
