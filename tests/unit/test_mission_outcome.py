"""Outcomes of missions from made-up tracks: when each leg ended, and how far from its way the vehicle was."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest

from pelagos.cli.main import main
from pelagos.report.legs import legs_lines, legs_numbers, legs_table
from pelagos.sim.guidance.guidance import Step
from pelagos.sim.guidance.line import Line
from pelagos.sim.guidance.orbit import Orbit
from pelagos.sim.guidance.outcome import Flown, LegOutcome, Track, outcomes
from pelagos.sim.guidance.task import Common, Level
from pelagos.sim.guidance.wait import GpsFix, Station

NAN = math.nan


def steps(*legs):
    found = []
    for tasks in legs:
        behind = len(found) + len(tasks)
        found += [Step(task, behind) for task in tasks]
    return found


def test_a_line_counts_from_its_middle_on_and_points_where_there_is_none():
    """North-west 100 m, 3 m to port, 0.8 m to starboard from its middle on; then a point that is passed by 1.3 m."""
    s = math.sqrt(0.5)
    ahead, right = np.array([s, s]), np.array([s, -s])
    run = np.arange(0.0, 100.5, 0.5)
    way = np.array([7.0, -4.0]) + run[:, None] * ahead + np.where(run < 50, -3.0, 0.8)[:, None] * right
    end = np.array([7.0, -4.0]) + 100 * ahead
    beyond = end + np.arange(1.0, 11.0)[:, None] * np.array([0.0, 2.0]) + np.array([1.3, 0.0])
    xy = np.concatenate([way, beyond])
    track = Track(2.0 + np.arange(len(xy)), np.c_[xy, np.full(len(xy), -5.0)])
    mission = steps([Line(tuple(end), (7.0, -4.0))], [Line((end[0], end[1] + 20.0))])
    ended = np.array([2.0 + len(way) - 1, 2.0 + len(xy) - 1])
    first, second = outcomes(Flown(mission, ["survey", "goto"], 2.0, ended, 2, True), track)
    assert (first.began_s, first.ended_s, second.began_s) == (2.0, ended[0], ended[0])
    assert first.off_m == pytest.approx(0.8)
    assert second.off_m == pytest.approx(1.3)


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_a_circle_counts_after_a_quarter_turn(turn):
    """On its way in it is 2 m outside, within the band of 6 m; from 120 degrees on 0.4 m inside."""
    angle = np.radians(np.arange(0, 360, 2.0))
    far = 20.0 + np.where(angle < math.radians(80), 2.0, -0.4)
    xy = np.array([-3.0, 8.0]) + far[:, None] * np.stack([np.cos(angle), -turn * np.sin(angle)], axis=-1)
    track = Track(np.arange(len(xy)) * 1.0, np.c_[xy, np.zeros(len(xy))])
    flown = Flown(steps([Orbit((-3.0, 8.0), 20.0, 1.0, turn)]), ["orbit"], 0.0, np.array([len(xy) - 1.0]), 1, False)
    assert outcomes(flown, track)[0].off_m == pytest.approx(0.4)


def test_a_dock_counts_the_depth_and_a_place_is_kept_by_those_that_stop():
    track = Track(
        np.arange(5.0), np.array([[0, 0, -4], [3, 0, -4.2], [6, 0.3, -4.4], [6, 0.4, -4.4], [6.0, 0.2, -4.4]])
    )
    dock = Line((6.0, 0.0), (0.0, 0.0), 1.0, again=True, common=Common(Level(4.0)))
    found = outcomes(Flown(steps([dock]), ["dock"], 0.0, np.array([4.0]), 1, False), track)
    assert found[0].off_m == pytest.approx(math.hypot(0.2, 0.4))
    stay = steps([Station(4.0, (6.0, 0.0))])
    assert outcomes(Flown(stay, ["station_keeping"], 0.0, np.array([4.0]), 1, True), track)[0].off_m == pytest.approx(
        0.4
    )
    assert outcomes(Flown(stay, ["station_keeping"], 0.0, np.array([4.0]), 1, False), track)[0].off_m is None


def test_legs_that_are_left_out_late_or_under_way_are_told():
    """No fix in 20 s; `until` left the second line of leg 2 out; leg 3 is under way, leg 4 not begun."""
    mission = steps([GpsFix(20.0)], [Line((9.0, 1.0)), Line((9.0, 8.0))], [Line((0.0, 8.0))], [Line((0.0, 0.0))])
    ended = np.array([23.0, 40.0, NAN, NAN, NAN])
    kinds = ["gps_fix", "waypoints", "goto", "goto"]
    found = outcomes(Flown(mission, kinds, 3.0, ended, 3, True), Track(np.zeros(0), np.zeros((0, 3))))
    assert [(leg.began_s, leg.ended_s, leg.late) for leg in found] == [
        (3.0, 23.0, True), (23.0, 40.0, False), (40.0, None, False), (None, None, False),
    ]  # fmt: skip
    (line,) = legs_lines({"auv[0]": found}, 52.0)
    assert line == (
        "auv[0]: 2 of 4 legs; leg 3 (goto) had taken 12 s when the run ended; leg 1 (gps_fix) ended by its time, "
        "without a fix"
    )
    (section,) = legs_table("auv_0", {"legs": legs_numbers({"auv[0]": found})})
    for words in ("ended by its time, without a fix", "under way when the run ended", "not begun"):
        assert words in section.body


def test_many_missions_are_told_together():
    done = [LegOutcome("survey", 0.0, 90.0, 0.31), LegOutcome("survey", 90.0, 132.0, 0.42)]
    assert legs_lines({"auv0": done}, 140.0) == ["auv0: 2 of 2 legs, 132 s; survey within 0.42 m"]
    many = {f"a[{i}]": done for i in range(20)} | {"b": [LegOutcome("orbit", 0.0, None, None)]}
    assert legs_lines(many, 140.0) == ["20 of 21 missions done; under way: b; survey within 0.42 m"]


def test_a_run_and_its_report_tell_how_the_mission_went(tmp_path, capsys):
    """A quadrotor goes to two points and stays, before its time is over."""
    mission = "[{type: goto, points: [[3, -2, 5], [3, 4, 6]], speed_mps: 2}, {type: hold, seconds: 1}]"
    (tmp_path / "a.yaml").write_text(
        "world: {type: flat, depth_m: 9}\ntick_rate_hz: 100\nduration_s: 20\nagents:\n"
        "  uav: {vehicle: quadrotor, start: {position_m: [0, 0, 4]}, mission: " + mission + "}\n"
    )
    with pytest.raises(SystemExit) as ended:
        main(["run", str(tmp_path / "a.yaml"), "--out", str(tmp_path / "out")])
    assert not ended.value.code
    said = next(line for line in capsys.readouterr().out.splitlines() if "legs" in line)
    assert re.fullmatch(r"  uav: 2 of 2 legs, \d+ s; goto within 0\.\d\d m", said)
    legs = json.loads((tmp_path / "out" / "stats.json").read_text())["legs"]["uav"]
    assert [leg["kind"] for leg in legs] == ["goto", "hold"]
    assert legs[1]["ended_s"] == pytest.approx(legs[0]["ended_s"] + 1.0, abs=0.11)  # guidance looks ten times a second
    assert "Mission of uav" in (tmp_path / "out" / "report.html").read_text()
