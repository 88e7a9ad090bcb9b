"""What every task shows and pays for the same actions, resets included."""

from __future__ import annotations

import numpy as np
import pytest

from known import SINGLE, check
from pelagos import envs


@pytest.mark.parametrize("name", envs.task_names())
def test_tasks(name: str) -> None:
    env = envs.make(name, 3)
    seen, _ = env.reset(seed=6)
    given = np.random.default_rng(2).uniform(-1.0, 1.0, (12, *env.action_space.shape))
    shown, paid, ended = [seen], [], []
    for action in given:
        seen, reward, terminated, truncated, _ = env.step(action)
        shown.append(seen)
        paid.append(reward)
        ended.append(terminated | truncated)
    parts = seen if isinstance(seen, dict) else {"obs": None}
    pictures = {part: np.array([s[part] if isinstance(s, dict) else s for s in shown]) for part in parts}
    check("tasks", name.removeprefix("pelagos/"), {**pictures, "reward": paid, "ended": ended}, SINGLE)
