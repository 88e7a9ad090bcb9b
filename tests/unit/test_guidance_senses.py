"""Guidance asks a sensor's class what its readings tell, so that a plug-in's serves as the built-in ones do."""

from __future__ import annotations

from collections import deque
from types import SimpleNamespace
from typing import Any, ClassVar, Literal

import numpy as np
import pytest
from pydantic import ConfigDict

import pelagos as pl
from pelagos.config import registry
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sim.clock import Clock
from pelagos.sim.feedback import Feedback, newest_row
from pelagos.sim.guidance.aboard import Fix
from pelagos.sim.missions import Missions
from pelagos.sim.navigator import External
from pelagos.sim.sampled import Sampled
from pelagos.sim.trajectory import CHANNELS


class LaserConfig(SensorConfig):
    """A range finder that looks along -z of its frame."""

    model_config = ConfigDict(extra="forbid")

    type: Literal["laser"] = "laser"
    rate_hz: float = 10.0
    """Readings per second [Hz]."""


class Laser:
    """A plug-in's range finder, in NumPy."""

    TITLE: ClassVar[str] = "Range along -z"
    Config: ClassVar[type[SensorConfig]] = LaserConfig
    SOURCES: ClassVar[tuple[str, ...]] = ()
    MAY_LACK: ClassVar[bool] = True
    ALTITUDE: ClassVar[str] = ""

    def __init__(self, config: LaserConfig, context: SensorContext) -> None:
        self._config, self._context = config, context

    def sense(self, motion: Kinematics) -> Measurement:
        """Distance along the sensor's -z [m]; NaN beyond 100 m."""
        turn = np.array(motion.attitude).T.reshape(-1, 4)
        own = np.asarray(self._config.q_body_sensor)
        down = np.stack([rotated(rotated(np.array([0.0, 0.0, -1.0]), own), q) for q in turn])
        hits = self._context.cast(motion, np.array(motion.position).T.reshape(-1, 3), down)
        reach = np.where(np.array(hits.valid), np.array(hits.t), np.nan).astype(np.float32)
        return Measurement(data=reach, truth=reach, valid=np.isfinite(reach))


def rotated(v: np.ndarray, q: np.ndarray) -> np.ndarray:
    """A vector turned by a quaternion (w, x, y, z)."""
    t = 2 * np.cross(q[1:], v)
    return v + q[0] * t + np.cross(q[1:], t)


def load(sensor: dict[str, Any], leg: dict[str, Any], world: dict[str, Any]) -> pl.Simulation:
    agent = {
        "vehicle": "bluerov2_heavy",
        "start": {"position_m": [1.0, -2.0], "depth_m": 6.0, "heading_deg": 0.0},
        "sensors": {"eye": sensor},
        "mission": [leg],
    }
    return pl.Simulation.load({"world": world, "agents": {"rov": agent}})


@pytest.fixture(autouse=True)
def laser(monkeypatch):
    """The plug-in, known for one test."""
    found = {"laser": registry.Entry("sensor", "laser", f"{__name__}:Laser", "lasers")}
    monkeypatch.setattr(registry, "_plugins", lambda kind: found if kind == "sensor" else {})


def test_altitude_is_held_with_a_plug_ins_range_finder():
    """From 6 m above the bottom down to 2.5 m, within 0.2 m while the vehicle goes to a point and holds there."""
    leg = {"type": "waypoints", "points": [[6.0, -4.0]], "altitude_m": 2.5}
    sim = load({"type": "laser"}, leg, {"type": "flat", "depth_m": 12.0})
    sim.run(40.0)
    assert sim.state["rov"].position[0, 2] == pytest.approx(-12.0 + 2.5, abs=0.2)


def test_a_sensor_that_tells_no_range_along_its_axis_is_refused():
    leg = {"type": "follow", "wall": "eye", "distance_m": 3.0, "seconds": 10.0}
    with pytest.raises(pl.ScenarioError, match="'eye' is a depth; a wall is followed with an altimeter"):
        load({"type": "depth"}, leg, {"type": "flat", "depth_m": 12.0})
    with pytest.raises(pl.ScenarioError, match="'eye' does not look sideways"):
        load({"type": "laser"}, leg, {"type": "flat", "depth_m": 12.0})


