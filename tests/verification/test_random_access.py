"""ALOHA's throughput by modems that send at random, against Abramson's and Roberts' formulas."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pelagos.acoustics.modulation import aloha_throughput
from pelagos.sensors.comms.link.budget import HeardSignal
from pelagos.sensors.comms.link.medium import ModemPose, SharedMedium
from pelagos.sensors.comms.link.modem_port import ModemPort
from pelagos.sensors.comms.link.traffic import Traffic
from pelagos.sensors.comms.modem import Modem, ModemConfig
from pelagos.sensors.sensor import SensorContext

STATIONS = 12
TICKS = 8  # of a packet
DT_NS = 10_000_000


class StillWater(SharedMedium):
    """All modems hear each other alike, after the same delay, far above the noise: what is lost is lost by others."""

    def pose(self, path: str) -> ModemPose:
        """One place for all."""
        return ModemPose(np.array([[0.0, 0.0, -10.0]]), np.array([[1.0, 0, 0, 0]]), np.zeros((1, 3)))

    def level(self, t: float) -> float:
        """No tide."""
        return 0.0

    def hear(
        self, pairs: Sequence[tuple[int, int, int]], poses: Mapping[int, ModemPose], t: float, cache: Any,
        lag: Sequence[float],
    ) -> list[HeardSignal]:  # fmt: skip
        """100 m."""
        return [HeardSignal(0.0667, 140.0, -np.inf, 0.0, 1.0, "", None) for _ in pairs]


@dataclass
class FirstEpisode:
    """Names of the random streams of one copy."""

    environment: NDArray[np.int64]
    number: NDArray[np.int64]


def network() -> Traffic:
    """Stations and a receiver, with packets of `TICKS` ticks."""
    config = ModemConfig.model_validate(
        {"device": "micromodem_psk", "mac": "aloha", "bit_rate_bps": 1600.0, "preamble_s": 0.0, "rate_hz": 100.0}
    )
    medium = StillWater()
    for k in range(STATIONS + 1):
        Modem(config, replace(SensorContext.alone(f"s{k}.modem", dt_ns=DT_NS), medium=medium))
    port: ModemPort = medium.modems["s0.modem"]
    assert round(port.duration_s(12) * 1e9) == TICKS * DT_NS
    return Traffic(medium, FirstEpisode(np.zeros(1, np.int64), np.zeros(1, np.int64)))


def throughput(load: float, *, slotted: bool, packets: int) -> tuple[float, int]:
    """Of stations that begin a packet at random while they are idle: packets received a packet time, and how many."""
    traffic, rng = network(), np.random.default_rng(7)
    share = load / STATIONS  # of its time in which a station sends
    chance = share if slotted else 1.0 / (1.0 + TICKS * (1.0 - share) / share)  # at an idle tick: mean gap of a renewal
    step, idle_from = TICKS if slotted else 1, np.zeros(STATIONS)
    last = round(packets / load) * TICKS
    received = 0
    for tick in range(last + 20):
        now = tick * DT_NS
        if tick % step == 0 and tick < last:
            for k in np.flatnonzero((idle_from <= tick) & (rng.random(STATIONS) < chance)):
                traffic.send(f"s{k}.modem", f"s{STATIONS}.modem", b"x" * 12, now_ns=now, acknowledge=False, where=[0])
                idle_from[k] = tick + TICKS
        received += len(traffic.read(f"s{STATIONS}.modem", tick).packets[0])
    return received / (last / TICKS), received


@pytest.mark.parametrize("load", [0.5])
def test_pure_aloha(load: float) -> None:
    """Of a few stations each is silent when a packet begins, and stays so: G ((1 - a) (1 - p)^(T - 1))^(N - 1).

    a = G/N is the share of its time that a station sends, p its chance to begin at an idle tick, T the packet's ticks.
    With many stations and short ticks that is G e^{-2G}. Four standard errors of the number received.
    """
    measured, received = throughput(load, slotted=False, packets=500)
    share = load / STATIONS
    begin = 1.0 / (1.0 + TICKS * (1.0 - share) / share)
    expected = load * ((1 - share) * (1 - begin) ** (TICKS - 1)) ** (STATIONS - 1)
    assert measured == pytest.approx(expected, rel=4 / np.sqrt(received))
    assert expected == pytest.approx(float(aloha_throughput(load)), rel=0.2)


@pytest.mark.parametrize("load", [1.0])
def test_slotted_aloha(load: float) -> None:
    """G (1 - G/N)^(N - 1), which is G e^{-G} for many stations."""
    measured, received = throughput(load, slotted=True, packets=500)
    expected = load * (1 - load / STATIONS) ** (STATIONS - 1)
    assert measured == pytest.approx(expected, rel=4 / np.sqrt(received))
    assert expected == pytest.approx(float(aloha_throughput(load, slotted=True)), rel=0.06)


@pytest.mark.parametrize(("payload", "kind", "fits"), [
    (31, "data", True), (32, "data", False), (31, "response", True), (32, "response", False), (999, "request", True),
])  # fmt: skip
def test_a_slot_holds_a_packet_before_its_guard_time(payload: int, kind: str, fits: bool) -> None:
    """At 1000 bit/s, 0.1 s of preamble and 4 bytes of header, 31 bytes take 0.38 s; a slot of 0.5 s has 0.115 s of
    guard, so that 0.385 s remain. Requests are a header alone; who has no slots sends anything."""
    medium = StillWater()
    Modem(ModemConfig(device="micromodem_psk"), replace(SensorContext.alone("s0.modem", dt_ns=DT_NS), medium=medium))
    one = medium.modems["s0.modem"]
    port = replace(one, bit_rate_bps=1000.0, preamble_s=0.1, slot_s=0.5, guard_s=0.115)
    assert replace(port, mac="tdma").holds(payload, kind) == fits
    assert replace(port, mac="aloha").holds(payload, kind)
