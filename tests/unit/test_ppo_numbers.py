"""Proximal policy optimisation by its numbers: NumPy stands for torch, which is not among what tests install."""

from __future__ import annotations

from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

from pelagos.envs.ppo import Recipe, _Learner, _Moments


class Rows(np.ndarray):
    """Rows as tensors are, as far as the method takes them; losses that are sent back are kept in `LOST`."""

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        return np.asarray(array).view(Rows)

    def exp(self) -> Any:
        return np.exp(self)

    def square(self) -> Any:
        return np.square(self)

    def clamp(self, low: float, high: float) -> Any:
        return np.clip(self, low, high)

    def clone(self) -> Any:
        return self.copy()

    def numpy(self) -> Any:
        return np.asarray(self)

    def mean(self, *_: Any, **__: Any) -> Any:
        return rows(np.asarray(self).mean())

    def std(self, *_: Any, **__: Any) -> Any:
        return rows(np.asarray(self).std(ddof=1))  # as torch's

    def backward(self) -> None:
        LOST.append(float(self))


LOST: list[float] = []


def rows(values: Any) -> Any:
    return np.asarray(values, dtype=float).view(Rows)


def learner(recipe: Recipe, **parts: Any) -> Any:
    """Of two numbers that are seen and one action; linear networks whose weights are told."""
    made = object.__new__(_Learner)
    torch = SimpleNamespace(
        stack=lambda v: rows(np.stack(v)), cat=lambda v: rows(np.concatenate(v)), from_numpy=rows, min=np.minimum,
        no_grad=nullcontext, randn_like=lambda m: rows(np.full(m.shape, 1.5)),
        randperm=lambda k: SimpleNamespace(chunk=lambda m: np.array_split(np.arange(k)[::-1], m)),
        nn=SimpleNamespace(utils=SimpleNamespace(clip_grad_norm_=lambda *given: None)),
    )  # fmt: skip
    made._actor = lambda x: rows(np.asarray(x) @ np.array([[0.3], [-0.2]]) + 0.1)
    made._critic = lambda x: rows(np.asarray(x) @ np.array([[0.5], [0.7]]) - 0.4)
    made._spread, made._recipe, made._torch = rows([-0.7]), recipe, torch
    made._adam = SimpleNamespace(zero_grad=lambda **_: None, step=lambda: None, param_groups=[{"lr": 0.0}])
    made._parameters, made._seed = [], 3
    for name, part in parts.items():
        setattr(made, name, part)
    return made


def test_moments_of_parts_are_those_of_the_whole() -> None:
    rng = np.random.default_rng(2)
    parts = [rng.normal([3.0, -50.0], [0.4, 9.0], (k, 2)).astype(np.float32) for k in (7, 40, 3)]
    made = _Moments(2)
    for part in parts:
        made.add(part)
    whole = np.concatenate(parts)
    np.testing.assert_allclose(made.mean, whole.mean(axis=0), rtol=1e-4)
    np.testing.assert_allclose(made.deviation, whole.std(axis=0), rtol=1e-3)


def test_the_likelihood_of_an_action_is_a_normal_one() -> None:
    """Up to a constant, of each number's own deviation."""
    made = learner(Recipe(), _spread=rows([-0.7, 0.4]))
    mean, action = np.array([[0.1, -0.5], [0.4, 0.3]]), np.array([[0.9, 0.2], [-0.3, 1.1]])
    found = made._log(rows(mean), rows(action))
    expected = norm.logpdf(action, mean, np.exp([-0.7, 0.4])).sum(axis=1)
    np.testing.assert_allclose(found - expected, np.log(2 * np.pi), rtol=1e-12)


def test_what_is_seen_is_normal_within_ten_deviations() -> None:
    made = learner(Recipe(), _seen=SimpleNamespace(mean=np.array([1.0, -2.0]), deviation=np.array([0.5, 4.0])))
    found = made._normal(rows([[2.0, 6.0], [-99.0, 99.0]]))
    np.testing.assert_allclose(found, [[2.0, 2.0], [-10.0, 10.0]])