def test_the_newest_readings_are_those_of_the_last_tick_of_each_copy() -> None:
    """Of three copies at two ticks; where a copy has none then, it is no number."""
    data, valid = np.arange(12.0).reshape(6, 2), np.array([False, True, True, True, False, True])
    sampled = Sampled(("a",), SimpleNamespace(name="s"), range(4, 8, 2), Measurement(data, data, valid, {"x": -data}))  # type: ignore[arg-type]
    for array, sign in (("", 1.0), ("x", -1.0)):
        np.testing.assert_array_equal(newest_row(sampled, array, 3), sign * np.array([[6, 7], [np.nan] * 2, [10, 11]]))


def heard(name: str, data: Any, valid: Any, *, fixes: bool = False, **extras: Any) -> Sampled:
    """Of three copies at two ticks."""
    m = Measurement(np.array(data, dtype=float), np.array(data, dtype=float), np.array(valid), extras)
    return Sampled(("a",), SimpleNamespace(name=name, fixes=fixes), range(4, 8, 2), m)  # type: ignore[arg-type]


@pytest.mark.parametrize("told", [False, True])
def test_guidance_knows_what_was_heard_since_it_asked(told: bool) -> None:
    """The last altitude or none, fixes of any tick until it asks, whom it follows; and the truth beside what it is told
    of its own place."""
    batch = SimpleNamespace(name="a", members=("a",))
    agents = {name: SimpleNamespace(name=name, batch=batch, member=0) for name in ("a", "b")}
    model: Any = SimpleNamespace(n=3, clock=Clock(50.0), agents=agents, batches={})
    missions = Missions(model)
    for name in agents:
        missions.feedback[name] = Feedback(np.array([4.0, 5.0, 6.0]), np.zeros(3, dtype=bool), down={"alt": "range"})
    mine = missions.feedback["a"]
    mine.keys = {"heat": ["heat", "heat.flow"]}
    none = [False] * 6
    missions.hear(heard("alt", np.zeros(6), [True] * 4 + [True, False], range=np.array([9, 9, 9, 2.5, np.nan, 7.0])))
    assert mine.altitude.tolist() == [2.5, np.inf, np.inf]
    missions.hear(heard("fix", np.zeros(6), [True, False, False, False, False, True], fixes=True))
    missions.hear(heard("fix", np.zeros(6), none, fixes=True))
    missions.hear(heard("other", np.zeros(6), [True] * 6))
    assert mine.gps.tolist() == [True, False, True]
    flow = np.arange(12.0).reshape(6, 2)
    missions.hear(heard("heat", np.arange(6.0), [True] * 6, flow=flow))
    np.testing.assert_array_equal(mine.readings["heat"], [[3.0], [4.0], [5.0]])
    np.testing.assert_array_equal(mine.readings["heat.flow"], flow[3:])
    missions.feedback["b"].gps[:] = True

    asked: list[Any] = []
    command = lambda aboard, truth: asked.append((aboard, truth, aboard.fixed.copy())) or np.full((3, 2), 0.5)
    missions.guidance["a"] = SimpleNamespace(steps=[], followed=("b",), command=command)  # type: ignore[assignment]
    rng = np.random.default_rng(3)
    rows = {name: rng.normal(size=(3, CHANNELS)) for name in agents}
    for row in rows.values():
        row[:, 3:7] /= np.linalg.norm(row[:, 3:7], axis=1, keepdims=True)
    place = Fix(rng.normal(size=(3, 3)), rng.normal(size=3), rng.normal(size=(3, 3)))
    if told:
        missions.navigators["a"], missions.solutions["a"] = External(place), deque()
    assert missions.commands(7, rows) == {}
    found = missions.commands(10, rows)
    assert list(found) == ["a"]
    ((aboard, truth, fixed),) = asked
    assert (aboard.t_s, aboard.dt_s) == (pytest.approx(0.2), pytest.approx(0.1))
    assert fixed.tolist() == [True, False, True]
    assert aboard.altitude is mine.altitude
    np.testing.assert_array_equal(aboard.others["b"].position, rows["b"][:, 0:3])
    np.testing.assert_array_equal((truth or aboard).own.position, rows["a"][:, 0:3])
    assert (truth is not None) == told
    if told:
        assert aboard.own is place
        (solution,) = missions.solutions["a"]
        assert solution.tick == 10
        np.testing.assert_array_equal(solution.position, place.position)
    assert not mine.gps.any()
    assert missions.feedback["b"].gps.all()
