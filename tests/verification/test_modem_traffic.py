"""Packets between made-up modems in made-up water, tick by tick: when they arrive, what becomes of them and why.

Headers take 0.1 + 8 4/1000 = 0.132 s; ticks are 20 ms; the first on which anything is sent is the first.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from modem_ports import modem_port

from pelagos.sensors.comms.link.budget import HeardSignal
from pelagos.sensors.comms.link.medium import ModemPose, SharedMedium
from pelagos.sensors.comms.link.modem_port import ModemPort
from pelagos.sensors.comms.link.traffic import Traffic

DT_NS = 20_000_000
NOISE = 70.0


def heard(delay: float = 0.25, level: float = 120.0, *, echoes: float = -math.inf, doppler: float = 1.0) -> HeardSignal:
    return HeardSignal(delay, level, echoes, 0.003, doppler, "", None)


def lost(why: str) -> HeardSignal:
    return HeardSignal(0.0, -math.inf, -math.inf, 0.0, 1.0, why, None)


@dataclass
class MadeWater(SharedMedium):
    """Signals by the agents of sender and receiver; places by agent and copy."""

    signals: Mapping[str, HeardSignal] = field(default_factory=dict)
    depths: Mapping[str, Sequence[float]] = field(default_factory=dict)
    sonar: Mapping[str, float] = field(default_factory=dict)
    sea: float = 0.0
    asked: list[tuple[str, int]] = field(default_factory=list)

    def pose(self, path: str) -> ModemPose:
        """At a depth of its own in each copy."""
        z = -np.array(self.depths.get(path[0], [10.0] * self.copies), float)
        return ModemPose(
            np.stack([0 * z, 0 * z, z], axis=-1), np.tile([1.0, 0, 0, 0], (self.copies, 1)), np.zeros((self.copies, 3))
        )

    def level(self, t: float) -> float:
        """Of the sea."""
        return self.sea

    def hear(self, pairs: Any, poses: Any, t: float, cache: Any, lag: Any) -> list[HeardSignal]:
        """Far above the noise after a quarter of a second, where nothing else is said."""
        names = [path[0] for path in self.modems]
        self.asked += [(names[a] + names[b], c) for a, b, c in pairs]
        return [self.signals.get(names[a] + names[b], heard()) for a, b, _ in pairs]

    def noise(self, port: ModemPort) -> float:
        """Alike."""
        return NOISE

    def sonar_noise(self, port: ModemPort, pose: ModemPose, copy: int) -> float:
        """By agent."""
        return self.sonar.get(port.agent, -math.inf)


def network(*ports: ModemPort, copies: int = 1, **keys: Any) -> Traffic:
    made = MadeWater(modems={p.path: p for p in ports}, seed=3, dt_ns=DT_NS, copies=copies, **keys)
    episodes: Any = SimpleNamespace(environment=np.arange(copies), number=np.zeros(copies, np.int64))
    return Traffic(made, episodes)


def three(**keys: Any) -> list[ModemPort]:
    return [modem_port(f"{name}.m", address=k, **keys) for k, name in enumerate("abc")]


def run(traffic: Traffic, ticks: int, *, first: int = 0) -> tuple[dict[str, list[Any]], dict[str, list[Any]]]:
    """Packets and fates by agent, of all copies, with the tick at which they were told."""
    packets: dict[str, list[Any]] = {}
    fates: dict[str, list[Any]] = {}
    for tick in range(first, ticks):
        for port in traffic._ports:
            if tick % port.period == 0:
                out = traffic.read(port.path, tick)
                for c in range(len(out.packets)):
                    packets.setdefault(port.agent, []).extend((tick, c, p) for p in out.packets[c])
                    fates.setdefault(port.agent, []).extend((tick, c, f) for f in out.fates[c])
    return packets, fates


def say(traffic: Traffic, agent: str, to: str, payload: bytes = b"hello", **keys: Any) -> int:
    usual: dict[str, Any] = {"now_ns": 0, "acknowledge": False, "where": [0]}
    return traffic.send(f"{agent}.m", to, payload, **(usual | keys))


def told(fates: dict[str, list[Any]], agent: str) -> list[str]:
    return [f.fate for _, _, f in fates.get(agent, [])]


def test_a_packet_is_on_its_way_for_its_delay_and_stretched_by_its_doppler() -> None:
    """Sent at 20 ms, 0.172 s long; heard from 0.27 s on, 0.172/0.8 s long: 0.485 s, told at 27 ticks of 20 ms to a
    modem that looks every third; an identical copy of the fleet, where nobody spoke, hears nothing."""
    a, _, c = three()
    traffic = network(
        a, modem_port("b.m", address=1, period=3), c, copies=2, signals={"ab": heard(0.25, 118.0, doppler=0.8)},
        depths={"a": [4.0, 6.5]},
    )  # fmt: skip
    assert say(traffic, "a", "b.m", where=[1], tag="of mine") == 1
    packets, fates = run(traffic, 40)
    ((tick, copy, packet),) = packets["b"]
    assert (tick, copy, packet.number, packet.sender, packet.to, packet.payload) == (27, 1, 0, "a.m", "b.m", b"hello")
    assert (packet.sent_ns, packet.received_ns, packet.tag, packet.depth_m) == (20_000_000, 485_000_000, "of mine", 6.5)
    assert packet.travel_time_s == pytest.approx(0.25, abs=1e-7)
    assert (packet.level_db, packet.snr_db, packet.delay_spread_s, packet.doppler) == (118.0, 48.0, 0.003, 0.8)
    assert math.isnan(packet.range_m)
    assert math.isnan(packet.azimuth_rad)
    ((_, _, fate),) = fates["b"]
    assert (fate.sender, fate.to, fate.receiver, fate.sent_ns, fate.time_ns) == (
        "a.m",
        "b.m",
        "b.m",
        20_000_000,
        485_000_000,
    )
    assert (fate.bytes, fate.fate, fate.level_db, fate.snr_db, fate.kind) == (5, "received", 118.0, 48.0, "data")
    ((_, _, other),) = fates["c"]  # who it was not for hears it too, but has no packet
    assert (other.receiver, other.fate) == ("c.m", "received")
    assert "c" not in {k for k, found in packets.items() if found}


def test_status_counts_since_the_reading_before() -> None:
    """What waits, whether it transmits, received, sent, noise: of three that were given one is sent at once."""
    traffic = network(*three())
    for _ in range(3):
        say(traffic, "a", "*")
    rows = {(p, t): traffic.read(f"{p}.m", t).status[0].tolist() for t in range(40) for p in "ab"}
    assert rows["a", 0] == [3, 0, 0, 0, NOISE]
    assert rows["a", 1] == [2, 1, 0, 1, NOISE]
    assert rows["a", 2] == [2, 1, 0, 0, NOISE]
    assert sum(rows["a", t][3] for t in range(40)) == 3
    assert [t for t in range(40) if rows["b", t][2]] == [23, 32]  # 0.02 + 0.25 + 0.172, and 0.2 + 0.25 + 0.172 s
    assert rows["b", 25] == [0, 0, 0, 0, NOISE]


def test_a_modem_that_looks_seldom_sends_and_counts_at_its_own_ticks() -> None:
    """Every third tick: both packets are sent on one, and counted in the reading of that tick."""
    traffic = network(modem_port("a.m"), modem_port("b.m", address=1, period=3))
    for _ in range(2):
        say(traffic, "b", "*", b"")
    rows = {}
    for tick in range(16):
        traffic.read("a.m", tick)
        if tick % 3 == 0:
            rows[tick] = traffic.read("b.m", tick).status[0, :4].tolist()
    assert rows == {
        0: [2, 0, 0, 0],
        3: [1, 1, 0, 1],
        6: [1, 1, 0, 0],
        9: [1, 1, 0, 0],
        12: [0, 1, 0, 1],
        15: [0, 1, 0, 0],
    }


@pytest.mark.parametrize(("level", "sent"), [(64.9, 1), (65.1, 0)])
def test_who_listens_hears_what_it_would_notice(level: float, sent: int) -> None:
    """5 dB below the noise, from 0.27 s on: b would send at 0.3 s."""
    traffic = network(*three(mac="csma"), signals={"ab": heard(level=level)})
    say(traffic, "a", "*", b"x" * 60)
    run(traffic, 15)
    say(traffic, "b", "*")
    traffic.read("a.m", 15)
    assert traffic.read("b.m", 15).status[0, 3] == sent


def test_ranges_of_requests_that_are_under_way_together() -> None:
    """To b, and to c before b has answered: both come out."""
    traffic = network(*three(), signals={"ac": heard(0.27), "ca": heard(0.29)})
    for to in ("b.m", "c.m"):
        say(traffic, "a", to, b"", kind="request")
    packets, _ = run(traffic, 70)
    ranges = {p.sender: p.range_m for _, _, p in packets["a"]}
    assert ranges == {"b.m": pytest.approx(0.25 * 1480.0, abs=1e-3), "c.m": pytest.approx(0.28 * 1480.0, abs=1e-3)}


def test_a_modem_is_wet_up_to_the_level_of_the_sea_and_foreign_packets_are_told_where_no_path_leads() -> None:
    ports = three()
    ports[2] = modem_port("c.m", address=2, modulation="bpsk")
    traffic = network(*ports, sea=0.5, depths={"b": [-0.4]}, signals={"ac": lost("blocked")})
    say(traffic, "a", "*")
    _, fates = run(traffic, 40)
    assert (told(fates, "b"), told(fates, "c")) == (["received"], ["blocked"])


def test_a_range_is_half_the_time_without_the_turnaround() -> None:
    """There in 0.25 s and back in 0.31 s: half of 0.56 s, at 1480 m/s."""
    traffic = network(*three()[:2], signals={"ba": heard(0.31)})
    say(traffic, "a", "b.m", b"", kind="request", tag="q")
    packets, _ = run(traffic, 60)
    ((_, _, request),), ((_, _, response),) = packets["b"], packets["a"]
    assert (request.kind, response.kind, response.tag) == ("request", "response", "q")
    assert math.isnan(request.range_m)
    assert response.sent_ns == round((0.02 + 0.25 + 0.132 + 0.04) * 1e9)
    assert response.range_m == pytest.approx(0.5 * 0.56 * 1480.0, abs=1e-3)


@pytest.mark.parametrize(("why", "keys"), [
    ("no path", {"signals": {"ab": lost("no path")}}), ("blocked", {"signals": {"ab": lost("blocked")}}),
    ("in air", {"depths": {"b": [-0.2]}}), ("in air", {"depths": {"a": [-0.2]}}),
    ("in air", {"sea": -10.5, "signals": {"ab": lost("blocked")}}), ("too deep", {"depths": {"b": [30.5]}}),
    ("too deep", {"depths": {"a": [12.5]}}), ("too deep", {"sea": 1.5, "depths": {"b": [29.0]}}),  # at high water
])  # fmt: skip
def test_what_cannot_arrive_is_known_when_it_is_sent(why: str, keys: dict[str, Any]) -> None:
    traffic = network(modem_port("a.m", depth_max_m=12.0), modem_port("b.m", address=1, depth_max_m=30.0), **keys)
    say(traffic, "a", "b.m")
    packets, fates = run(traffic, 6)
    ((tick, _, fate),) = fates["b"]
    assert (tick, fate.fate, fate.time_ns, fate.level_db, fate.snr_db) == (2, why, 20_000_000, -math.inf, -math.inf)
    assert packets == {"a": [], "b": []}


@pytest.mark.parametrize(("fate", "signal", "sonar"), [
    ("out of range", heard(level=64.9), -math.inf), ("noise", heard(level=65.1), -math.inf),
    ("multipath", heard(level=100.0, echoes=104.0), -math.inf), ("sonar", heard(level=100.0), 104.0),
    ("multipath", heard(level=100.0, echoes=104.0), 104.0), ("received", heard(level=100.0, echoes=80.0), 81.0),
])  # fmt: skip
def test_a_packet_is_lost_by_the_first_disturbance_that_is_too_much(fate: str, signal: Any, sonar: float) -> None:
    """Noticed from 5 dB below the noise on; 4 dB below an echo or a sonar all 72 bits are never right."""
    traffic = network(*three(bandwidth_hz=1000.0), signals={"ab": signal}, sonar={"b": sonar})
    say(traffic, "a", "b.m")
    _, fates = run(traffic, 40)
    ((_, _, found),) = fates["b"]
    assert found.fate == fate
    disturbance = sum(10 ** (v / 10) for v in (NOISE, signal.echoes_db, sonar))
    assert found.snr_db == pytest.approx(signal.level_db - 10 * math.log10(disturbance))
    assert told(fates, "c") == ["received"]


@pytest.mark.parametrize(("keys", "fates_at_b"), [
    ({"modulation": "bpsk"}, ["received"]), ({"bit_rate_bps": 990.0}, ["received"]),
    ({"bandwidth_hz": 51e3}, ["received"]), ({"frequency_hz": 60e3}, ["received"]), ({}, ["collision", "collision"]),
])  # fmt: skip
def test_spreading_helps_against_foreign_packets_alone(keys: dict[str, Any], fates_at_b: list[str]) -> None:
    """3 dB below in 50 kHz of 1000 bit/s: 17 dB better as noise, but a code of one's own kind is not spread."""
    ports = three(bandwidth_hz=50e3)
    ports[2] = modem_port("c.m", address=2, **{"bandwidth_hz": 50e3} | keys)
    traffic = network(*ports, signals={"ab": heard(level=100.0), "cb": heard(level=97.0)})
    say(traffic, "a", "*")
    say(traffic, "c", "*")
    _, fates = run(traffic, 60)
    assert told(fates, "b") == fates_at_b


