"""Other libraries' environments, by their own checkers. Each needs its library, and is skipped where it is missing.

None of them is among what `make test` installs: torch alone is larger than everything else together. Install
`stable-baselines3 rsl-rl-lib torchrl skrl` beside Pelagos to run these.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pelagos import envs
from pelagos.envs.tasks.hover import Hover
from pelagos.envs.team import FormationEnv
from pelagos.errors import CommandError

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore")]


class Short(Hover):
    seconds = 0.5


def test_stable_baselines3_learns_and_sees_ends() -> None:
    sb3 = pytest.importorskip("stable_baselines3")
    from stable_baselines3.common.vec_env import VecMonitor

    from pelagos.envs.sb3 import SB3Env

    env = SB3Env(envs.FleetEnv(Short(), 4))
    env.seed(3)
    first = env.reset()
    for _ in range(10):
        seen, _, done, infos = env.step(np.full((4, 8), 0.3, dtype=np.float32))
    assert done.all()
    assert infos[2]["TimeLimit.truncated"]
    assert (infos[2]["terminal_observation"] != seen[2]).any()
    env.seed(3)
    np.testing.assert_array_equal(env.reset(), first)
    model = sb3.PPO("MlpPolicy", VecMonitor(env), n_steps=20, batch_size=40, n_epochs=1, device="cpu")
    model.learn(160)
    assert model.ep_info_buffer[-1]["l"] == 10
    with pytest.raises(CommandError, match="arrays='numpy'"):
        SB3Env(envs.FleetEnv(Short(), 4, autoreset="disabled"))


def test_stable_baselines3_learns_from_pictures() -> None:
    sb3 = pytest.importorskip("stable_baselines3")
    from stable_baselines3.common.vec_env import VecMonitor

    from pelagos.envs.sb3 import SB3Env
    from pelagos.envs.tasks.pipeline import PipelineFollowing

    class Brief(PipelineFollowing):
        seconds = 0.8

    env = SB3Env(envs.SensingEnv(Brief(), 2))
    env.seed(3)
    first = env.reset()
    for _ in range(4):
        seen, _, done, infos = env.step(np.full((2, 4), 0.3, dtype=np.float32))
    assert done.all()
    assert (infos[1]["terminal_observation"]["camera"] != seen["camera"][1]).any()
    assert infos[0]["off_line_m"] > 0
    env.seed(3)
    for name, value in env.reset().items():
        np.testing.assert_array_equal(value, first[name])
    model = sb3.PPO("MultiInputPolicy", VecMonitor(env), n_steps=8, batch_size=8, n_epochs=1, device="cpu")
    model.learn(16)
    assert model.ep_info_buffer[-1]["l"] == 4


def test_ppo_takes_sensors_that_give_numbers_and_refuses_pictures(tmp_path: Path) -> None:
    pytest.importorskip("torch")
    from pelagos.envs.policy import policy_of
    from pelagos.envs.ppo import Recipe, train
    from pelagos.envs.tasks.terrain import TerrainFollowing

    class Brief(TerrainFollowing):
        seconds = 4.0

    env = envs.SensingEnv(Brief(), 4)
    twice = [train(env, Recipe(steps=256, horizon=32), seed=4) for _ in range(2)]
    for p, q in zip(twice[0].policy.weights, twice[1].policy.weights, strict=True):
        assert p.tobytes() == q.tobytes()
    assert twice[0].curve[-1]["height_error_m"] > 0
    twice[0].policy.save(tmp_path / "policy.npz")
    seen, _ = env.reset(seed=2)
    actions = policy_of(str(tmp_path / "policy.npz"), env)(seen)
    np.testing.assert_array_equal(actions, twice[0].policy(seen))
    assert actions.shape == (4, 2)
    with pytest.raises(CommandError, match=r"'sonar' has shape \(48, 50\)"):
        train(envs.make("pelagos/ObstacleAvoidance-v0", 2), Recipe(steps=64))


def test_rsl_rl_learns() -> None:
    pytest.importorskip("rsl_rl")
    from pelagos.envs.rsl_rl import RslRlEnv

    env = RslRlEnv(envs.FleetEnv(Short(), 4, arrays="torch"))
    import torch

    for k in range(10):
        seen, reward, done, extras = env.step(torch.full((4, 8), 0.3))
        assert bool(done.all()) == (k == 9)
    assert extras["time_outs"].all()
    assert float(extras["log"]["distance_m"]) > 0
    assert seen["policy"].shape == (4, 14)
    assert reward.shape == (4,)


def test_torchrl_checks_its_specs() -> None:
    pytest.importorskip("torchrl")
    from torchrl.envs import GymWrapper
    from torchrl.envs.utils import check_env_specs

    env = GymWrapper(envs.FleetEnv(Short(), 4))
    check_env_specs(env)
    assert env.rollout(25, break_when_any_done=False).shape == (4, 25)


def test_skrl_wraps_it() -> None:
    pytest.importorskip("skrl")
    import torch
    from skrl.envs.wrappers.torch import wrap_env

    env: Any = wrap_env(envs.FleetEnv(Short(), 4))
    seen, _ = env.reset()
    assert seen.shape == (4, 14)
    seen, reward, *_ = env.step(torch.zeros(4, 8))
    assert reward.shape == (4, 1)


def test_tensors_share_the_kernels_memory_and_equal_numpy() -> None:
    torch = pytest.importorskip("torch", reason="pelagos[learn] is not installed")
    one, other = envs.FleetEnv(Short(), 4, seed=1), envs.FleetEnv(Short(), 4, seed=1, arrays="torch")
    np.testing.assert_array_equal(one.reset()[0], other.reset()[0].numpy())
    for k in range(12):
        a = np.random.default_rng(k).uniform(-1, 1, (4, 8)).astype(np.float32)
        mine, theirs = one.step(a), other.step(torch.from_numpy(a))
        for p, q in zip(mine[:4], theirs[:4], strict=True):
            np.testing.assert_array_equal(p, q.numpy())


def test_ppo_is_repeatable_and_improves(tmp_path: Path) -> None:
    """From the same seed the same policy, byte for byte; after 60 updates hover is better than at random."""
    pytest.importorskip("torch")
    from pelagos.envs.evaluate import evaluate
    from pelagos.envs.policy import Network, policy_of
    from pelagos.envs.ppo import Recipe, train

    def learned(steps: int) -> Network:
        return train(envs.FleetEnv(Hover(), 256, arrays="torch"), Recipe(steps=steps), seed=4).policy

    twice = [learned(30_000) for _ in range(2)]
    for p, q in zip(twice[0].weights, twice[1].weights, strict=True):
        assert p.tobytes() == q.tobytes()
    policy = learned(500_000)
    policy.save(tmp_path / "policy.npz")
    env = envs.FleetEnv(Hover(), 64)
    loaded = policy_of(str(tmp_path / "policy.npz"), env)
    scores = [evaluate(env, p, seed=9).returns.mean() for p in (policy_of("random", env), policy, loaded)]
    assert scores[1] == scores[2]
    assert scores[1] > scores[0] + 20


def test_members_share_a_policy_as_copies_of_one_learner() -> None:
    """The rows of two teams are what each team alone sees and gets; a team that is over begins anew at once."""
    torch = pytest.importorskip("torch", reason="pelagos[learn] is not installed")
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
