"""What a fleet makes of the row of numbers that its kernel answers with, copy by copy, without the kernel."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos.envs.fleet import FleetEnv
from pelagos.envs.program import CLIPPED, NO_NUMBER, NOT_FINITE, TERMINATED, TRUNCATED
from pelagos.errors import CommandError

CODES = [TERMINATED, TRUNCATED | CLIPPED, NOT_FINITE | TERMINATED | CLIPPED, 0]
SEEN, LAST = np.arange(8.0).reshape(4, 2), 100 + np.arange(8.0).reshape(4, 2)
REWARD, METRICS = [1.5, -2.0, 0.0, 4.0], {"near_m": [0.5, 7.0, 3.0, 1.0], "far_m": [9.0, 8.0, 7.0, 6.0]}


def fleet(mode: str = "same_step") -> Any:
    made: Any = object.__new__(FleetEnv)
    vars(made).update(num_envs=4, arrays="numpy", clipped=0, not_finite=0)
    made.program = SimpleNamespace(size=2, actions=2, metrics=list(METRICS), autoreset=mode)
    return made


def answer(mode: str, codes: list[int]) -> np.ndarray:
    parts = [SEEN, *([LAST] if mode == "same_step" else []), REWARD, codes, *METRICS.values()]
    return np.concatenate([np.ravel(part) for part in parts]).astype(np.float32)


@pytest.mark.parametrize("mode", ["same_step", "next_step", "disabled"])
def test_each_copy_has_its_part_of_the_answer(mode: str) -> None:
    env = fleet(mode)
    for again in (1, 2):
        seen, reward, terminated, truncated, info = env._told(answer(mode, CODES))
        assert (seen.tolist(), reward.tolist()) == (SEEN.tolist(), REWARD)
        assert terminated.tolist() == [True, False, True, False]
        assert truncated.tolist() == [False, True, False, False]
        assert info["clipped"].tolist() == [False, True, True, False]
        assert info["not_finite"].tolist() == [False, False, True, False]
        assert (env.clipped, env.not_finite) == (2 * again, again)
        for name, values in METRICS.items():
            assert info[name].tolist() == values
        assert ("final_obs" in info) == (mode == "same_step")
        if mode == "same_step":
            done = [True, True, True, False]
            assert info["final_obs"].tolist() == LAST.tolist()
            assert info["_final_obs"].tolist() == info["_final_info"].tolist() == done
            last = info["final_info"]
            assert {name: last[name].tolist() for name in METRICS} == METRICS
            assert [last[f"_{name}"].tolist() for name in METRICS] == [done, done]
    *_, info = env._told(answer(mode, [0, 0, 0, 0]))
    assert set(info) == set(METRICS)
    *_, info = env._told(answer(mode, [CLIPPED, TERMINATED, 0, 0]))
    assert ("final_obs" in info, info["clipped"].sum()) == (mode == "same_step", 1)
    with pytest.raises(CommandError, match="the action of copy 1 is not finite, as of 1 others"):
        env._told(answer(mode, [0, NO_NUMBER, 0, NO_NUMBER | CLIPPED]))
    with pytest.raises(CommandError, match=r"the action of copy 2 is not finite$"):
        env._told(answer(mode, [0, 0, NO_NUMBER, 0]))


def test_actions_out_of_range_are_refused_by_copy() -> None:
    env = fleet()
    env._inbox = SimpleNamespace(values=np.array([1.0, -1.0, 0.0, 0.5, -0.2, 1.0, 1.0, 1.0], np.float32))
    env._refuse()
    env._inbox.values[[3, 4]] = 1.25, -7.0
    with pytest.raises(CommandError, match=r"copy 1 was given \[0\. +1\.25\], and so were 1 others"):
        env._refuse()
    env._inbox.values[3] = 0.0
    with pytest.raises(CommandError, match=r"copy 2 was given \[-7\. +1\. *\]$"):
        env._refuse()


def test_numbers_of_episodes_are_the_second_row_of_counts() -> None:
    env = fleet()
    env._keeps = None, np.arange(12, dtype=np.uint32)
    assert env.episode.tolist() == [4, 5, 6, 7]