@dataclass
class Ray:
    """A carrier that keeps what it is asked, by its name; what comes is as loud as the receiver is good."""

    name: str
    noisy: float
    asked: list[Any] = field(default_factory=list)

    def hear(self, pair: Any, poses: Any, t: float, at: Any) -> HeardSignal:
        self.asked.append((self.name + at.name, pair, sorted(poses), t))
        return heard(0.01, at.noisy + 25.0)

    def noise(self) -> float:
        return self.noisy


def test_the_depth_that_a_packet_tells_counts_from_the_level_of_the_sea() -> None:
    """Senders at z = 0.4 and -6.5 m in two copies of a fleet, a sea 1.25 m above or 2.5 m below z = 0: level - z, which
    is negative above the water."""
    for sea, expected in ((1.25, [0.85, 7.75]), (-2.5, [-2.9, 4.0])):
        radio = [
            modem_port(f"{name}.m", address=k, kind="light", carrier=Ray(name, 50.0)) for k, name in enumerate("ab")
        ]
        traffic = network(*radio, copies=2, sea=sea, depths={"a": [-0.4, 6.5]})
        say(traffic, "a", "b.m", where=[0, 1])
        packets, _ = run(traffic, 40)
        assert [p.depth_m for _, _, p in packets["b"]] == pytest.approx(expected)


