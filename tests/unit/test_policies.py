"""Policies by name, and what is refused."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from pelagos.envs.policy import policy_of
from pelagos.errors import CommandError


def test_a_task_without_a_scripted_baseline_says_so() -> None:
    env: Any = SimpleNamespace(action_space=SimpleNamespace(shape=(2, 3)), task=object())
    assert policy_of("zero", env)(None).shape == (2, 3)
    with pytest.raises(CommandError, match="object has no scripted baseline; choose random, zero or a file"):
        policy_of("script", env)
