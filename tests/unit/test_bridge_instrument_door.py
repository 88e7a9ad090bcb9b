"""Several sensors on one instrument's port: who hears what, clocks, requests, and a run that begins anew."""

from __future__ import annotations

import struct
import time
from collections import Counter
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta, timezone
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos.bridges import instrument
from pelagos.bridges.instrument import InstrumentConfig, InstrumentDoor
from pelagos.bridges.instruments import ping
from pelagos.bridges.tap import Tap
from pelagos.config import registry

SENSORS = ("depth", "gps", "altimeter", "singlebeam")


class Port:
    """Keeps what is written, and has what a driver asks."""

    where = "here"

    def __init__(self) -> None:
        self.troubles = Counter({"lost": 2})
        self.asked: list[tuple[object, bytes]] = []
        self.written: list[bytes] = []
        self.replied: list[tuple[object, bytes]] = []
        self.closed = False

    def read(self) -> list[tuple[object, bytes]]:
        asked, self.asked = self.asked, []
        return asked

    def write(self, raw: bytes) -> None:
        self.written.append(raw)

    def reply(self, peer: object, raw: bytes) -> None:
        self.replied.append((peer, raw))

    def close(self) -> None:
        self.closed = True


class Sim:
    """Sensors that are listened to, of an agent at rest."""

    def __init__(self, dt_ns: int) -> None:
        self.dt_ns, self.heard = dt_ns, dict[str, tuple[Any, bool]]()
        configs = {name: registry.find("sensor", name).config.model_validate({"type": name}) for name in SENSORS}
        sensors = {name: SimpleNamespace(config=config) for name, config in configs.items()}
        self.model = SimpleNamespace(agents={"a": SimpleNamespace(sensors=sensors)})

    def subscribe(self, name: str, hear: Any, *, invalid: bool) -> Any:
        self.heard[name] = (hear, invalid)
        return SimpleNamespace(cancel=lambda: self.heard.pop(name))


@pytest.fixture
def port(monkeypatch: pytest.MonkeyPatch) -> Port:
    made = Port()
    monkeypatch.setattr(instrument, "open_port", lambda text: made)
    return made


@pytest.fixture
def far_east(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A machine whose own clock is nine hours ahead."""
    monkeypatch.setenv("TZ", "Asia/Tokyo")
    time.tzset()
    yield
    monkeypatch.undo()
    time.tzset()


def opened(
    protocol: str, sensors: tuple[str, ...], dt_ms: int = 10, **keys: Any
) -> tuple[InstrumentDoor, Any, list[float]]:
    sim, rates = Sim(dt_ms * 1_000_000), list[float]()
    exchange: Any = SimpleNamespace(sim=sim, at_least=rates.append)
    config = InstrumentConfig(type="instrument", protocol=protocol, sensors=sensors, port="udp:9", **keys)  # type: ignore[arg-type]
    door = InstrumentDoor(exchange, config)
    door.open(sim, Tap())  # type: ignore[arg-type]
    return door, sim, rates


def reading(t_s: float, *data: float, valid: bool = True) -> Any:
    return SimpleNamespace(t_ns=round(t_s * 1e9), data=np.array([data]), valid=np.array([valid]))


@pytest.mark.parametrize(
    ("start", "hour"),
    [(datetime(2027, 3, 1, 10, 0, 58), b"100058"), (datetime(2027, 3, 1, 10, 0, 58, tzinfo=UTC), b"100058"),
     (datetime(2027, 3, 1, 10, 0, 58, tzinfo=timezone(timedelta(hours=-3))), b"130058")],
)  # fmt: skip
@pytest.mark.usefixtures("far_east")
def test_each_sensor_speaks_for_itself_in_universal_time(start: datetime, hour: bytes, port: Port) -> None:
    """A receiver tells that it has no fix, a depth gauge that lost its reading is silent."""
    door, sim, _ = opened("nmea", ("depth", "a.gps"), start_utc=start)
    assert {name: invalid for name, (_, invalid) in sim.heard.items()} == {"a.depth": False, "a.gps": True}
    sim.heard["a.gps"][0](reading(1.25, 0.0, 0.0, 0.0, valid=False))
    sim.heard["a.depth"][0](reading(1.5, 10.0))
    assert not port.written
    door.send(sim, ())
    fix, depth = port.written
    assert fix.startswith(b"$GPGGA," + hour[:4] + b"59.25,,,,,0,")
    assert depth.startswith(b"$YXXDR,P,2.01")  # 1.01325 bar and 10 m of 1025 kg/m^3
    assert (door.spoken, door.name) == (2, "nmea depth+a.gps")
    door.send(sim, ())
    assert len(port.written) == 2
    door.close()
    assert (sim.heard, port.closed) == ({}, True)


@pytest.mark.parametrize(("dt_ms", "rate"), [(5, 50.0), (50, 20.0)])
def test_a_port_is_looked_at_fifty_times_a_second_or_at_every_tick(dt_ms: int, rate: float, port: Port) -> None:
    _, _, rates = opened("nmea", ("depth", "altimeter"), dt_ms)
    assert rates == [rate, rate]


def test_every_instrument_on_a_port_answers_who_asked(port: Port) -> None:
    """And after a reset nothing that was said before is sent; what was no request is counted of all."""
    door, sim, _ = opened("ping1d", ("altimeter", "singlebeam"))
    sim.heard["a.altimeter"][0](reading(0.0, 7.25))
    sim.heard["a.singlebeam"][0](reading(0.0, 0.0, 0.5, 0.25, 0.0))
    ask = ping.frame(ping.GENERAL_REQUEST, struct.pack("<H", ping.DISTANCE))
    port.asked = [("one", ask), ("two", b"rubbish of noise"), ("two", ask)]
    door.send(sim, ())
    assert [peer for peer, _ in port.replied] == ["one", "one", "two", "two"]
    told = [next(ping.Frames().feed(raw)) for _, raw in port.replied]
    assert told[:2] == told[2:]
    distances = [struct.unpack_from("<IH", payload) for _, payload in told[:2]]
    config = sim.model.agents["a"].sensors["singlebeam"].config
    middle = config.range_min_m + 1.5 * (config.range_max_m - config.range_min_m) / 4
    assert distances == [(7250, 100), (round(1000 * middle), 50)]
    found = door.report()
    assert (found["lost"], found["bytes that were no request"]) == (2, 2 * 16)
    stream = ping.frame(ping.CONTINUOUS_START, struct.pack("<H", ping.DISTANCE_SIMPLE))
    port.asked = [("one", stream)]
    door.send(sim, ())
    sim.heard["a.altimeter"][0](reading(5.0, 8.5))
    door.open(sim, Tap())  # the run begins anew
    door.send(sim, ())
    assert (port.written, door.spoken) == ([], 0)
    sim.heard["a.altimeter"][0](reading(0.5, 9.5))  # earlier than the last, and due
    door.send(sim, ())
    ((number, payload),) = ping.Frames().feed(port.written[0])
    assert (number, struct.unpack("<IB", payload)) == (ping.DISTANCE_SIMPLE, (9500, 100))