def test_light_goes_from_the_senders_lamp_to_the_receivers_diode() -> None:
    """Three devices of different makes; nobody asks the water, and the noise is the receiver's own."""
    a, b, c = (
        modem_port(f"{n}.m", address=k, kind="light", carrier=Ray(n, 31.0 + 7 * k), multipath_window_s=1.0)
        for k, n in enumerate("abc")
    )
    traffic = network(a, b, c, copies=2)
    say(traffic, "b", "c.m", where=[1])
    packets, fates = run(traffic, 30)
    assert [c.carrier.asked, a.carrier.asked] == [[], []]  # type: ignore[union-attr]
    assert b.carrier.asked == [("ba", (1, 0, 1), [0, 1, 2], 0.02), ("bc", (1, 2, 1), [0, 1, 2], 0.02)]  # type: ignore[union-attr]
    assert traffic._medium.asked == []  # type: ignore[attr-defined]
    ((_, copy, packet),) = packets["c"]
    assert (copy, packet.level_db, packet.snr_db) == (1, 31.0 + 14 + 25.0, 25.0)
    assert [told(fates, name) for name in "abc"] == [["received"], [], ["received"]]


def test_bands_that_do_not_meet_are_not_asked_for() -> None:
    """Half of both widths apart at least: 5 and 3 kHz, so 4 kHz; other kinds of signals never meet."""
    ports = [modem_port("a.m"), modem_port("b.m", address=1, frequency_hz=28.99e3, bandwidth_hz=3e3),
             modem_port("c.m", address=2, frequency_hz=21e3, bandwidth_hz=3e3),
             modem_port("d.m", address=3, frequency_hz=21.01e3, bandwidth_hz=3e3),
             modem_port("e.m", address=4, kind="light")]  # fmt: skip
    traffic = network(*ports, copies=2)
    say(traffic, "a", "*", where=[1])
    run(traffic, 2)
    assert sorted(traffic._medium.asked) == [("ab", 1), ("ad", 1)]  # type: ignore[attr-defined]


