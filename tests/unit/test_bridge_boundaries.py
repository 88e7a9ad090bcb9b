"""A run's boundaries with doors and autopilots: how often, in which order, steps of a paused run, and the end."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from pelagos.bridges import exchange as module
from pelagos.bridges.exchange import Exchange
from pelagos.bridges.journal import TOPIC

MS = 1_000_000


class Sim:
    """Listeners with their rates, time, and whether it is held."""

    def __init__(self) -> None:
        self.time_ns, self.dt_ns = 0, 10 * MS
        self.listeners: list[tuple[Callable[[Any], object], float | None]] = []
        self.asked: list[Any] = []
        self.held = False
        self.during: Callable[[], object] = lambda: None

    def on_tick(self, tell: Callable[[Any], object], rate_hz: float | None = None) -> Any:
        entry = (tell, rate_hz)
        self.listeners.append(entry)

        def cancel() -> None:
            self.listeners = [other for other in self.listeners if other is not entry]

        return SimpleNamespace(cancel=cancel)

    def run(self, seconds: float | None, *, record: Any, progress: Any, realtime: Any) -> str:
        self.asked.append((seconds, realtime))
        self.during()
        return "result"

    def post(self, do: Callable[[], object]) -> None:
        do()

    def pause(self) -> None:
        self.held = True

    def resume(self) -> None:
        self.held = False

    def stop(self) -> None:
        self.asked.append("stop")

    def boundary(self, rate_hz: float | None) -> None:
        for tell, rate in list(self.listeners):
            if rate == rate_hz:
                tell(self)


class Kept:
    """A door and an autopilot that say what is done with them."""

    def __init__(self, name: str, log: list[Any], *, rate_hz: float | None = None, **troubles: int) -> None:
        self.name, self.log, self.rate_hz, self.troubles = name, log, rate_hz, troubles

    def open(self, sim: Any, tap: Any) -> None:
        self.log.append(f"{self.name} opens")

    def send(self, sim: Any, messages: Any) -> None:
        self.log.append((f"{self.name} sends", [m.t_ns // MS for m in messages]))

    def answer(self, sim: Any) -> None:
        self.log.append(f"{self.name} answers")

    def wait(self, sim: Any) -> None:
        self.log.append(f"{self.name} waits")

    def report(self) -> Any:
        return self.troubles

    def close(self) -> None:
        self.log.append(f"{self.name} closes")


class Parts:
    """Stands for what a run has beside its doors."""

    def __init__(self, log: list[Any]) -> None:
        self.log, self.tap, self.by_member = log, None, list[bool]()

    def recorder(self, path: Any, sim: Any, *, writer: Any, by_member: bool) -> Any:
        self.tap = writer
        self.by_member.append(by_member)
        return SimpleNamespace(close=lambda: self.log.append("recorder closes"))

    def machinery(self, sim: Any, tap: Any) -> Any:
        return SimpleNamespace(say=lambda sim: self.log.append("machinery"))


@pytest.fixture
def log() -> list[Any]:
    return []


@pytest.fixture
def parts(monkeypatch: pytest.MonkeyPatch, log: list[Any]) -> Parts:
    made = Parts(log)
    monkeypatch.setattr(module, "open_recorder", made.recorder)
    monkeypatch.setattr(module, "Machinery", made.machinery)
    return made


@pytest.fixture
def sim() -> Any:
    return Sim()


@pytest.mark.parametrize(
    ("keys", "rate", "factor"),
    [({}, 2.0, False), ({"realtime": 3.0}, 100.0, 1e6), ({"realtime": 0.5, "rate_hz": 7.0}, 7.0, 1e6),
     ({"rate_hz": 9.0}, 9.0, False)],
)  # fmt: skip
def test_boundaries_come_as_often_as_the_most_demanding_wants(
    keys: dict[str, float], rate: float, factor: Any, sim: Any, parts: Parts
) -> None:
    """Twice a second, a hundred times by the clock; a door may want more, and none makes them fewer."""
    exchange = Exchange(sim, **keys)  # type: ignore[arg-type]
    exchange.at_least(1.0)
    seen: list[Any] = []
    sim.during = lambda: seen.append([rate_hz for _, rate_hz in sim.listeners])
    assert exchange.run(4.5) == "result"
    exchange.at_least(250.0)
    exchange.at_least(30.0)
    exchange.run()
    assert seen == [[rate], [250.0]]
    assert sim.asked == [(4.5, factor), (None, factor)]
    assert not sim.listeners


def test_a_boundary_tells_what_was_measured_before_anybody_is_obeyed(sim: Any, parts: Parts, log: list[Any]) -> None:
    """What was steered is in the messages of its own boundary, and so are the actuators; orders come last."""
    exchange: Any = Exchange(sim, rate_hz=20.0)
    exchange.add(Kept("it", log))
    exchange.inbox = SimpleNamespace(
        write_down=lambda: (log.append("written"), exchange.note("what", sim.time_ns)),
        drain=lambda: (log.append("orders"), exchange.note("order", sim.time_ns + 1 * MS)),
        refused=Counter(),
    )
    exchange.pace = SimpleNamespace(
        keep=lambda t_ns: log.append(("paced", t_ns // MS)),
        restart=lambda t_ns: log.append(("from", t_ns // MS)),
        factor=0.0,
    )
    sim.time_ns = 30 * MS

    def during() -> None:
        sim.time_ns = 50 * MS
        sim.boundary(20.0)
        sim.time_ns = 90 * MS

    sim.during = during
    exchange.run(1.0)
    assert log == [
        "it opens", ("from", 30), ("paced", 50), "written", "machinery", ("it sends", [50]), "orders",
        "written", ("it sends", [51, 90]), "recorder closes",
    ]  # fmt: skip
    exchange.note("nobody", 0)  # no run, no recording
    assert parts.tap is not None
    assert not parts.tap.take()
    assert TOPIC in {channel.topic for channel in parts.tap.channels.values()}


def test_doors_alone_have_members_told_apart_and_actuators(sim: Any, parts: Parts, log: list[Any]) -> None:
    exchange = Exchange(sim)
    sim.during = lambda: sim.boundary(2.0)
    exchange.run(1.0)
    assert log == ["recorder closes"]
    exchange.add(Kept("it", log))
    exchange.run(1.0)
    assert log[1:] == ["it opens", "machinery", ("it sends", []), ("it sends", []), "recorder closes"]
    assert parts.by_member == [False, True]


def test_autopilots_that_meet_at_one_time_think_at_one_time(sim: Any, parts: Parts, log: list[Any]) -> None:
    """Each at its own rate, and all of one rate are answered before any is waited for."""
    exchange = Exchange(sim)
    for name, rate_hz in (("a", 50.0), ("b", None), ("c", 50.0)):
        exchange.drive(Kept(name, log, rate_hz=rate_hz))

    def during() -> None:
        for rate_hz in (50.0, None, 2.0):
            sim.boundary(rate_hz)

    sim.during = during
    exchange.run(1.0)
    assert log == [
        "a answers", "c answers", "a waits", "c waits", "b answers", "b waits", "recorder closes"
    ]  # fmt: skip
    assert not sim.listeners


@pytest.fixture
def stepped(sim: Any, log: list[Any]) -> Iterator[Any]:
    """A paused run at 50 ms."""
    sim.time_ns, sim.held = 50 * MS, True
    exchange: Any = Exchange(sim)
    exchange.add(Kept("it", log))
    exchange._tap = SimpleNamespace(take=list)
    exchange.pace = SimpleNamespace(restart=lambda t_ns: log.append(("from", t_ns // MS)))
    yield exchange
    assert not sim.listeners


def test_a_paused_run_goes_on_by_so_many_ticks_and_is_held_again(stepped: Any, sim: Any, log: list[Any]) -> None:
    done = stepped.step(3)
    assert (sim.held, log.pop()) == (False, ("from", 50))
    for ms in (50, 60, 70):  # the tick at which it stood is none
        sim.time_ns = ms * MS
        sim.boundary(None)
        assert (done.is_set(), sim.held, log) == (False, False, [])
    sim.time_ns = 80 * MS
    sim.boundary(None)
    assert (done.is_set(), sim.held, log) == (True, True, [("it sends", [])])


@pytest.mark.parametrize("how", ["step", "resume"])
def test_steps_that_others_follow_are_over(stepped: Any, sim: Any, log: list[Any], how: str) -> None:
    first = stepped.step(5)
    sim.time_ns = 60 * MS
    sim.boundary(None)
    second = stepped.step(1) if how == "step" else None
    if second is None:
        stepped.resume()
    assert first.is_set()
    assert (sim.held, log) == (False, [("from", 50), ("from", 60)])
    sim.time_ns = 70 * MS
    sim.boundary(None)
    assert sim.held == (second is not None)
    assert second is None or second.is_set()


def test_a_reset_that_is_asked_for_ends_the_run_and_is_forgotten_in_the_next(sim: Any, parts: Parts) -> None:
    exchange = Exchange(sim)
    sim.during = exchange.reset
    exchange.run(1.0)
    assert exchange.reset_asked
    assert sim.asked[-1] == "stop"
    sim.during = lambda: None
    exchange.run(1.0)
    assert not exchange.reset_asked


def test_the_end_counts_the_troubles_of_doors_and_autopilots_by_their_names(sim: Any, log: list[Any]) -> None:
    exchange = Exchange(sim)
    exchange.add(Kept("it", log, late=2, never=0))
    exchange.add(Kept("other", log, late=5))
    exchange.drive(Kept("pilot", log, silent=1))
    exchange.inbox.refuse("odd")
    found = {"it: late": 2, "other: late": 5, "pilot: silent": 1, "refused: odd": 1}
    assert dict(exchange.close()) == found
    assert log == ["it closes", "other closes", "pilot closes"]
    assert dict(exchange.close()) == {"refused: odd": 1}
    assert len(log) == 3
    assert exchange.do(lambda: log.append("done"), 0.0)
    assert log[-1] == "done"
