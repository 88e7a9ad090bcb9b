"""Policies by name, what is refused, and what copies that end at other times score."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium
import numpy as np
import pytest

from pelagos.envs.evaluate import evaluate
from pelagos.envs.policy import Network, policy_of
from pelagos.envs.sensing import measured
from pelagos.envs.trajectories import collect
from pelagos.errors import CommandError, LookupFailed
from pelagos.sensors.sensor import Reading


def test_a_task_without_a_scripted_baseline_says_so() -> None:
    env: Any = SimpleNamespace(action_space=SimpleNamespace(shape=(2, 3)), task=object())
    assert policy_of("zero", env)(None).shape == (2, 3)
    with pytest.raises(CommandError, match="object has no scripted baseline; choose random, zero or a file"):
        policy_of("script", env)


class Uneven:
    """Three copies whose episodes last two, three and four steps, every other one to a truncation."""

    autoreset, arrays, num_envs, task = "same_step", "numpy", 3, None
    first_environment = 4

    def reset(self, seed: int = 0) -> tuple[Any, dict[str, Any]]:
        self._step, self._episode = np.zeros(3, dtype=int), np.zeros(3, dtype=int)
        return self._seen(), {}

    def _seen(self) -> Any:
        return {"state": (100.0 * np.arange(3) + 10.0 * self._episode + self._step)[:, None]}

    def step(self, actions: Any) -> tuple[Any, ...]:
        self._step += 1
        done = self._step == np.arange(2, 5)
        reward, ends = np.arange(3.0) + 0.1 * self._step, done & (self._episode % 2 == 0)
        last, far = self._seen(), 7.0 * np.arange(3) + self._episode
        self._episode[done] += 1
        self._step[done] = 0
        final = {"final_obs": last, "_final_obs": done, "final_info": {"far": far, "_far": done}, "_final_info": done}
        return self._seen(), reward, ends, done & ~ends, {"far": far} | (final if done.any() else {})


def lasted(copy: int) -> tuple[float, int]:
    """Return and length of its episodes."""
    return sum(copy + 0.1 * s for s in range(1, copy + 3)), copy + 2


def test_scores_are_of_the_same_number_of_first_episodes_of_every_copy() -> None:
    scores = evaluate(Uneven(), lambda seen: np.zeros((3, 1)), episodes=6)  # type: ignore[arg-type]
    found = zip(scores.returns, scores.lengths, scores.terminated, scores.metrics["far"], strict=True)
    expected = [(*lasted(copy), episode == 0, 7.0 * copy + episode) for copy in range(3) for episode in range(2)]
    assert sorted(map(tuple, np.round(list(found), 9).tolist())) == sorted(map(tuple, np.round(expected, 9).tolist()))


@pytest.mark.parametrize(("asked", "got"), [(None, 3), (1, 3), (3, 3), (4, 6), (7, 9)])
def test_every_copy_has_as_many_episodes_as_make_up_what_is_asked_for(asked: int | None, got: int) -> None:
    scores = evaluate(Uneven(), lambda seen: np.zeros((3, 1)), episodes=asked)  # type: ignore[arg-type]
    told = scores.summary()
    assert (len(scores.returns), told["episodes"], told["length"]) == (got, got, 3.0)
    spread = math.sqrt(sum((r - np.mean(scores.returns)) ** 2 for r in scores.returns) / (got - 1))
    assert told["return_standard_error"] == pytest.approx(spread / math.sqrt(got))
    assert told["far"] == pytest.approx(np.mean(scores.metrics["far"]))


def test_episodes_are_cut_out_of_their_copies_steps() -> None:
    found = collect(Uneven(), lambda seen: np.array([[-0.3], [0.1], [0.5]]), episodes=6)  # type: ignore[arg-type]
    assert [(e.environment, e.episode) for e in found] == [(4 + i, k) for i in range(3) for k in range(2)]
    for one in found:
        copy, steps = one.environment - 4, np.arange(one.environment - 1)
        assert one.observations["state"].ravel().tolist() == (100.0 * copy + 10 * one.episode + steps).tolist()
        assert one.actions.ravel() == pytest.approx(np.full(copy + 2, [-0.3, 0.1, 0.5][copy]))
        assert one.rewards == pytest.approx(copy + 0.1 * steps[1:])
        assert [one.terminations.sum(), one.truncations.sum()] == [one.episode == 0, one.episode == 1]


def test_measured_numbers_are_those_of_copies_that_the_sensor_reaches() -> None:
    data, valid = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]), np.array([True, False, True])
    readings = {"ranger": Reading(data, data, 0, "a/ranger", valid, {})}
    assert measured(readings, "ranger", 3, 2, otherwise=-1.0).tolist() == [[1.0, 2.0], [-1.0, -1.0], [7.0, 8.0]]
    assert measured(readings, "other", 3, 2, otherwise=-1.0).tolist() == [[-1.0, -1.0]] * 3


def network(inputs: int, outputs: int) -> Network:
    hidden = np.linspace(-0.4, 0.7, 4 * inputs, dtype=np.float32).reshape(4, inputs)
    last = np.linspace(0.5, -0.3, outputs * 4, dtype=np.float32).reshape(outputs, 4)
    biases = [np.full(4, 0.1, np.float32), np.full(outputs, -0.2, np.float32)]
    mean, deviation = np.arange(inputs, dtype=np.float32), np.full(inputs, 2.0, np.float32)
    return Network(mean, deviation, [hidden, last], biases, "docking")


@pytest.mark.parametrize(("inputs", "outputs"), [(5, 3), (6, 2), (4, 3), (4, 2)])
def test_a_policy_of_other_observations_or_other_actions_is_refused(inputs: int, outputs: int, tmp_path: Path) -> None:
    """The task has five numbers and two actions; each alone that differs is enough."""
    spaces = {"a": gymnasium.spaces.Box(-1, 1, (2,)), "b": gymnasium.spaces.Box(-1, 1, (3,))}
    shape = SimpleNamespace(shape=(7, 2))
    env: Any = SimpleNamespace(action_space=shape, task=None, single_observation_space=gymnasium.spaces.Dict(spaces))
    network(5, 2).save(tmp_path / "fits.npz")
    kept = policy_of(str(tmp_path / "fits.npz"), env)
    seen = np.array([[0.5, -1.0, 2.5, 3.0, 1.0]])
    assert kept(seen) == pytest.approx(network(5, 2)(seen))
    network(inputs, outputs).save(tmp_path / "other.npz")
    said = f"takes {inputs} numbers and gives {outputs}; it was trained for docking, and this task has 5 .* and 2 act"
    with pytest.raises(CommandError, match=said):
        policy_of(str(tmp_path / "other.npz"), env)
    with pytest.raises(LookupFailed, match=r"unknown policy, and no file either, 'scrip'.*script"):
        policy_of("scrip", env)