@pytest.mark.parametrize(("tick", "fate"), [(4, "received"), (5, "half duplex"), (22, "half duplex"), (23, "received")])
def test_a_modem_that_sends_is_deaf(tick: int, fate: str) -> None:
    """Is heard from 0.27 to 0.442 s, and sends for 0.172 s from the tick on: 80 to 252 and 460 to 632 ms are apart."""
    traffic = network(*three()[:2])
    say(traffic, "a", "b.m")
    before = run(traffic, tick)[1]
    say(traffic, "b", "a.m")
    after = run(traffic, 70, first=tick)[1]
    assert told(before, "b") + told(after, "b") == [fate]
    assert told(after, "a") == ["received"]


@pytest.mark.parametrize(("longest", "hush"), [(64, 1.288), (128, 1.5)])
def test_who_overhears_a_request_to_send_keeps_silent(longest: int, hush: float) -> None:
    """For two of its longest packets, 2 (0.1 + 8 68/1000) s, but no longer than answers are waited for."""
    traffic = network(*three(mac="maca", packet_max_bytes=longest), signals={"ac": heard(0.31)})
    say(traffic, "a", "b.m")
    run(traffic, 25)
    station = traffic._stations[2][0]
    assert station.silent_ns == round((0.02 + 0.31 + 0.132 + hush) * 1e9)
    assert traffic._stations[1][0].silent_ns == 0


