"""HoloOcean's two media: who hears a message when, by the geometry of the world; sound goes at 1500 m/s."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pelagos.compat.holoocean.comms_sensors import AcousticBeaconSensor, OpticalModemSensor
from pelagos.compat.holoocean.exceptions import UnknownName

if TYPE_CHECKING:
    from pelagos.compat.holoocean.environments import HoloOceanEnvironment

SOUND_SPEED: Final = 1500.0  # [m/s]
REPLIES: Final = {"MSG_REQ": "MSG_RESP", "MSG_REQU": "MSG_RESPU", "MSG_REQX": "MSG_RESPX"}
TYPES: Final = ("OWAY", "OWAYU", *REPLIES, *REPLIES.values())
OPTICAL_REACH: Final = 50.0  # [m]


@dataclass
class Flight:
    """An acoustic message on its way to one beacon.

    Attributes:
        sender, receiver: their numbers.
        kind, data: what is sent.
        arrives: tick of the medium; None until its first tick.
        seen: what the receiver learns of the geometry, frozen at the first tick.
        lost: it will not be heard.
    """

    sender: int
    receiver: int
    kind: str
    data: Any
    arrives: int | None = None
    seen: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    lost: bool = False


@dataclass
class Media:
    """Messages under way in one environment."""

    env: HoloOceanEnvironment
    flights: list[Flight] = field(default_factory=list)
    beams: list[tuple[int, int, Any]] = field(default_factory=list)
    tick: int = 0

    def send(self, sender: int, to: Any, kind: str, data: Any) -> None:
        """Give an acoustic message to a beacon, which transmits until every addressee has it.

        Raises:
            ValueError: a type of message that there is not.
        """
        if kind not in TYPES:
            raise ValueError(f"{kind!r} is no type of acoustic message; there are {', '.join(TYPES)}")
        beacons = self.env.stations("beacons")
        if _station(beacons, sender, "acoustic beacon").status == "Transmitting":
            print(f"Beacon {sender} is still transmitting, so the message was not sent")
            return
        flights = [Flight(sender, r, kind, data) for r in _addressees(beacons, sender, to, "acoustic beacon")]
        if flights:  # to all, where there is no other beacon, is to nobody
            beacons[sender].status = "Transmitting"
        self.flights += flights

    def shine(self, sender: int, to: Any, data: Any) -> None:
        """Give a message to an optical modem."""
        modems = self.env.stations("modems")
        _station(modems, sender, "optical modem")
        self.beams += [(sender, r, data) for r in _addressees(modems, sender, to, "optical modem")]

    def advance(self) -> None:
        """One tick: hand over what arrives."""
        if self.flights:
            self._acoustic()
        if self.beams:
            self._optical()
        self.tick += 1

    def clear(self) -> None:
        """Nothing is under way."""
        self.flights.clear()
        self.beams.clear()

    def _acoustic(self) -> None:
        beacons = self.env.stations("beacons")
        senders = {f.sender for f in self.flights}
        if len(senders) > 1:  # more than one in the water: all are lost
            for number in senders:
                beacons[number].status = "Idle"
            self.flights.clear()
            return
        replies = []
        for flight in list(self.flights):
            if flight.arrives is None:
                self._launch(flight, beacons)
            assert flight.arrives is not None
            if self.tick < flight.arrives:
                continue
            self.flights.remove(flight)
            if not flight.lost:
                beacons[flight.receiver].inbox.append(_received(flight))
                if flight.kind in REPLIES:
                    replies.append(flight)
        for number in senders:
            if not any(f.sender == number for f in self.flights):
                beacons[number].status = "Idle"
        for flight in replies:
            self.send(flight.receiver, flight.sender, REPLIES[flight.kind], None)

    def _launch(self, flight: Flight, beacons: dict[int, AcousticBeaconSensor]) -> None:
        """Freeze the geometry."""
        sender, receiver = beacons[flight.sender], beacons[flight.receiver]
        here, there = (self.env.motions[s.agent_name] for s in (sender, receiver))
        start, end = sender.point(here), receiver.point(there)
        line = start - end
        distance = float(np.linalg.norm(line))
        x, y, z = receiver.axes(there).T @ line
        flight.seen = math.atan2(y, x), math.atan2(z, math.hypot(x, y)), distance, float(end[2])
        flight.arrives = self.tick + round(distance / (self.env._dt * SOUND_SPEED))
        flight.lost = not sender.within(distance, None)
        if not flight.lost and sender.config.get("CheckVisible", False):
            flight.lost = not self.env.sees(sender.agent_name, start, receiver.agent_name, end)

    def _optical(self) -> None:
        modems = self.env.stations("modems")
        beams, self.beams = self.beams, []
        for sender, receiver, data in beams:
            if self._aligned(modems[sender], modems[receiver]):
                modems[receiver].inbox.append(data)

    def _aligned(self, sender: OpticalModemSensor, receiver: OpticalModemSensor) -> bool:
        here, there = (self.env.motions[s.agent_name] for s in (sender, receiver))
        start, end = sender.point(here), receiver.point(there)
        distance = float(np.linalg.norm(end - start))
        if not sender.within(distance, OPTICAL_REACH) or distance == 0:
            return False
        line = (end - start) / distance
        if not (sender.looks_at(sender.axes(here), line) and receiver.looks_at(receiver.axes(there), -line)):
            return False
        return self.env.sees(receiver.agent_name, end, sender.agent_name, start)


def _station(stations: dict[int, Any], number: Any, what: str) -> Any:
    """The station of a number.

    Raises:
        UnknownName: there is none.
    """
    if number not in stations:
        there = ", ".join(f"{n} of {s.agent_name}" for n, s in stations.items()) or "none"
        raise UnknownName(f"there is no {what} with the id {number!r}; there is {there}")
    return stations[number]


def _addressees(stations: dict[int, Any], sender: int, to: Any, what: str) -> list[int]:
    """Numbers that a message goes to."""
    if (isinstance(to, str) and to == "all") or (isinstance(to, int) and to == -1):
        return [number for number in stations if number != sender]
    return [int(_station(stations, number, what).id) for number in (to if isinstance(to, list | tuple) else [to])]


def _received(flight: Flight) -> list[Any]:
    """The message as the receiver's state has it."""
    azimuth, elevation, distance, depth = flight.seen
    head = [flight.kind, flight.sender, flight.data]
    more: dict[str, list[Any]] = {
        "OWAY": [], "MSG_REQ": [], "MSG_RESP": [], "OWAYU": [azimuth, elevation], "MSG_REQU": [azimuth, elevation],
        "MSG_RESPU": [azimuth, elevation, distance], "MSG_REQX": [azimuth, elevation, depth],
        "MSG_RESPX": [azimuth, elevation, distance, depth],
    }  # fmt: skip
    return head + more[flight.kind]
