"""A team of vehicles as PettingZoo's `ParallelEnv`."""

from __future__ import annotations

import numpy as np
import pytest
from pettingzoo.test import parallel_api_test

from pelagos.envs.team import FormationEnv
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


def test_teams_that_differ_share_no_policy() -> None:
    from pelagos.envs.shared import SharedTeams

    with pytest.raises(CommandError, match="2 kinds"):
        SharedTeams([FormationEnv(2), FormationEnv(3)])
    with pytest.raises(CommandError, match="at least one"):
        SharedTeams([])
