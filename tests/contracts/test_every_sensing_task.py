"""Environments with sensors: copies of their own, resets of some, and a script that steers by its sonar."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest

from pelagos import envs
from pelagos.envs.evaluate import evaluate
from pelagos.envs.policy import policy_of
from pelagos.envs.registry import has_sensors, register
from pelagos.envs.sensing import Judgement
from pelagos.envs.tasks.obstacles import ObstacleAvoidance
from pelagos.envs.tasks.wall_inspection import WallInspection
from pelagos.errors import CommandError, InputError, LookupFailed

REACHED = {  # means of the scripts' metrics at the ends of episodes: least and most
    "WallInspection-v0": {"stand_off_error_m": (0.0, 0.6)},
    "PipelineFollowing-v0": {"off_line_m": (0.0, 0.3), "height_error_m": (0.0, 0.2), "speed_mps": (0.35, 0.45)},
    "TerrainFollowing-v0": {"height_error_m": (0.0, 1.5), "heading_error_rad": (0.0, 0.05)},
    "ObstacleAvoidance-v0": {"through": (1.0, 1.0), "collided": (0.0, 0.0)},
}


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
    with pytest.raises(CommandError, match=r"copy 1 are \[0.0, nan, 0.0, 0.0\]"):
        env.step([[0, 0, 0, 0], [0, np.nan, 0, 0], [0, 0, 0, 0]])
    with pytest.raises(CommandError, match=r"reset_mask is \(3,\) bool"):
        env.reset(options={"reset_mask": [0, 1, 1]})
    with pytest.raises(LookupFailed, match="a task with sensors, 'arrays'"):
        envs.make("pelagos/WallInspection-v0", 2, arrays="torch")
    env.task.judge = lambda *_: Judgement(np.array([0.0, np.inf, 0.0]), np.zeros(3, dtype=bool))  # type: ignore[method-assign]
    with pytest.raises(CommandError, match=r"Brief.judge gives copy 1 a reward of inf"):
        env.step(np.zeros((3, 4)))
    for options, message in (({"beams": 0}, "at least 1"), ({"bins": -4}, "bins is a number from 0 on, not -4")):
        with pytest.raises(InputError, match=message):
            envs.make("pelagos/WallInspection-v0", 2, **options)
    assert not np.array_equal(*(ObstacleAvoidance(world_seed=k).pillars for k in (1, 2)))
    register()
    single = gymnasium.make("pelagos/WallInspection-v0", beams=8, rays=4, bins=24)
    assert single.observation_space["sonar"].shape == (8, 24)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", [n for n in envs.task_names() if has_sensors(n)])
def test_the_script_does_by_its_sensors_what_it_says(name: str) -> None:
    env = envs.make(name, 4)
    chance = evaluate(env, policy_of("random", env, seed=1), seed=2)
    scores = evaluate(env, policy_of("script", env), seed=2)
    assert scores.returns.min() > chance.returns.max()
    assert env.not_finite == 0
    for metric, (least, most) in REACHED[name.removeprefix("pelagos/")].items():
        assert least <= scores.metrics[metric].mean() <= most, metric
