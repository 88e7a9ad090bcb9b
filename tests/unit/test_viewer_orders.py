"""Orders of browsers where there is no ground, at limits, and in their order; way-points reached and passed."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos.errors import CommandError, InputError, LookupFailed
from pelagos.viewer import orders as module
from pelagos.viewer import pilot as pilots
from pelagos.viewer.orders import Orders
from pelagos.viewer.pilot import Pilot


class Desk:
    """Orders for a simulation of which only what they ask for is there."""

    def __init__(self, tmp_path: Path) -> None:
        self.ground = -20.0
        self.done: list[Any] = []
        note = lambda name: lambda *values, **keys: self.done.append((name, *values, *keys.items()))
        body = lambda name, speed: SimpleNamespace(
            name=name, fastest_mps=speed, position=np.array([[3.0, 4.0, -7.0], [9, 9, 9]]), remove=note("remove"),
            move=lambda position: self.done.append(("move", position)),
        )  # fmt: skip
        self.sim: Any = SimpleNamespace(
            world=SimpleNamespace(height=lambda x, y: self.ground + 0.5 * x), spawn=lambda prop: self.done.append(prop),
            model=SimpleNamespace(agents={"a": 1, "b": 2}), gate=SimpleNamespace(settle=lambda: None),
            state={"a": SimpleNamespace(position=np.array([[1.0, 2.0, -6.5], [0, 0, 0]]))},
            bodies=SimpleNamespace(bodies=[body("crate", None), body("ferry", 2.0)]),
            ocean=SimpleNamespace(set=lambda **keys: self.done.append(keys)),
        )  # fmt: skip
        self.pilot: Any = SimpleNamespace(
            sim=self.sim, post=lambda order: order(), goals={"a": [1], "b": [2]}, paused=False, speed=1.0,
            go_to=lambda agent, place: self.done.append((agent, *place.tolist())), reset=note("reset"),
            begin_recording=lambda path: self.done.append(path.name), end_recording=lambda: None,
        )  # fmt: skip
        self.orders = Orders(self.pilot, tmp_path / "results")

    def do(self, what: str, **keys: Any) -> Any:
        assert self.orders.obey({"do": what, **keys})
        return self.done[-1] if self.done else None


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    return Desk(tmp_path)


@pytest.mark.parametrize(("ground", "depth", "z"), [
    (-20.0, 5.0, -5.0), (-20.0, 19.0, -17.0), (-20.0, 18.1, -17.0), (-20.0, None, -6.5), (-6.0, None, -3.0),
    (-2.5, 4.0, 0.0), (math.nan, 400.0, -400.0), (5.0, -3.0, 3.0), (-20.0, 0.0, 0.0),
])  # fmt: skip
def test_a_way_point_is_two_metres_over_the_ground_and_not_over_the_water(desk, ground, depth, z):
    """At x = 2 m the ground is 1 m higher than at 0; a vehicle that flies stays in the air."""
    desk.ground = ground
    more = {} if depth is None else {"depth": depth}
    assert desk.do("goal", agent="a", x=2.0, y=-9.0, **more) == ("a", 2.0, -9.0, z)


@pytest.mark.parametrize(("ground", "keys", "z", "size"), [
    (-20.0, {}, -18.5, 1.0), (-20.0, {"size": 3.0}, -17.5, 3.0), (-20.0, {"depth": 4.0}, -4.0, 1.0),
    (math.nan, {"size": 3.0}, -5.0, 3.0),
])  # fmt: skip
def test_a_prop_is_put_upon_the_ground_or_at_five_metres(desk, ground, keys, z, size):
    desk.ground = ground
    prop = desk.do("spawn", x=2.0, y=-9.0, **keys)
    assert tuple(prop.position) == (2.0, -9.0, z)
    assert tuple(prop.size) == (size, size, size)
    assert (prop.shape, prop.label) == ("box", "debris")


def test_a_prop_that_is_moved_keeps_its_height_over_the_ground(desk):
    assert desk.do("move", name="crate", x=9.0, y=1.0) == ("move", (9.0, 1.0, -4.0))  # from x = 3 the ground rises 3 m
    desk.ground = math.nan
    assert desk.do("move", name="crate", x=9.0, y=1.0) == ("move", (9.0, 1.0, -7.0))
    with pytest.raises(LookupFailed, match="unknown prop 'ferry'"):  # it goes its own way
        desk.do("remove", name="ferry")
    assert desk.do("remove", name="crate") == ("remove",)


def test_a_stick_counts_for_the_time_since_it_was_heard_and_ends_the_way_to_a_goal(desk, monkeypatch):
    clock = iter([100.0, 100.25, 101.0, 105.0])
    monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    given: list[Any] = []
    monkeypatch.setattr(
        module, "drive", lambda sim, agent, axes, dt_s: given.append((agent, axes.surge, round(dt_s, 9)))
    )
    left = []
    for agent, surge in (("a", 0.5), ("a", 0.25), ("b", -1), ("a", 7)):
        desk.do("drive", agent=agent, surge=surge)
        left.append([*desk.pilot.goals])
    assert left == [["b"], ["b"], [], []]
    assert given == [("a", 0.5, 0.1), ("a", 0.25, 0.25), ("b", -1.0, 0.1), ("a", 1.0, 4.75)]


def test_recordings_of_the_page_are_numbered(desk, tmp_path):
    assert desk.do("record", on=True) == "view-1.mcap"
    (tmp_path / "results" / "view-1.mcap").touch()
    (tmp_path / "results" / "view-2.mcap").touch()
    assert desk.do("record", on=True) == "view-3.mcap"
    count = len(desk.done)
    desk.do("record", on=False)
    assert len(desk.done) == count


@pytest.mark.parametrize("seed", [True, -1, 2**63, 1.0, "7"])
def test_seeds_that_are_none_are_refused(desk, seed):
    with pytest.raises(CommandError, match="a seed is a whole number from 0 on"):
        desk.do("reset", seed=seed)
    assert desk.do("reset", seed=0) == ("reset", 0)
    assert desk.do("reset", seed=2**63 - 1) == ("reset", 2**63 - 1)
    assert desk.do("reset") == ("reset", None)


def test_waves_are_as_long_as_they_may_be_steep(desk):
    """A fifteenth of the wavelength g T^2 / (2 pi) at most; a flat sea has no period."""
    height = 3.0
    least = math.sqrt(15 * height * 2 * math.pi / 9.80665)
    sea = lambda period, **keys: desk.do("waves", **{"height": height, "period": period, "towards_deg": 200, **keys})
    with pytest.raises(CommandError, match=rf"peak period of {least:.1f} to 25 s"):
        sea(0.99 * least)
    with pytest.raises(CommandError, match=r"not 25\.1 s"):
        sea(25.1)
    (waves,) = sea(1.01 * least)["keys"]["waves"]
    assert waves == {
        "type": "jonswap",
        "significant_height_m": 3.0,
        "peak_period_s": 1.01 * least,
        "towards_deg": 200.0,
    }
    assert sea(0.1, height=0)["keys"] == {"waves": []}
    with pytest.raises(CommandError, match="0 to 15 m"):
        sea(20.0, height=15.1)
    assert sea(20.0, height=15.0)["keys"]["waves"]


@pytest.mark.parametrize(("towards", "way"), [(0, (2, 0, 0)), (90, (0, -2, 0)), (210, (-math.sqrt(3), 1, 0))])
def test_a_current_sets_to_where_the_compass_says(desk, towards, way):
    assert desk.do("current", speed=2.0, towards_deg=towards)["current"] == pytest.approx(way, abs=1e-12)
    assert desk.do("current", speed=10.0, towards_deg=towards)
    with pytest.raises(CommandError, match=r"0 to 10 m/s, not -0\.1"):
        desk.do("current", speed=-0.1, towards_deg=towards)


def test_speeds_of_a_run(desk):
    for speed in (0, 0.1, 100):
        desk.do("speed", speed=speed)
        assert desk.pilot.speed == speed
    for speed in (-0.1, 100.1, math.inf, True, None):
        with pytest.raises(CommandError, match="speed"):
            desk.do("speed", speed=speed)
    desk.do("pause")
    assert desk.pilot.paused
    desk.do("pause", paused=True)
    assert desk.pilot.paused
    desk.do("pause")
    assert not desk.pilot.paused


def follower(monkeypatch: pytest.MonkeyPatch) -> tuple[Any, list[Any]]:
    given: list[Any] = []
    monkeypatch.setattr(
        pilots, "apply", lambda order, sim: given.append((order.kind, order.target, order.data["values"]))
    )
    made: Any = object.__new__(Pilot)
    made.goals, made._from = {}, {}
    made.sim = SimpleNamespace(state={"a": SimpleNamespace(position=np.array([[0.0, 0.0, -5.0], [99, 99, 99]]))})
    return made, given


@pytest.mark.parametrize(("x", "y", "reached"), [
    (37.1, 20.0, True), (36.9, 20.0, False), (40.0, 22.9, True), (38.0, 16.0, False), (20.0, 10.0, False),
    (47.0, 13.0, True), (31.0, 27.0, False), (33.0, 35.0, True),
])  # fmt: skip
def test_a_way_point_is_reached_within_three_metres_or_passed(monkeypatch, x, y, reached):
    """Passed is a line through it, across the way from where the vehicle was when it made for it."""
    made, given = follower(monkeypatch)
    first, second = np.array([40.0, 20.0, -5.0]), np.array([0.0, 60.0, -7.0])
    made.go_to("a", first)
    made.go_to("a", second)
    assert given == [("waypoint", "a", first.tolist())]
    made.sim.state["a"].position[0, :2] = (x, y)
    made._follow_goals()
    assert [g.tolist() for g in made.goals["a"]] == [g.tolist() for g in ((second,) if reached else (first, second))]
    assert given[1:] == ([("waypoint", "a", second.tolist())] if reached else [])
    if reached:
        assert made._from["a"].tolist() == [x, y]
        made.sim.state["a"].position[0, :2] = (0.0, 61.0)
        made._follow_goals()
        assert made.goals["a"] == []


def test_a_way_point_that_cannot_be_made_for_is_forgotten(monkeypatch):
    made, _ = follower(monkeypatch)
    monkeypatch.setattr(pilots, "apply", lambda order, sim: (_ for _ in ()).throw(InputError("no mode for it")))
    with pytest.raises(InputError, match="no mode for it"):
        made.go_to("a", np.array([1.0, 2.0, -3.0]))
    assert made.goals == {"a": []}