def test_experience_counts_what_lies_beyond_the_limit_of_time() -> None:
    """Rewards by their deviation so far; where the time was over, the value of the last observation goes on."""
    rng, n, horizon, discount = np.random.default_rng(4), 3, 4, 0.83
    seen, final = rng.normal(size=(horizon + 1, n, 2)), rng.normal(size=(horizon, n, 2))
    reward, metric = rng.normal(2.0, 3.0, (horizon, n)), rng.normal(size=(horizon, n))
    terminated, truncated = np.zeros((2, horizon, n), dtype=bool)
    terminated[1, 0] = truncated[1, 2] = truncated[3, 1] = True
    acted: list[Any] = []

    def step(action: Any) -> Any:
        k = len(acted)
        acted.append(np.asarray(action))
        info = {"final_obs": rows(final[k]), "far_m": rows(metric[k])}
        return rows(seen[k + 1]), rows(reward[k]), terminated[k], truncated[k], info

    known: list[Any] = []
    made = learner(
        Recipe(horizon=horizon, discount=discount), _env=SimpleNamespace(step=step, metrics=["far_m"]),
        _rewards=_Moments(1), _ends={"far_m": np.nan}, _normal=lambda x: 2 * x,
        _seen=SimpleNamespace(add=lambda v: known.append(np.asarray(v))),
        _advantages=lambda kept, last: {**kept, "last": last},
    )  # fmt: skip
    batch, after, told = made._roll(rows(seen[0]))
    value = lambda x: np.asarray(2 * x) @ [0.5, 0.7] - 0.4
    mean = 2 * seen[:-1] @ [[0.3], [-0.2]] + 0.1
    action = mean + 1.5 * np.exp(-0.7)
    np.testing.assert_allclose(batch["action"], action)
    np.testing.assert_allclose(acted, np.clip(action, -1, 1))
    assert (np.abs(action) > 1).any()
    np.testing.assert_allclose(batch["seen"], 2 * seen[:-1])
    np.testing.assert_allclose(batch["value"], value(seen[:-1]))
    np.testing.assert_allclose(batch["last"], value(seen[-1]))
    np.testing.assert_allclose(batch["log"], [[-0.5 * 1.5**2 + 0.7] * n] * horizon)
    for k in range(horizon):
        expected = reward[k] / reward[: k + 1].std() + discount * value(final[k]) * truncated[k]
        np.testing.assert_allclose(batch["reward"][k], expected, rtol=2e-3)
    assert np.array(batch["over"]).tolist() == (terminated | truncated).tolist()
    np.testing.assert_array_equal(after, seen[-1])
    np.testing.assert_array_equal(known[0], seen[:-1].reshape(-1, 2))
    assert told["reward"] == pytest.approx(reward.mean())
    assert told["far_m"] == pytest.approx(np.mean([metric[1, 0], metric[1, 2], metric[3, 1]]))


def test_an_update_lowers_the_clipped_loss() -> None:
    """J. Schulman et al. 2017 (arXiv 1707.06347), equations 7 and 9, of advantages of mean 0 and deviation 1."""
    rng, clip = np.random.default_rng(7), 0.15
    batch = {"seen": rng.normal(size=(11, 2)), "action": rng.normal(size=(11, 1)), "advantage": rng.normal(2, 3, 11),
             "goal": rng.normal(size=11)}  # fmt: skip
    made = learner(Recipe(epochs=2, minibatches=3, clip=clip))
    mean, spread = batch["seen"] @ [[0.3], [-0.2]] + 0.1, np.exp(-0.7)
    now = norm.logpdf(batch["action"], mean, spread).sum(axis=1) + 0.5 * np.log(2 * np.pi)
    batch["log"] = now - rng.normal(0, 0.3, 11)
    LOST.clear()
    made._update({k: rows(v) for k, v in batch.items()})
    expected = []
    for part in np.array_split(np.arange(11)[::-1], 3):
        a = batch["advantage"][part]
        a = (a - a.mean()) / a.std(ddof=1)
        ratio = np.exp(now - batch["log"])[part]
        gain = np.where(a > 0, np.minimum(ratio, 1 + clip) * a, np.maximum(ratio, 1 - clip) * a).mean()
        off = batch["seen"][part] @ [0.5, 0.7] - 0.4 - batch["goal"][part]
        expected.append(0.25 * (off**2).mean() - gain)
    np.testing.assert_allclose(LOST, expected * 2, rtol=1e-6)


@pytest.mark.parametrize(("until", "updates"), [(None, 4), (("far_m", 2.0), 3), (("far_m", 2.5), 2)])
def test_the_rate_falls_to_nothing_and_learning_ends_where_it_is_good_enough(until: Any, updates: int) -> None:
    """80 decisions asked for, 24 in an update of three copies and eight decisions: the fourth goes beyond."""
    rates: list[float] = []
    far = iter((3.0, 2.5, 2.0, 1.0))
    made = learner(
        Recipe(steps=80, horizon=8, rate=0.6, until=until),
        _env=SimpleNamespace(num_envs=3, reset=lambda seed: (rows([[seed]]), {})), _network=lambda name: f"net {name}",
        _seen=SimpleNamespace(add=lambda values: None), _update=lambda batch: rates.append(group["lr"]),
        _roll=lambda seen: ({}, seen, {"far_m": next(far)}),
    )  # fmt: skip
    (group,) = made._adam.param_groups
    told: list[Any] = []
    out = made.learn("it", told.append)
    assert rates == pytest.approx([0.6 * (1 - 24 * k / 80) for k in range(updates)])
    assert [row["steps"] for row in out.curve] == [24.0 * (k + 1) for k in range(updates)]
    assert (out.reached, out.policy, told) == (until is not None, "net it", out.curve)