def test_a_queue_takes_what_it_has_room_for_in_each_copy() -> None:
    traffic = network(*three(queue=3), copies=2)
    assert say(traffic, "a", "*", where=[1]) == 1
    assert [say(traffic, "a", "*", where=[0, 1]) for _ in range(4)] == [2, 2, 1, 0]
    assert [len(traffic._stations[0][c].queue) for c in (0, 1)] == [3, 3]
    assert [s.queue for s in traffic._stations[1]] == [[], []]


def test_beacons_begin_apart_by_their_address() -> None:
    """Every 6 s, the first a third of that apart; an address beyond the number of modems begins anew from the first."""
    ports = three(beacon_s=6.0, beacon_bytes=4, beacon_to="a.m", acknowledge=True)
    ports[1] = modem_port("b.m", address=7, beacon_s=6.0, beacon_bytes=4, acknowledge=True)
    ports[0] = modem_port("a.m", address=5)
    traffic = network(*ports)
    packets, fates = run(traffic, 700)
    of_b = [p for _, _, p in packets["a"] if p.sender == "b.m"]
    of_c = [p for _, _, p in packets["a"] if p.sender == "c.m"]
    assert [p.sent_ns / 1e9 for p in of_b] == [2.0, 8.0]
    assert [p.sent_ns / 1e9 for p in of_c] == [4.0, 10.0]
    assert [(p.to, p.payload) for p in of_b + of_c[:1]] == [("*", b"\0" * 4)] * 2 + [("a.m", b"\0" * 4)]
    assert [f.sender for _, _, f in fates["c"] if f.kind == "ack" and f.to == "c.m"] == ["a.m", "a.m"]


