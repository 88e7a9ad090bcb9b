"""Steps of the run that a recording is of, as a fit learns them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from pelagos.identification import load_plan
from pelagos.identification.run_steps import RunSteps, in_run_steps, run_steps, says_its_steps

SCENARIO = """
agents:
  usv: {count: 2, vehicle: {integrator: semi_implicit}}
  auv: {vehicle: {integrator: runge_kutta}}
  rov: {vehicle: {integrator: semi_implicit}}
  odd: {vehicle: {integrator: leapfrog}}
  bare: {}
"""
TOPICS = {
    "/usv_1/gps": "usv[1]", "/usv_1/truth": "usv[1]", "/auv/truth": "auv", "/rov/truth": "rov", "/odd/truth": "odd",
    "/bare/truth": "bare", "/tf": None,
}  # fmt: skip
PLAN = {"columns": {"north": "x"}, "commands": {}}


def recording(text: str | None = SCENARIO, dt_ns: str = "20000000") -> Any:
    about = {topic: {} if agent is None else {"agent": agent} for topic, agent in TOPICS.items()}
    return SimpleNamespace(
        channels={topic: SimpleNamespace(about=told) for topic, told in about.items()},
        attachments={} if text is None else {"scenario.yaml": text.encode()},
        metadata={"dt_ns": dt_ns},
    )


@pytest.mark.parametrize(("columns", "integrator"), [
    (["/usv_1/gps.latitude", "/usv_1/truth.twist.x"], "semi_implicit"), (["/auv/truth.twist.x"], "runge_kutta"),
    (["/usv_1/gps.latitude", "/rov/truth.pose.x"], "semi_implicit"),  # two that are moved alike
    (["/usv_1/gps.latitude", "/auv/truth.pose.x"], None), (["/odd/truth.x"], None), (["/bare/truth.x"], None),
    (["/tf.x"], None), (["/tf.x", "/auv/truth.x"], "runge_kutta"), (["/auv/truthful.x"], None), ([], None),
])  # fmt: skip
def test_a_recording_knows_the_steps_of_the_vehicle_whose_columns_are_named(columns, integrator):
    """A member of a group has the vehicle of its group; ticks of 20 ms."""
    found = run_steps(recording(), columns)
    assert found == (None if integrator is None else RunSteps(integrator, pytest.approx(0.02, rel=1e-12)))


@pytest.mark.parametrize("told", [
    recording(None), recording("agents: [1"), recording("- 1"), recording("agents: {auv: 3}"), recording(dt_ns=""),
    recording(dt_ns="999999"),  # a tick below 1 ms, whose error is nothing
])  # fmt: skip
def test_recordings_of_other_programs_and_damaged_ones_say_nothing(told):
    assert run_steps(recording(dt_ns="1000000"), ["/auv/truth.x"]) == RunSteps("runge_kutta", 1e-3)
    assert run_steps(told, ["/auv/truth.x"]) is None


def test_steps_are_the_same_by_their_way_and_length():
    steps = RunSteps("conservative", 0.05)
    assert steps.are("conservative", 0.1 - 0.05)
    assert not steps.are("semi_implicit", 0.05)
    assert not steps.are("conservative", 0.0501)
    assert not steps.are("conservative", 0.1)
    assert [steps.ticks(h) for h in (0.05, 0.35, 0.07, 0.02)] == [1, 7, None, None]


@pytest.mark.parametrize(("tick", "spacing", "usual", "expected"), [
    (0.02, 0.1, 0.1, 0.1), (0.1, 0.1, 0.1, 0.1), (0.05, 0.2, 0.1, 0.1),
    (0.03, 0.24, 0.08, 0.06),  # 8 ticks in three parts are no whole ticks: 4 of 60 ms
    (0.05, 0.35, 0.0875, 0.05),  # a prime number of ticks: one each
    (0.005, 0.145, 0.0725, 0.0725),  # 29 ticks: one each would be a fourteenth of the usual step
    (0.03, 0.1, 0.1, 0.1), (0.25, 0.1, 0.1, 0.1),  # rows between ticks
    (0.25, 0.25, 0.25 / 3, 0.25 / 3),  # no step of a grid is longer than 0.1 s
])  # fmt: skip
def test_a_grid_has_whole_ticks_where_they_come_near_to_its_usual_step(tick, spacing, usual, expected):
    assert RunSteps("conservative", tick).grid_s(spacing, usual) == pytest.approx(expected, rel=1e-12)


def test_a_plan_that_says_nothing_of_steps_takes_those_of_the_run():
    plan, run = load_plan(PLAN), RunSteps("semi_implicit", 0.02)
    made = in_run_steps(plan, run, 0.1)
    assert (made.integrator, made.substeps) == ("semi_implicit", 5)
    assert in_run_steps(plan, run, 16 * 0.02).substeps == 16
    for other in (in_run_steps(plan, run, 17 * 0.02), in_run_steps(plan, run, 0.11), in_run_steps(plan, None, 0.1)):
        assert other is plan
    for said in (
        {"integrator": "vehicle"},
        {"substeps": 2},
        {"step_s": 0.1},
        {"vehicle": {"integrator": "runge_kutta"}},
    ):
        own = load_plan({**PLAN, **said})
        assert says_its_steps(own)
        assert in_run_steps(own, run, 0.1) is own
    assert not says_its_steps(load_plan({**PLAN, "vehicle": {"length_m": 2.0}}))


@pytest.mark.parametrize(("member", "integrator"), [
    (0, "semi_implicit"), (1, "runge_kutta"), (2, "semi_implicit"), (3, None), (4, None), (5, "conservative"),
])  # fmt: skip
def test_a_member_may_have_a_way_of_its_own(member, integrator):
    """By an override; one of another vehicle leaves the word to the catalogue."""
    text = """
agents:
  usv:
    count: 6
    vehicle: {type: otter, integrator: semi_implicit}
    overrides:
      1: {vehicle: {integrator: runge_kutta}}
      2: {vehicle: {mass_kg: 95}}
      3: {vehicle: {type: wamv}}
      4: {vehicle: wamv}
      5: {vehicle: {type: wamv, integrator: conservative}}
"""
    told = SimpleNamespace(
        channels={"/it": SimpleNamespace(about={"agent": f"usv[{member}]"})},
        attachments={"scenario.yaml": text.encode()}, metadata={"dt_ns": "50000000"},
    )  # fmt: skip
    found: Any = run_steps(told, ["/it.x"])  # type: ignore[arg-type]
    assert (found and found.integrator) == integrator
