"""Packets, and what became of them at each receiver."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, get_args

Kind = Literal["data", "ack", "rts", "cts", "request", "response"]
Fate = Literal[
    "received", "no path", "blocked", "out of range", "half duplex", "noise", "multipath", "collision", "sonar",
    "in air", "too deep", "out of beam", "submerged",
]  # fmt: skip
FATES: Final[tuple[Fate, ...]] = get_args(Fate)
BROADCAST: Final = "*"


@dataclass(frozen=True)
class Packet:
    """A packet that a modem received.

    Attributes:
        number: counts the packets of a copy of the fleet.
        kind: data, or a part of a protocol.
        sender, to: "agent.modem"; `to` is "*" for all.
        payload: bytes.
        sent_ns: simulation time of the first bit at the sender [ns].
        received_ns: of the last bit at the receiver [ns].
        travel_time_s: from the sender's clock to the receiver's, with their offsets and drifts [s].
        level_db: at the receiver [dB re 1 uPa].
        snr_db: over noise, other sound and echoes beyond the receiver's window [dB].
        delay_spread_s: root mean square over all paths [s].
        doppler: received over sent frequency.
        range_m: of a response: from the time since the request, at the modem's own sound speed [m]; NaN else.
        azimuth_rad, elevation_rad: where the sound came from, in the frame of a receiver with an array; NaN else.
        depth_m: that the sender reports of itself: below the sea's level, tide included, waves left out [m].
        tag: text that comes along without taking time, for protocols above.
    """

    number: int
    kind: Kind
    sender: str
    to: str
    payload: bytes
    sent_ns: int
    received_ns: int
    travel_time_s: float
    level_db: float
    snr_db: float
    delay_spread_s: float
    doppler: float
    range_m: float
    azimuth_rad: float
    elevation_rad: float
    depth_m: float
    tag: str = ""


@dataclass(frozen=True)
class Reception:
    """Fate of a packet at one receiver, whether it was for it or not.

    Attributes:
        number, kind, sender, to: as in `Packet`.
        receiver: "agent.modem".
        sent_ns: [ns].
        time_ns: when the fate was known: at the packet's end, or when it was sent where no path leads [ns].
        bytes: of the payload.
        fate: see `FATES`.
        level_db, snr_db: at the receiver; -inf where nothing came.
    """

    number: int
    kind: Kind
    sender: str
    to: str
    receiver: str
    sent_ns: int
    time_ns: int
    bytes: int
    fate: Fate
    level_db: float
    snr_db: float


@dataclass
class Outgoing:
    """A packet on its way through a queue.

    Attributes:
        kind, to, tag: see `Packet`.
        payload: its bytes, a character each.
        asked_ns: when it was given to the modem [ns].
        tries: how often it was sent.
        acknowledge: it is to be acknowledged.
        reply_to: number of the packet that this answers; -1 for none.
        not_before_ns: earliest start [ns].
    """

    kind: Kind
    to: str
    payload: str
    tag: str
    asked_ns: int
    tries: int = 0
    acknowledge: bool = False
    reply_to: int = -1
    not_before_ns: int = 0
    number: int = -1


@dataclass
class Transmission:
    """A packet in the water.

    Attributes:
        number: of the packet.
        outgoing: what is sent.
        sender: index of the modem.
        copy: of the fleet.
        start_ns, end_ns: at the sender [ns].
        clock_s: of the sender at the start [s].
        depth_m: of the sender below the sea's level [m].
    """

    number: int
    outgoing: Outgoing
    sender: int
    copy: int
    start_ns: int
    end_ns: int
    clock_s: float
    depth_m: float


@dataclass
class Incoming:
    """A transmission on its way to one receiver.

    Attributes:
        transmission: what comes.
        receiver: index of the modem.
        start_ns, end_ns: at the receiver [ns]; those of the sending where no path leads.
        delay_s: travel time of the first loud path [s].
        level_db: of what comes within the window [dB re 1 uPa]; -inf without a path.
        echoes_db: of what comes later [dB re 1 uPa].
        noise_db: in the band, sonars left out [dB re 1 uPa].
        sonar_db: of sonars [dB re 1 uPa].
        spread_s: of all paths [s].
        doppler: received over sent frequency.
        lost: why nothing can come; empty where something may.
        azimuth_rad, elevation_rad: measured; NaN without an array.
    """

    transmission: Transmission
    receiver: int
    start_ns: int
    end_ns: int
    delay_s: float
    level_db: float
    echoes_db: float
    noise_db: float
    sonar_db: float
    spread_s: float
    doppler: float
    lost: str
    azimuth_rad: float
    elevation_rad: float
