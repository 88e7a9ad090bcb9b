"""Environments with sensors: copies of their own, resets of some, and a script that steers by its sonar."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest

from pelagos import envs
from pelagos.envs.evaluate import evaluate
from pelagos.envs.policy import policy_of
from pelagos.envs.registry import register
from pelagos.envs.tasks.wall_inspection import WallInspection
from pelagos.errors import CommandError, LookupFailed


class Brief(WallInspection):
    """Three decisions."""

    seconds = 0.6

    def __init__(self) -> None:
        super().__init__(beams=16, rays=8, bins=32)


def fleet(autoreset: Any, n: int = 3, environment: int = 0) -> envs.SensingEnv:
    return envs.SensingEnv(Brief(), n, seed=5, environment=environment, autoreset=autoreset)


def same(mine: Any, theirs: Any) -> None:
    for name, value in mine.items():
        np.testing.assert_array_equal(value, theirs[name], err_msg=name)


def test_modes_agree_and_a_copy_is_a_fleet_of_one() -> None:
    given = np.random.default_rng(1).uniform(-1, 1, (5, 3, 4))
    told: dict[str, list[Any]] = {}
    for mode in ("same_step", "disabled"):
        env = fleet(mode)
        seen, _ = env.reset(seed=5)
        told[mode] = [seen]
        assert all(v.dtype == env.single_observation_space[k].dtype for k, v in seen.items())
        assert env.observation_space.contains(seen)
        for k, a in enumerate(given):
            seen, reward, terminated, truncated, info = env.step(a)
            assert not terminated.any()
            assert truncated.all() == (k == 2)
            if k == 2:
                told[mode].append(info["final_obs"] if mode == "same_step" else seen)
                if mode == "disabled":
                    seen, _ = env.reset(options={"reset_mask": truncated})
            told[mode] += [seen, {"reward": reward}]
    for mine, theirs in zip(told["same_step"], told["disabled"], strict=True):
        same(mine, theirs)
    alone = fleet("disabled", 1, environment=2)
    first, _ = alone.reset(seed=5)
    same(first, {k: v[2:3] for k, v in told["disabled"][0].items()})
    assert len({row.tobytes() for row in told["disabled"][0]["sonar"]}) == 3
    seen, *_ = alone.step(given[0][2:3])
    same(seen, {k: v[2:3] for k, v in told["disabled"][1].items()})


def test_bad_input_is_told() -> None:
    env = fleet("same_step")
    with pytest.raises(CommandError, match="first call is reset"):
        env.step(np.zeros((3, 4)))
    env.reset()
    with pytest.raises(CommandError, match=r"shape \(3, 4\); given \(4,\)"):
        env.step(np.zeros(4))
    with pytest.raises(CommandError, match=r"reset_mask is \(3,\) bool"):
        env.reset(options={"reset_mask": [0, 1, 1]})
    with pytest.raises(LookupFailed, match="a task with sensors, 'arrays'"):
        envs.make("pelagos/WallInspection-v0", 2, arrays="torch")
    register()
    single = gymnasium.make("pelagos/WallInspection-v0", beams=8, rays=4, bins=24)
    assert single.observation_space["sonar"].shape == (8, 24)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_the_script_follows_the_wall_by_its_sonar() -> None:
    env = envs.make("pelagos/WallInspection-v0", 4)
    chance = evaluate(env, policy_of("random", env, seed=1), seed=2)
    scores = evaluate(env, policy_of("script", env), seed=2)
    assert scores.returns.min() > chance.returns.max()
    assert scores.metrics["stand_off_error_m"].mean() < 0.6


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_the_script_follows_the_pipe_by_its_camera() -> None:
    env = envs.make("pelagos/PipelineFollowing-v0", 4)
    chance = evaluate(env, policy_of("random", env, seed=1), seed=2)
    scores = evaluate(env, policy_of("script", env), seed=2)
    assert scores.returns.min() > chance.returns.max()
    assert scores.metrics["off_line_m"].mean() < 0.3
    assert scores.metrics["height_error_m"].mean() < 0.2
    assert scores.metrics["speed_mps"].mean() > 0.35
