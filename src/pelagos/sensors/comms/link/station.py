"""One modem in one copy: its queue, and when its protocol lets it send.

Protocols: `none` sends when it is asked, and after a lost acknowledgement again at once; `aloha` after a random time;
`csma` listens before; `tdma` sends in its slot; `maca` asks the receiver first (RTS, CTS), as others then keep silent.

Sources: N. Abramson, AFIPS Conf. Proc. 37, 281 (1970), doi 10.1145/1478462.1478502 (ALOHA); L. Kleinrock and F. A.
Tobagi, IEEE Trans. Commun. 23, 1400 (1975), doi 10.1109/TCOM.1975.1092768 (CSMA); P. Karn, ARRL/CRRL Computer
Networking Conf. 9, 134 (1990) (MACA).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from pelagos.sensors.comms.link.modem_port import ModemPort
from pelagos.sensors.comms.link.packet import BROADCAST, Incoming, Outgoing

SECOND = 1_000_000_000  # [ns]


@dataclass
class Station:
    """State of a modem that changes.

    Attributes:
        begin_ns: when its episode began, from which slots count [ns].
        queue: data and requests that wait.
        replies: answers of the protocol, which go first.
        sending: `[start, end]` of transmissions that may still matter [ns].
        wait_ns: no new packet before [ns].
        silent_ns: others have the water until [ns].
        pending: a packet that waits for an acknowledgement or for leave to be sent.
        awaits: `ack` or `cts`.
        deadline_ns: until when [ns].
        slot: last slot in which it has sent.
        draws: random numbers drawn for waiting times.
        beacon, round: number of beacons, and of requests for ranges, so far.
        next_ns: when it reports by itself again, since its episode began [ns].
        received, sent: since its last reading.
        asked: clock at which requests were sent, by number of the packet [s].
    """

    begin_ns: int = 0
    queue: list[Outgoing] = field(default_factory=list)
    replies: list[Outgoing] = field(default_factory=list)
    sending: list[list[int]] = field(default_factory=list)
    wait_ns: int = 0
    silent_ns: int = 0
    pending: Outgoing | None = None
    awaits: str = ""
    deadline_ns: int = 0
    slot: int = -1
    draws: int = 0
    beacon: int = 0
    round: int = 0
    next_ns: int = 0
    received: int = 0
    sent: int = 0
    asked: dict[int, float] = field(default_factory=dict)

    def busy(self, now: int) -> bool:
        """It transmits."""
        return any(start <= now < end for start, end in self.sending)

    def sends_within(self, start: int, end: int) -> bool:
        """It transmits at some time between two [ns]."""
        return any(a < end and start < b for a, b in self.sending)


def next_to_send(
    station: Station, port: ModemPort, now: int, *, channel_busy: Callable[[], bool], draw: Callable[[], float]
) -> tuple[Outgoing, int] | None:
    """Next transmission of a station, and the time from which it may be sent [ns]; changes the station.

    Args:
        now: [ns].
        channel_busy: whether it hears another packet.
        draw: a random number 0 .. 1, for a waiting time.
    """
    if station.busy(now):
        return None
    for reply in station.replies:
        if reply.not_before_ns <= now:
            station.replies.remove(reply)
            if reply.kind == "data":
                _sent(station, port, reply, now)
            return reply, reply.not_before_ns
    if station.replies:
        return None  # an answer is about to be due
    if station.pending is not None:
        if now < station.deadline_ns:
            return None
        _give_up_or_again(station, port, now, draw())
    if not station.queue or now < station.wait_ns or now < station.silent_ns:
        return None
    head = station.queue[0]
    length = round(port.duration_s(len(head.payload), head.kind) * SECOND)
    if port.mac == "tdma":
        slot = _slot(port, now - station.begin_ns)
        room = _left(port, now - station.begin_ns) - round(port.guard_s * SECOND)
        if slot is None or slot == station.slot or room < length:
            return None
        station.slot = slot
    elif port.mac in ("csma", "maca") and channel_busy():
        station.wait_ns = now + round((0.5 + draw()) * length)
        station.draws += 1
        return None
    station.queue.pop(0)
    if port.mac == "maca" and head.kind == "data" and head.to != BROADCAST:
        station.pending, station.awaits = head, "cts"
        station.deadline_ns = now + round(port.timeout_s * SECOND)
        return Outgoing("rts", head.to, "", "", now), now
    _sent(station, port, head, now)
    return head, now


def _sent(station: Station, port: ModemPort, packet: Outgoing, now: int) -> None:
    """Remember a packet that is to be acknowledged."""
    packet.tries += 1
    if packet.acknowledge and packet.to != BROADCAST:
        length = port.duration_s(len(packet.payload), packet.kind)
        station.pending, station.awaits = packet, "ack"
        station.deadline_ns = now + round((length + port.timeout_s) * SECOND)


def _give_up_or_again(station: Station, port: ModemPort, now: int, draw: float) -> None:
    """The answer did not come: try again, by a protocol after a random time, or give the packet up."""
    lost = station.pending
    assert lost is not None
    station.pending = None
    if station.awaits == "cts":
        lost.tries += 1  # a request that nobody answered
    if lost.tries <= port.retries:
        station.queue.insert(0, lost)
    if port.mac == "none":
        return
    length = port.duration_s(len(lost.payload), lost.kind)
    station.wait_ns = now + round(draw * 2 ** min(lost.tries, 5) * length * SECOND)
    station.draws += 1


def _slot(port: ModemPort, now: int) -> int | None:
    """Number of the slot that runs, if it is the modem's own."""
    length = round(port.slot_s * SECOND)
    number = now // length
    return number if number % port.slots == port.address % port.slots else None


def _left(port: ModemPort, now: int) -> int:
    length = round(port.slot_s * SECOND)
    return length - now % length


def answer(station: Station, port: ModemPort, i: Incoming, sender: str) -> None:
    """Reaction of a modem's protocol to a packet for it."""
    t = i.transmission
    kind, after = t.outgoing.kind, round(port.turnaround_s * SECOND)
    if kind == "data" and t.outgoing.acknowledge and t.outgoing.to == port.path:
        station.replies.append(
            Outgoing("ack", sender, "", "", i.end_ns, reply_to=t.number, not_before_ns=i.end_ns + after)
        )
    elif kind == "rts":
        station.replies.append(Outgoing("cts", sender, "", "", i.end_ns, not_before_ns=i.end_ns + after))
    elif kind == "request":
        station.replies.append(
            Outgoing(
                "response", sender, "", t.outgoing.tag, i.end_ns, reply_to=t.number, not_before_ns=i.end_ns + after
            )
        )
    elif kind == "cts" and station.pending is not None and station.awaits == "cts":
        ready, station.pending = station.pending, None
        ready.not_before_ns = i.end_ns + after
        station.replies.append(ready)
    elif kind in ("ack", "response") and station.pending is not None and station.pending.number == t.outgoing.reply_to:
        station.pending = None
