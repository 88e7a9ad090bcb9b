"""Orders on their way to the thread that steps: streams of each agent, who replaces whom, when they are noted."""

from __future__ import annotations

import json
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos.bridges import inbox as module
from pelagos.bridges.inbox import STREAM_S, Inbox
from pelagos.errors import CommandError
from pelagos.sim.order import Order

MS = 1_000_000


class Sim:
    """Time, and what waits for the next boundary."""

    def __init__(self) -> None:
        self.time_ns, self.dt_ns = 0, 10 * MS
        self.posted: list[Callable[[], object]] = []
        self.mode, self.steered = "actuators", list[Any]()
        self.stepper = SimpleNamespace(
            mode=lambda agent: self.mode, set_command=lambda agent, rows: self.steered.append((agent, rows))
        )

    def post(self, do: Callable[[], object]) -> None:
        self.posted.append(do)


@pytest.fixture
def done(monkeypatch: pytest.MonkeyPatch) -> list[Order]:
    """What was obeyed; orders for "nobody" cannot be."""
    found: list[Order] = []

    def apply(order: Order, sim: Any) -> None:
        if order.target == "nobody":
            raise CommandError("there is no nobody")
        found.append(order)

    monkeypatch.setattr(module, "apply", apply)
    return found


def velocity(agent: str, surge: float = 0.3, **more: float) -> Order:
    return Order("velocity", agent, {"values": [surge, 0, 0, 0, 0, 0], **more})


def test_each_agent_has_a_stream_of_velocities_of_its_own(done: list[Order]) -> None:
    """The time since the last one of the same agent; none behind a gap of more than a second, or a reset."""
    sim: Any = Sim()
    inbox = Inbox(sim)
    for agent, t_s, since_s in (
        ("a", 0.2, 0.0), ("b", 0.3, 0.0), ("a", 0.7, 0.5), ("b", 0.7, 0.4), ("a", 0.7 + STREAM_S, STREAM_S),
        ("a", 1.71 + STREAM_S, 0.0), ("a", 0.1, 0.0), ("a", 0.35, 0.25), ("b", 0.6, 0.0),
    ):  # fmt: skip
        sim.time_ns = round(t_s * 1e9)
        inbox.obey(velocity(agent))
        assert done[-1].data["since_s"] == pytest.approx(since_s, abs=1e-9), (agent, t_s)
        assert done[-1].data["values"][0] == 0.3
    inbox.obey(velocity("a", since_s=0.7))  # a run that is repeated
    inbox.obey(Order("pose", "a", {"values": [1, 2, 3, 0, 0, 0]}))
    assert done[-2].data["since_s"] == 0.7
    assert "since_s" not in done[-1].data
    sim.time_ns += 100 * MS
    inbox.obey(velocity("a"))
    assert done[-1].data["since_s"] == pytest.approx(0.35)  # from 0.35 s to 0.7 s: what told its own time is no part


def test_the_newest_of_an_agents_commands_goes_to_the_boundary_with_the_others(done: list[Order]) -> None:
    sim: Any = Sim()
    inbox = Inbox(sim)
    first = inbox.put(velocity("a", 0.1))
    other, mode = inbox.put(velocity("b", 0.2)), inbox.put(Order("mode", "a", {"mode": "x"}))
    newest, twice = inbox.put(velocity("a", 0.4)), inbox.put(Order("mode", "a", {"mode": "y"}))
    assert len(sim.posted) == 1
    assert first.done.is_set()
    assert (first.wait(0.0), other.done.is_set()) == ("", False)
    sim.posted.pop()()
    told = [(o.kind, o.target, o.data.get("mode") or o.data["values"][0]) for o in done]
    assert told == [("velocity", "b", 0.2), ("mode", "a", "x"), ("velocity", "a", 0.4), ("mode", "a", "y")]
    assert [t.wait(0.0) for t in (other, mode, newest, twice)] == [""] * 4
    assert inbox.obeyed == {"velocity": 2, "mode": 2}
    again = inbox.put(velocity("a", 0.5))
    assert len(sim.posted) == 1  # what comes after a boundary asks for another
    sim.posted.pop()()
    assert (again.wait(0.0), done[-1].data["values"][0]) == ("", 0.5)


def test_what_is_steered_is_written_down_later_with_its_own_time(done: list[Order]) -> None:
    sim: Any = Sim()
    notes: list[tuple[dict[str, Any], int]] = []
    inbox = Inbox(sim, note=lambda text, t_ns: notes.append((json.loads(text), t_ns)))
    sim.time_ns = 50 * MS
    inbox.steer("a", [0.5, -0.25], "pilot")
    sim.time_ns = 70 * MS
    inbox.steer("b", [0.125, 1.0], "pilot")
    assert not notes
    sim.time_ns = 90 * MS
    for _ in range(2):
        inbox.write_down()
    assert [(n["tick"], n["t_ns"], t_ns, n["target"], n["data"]["values"]) for n, t_ns in notes] == [
        (5, 50 * MS, 50 * MS, "a", [0.5, -0.25]), (7, 70 * MS, 70 * MS, "b", [0.125, 1.0]),
    ]  # fmt: skip
    assert {(n["kind"], n["data"]["mode"], n["source"]) for n, _ in notes} == {("command", "actuators", "pilot")}
    assert [(agent, rows.tolist()) for agent, rows in sim.steered] == [("a", [[0.5, -0.25]]), ("b", [[0.125, 1.0]])]
    assert all(rows.dtype == np.float64 for _, rows in sim.steered)
    assert not done
    sim.mode = "velocity"
    inbox.steer("a", [0.75, 0.5], "pilot")  # the long way, which changes the mode
    assert (done[0].data, len(sim.steered)) == ({"values": [0.75, 0.5], "mode": "actuators"}, 2)
    assert (notes[-1][0]["tick"], inbox.obeyed) == (9, {"command": 3})


def test_refusals_are_told_with_their_source_and_leave_no_note(done: list[Order]) -> None:
    sim: Any = Sim()
    said, notes = list[str](), list[Any]()
    inbox = Inbox(sim, note=lambda *note: notes.append(note), say=said.append)
    tickets = [inbox.put(Order("mode", "nobody", {"mode": "x"}, source)) for source in ("peer", "", "peer")]
    inbox.drain()
    assert [t.wait(0.0) for t in tickets] == [
        "peer: there is no nobody", "there is no nobody", "peer: there is no nobody"
    ]  # fmt: skip
    assert said == ["peer: there is no nobody", "there is no nobody"]
    assert inbox.refused == {"peer: there is no nobody": 2, "there is no nobody": 1}
    assert not notes
    assert not inbox.obeyed
    assert not done
