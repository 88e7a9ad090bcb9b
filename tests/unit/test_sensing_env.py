"""`SensingEnv` beside one life after the other, in plain arithmetic: over a simulation whose copies are one number."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import gymnasium
import numpy as np
import pytest

from pelagos import envs
from pelagos.envs import sensing
from pelagos.errors import CommandError

N, SEED, FIRST, STEPS, LIMIT = 5, 11, 3, 40, 6
BROKEN, LOST = 9.0, -5.0


class Numbers:
    """Copies that are one number: a command moves it once a tick, beyond `BROKEN` it is no state any more."""

    def __init__(self, n: int) -> None:
        self.model, self.dt_ns, self.ended = SimpleNamespace(agents={"boat": None}), 50_000_000, np.zeros(n, bool)
        self.x, self.seeds = np.zeros(n), list[int]()

    def step(self, commands: dict[str, Any], *, ticks: int) -> Any:
        self.x = self.x + ticks * commands["boat"]
        self.ended = self.x > BROKEN
        return {"boat": self.x}

    def reset(self, *, seed: int | None = None, where: Any = None, state: Any = None) -> Any:
        if seed is not None:
            self.seeds.append(seed)
            self.x = np.full_like(self.x, np.nan)
            return {}
        self.x, self.ended = self.x.copy(), self.ended & ~where
        self.x[where] = state["boat"]["position"][:, 0]
        return {"boat": self.x}


class Drift:
    """A task that ends below `LOST`; rewards tell the first step, the action and the state apart."""

    agent, rate_hz, seconds, actions = "boat", 4.0, 1.5, 2
    space = gymnasium.spaces.Dict(
        {"x": gymnasium.spaces.Box(-99, 99, (1,)), "picture": gymnasium.spaces.Box(-99, 99, (2, 3))}
    )

    def scenario(self) -> dict[str, Any]:
        return {"name": "drift"}

    def start(self, random: np.random.Generator, sim: Any) -> dict[str, Any]:
        return {"position": [random.uniform(-2.0, 4.0), 0.0, 0.0]}

    def command(self, actions: Any, sim: Any) -> Any:
        return actions[:, 0] + 0.5 * actions[:, 1]

    def observe(self, sim: Any, readings: Any) -> dict[str, Any]:
        return {"x": readings[:, None], "picture": readings[:, None, None] + np.arange(6.0).reshape(2, 3)}

    def judge(self, sim: Any, actions: Any, began: Any) -> Any:
        reward = np.where(sim.ended, np.nan, sim.x + 10.0 * actions[:, 1] + 100.0 * began)
        return envs.Judgement(reward, sim.x < LOST, {"x_m": sim.x})


def born(copy: int, episode: int) -> float:
    return float(np.random.default_rng([SEED, FIRST + copy, episode]).uniform(-2.0, 4.0))


def life(mode: str, copy: int, given: Any) -> Iterator[tuple[Any, ...]]:
    """x seen, reward, terminated, truncated, broken, and x before a reset, of each decision of one copy."""
    x, steps, episode, over = born(copy, 0), 0, 0, False
    for a in np.clip(given, -1.0, 1.0):
        if mode == "next_step" and over:
            episode, steps, over = episode + 1, 0, False
            x = born(copy, episode)
            yield x, 0.0, False, False, False, None
            continue
        x, steps = x + 5 * (a[0] + 0.5 * a[1]), steps + 1
        broken = x > BROKEN
        reward = 0.0 if broken else x + 10.0 * a[1] + 100.0 * (steps == 1)
        terminated = broken or x < LOST
        truncated = not terminated and steps >= LIMIT
        over, last = terminated or truncated, x
        if mode == "same_step" and over:
            episode, steps = episode + 1, 0
            x = born(copy, episode)
        yield x, reward, terminated, truncated, broken, last


def made(monkeypatch: pytest.MonkeyPatch, mode: Any) -> tuple[envs.SensingEnv, dict[str, Any]]:
    asked: dict[str, Any] = {}

    def load(scenario: Any, **keys: Any) -> Numbers:
        asked.update(keys, scenario=scenario)
        return Numbers(keys["n"])

    monkeypatch.setattr(sensing.Simulation, "load", load)
    task: Any = Drift()
    return envs.SensingEnv(task, N, seed=SEED, environment=FIRST, autoreset=mode), asked


@pytest.mark.parametrize("mode", ["same_step", "next_step", "disabled"])
def test_every_copy_lives_one_life_after_the_other(mode: str, monkeypatch: pytest.MonkeyPatch) -> None:
    env, asked = made(monkeypatch, mode)
    assert asked == {"scenario": {"name": "drift"}, "n": N, "seed": SEED, "environment": FIRST}
    given = np.random.default_rng(2).uniform(-1.6, 1.6, (STEPS, N, 2))
    lives = [list(life(mode, i, given[:, i])) for i in range(N)]
    seen, info = env.reset()
    assert (seen["x"][:, 0].tolist(), info) == ([born(i, 0) for i in range(N)], {})
    ends = broke = 0
    for k, actions in enumerate(given):
        seen, reward, terminated, truncated, info = env.step(actions)
        xs, rewards, lost, late, broken, last = (
            list(column) for column in zip(*(one[k] for one in lives), strict=True)
        )
        np.testing.assert_allclose(seen["x"][:, 0], xs, rtol=1e-12)
        np.testing.assert_allclose(seen["picture"][:, 1, 2], np.array(xs) + 5, rtol=1e-12)
        np.testing.assert_allclose(reward, rewards, rtol=1e-6)
        assert (terminated.tolist(), truncated.tolist(), reward.dtype) == (lost, late, np.float32)
        assert ("not_finite" in info) == any(broken)
        if any(broken):
            assert info["not_finite"].tolist() == broken
        alive = [i for i, x in enumerate(last) if x is not None]
        np.testing.assert_allclose(info["x_m"][alive], [last[i] for i in alive], rtol=1e-6)
        ended, broke = terminated | truncated, broke + sum(broken)
        ends += ended.sum()
        assert ("final_obs" in info) == (mode == "same_step" and bool(ended.any()))
        if "final_obs" in info:
            np.testing.assert_allclose(info["final_obs"]["x"][:, 0], last, rtol=1e-12)
            np.testing.assert_allclose(info["final_info"]["x_m"], last, rtol=1e-6)
            assert info["_final_obs"].tolist() == info["_final_info"].tolist() == ended.tolist()
            assert ("not_finite" in info["final_info"]) == any(broken)
        if mode == "disabled" and k == 0:
            break  # the state of a copy that is over is nobody's matter
    assert env.not_finite == broke
    assert mode == "disabled" or (broke > 3 and ends > broke + 10)


def test_resets_of_some_of_all_and_of_a_seed(monkeypatch: pytest.MonkeyPatch) -> None:
    env, _ = made(monkeypatch, "disabled")
    sim: Any = env.sim
    env.reset()
    still = np.zeros((N, 2))
    env.step(still)
    some = np.array([False, True, False, True, False])
    seen, _ = env.reset(options={"reset_mask": some})
    assert seen["x"][:, 0].tolist() == [born(i, int(some[i])) for i in range(N)]
    reward = env.step(still)[1]  # the first step of those alone
    np.testing.assert_allclose(reward - seen["x"][:, 0], 100.0 * some, atol=1e-4)
    for k in range(2, LIMIT + 1):
        late = env.step(still)[3]
        assert late.tolist() == (~some if k == LIMIT - 1 else np.full(N, k == LIMIT)).tolist()
    assert env.reset()[0]["x"][:, 0].tolist() == [born(i, 1 + int(some[i])) for i in range(N)]
    assert (sim.seeds, env.first_environment) == ([SEED], FIRST)
    assert env.reset(seed=SEED)[0]["x"][:, 0].tolist() == [born(i, 0) for i in range(N)]
    assert env.reset(seed=SEED + 1)[0]["x"][0, 0] != born(0, 0)
    assert sim.seeds == [SEED, SEED, SEED + 1]
    with pytest.raises(CommandError, match="reset_mask is"):
        env.reset(options={"reset_mask": np.zeros(N, bool)})
    with pytest.raises(CommandError, match="without a seed"):
        env.reset(seed=1, options={"reset_mask": some})


def test_a_copy_that_was_over_and_is_reset_by_hand_is_not_reset_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    env, _ = made(monkeypatch, "next_step")
    env.reset()
    still, some = np.zeros((N, 2)), np.array([True, False, True, True, False])
    for _ in range(LIMIT):
        late = env.step(still)[3]
    assert late.all()
    env.reset(options={"reset_mask": some})
    seen, reward, *_ = env.step(still)
    assert seen["x"][:, 0].tolist() == [born(i, 1) for i in range(N)]
    assert ((reward > 50) == some).all()  # it was a first step for them, and the beginning for the others
