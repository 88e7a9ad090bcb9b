"""Runs in segments: where each ends, what is told of the whole, and when the missions end it."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pelagos.cli.segments import Plan, _joined, run_segments
from pelagos.errors import InputError
from pelagos.sim.run import SETTLE_S, RunResult

TICK_NS = 10_000_000


def result(simulated_s: float, wall_s: float = 0.0, **more: Any) -> RunResult:
    told: dict[str, Any] = {"counts": {}, "observations": {}, **more}
    return RunResult(
        simulated_s, wall_s, "time", ms_per_call={}, seconds_by_part={}, recording=None, **told
    )  # fmt: skip


class Sim:
    """Goes on by ticks, tells each, and has missions that end at a time [s]."""

    def __init__(self, begins_s: float, missions_s: float) -> None:
        self.time_ns, self.dt_ns = round(begins_s * 1e9), TICK_NS
        self.stepper = SimpleNamespace(missions_done=lambda: self.time_ns >= missions_s * 1e9 - 1)
        self.asked: list[float] = []
        self.stopped = False

    def stop(self) -> None:
        self.stopped = True

    def run(
        self, seconds: float, *, record: Any, realtime: bool, progress: Callable[[float, float], None]
    ) -> RunResult:
        assert (record, realtime) == ("recorder", True)
        self.asked.append(round(seconds, 6))
        begun, self.stopped = self.time_ns, False
        for k in range(1, round(seconds * 1e9 / TICK_NS) + 1):
            self.time_ns = begun + k * TICK_NS
            progress(k * TICK_NS * 1e-9, seconds)
            if self.stopped:
                break
        ticks = (self.time_ns - begun) // TICK_NS
        return result(
            (self.time_ns - begun) * 1e-9, 0.5, counts={"a.imu": ticks}, observations={"a": {"imu": self.time_ns}}
        )


class Course:
    """A run by a plan, with what was told and kept."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.folder, self.kept, self.told = folder, list[float](), list[tuple[float, float]]()
        self.stopping = SimpleNamespace(asked=False)
        self.stops_at_s = math.inf
        monkeypatch.setattr("pelagos.sim.resume.keep", lambda sim, recorder, folder: self.kept.append(self.now_s(sim)))

    @staticmethod
    def now_s(sim: Any) -> float:
        return round(sim.time_ns * 1e-9, 6)

    def run(self, sim: Any, plan: Plan) -> RunResult:
        def progress(t_s: float, whole_s: float) -> None:
            self.told.append((round(t_s, 6), whole_s))
            self.stopping.asked = t_s > self.stops_at_s
            if self.stopping.asked:
                sim.stop()

        recorder, stopping = "recorder", self.stopping
        return run_segments(sim, recorder, self.folder, plan, stopping, progress)  # type: ignore[arg-type]


@pytest.fixture
def course(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Course:
    return Course(tmp_path, monkeypatch)


def plan(duration_s: float, *, missions: bool = False) -> Plan:
    return Plan(duration_s, missions, 0.5, "it.mcap", realtime=True)


@pytest.mark.parametrize(
    ("begins_s", "asked", "kept"),
    [(0.0, [0.5, 0.5, 0.25], [0.5, 1.0, 1.25]), (0.3, [0.2, 0.5, 0.25], [0.5, 1.0, 1.25]), (1.0, [0.25], [1.25])],
)
def test_segments_end_at_multiples_of_their_length(
    begins_s: float, asked: list[float], kept: list[float], course: Course
) -> None:
    """Also those of a run that goes on from within one; the rest of the time is the last one."""
    sim = Sim(begins_s, missions_s=0.1)
    whole = course.run(sim, plan(1.25))
    assert (sim.asked, course.kept, whole.ended) == (asked, kept, "time")
    assert whole.simulated_s == pytest.approx(1.25 - begins_s)
    assert whole.wall_s == pytest.approx(0.5 * len(asked))
    assert whole.counts == {"a.imu": round(100 * (1.25 - begins_s))}
    assert [t for t, _ in course.told] == pytest.approx([begins_s + 0.01 * (k + 1) for k in range(len(course.told))])
    assert whole.observations == {"a": {"imu": 1_250_000_000}}
    assert {of for _, of in course.told} == {1.25}
    assert Plan.load(course.folder) == plan(1.25)


@pytest.mark.parametrize(("missions_s", "end_s"), [(0.72, 0.72 + SETTLE_S), (4.6, 5.0), (1.0, 1.0 + SETTLE_S)])
def test_a_run_goes_on_for_a_while_after_its_missions(missions_s: float, end_s: float, course: Course) -> None:
    """As long as one without segments, but no longer than the run may last; segments go on as before."""
    sim = Sim(0.0, missions_s)
    whole = course.run(sim, plan(5.0, missions=True))
    assert (course.now_s(sim), whole.ended) == (pytest.approx(end_s), "missions")
    assert missions_s in course.kept
    assert all(t in (missions_s, pytest.approx(end_s)) or t % 0.5 == 0 for t in course.kept)
    left = Plan.load(course.folder)
    assert (left.duration_s, left.until_missions_end, left.settling) == (pytest.approx(end_s), False, True)
    assert left.every_s == 0.5


def test_a_run_that_is_to_end_keeps_what_it_has(course: Course) -> None:
    sim, course.stops_at_s = Sim(0.0, math.inf), 0.705
    whole = course.run(sim, plan(2.0, missions=True))
    assert (whole.ended, course.kept) == ("stopped", [0.5, 0.71])
    assert whole.simulated_s == pytest.approx(0.71)


@pytest.mark.parametrize(("begins_s", "left"), [(1.25, False), (1.246, False), (1.24, True)])
def test_a_run_that_has_ended_is_not_gone_on_with(begins_s: float, left: bool, course: Course) -> None:
    """Less than half a tick is nothing."""
    sim = Sim(begins_s, math.inf)
    if left:
        course.run(sim, plan(1.25))
        assert sim.asked == [0.01]
        return
    with pytest.raises(InputError, match="this run has ended already"):
        course.run(sim, plan(1.25))


def test_two_segments_are_one_run() -> None:
    """Times and counts add up; the newest reading of each sensor stays, also of one that was silent in the second."""
    first = result(
        1.5, 0.25, counts={"a.imu": 3, "a.gps": 1}, observations={"a": {"imu": 1, "gps": 2}, "b": {"imu": 5}}
    )
    second = result(2.25, 0.5, counts={"a.imu": 4, "a.gps": 0}, observations={"a": {"imu": 3}, "b": {"dvl": 6}})
    whole = _joined(first, second)
    assert (whole.simulated_s, whole.wall_s, whole.real_time_factor) == (3.75, 0.75, 5.0)
    assert whole.counts == {"a.imu": 7, "a.gps": 1}
    assert whole.observations == {"a": {"imu": 3, "gps": 2}, "b": {"imu": 5, "dvl": 6}}