def test_interrogations_go_round() -> None:
    """Every second another one, from the beginning on; b and c in turn."""
    ports = three()
    ports[0] = modem_port("a.m", interrogate=("b", "c.m"), interrogate_s=1.0)
    packets, _ = run(network(*ports), 260)
    asked = [(p.sent_ns / 1e9, p.to) for _, _, p in packets["b"] + packets["c"]]
    assert {to for _, to in asked} == {"b.m", "c.m"}
    requests = sorted((p.sent_ns / 1e9, p.to) for a in "bc" for _, _, p in packets[a] if p.kind == "request")
    assert requests == [(0.02, "b.m"), (1.0, "c.m"), (2.0, "b.m"), (3.0, "c.m"), (4.0, "b.m")]
    assert [p.sender for _, _, p in packets["a"]] == ["b.m", "c.m", "b.m", "c.m", "b.m"]


def test_clocks_err_by_an_offset_and_from_the_beginning_on_by_a_drift() -> None:
    """Standard deviations within four standard errors, over 300 copies; a copy that begins anew has its offset then."""
    port = modem_port("a.m", clock_offset_std_s=0.5, clock_drift_std_ppm=3000.0)
    traffic = network(port, modem_port("b.m", address=1), copies=300)
    start, late = (np.array([traffic.clock(0, c, t * 10**9) for c in range(300)]) - t for t in (0, 40))
    drift = (late - start) / 40
    assert start.std() == pytest.approx(0.5, rel=4 / math.sqrt(600))
    assert drift.std() == pytest.approx(3e-3, rel=4 / math.sqrt(600))
    assert abs(np.corrcoef(start, drift)[0, 1]) < 4 / math.sqrt(300)
    traffic.forget(np.arange(300) == 7, 500)  # 10 s
    assert traffic.clock(0, 7, 10 * 10**9) == pytest.approx(10.0 + start[7], abs=1e-12)
    assert traffic.clock(0, 8, 40 * 10**9) == pytest.approx(40.0 + late[8], abs=1e-12)
    assert traffic.clock(1, 3, 1_250_000_000) == 1.25


def test_what_is_kept_goes_on_in_another_run() -> None:
    ports = three(beacon_s=0.7, mac="csma", clock_offset_std_s=0.01)
    whole = run(network(*ports), 160)
    first = network(*ports)
    half = run(first, 61)
    kept = first.memory()
    run(first, 90, first=61)
    second = network(*ports)
    second.recall(kept)
    rest = run(second, 160, first=61)
    for k in (0, 1):
        assert {n: half[k].get(n, []) + rest[k].get(n, []) for n in whole[k]} == whole[k]
    assert any(whole[0].values())


def test_what_was_heard_before_a_checkpoint_disturbs_what_ends_after_it() -> None:
    """A short packet ends at b first, and is told lost; the long one that it met is lost too, in another run."""
    first, second = network(*three()), network(*three())
    say(first, "c", "*", b"")
    say(first, "a", "*", b"x" * 40)
    assert told(run(first, 24)[1], "b") == ["collision"]
    second.recall(first.memory())
    for traffic in (first, second):
        assert told(run(traffic, 60, first=24)[1], "b") == ["collision"]


def test_a_packet_that_waits_for_its_acknowledgement_is_counted_as_waiting() -> None:
    traffic = network(*three(), signals={"ab": lost("blocked")})
    say(traffic, "a", "b.m", acknowledge=True)
    assert [traffic.read("a.m", tick).status[0, 0] for tick in range(3)] == [1, 1, 1]
