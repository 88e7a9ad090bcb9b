"""Protocols of one modem, call by call: who may send when, what is waited for, and how often it is tried again.

A packet of 11 bytes takes 0.1 + 8 (4 + 11)/1000 = 0.22 s; times are in nanoseconds.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from modem_ports import modem_port

from pelagos.sensors.comms.link.modem_port import ModemPort
from pelagos.sensors.comms.link.packet import Incoming, Outgoing, Transmission
from pelagos.sensors.comms.link.station import Station, answer, next_to_send

S = 1_000_000_000
LENGTH = 220_000_000


def packet(text: str = "x" * 11, to: str = "b.m", **keys: Any) -> Outgoing:
    return Outgoing("data", to, text, "", 0, **keys)


def asked(station: Station, port: ModemPort, now: int, *, busy: bool = False, draw: float = 0.25) -> Any:
    return next_to_send(station, port, now, channel_busy=lambda: busy, draw=lambda: draw)


def test_a_modem_transmits_from_the_first_to_before_the_last_moment() -> None:
    station = Station(sending=[[100, 200], [300, 450]])
    assert [station.busy(t) for t in (99, 100, 199, 200, 300, 449, 450)] == [
        False,
        True,
        True,
        False,
        True,
        True,
        False,
    ]
    spans = {(0, 100): False, (0, 101): True, (199, 250): True, (200, 300): False, (150, 160): True, (440, 900): True}
    assert {span: station.sends_within(*span) for span in spans} == spans


def test_packets_go_in_the_order_in_which_they_were_given_and_wait_for_the_modem_itself() -> None:
    first, second = packet("one"), packet("two")
    station, port = Station(queue=[first, second], sending=[[50, 90]], wait_ns=120, silent_ns=150), modem_port()
    assert [asked(station, port, now) for now in (60, 100, 130, 149)] == [None] * 4  # sends, waits, keeps silent
    assert asked(station, port, 150) == (first, 150)
    assert (first.tries, station.pending, station.queue, station.draws) == (1, None, [second], 0)
    assert asked(station, port, 151) == (second, 151)
    assert asked(station, port, 152) is None


@pytest.mark.parametrize(("to", "waits"), [("b.m", True), ("*", False)])
def test_an_acknowledgement_is_waited_for_from_the_end_of_the_packet(to: str, waits: bool) -> None:
    """0.22 s of packet and 1.5 s; twice again where none comes, at once, and then the next packet has its turn."""
    lost, after = packet(to=to, acknowledge=True), packet("after")
    station, port = Station(queue=[lost, after]), modem_port(retries=2)
    now, sent = 7, []
    for _ in range(3 if waits else 1):
        sent.append(asked(station, port, now))
        if waits:
            assert (station.pending, station.awaits) == (lost, "ack")
            assert station.deadline_ns == now + LENGTH + 3 * S // 2
            assert asked(station, port, station.deadline_ns - 1) is None
            now = station.deadline_ns
    assert [found for found, _ in sent] == [lost] * len(sent)
    assert lost.tries == len(sent)
    assert asked(station, port, now) == (after, now)
    assert (station.draws, station.wait_ns, station.pending) == (0, 0, None)


def test_a_protocol_waits_at_random_twice_as_long_each_time_up_to_the_fifth() -> None:
    """2, 4, 8, 16, 32, 32, 32 packets at most: here three quarters of that."""
    lost, port = packet(acknowledge=True), modem_port(mac="aloha", retries=7)
    station, now, waits = Station(queue=[lost]), 0, []
    for _ in range(7):
        assert asked(station, port, now) == (lost, now)
        now = station.deadline_ns
        assert asked(station, port, now, draw=0.75) is None
        assert station.queue == [lost]
        waits.append(station.wait_ns - now)
        now = station.wait_ns
        assert asked(station, port, now - 1) is None
    assert waits == [round(0.75 * k * LENGTH) for k in (2, 4, 8, 16, 32, 32, 32)]
    assert station.draws == 7
    assert asked(station, port, now) == (lost, now)
    assert asked(station, port, station.deadline_ns) is None  # given up
    assert (station.queue, station.pending, lost.tries) == ([], None, 8)


@pytest.mark.parametrize("mac", ["csma", "maca"])
def test_who_listens_first_waits_half_to_one_and_a_half_packets(mac: str) -> None:
    head = packet(to="*")
    station, port = Station(queue=[head]), modem_port(mac=mac)
    assert asked(station, port, 5, busy=True, draw=0.3) is None
    assert (station.wait_ns, station.draws, station.queue) == (5 + round(0.8 * LENGTH), 1, [head])
    assert asked(station, port, station.wait_ns - 1) is None
    assert asked(station, port, station.wait_ns) == (head, station.wait_ns)
    station = Station(queue=[head])
    assert asked(station, modem_port(mac="aloha"), 5, busy=True) == (head, 5)


def test_maca_asks_before_it_sends_to_one() -> None:
    """A request to send, and the packet when leave comes; what goes to all, and other kinds, go without."""
    head, port = packet("long" * 5, acknowledge=True), modem_port(mac="maca", retries=2)
    station = Station(queue=[head])
    asks, at = asked(station, port, 40)
    assert (asks.kind, asks.to, asks.payload, asks.asked_ns, at) == ("rts", "b.m", "", 40, 40)
    assert (station.pending, station.awaits, station.deadline_ns, station.queue) == (head, "cts", 40 + 3 * S // 2, [])
    assert head.tries == 0
    answer(station, port, incoming(Outgoing("cts", "a.m", "", "", 0), end_ns=900), "b.m")
    assert (station.pending, station.replies) == (None, [head])
    assert head.not_before_ns == 900 + 40_000_000
    assert asked(station, port, head.not_before_ns - 1) is None
    assert asked(station, port, head.not_before_ns + 3) == (head, head.not_before_ns)
    assert (head.tries, station.pending, station.awaits, station.replies) == (1, head, "ack", [])
    for other in (packet(to="*"), Outgoing("request", "b.m", "", "", 0)):
        assert asked(Station(queue=[other]), port, 9) == (other, 9)


def test_requests_to_send_that_nobody_answers_are_counted() -> None:
    head, port = packet(), modem_port(mac="maca", retries=2)
    station, now, kinds = Station(queue=[head]), 0, []
    for _ in range(10):
        found = asked(station, port, now, draw=0.0)
        kinds.append(found and found[0].kind)
        now = station.deadline_ns
    assert kinds[:4] == ["rts", "rts", "rts", None]
    assert (head.tries, station.pending, station.queue) == (3, None, [])


@pytest.mark.parametrize(("payload", "room"), [(11, 0.22), (26, 0.34)])
def test_tdma_sends_once_in_its_own_slot_while_there_is_room(payload: int, room: float) -> None:
    """Slots of 0.5 s from when the episode began, three a frame, the last 0.1 s silent: address 7 has the second."""
    port = modem_port(mac="tdma", address=7)
    station = Station(begin_ns=9 * S // 10, queue=[packet("y" * payload) for _ in range(9)])
    step, sent = S // 50, []
    for now in range(station.begin_ns, station.begin_ns + 5 * S, step):
        if asked(station, port, now):
            sent.append((now - station.begin_ns) / S)
    assert sent == [0.5, 2.0, 3.5]
    latest = [
        t for t in np.arange(0, 250) / 50
        if asked(Station(begin_ns=9 * S // 10, queue=[packet("y" * payload)]), port, 9 * S // 10 + round(t * S))
    ]  # fmt: skip
    expected = [t for t in np.arange(0, 250) / 50 if 0.5 <= t % 1.5 < 1.0 and round(1.0 - t % 1.5 - 0.1 - room, 6) >= 0]
    assert latest == expected


def test_answers_go_first_and_keep_new_packets_back() -> None:
    early, late = (
        Outgoing("ack", "b.m", "", "", 0, not_before_ns=100),
        Outgoing("cts", "c.m", "", "", 0, not_before_ns=60),
    )
    station, port = Station(replies=[early, late], queue=[packet()], wait_ns=10**12), modem_port()
    assert asked(station, port, 59) is None
    assert asked(station, port, 70) == (late, 60)
    assert asked(station, port, 99) is None
    assert asked(station, port, 130) == (early, 100)
    assert (station.replies, station.pending) == ([], None)
    station.wait_ns = 140
    assert asked(station, port, 140) is not None


def incoming(outgoing: Outgoing, *, end_ns: int, number: int = 17) -> Incoming:
    sent = Transmission(number, outgoing, 1, 0, 0, 5, 0.0, 3.0)
    return Incoming(sent, 0, 1, end_ns, 0.1, 90.0, 0.0, 40.0, 0.0, 0.0, 1.0, "", 0.0, 0.0)


@pytest.mark.parametrize(
    ("given", "reply"),
    [
        (Outgoing("data", "a.m", "hi", "t", 0, acknowledge=True), ("ack", "b.m", "", "", 17)),
        (Outgoing("data", "*", "hi", "t", 0, acknowledge=True), None),
        (Outgoing("data", "a.m", "hi", "t", 0), None),
        (Outgoing("rts", "a.m", "", "t", 0), ("cts", "b.m", "", "", -1)),
        (Outgoing("request", "*", "", "tag", 0), ("response", "b.m", "", "tag", 17)),
        (Outgoing("ack", "a.m", "", "", 0, reply_to=4), None),
        (Outgoing("cts", "a.m", "", "", 0), None),
    ],
)
def test_answers_to_each_kind_of_packet(given: Outgoing, reply: tuple[Any, ...] | None) -> None:
    """40 ms after its end, to who sent it."""
    station = Station()
    answer(station, modem_port(), incoming(given, end_ns=2 * S), "b.m")
    found = [(r.kind, r.to, r.payload, r.tag, r.reply_to) for r in station.replies]
    assert found == ([] if reply is None else [reply])
    assert all((r.not_before_ns, r.asked_ns) == (2 * S + 40_000_000, 2 * S) for r in station.replies)


@pytest.mark.parametrize(
    ("kind", "number", "awaits", "kept"),
    [("ack", 4, "ack", False), ("ack", 5, "ack", True), ("response", 4, "ack", False), ("response", 3, "ack", True),
     ("cts", 4, "ack", True), ("data", 4, "ack", True)],
)  # fmt: skip
def test_an_answer_ends_the_wait_for_its_own_packet_alone(kind: Any, number: int, awaits: str, kept: bool) -> None:
    waiting = packet(acknowledge=True)
    waiting.number = 4
    station = Station(pending=waiting, awaits=awaits)
    answer(station, modem_port(), incoming(Outgoing(kind, "a.m", "", "", 0, reply_to=number), end_ns=S), "b.m")
    assert station.pending is (waiting if kept else None)
    assert station.replies == []
