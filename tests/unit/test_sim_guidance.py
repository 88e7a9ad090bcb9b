"""Guidance: lines, altitude hold, and the order of tasks, on a point that obeys perfectly."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from pelagos.sim.guidance import DEPTH_RATE_MPS, Guidance, Task, lawnmower, plan
from pelagos.sim.state import AgentState


def state(x=0.0, y=0.0, depth=0.0, heading=0.0) -> AgentState:
    half = -heading / 2
    z3 = np.zeros((1, 3))
    q = np.array([[math.cos(half), 0, 0, math.sin(half)]])
    return AgentState(np.array([[x, y, -depth]]), q, z3, z3, z3, z3, np.zeros((1, 0)))


NO_FIX, DEEP = np.array([False]), np.array([np.inf])


def test_lawnmower_lines_alternate_and_grow_to_starboard():
    leg = SimpleNamespace(corner=(0.0, 0.0), heading_deg=90.0, length_m=100.0, width_m=50.0, spacing_m=25.0)
    lines = lawnmower(leg)
    assert len(lines) == 3
    # heading east is y negative in NWU; starboard of east is south, x negative
    assert np.allclose(lines[0], [(0, 0), (0, -100)])
    assert np.allclose(lines[1], [(-25, -100), (-25, 0)])
    assert np.allclose(lines[2], [(-50, 0), (-50, -100)])


@pytest.mark.parametrize(("y", "sign"), [(5.0, 1.0), (-5.0, -1.0)])
def test_a_vehicle_beside_its_line_steers_towards_it(y, sign):
    g = Guidance.start(
        [Task("transit", end=(100.0, 0.0), start=(0.0, 0.0), depth_m=3.0)], state(), dt_s=0.1, length_m=1.5
    )
    depth, heading, speed = g.command(state(x=10.0, y=y), DEEP, NO_FIX, 0.0)[0]
    assert heading == pytest.approx(sign * math.atan2(5.0, 18.0))  # west of a northward line: turn to the right
    assert (depth, speed) == (3.0, 1.5)


def test_altitude_hold_ramps_the_depth_set_point():
    g = Guidance.start(
        [Task("transit", end=(100.0, 0.0), start=(0.0, 0.0), altitude_m=5.0)], state(depth=2.0), dt_s=0.1, length_m=1.5
    )
    depths = [g.command(state(depth=2.0), np.array([15.0]), NO_FIX, 0.1 * k)[0][0] for k in range(3)]
    assert np.allclose(np.diff([2.0, *depths]), DEPTH_RATE_MPS * 0.1)
    held = [g.command(state(depth=12.0), np.array([5.0]), NO_FIX, 0.1 * k)[0][0] for k in range(600)]
    assert held[-1] == pytest.approx(12.0, abs=1e-3)
    assert max(held) <= 12.0


def test_tasks_follow_each_other_and_the_mission_ends():
    tasks = [Task("dive", depth_m=5.0), Task("transit", end=(10.0, 0.0), depth_m=5.0), Task("surface", depth_m=0.0),
             Task("fix", depth_m=0.0, seconds=30.0)]  # fmt: skip
    g = Guidance.start(tasks, state(), dt_s=0.1, length_m=1.5)
    assert g.command(state(), DEEP, NO_FIX, 0.0)[0][0] == 5.0
    g.command(state(depth=4.5), DEEP, NO_FIX, 10.0)
    assert g.progress[0].task == 1
    g.command(state(x=10.5, depth=5.0), DEEP, NO_FIX, 20.0)
    assert g.progress[0].task == 2
    g.command(state(x=12.0, depth=0.1), DEEP, NO_FIX, 30.0)
    assert g.progress[0].task == 3
    for k in range(3):
        g.command(state(x=12.0), DEEP, np.array([True]), 31.0 + k)
    assert g.done


def test_a_fix_that_never_comes_times_out():
    g = Guidance.start([Task("fix", depth_m=0.0, seconds=30.0)], state(), dt_s=0.1, length_m=1.5)
    g.command(state(), DEEP, NO_FIX, 29.0)
    assert not g.done
    g.command(state(), DEEP, NO_FIX, 30.0)
    assert g.done


def test_plan_covers_every_kind_of_leg():
    legs = [
        SimpleNamespace(type="dive", depth_m=3.0, altitude_m=None, speed_mps=None),
        SimpleNamespace(type="waypoints", points=((1, 2), (3, 4)), depth_m=3.0, altitude_m=None, speed_mps=2.0,
                        acceptance_m=4.0),
        SimpleNamespace(type="lawnmower", corner=(0, 0), heading_deg=0.0, length_m=9.0, width_m=0.0, spacing_m=5.0,
                        depth_m=None, altitude_m=5.0, speed_mps=None, acceptance_m=2.0),
        SimpleNamespace(type="hold", seconds=4.0),
        SimpleNamespace(type="surface", speed_mps=None),
        SimpleNamespace(type="gps_fix", timeout_s=20.0),
    ]  # fmt: skip
    tasks = plan(legs)
    assert [t.kind for t in tasks] == ["dive", "transit", "transit", "transit", "transit", "hold", "surface", "fix"]
    assert tasks[2].start == (1.0, 2.0)
    assert tasks[2].speed_mps == 2.0
    assert tasks[4].altitude_m == 5.0
