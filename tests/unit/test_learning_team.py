"""A team of vehicles as PettingZoo's `ParallelEnv`."""

from __future__ import annotations

import numpy as np
import pytest
from pettingzoo.test import parallel_api_test

from pelagos.envs.team import _RANGE_NOISE_M, FormationEnv
from pelagos.errors import CommandError


@pytest.mark.filterwarnings("ignore")
def test_pettingzoo_checks_it_and_the_script_keeps_the_ring() -> None:
    env = FormationEnv(3, seconds=16.0)
    parallel_api_test(env, num_cycles=4)
    first, _ = env.reset(seed=4)
    middle = -first["rov1"][:2]  # at the beginning the middle is the origin
    assert np.hypot(*middle) == pytest.approx(np.hypot(*env.sim.state["rov1"].position[0, :2]), abs=1e-5)
    seen, info, steps = first, {}, 0
    while env.agents:
        seen, reward, terminated, truncated, info = env.step(env.script(seen))
        steps += 1
    assert steps == 80
    assert all(truncated.values())
    assert not any(terminated.values())
    assert info["rov2"]["ring_error_m"] < 0.3
    assert info["rov2"]["range_error_m"] < 0.3
    assert reward["rov0"] > 0.4
    again, _ = env.reset(seed=4)
    for name, value in first.items():
        np.testing.assert_array_equal(again[name], value)
    with pytest.raises(CommandError, match="actions are those of rov0, rov1, rov2"):
        env.step({"rov0": np.zeros(3)})


def test_members_see_their_own_motion_and_the_others_from_where_they_are() -> None:
    """Speeds, sine and cosine of the yaw, then the ranges to the others in order, within five deviations."""
    env = FormationEnv(3, seconds=16.0)
    env.reset(seed=4)
    acts = {"rov0": [0.6, 0.1, 0.3], "rov1": [-0.2, 0.5, -0.4], "rov2": [0.1, -0.3, 0.8]}
    for _ in range(6):
        seen = env.step({name: np.array(act, dtype=np.float32) for name, act in acts.items()})[0]
    states = {name: env.sim.state[name] for name in acts}
    ranges = []
    for name, own in states.items():
        yaw = own.euler[0, 2]
        assert seen[name][2:6] == pytest.approx([*own.velocity[0, :2], np.sin(yaw), np.cos(yaw)], abs=1e-5)
        away = [np.linalg.norm(s.position[0] - own.position[0]) for other, s in states.items() if other != name]
        assert seen[name][6:] == pytest.approx(away, abs=5.0 * _RANGE_NOISE_M)
        ranges.append(away)
    assert np.ptp(ranges, axis=0).min() > 0.3  # else nobody would see them mixed


def test_teams_that_differ_share_no_policy() -> None:
    from pelagos.envs.shared import SharedTeams

    with pytest.raises(CommandError, match="2 kinds"):
        SharedTeams([FormationEnv(2), FormationEnv(3)])
    with pytest.raises(CommandError, match="at least one"):
        SharedTeams([])
