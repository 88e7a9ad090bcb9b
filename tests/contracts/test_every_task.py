"""Every task: one kernel a step, and a scripted baseline that does better than chance and as well as it says."""

from __future__ import annotations

import drjit as dr
import numpy as np
import pytest

from pelagos import envs
from pelagos.envs.evaluate import evaluate
from pelagos.envs.policy import policy_of
from pelagos.envs.registry import has_sensors

QUICK = ("pelagos/DepthHeading-v0",)
NAMES = [name for name in envs.task_names() if not has_sensors(name)]  # the others: test_every_sensing_task
REACHED = {  # what the scripted baseline comes to at the end of its episodes, on average, at most
    "Hover-v0": {"distance_m": 0.15, "heading_error_rad": 0.02},
    "MarineGymHover-v0": {"distance_m": 0.1},
    "OceanScaleHover-v0": {"distance_m": 0.06},
    "Waypoint-v0": {"distance_m": 0.3},
    "PathInCurrent-v0": {"off_line_m": 6.0},
    "DepthHeading-v0": {"depth_error_m": 0.05, "heading_error_rad": 0.02},
    "Docking-v0": {"distance_m": 0.15},
    "StationKeeping-v0": {"distance_m": 2.0},
    "GyreTransect-v0": {"distance_m": 50.0, "energy_kj": 70.0},
}


@pytest.mark.parametrize("name", [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in NAMES])
def test_a_step_is_one_kernel_and_the_script_beats_chance(name: str) -> None:
    env = envs.make(name, 16)
    chance = evaluate(env, policy_of("random", env, seed=1), seed=2)
    assert env.not_finite == 0
    assert (np.abs(chance.returns) > 0).all()
    if hasattr(env.task, "script"):
        scores = evaluate(env, policy_of("script", env), seed=2)
        spread = np.hypot(scores.returns.std(), chance.returns.std()) / np.sqrt(len(scores.returns))
        assert scores.returns.mean() > chance.returns.mean() + 3 * spread
        for metric, most in REACHED[name.removeprefix("pelagos/")].items():
            assert scores.metrics[metric].mean() <= most, metric
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        dr.kernel_history()
        for _ in range(3):
            seen, *_ = env.step(env.action_space.sample())
        assert [k["type"] for k in dr.kernel_history()] == [dr.KernelType.JIT] * 3
    assert seen.shape == (16, len(env.names))
    assert len({row.tobytes() for row in seen}) == 16
