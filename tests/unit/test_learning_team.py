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


def test_members_share_a_policy_as_copies_of_one_learner() -> None:
    """The rows of two teams are what each team alone sees and gets; a team that is over begins anew at once."""
    torch = pytest.importorskip("torch")
    from pelagos.envs.shared import SharedTeams, acts_of, rows_of

    alone, shared = FormationEnv(2, seconds=0.6), SharedTeams([FormationEnv(2, seconds=0.6) for _ in range(2)])
    assert (shared.num_envs, shared.size, shared.actions) == (4, 7 + 2, 3)
    assert shared.metrics == ["ring_error_m", "range_error_m"]
    seen, _ = shared.reset(seed=5)
    mine, _ = alone.reset(seed=6)  # the second team's
    np.testing.assert_array_equal(seen.numpy()[2:], rows_of(mine))
    np.testing.assert_array_equal(seen.numpy()[:, 7:], [[1, 0], [0, 1]] * 2)
    actions = np.array([[0.5, -0.3, 0.2], [-0.4, 0.6, -0.1], [0.9, 0.1, -0.7], [-0.2, -0.8, 0.3]], dtype=np.float32)
    for step in range(3):
        seen, reward, terminated, truncated, info = shared.step(torch.from_numpy(actions))
        mine, rewards, *_, infos = alone.step(dict(zip(alone.possible_agents, actions[2:], strict=True)))
        np.testing.assert_array_equal(info["final_obs"].numpy()[2:], rows_of(mine))
        assert reward.numpy()[2:] == pytest.approx([*rewards.values()], abs=1e-6)
        assert info["ring_error_m"].numpy()[3] == pytest.approx(infos["rov1"]["ring_error_m"], abs=1e-6)
        assert truncated.tolist() == [step == 2] * 4
        assert not terminated.any()
    mine, _ = alone.reset()
    np.testing.assert_array_equal(seen.numpy()[2:], rows_of(mine))
    made = acts_of(lambda rows: rows[:, 6:9], mine)
    np.testing.assert_array_equal(made["rov1"], [mine["rov1"][6], 0.0, 1.0])


def test_teams_that_differ_share_no_policy() -> None:
    from pelagos.envs.shared import SharedTeams

    with pytest.raises(CommandError, match="2 kinds"):
        SharedTeams([FormationEnv(2), FormationEnv(3)])
    with pytest.raises(CommandError, match="at least one"):
        SharedTeams([])
