"""Proximal policy optimisation in one file, for baselines that anybody can repeat.

Source: J. Schulman et al., "Proximal policy optimization algorithms", arXiv 1707.06347, with generalised advantages
(arXiv 1506.02438) and the details that S. Huang et al. list ("The 37 implementation details of PPO", ICLR blog 2022):
orthogonal weights, normalised observations and advantages, clipped gradients, a rate that falls to 0. Episodes that the
limit of time cut are continued by the value of their last observation.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pelagos.envs.flat import FlatSensing
from pelagos.envs.fleet import FleetEnv
from pelagos.envs.policy import Network
from pelagos.envs.sensing import SensingEnv
from pelagos.envs.shared import SharedTeams
from pelagos.errors import CommandError, LookupFailed


@dataclass(frozen=True)
class Recipe:
    """Numbers of the method.

    Attributes:
        steps: decisions of all copies together, at most.
        horizon: decisions of a copy between two updates.
        epochs, minibatches: of an update.
        rate: of Adam at the beginning.
        discount, trace: gamma, lambda.
        clip: of the ratio.
        hidden: widths of the layers, of actor and critic each.
        until: stop where the mean of a metric at the ends of an update's episodes is at most this.
        max_s: stop after so long [s].
    """

    steps: int = 2_000_000
    horizon: int = 32
    epochs: int = 4
    minibatches: int = 8
    rate: float = 1e-3
    discount: float = 0.98
    trace: float = 0.95
    clip: float = 0.2
    hidden: tuple[int, ...] = (64, 64)
    until: tuple[str, float] | None = None
    max_s: float | None = None


@dataclass
class Trained:
    """Result of a training.

    Attributes:
        policy: the network.
        curve: a row an update: steps, seconds, reward a step, and the metrics at the last ends of episodes.
        reached: whether `until` was met.
    """

    policy: Network
    curve: list[dict[str, float]] = field(default_factory=list)
    reached: bool = False


def train(
    env: FleetEnv | SensingEnv | SharedTeams,
    recipe: Recipe,
    *,
    seed: int = 0,
    name: str = "",
    each: Callable[[dict[str, float]], None] | None = None,
) -> Trained:
    """Learn a policy for an environment with `autoreset="same_step"`, and with `arrays="torch"` or sensors.

    Teams learn a policy that their members share. Torch computes in one thread here: its threads and Dr.Jit's would
    wait for each other. From the same seed, numbers are the same on the same machine.

    Args:
        env: what is learned.
        recipe: how.
        seed: of episodes, first weights and exploration.
        name: of the task, kept in the policy.
        each: told every row of the curve.

    Raises:
        CommandError: an environment of another kind, or observations that hold pictures.
        LookupFailed: `until` names no metric of the task.
    """
    torch = _torch()
    rows: FleetEnv | FlatSensing | SharedTeams = FlatSensing(env) if isinstance(env, SensingEnv) else env
    if isinstance(rows, FleetEnv) and (rows.autoreset != "same_step" or rows.arrays != "torch"):
        raise CommandError("train needs an environment with arrays='torch' and autoreset='same_step'")
    if recipe.until is not None and recipe.until[0] not in rows.metrics:
        raise LookupFailed("metric", recipe.until[0], rows.metrics, where="until")
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        return _Learner(rows, recipe, seed).learn(name, each)
    finally:
        torch.set_num_threads(threads)


def _torch() -> Any:
    try:
        import torch
    except ImportError:
        raise CommandError("learning needs torch: pip install 'pelagos[learn]'") from None
    return torch


class _Learner:
    def __init__(self, env: FleetEnv | FlatSensing | SharedTeams, recipe: Recipe, seed: int) -> None:
        torch = self._torch = _torch()
        self._env, self._recipe, self._seed = env, recipe, seed
        torch.manual_seed(seed)
        size, count = env.size, env.actions
        self._actor, self._critic = self._layers(size, count, 0.01), self._layers(size, 1, 1.0)
        self._spread = torch.nn.Parameter(torch.full((count,), -0.5))
        parameters = [*self._actor.parameters(), *self._critic.parameters(), self._spread]
        self._parameters, self._adam = parameters, torch.optim.Adam(parameters, lr=recipe.rate, eps=1e-5)
        self._seen = _Moments(size)
        self._rewards = _Moments(1)
        self._ends = dict.fromkeys(env.metrics, float("nan"))

    def _layers(self, inputs: int, outputs: int, gain: float) -> Any:
        torch, found = self._torch, []
        widths = [inputs, *self._recipe.hidden, outputs]
        for i, (a, b) in enumerate(itertools.pairwise(widths)):
            last = i == len(widths) - 2
            layer = torch.nn.Linear(a, b)
            torch.nn.init.orthogonal_(layer.weight, gain if last else np.sqrt(2))
            torch.nn.init.zeros_(layer.bias)
            found += [layer] if last else [layer, torch.nn.Tanh()]
        return torch.nn.Sequential(*found)

    def learn(self, name: str, each: Callable[[dict[str, float]], None] | None) -> Trained:
        recipe, env = self._recipe, self._env
        start, done_steps = time.perf_counter(), 0
        seen, _ = env.reset(seed=self._seed)
        self._seen.add(seen.numpy())
        out = Trained(self._network(name))
        while done_steps < recipe.steps and not out.reached:
            share = 1.0 - done_steps / recipe.steps
            for group in self._adam.param_groups:
                group["lr"] = recipe.rate * share
            batch, seen, row = self._roll(seen)
            self._update(batch)
            done_steps += recipe.horizon * env.num_envs
            row = {"steps": float(done_steps), "seconds": time.perf_counter() - start, **row}
            out.curve.append(row)
            if each is not None:
                each(row)
            if recipe.until is not None and row.get(recipe.until[0], np.inf) <= recipe.until[1]:
                out.reached = True
            if recipe.max_s is not None and row["seconds"] > recipe.max_s:
                break
        out.policy = self._network(name)
        return out

    def _roll(self, seen: Any) -> tuple[dict[str, Any], Any, dict[str, float]]:
        """Experience of a horizon, the observations after it, and what to tell of it."""
        torch, env, recipe = self._torch, self._env, self._recipe
        kept: dict[str, list[Any]] = {k: [] for k in ("seen", "action", "log", "value", "reward", "over", "told")}
        ends: dict[str, list[Any]] = {name: [] for name in env.metrics}
        raw = []
        with torch.no_grad():
            for _ in range(recipe.horizon):
                x = self._normal(seen)
                mean, value = self._actor(x), self._critic(x)[:, 0]
                action = mean + self._spread.exp() * torch.randn_like(mean)
                raw.append(seen.numpy())
                after, reward, terminated, truncated, info = env.step(action.clamp(-1, 1))
                over = terminated | truncated
                reward = reward.clone()
                self._rewards.add(reward.numpy()[:, None])
                raw_reward = reward / self._rewards.deviation[0]
                if over.any():
                    beyond = self._critic(self._normal(info["final_obs"]))[:, 0]
                    raw_reward = raw_reward + recipe.discount * beyond * truncated
                    for metric, values in ends.items():
                        values.append(info[metric][over])
                row = (x, action, self._log(mean, action), value, raw_reward, over, reward.mean())
                for key, thing in zip(kept, row, strict=True):
                    kept[key].append(thing)
                seen = after
            last = self._critic(self._normal(seen))[:, 0]
        batch = self._advantages(kept, last)
        self._seen.add(np.concatenate(raw))
        told = {"reward": float(torch.stack(kept["told"]).mean())}
        self._ends |= {k: float(torch.cat(v).mean()) for k, v in ends.items() if v}
        told |= self._ends
        return batch, seen, told

    def _advantages(self, kept: Mapping[str, list[Any]], last: Any) -> dict[str, Any]:
        torch, recipe = self._torch, self._recipe
        found, running, following = [], torch.zeros_like(last), last
        for t in reversed(range(recipe.horizon)):
            on = (~kept["over"][t]).float()
            error = kept["reward"][t] + recipe.discount * following * on - kept["value"][t]
            running = error + recipe.discount * recipe.trace * on * running
            following = kept["value"][t]
            found.append(running)
        advantage = torch.stack(found[::-1])
        batch = {k: torch.cat(kept[k]) for k in ("seen", "action", "log")}
        value = torch.stack(kept["value"])
        return batch | {"advantage": advantage.reshape(-1), "goal": (advantage + value).reshape(-1)}

    def _update(self, batch: Mapping[str, Any]) -> None:
        torch, recipe = self._torch, self._recipe
        count = len(batch["log"])
        for _ in range(recipe.epochs):
            for chosen in torch.randperm(count).chunk(recipe.minibatches):
                part = {k: v[chosen] for k, v in batch.items()}
                mean = self._actor(part["seen"])
                ratio = (self._log(mean, part["action"]) - part["log"]).exp()
                a = part["advantage"]
                a = (a - a.mean()) / (a.std() + 1e-8)
                gain = torch.min(ratio * a, ratio.clamp(1 - recipe.clip, 1 + recipe.clip) * a).mean()
                error = 0.5 * (self._critic(part["seen"])[:, 0] - part["goal"]).square().mean()
                self._adam.zero_grad(set_to_none=True)
                (0.5 * error - gain).backward()
                torch.nn.utils.clip_grad_norm_(self._parameters, 0.5)
                self._adam.step()

    def _log(self, mean: Any, action: Any) -> Any:
        """Log-likelihood of an action, up to a constant."""
        return -(0.5 * ((action - mean) / self._spread.exp()).square() + self._spread).sum(-1)

    def _normal(self, seen: Any) -> Any:
        torch, m = self._torch, self._seen
        return ((seen - torch.from_numpy(m.mean)) / torch.from_numpy(m.deviation)).clamp(-10, 10)

    def _network(self, name: str) -> Network:
        linear = [layer for layer in self._actor if hasattr(layer, "weight")]
        weights, biases = ([getattr(x, part).detach().numpy().copy() for x in linear] for part in ("weight", "bias"))
        return Network(self._seen.mean.copy(), self._seen.deviation.copy(), weights, biases, name)


class _Moments:
    """Running mean and deviation (Chan, Golub and LeVeque 1979) of what was added so far."""

    def __init__(self, size: int) -> None:
        self._count, self._mean, self._squares = 1e-4, np.zeros(size), np.ones(size) * 1e-4

    def add(self, rows: NDArray[np.float32]) -> None:
        values = rows.astype(np.float64)
        count, mean = len(values), values.mean(axis=0)
        step, whole = mean - self._mean, self._count + count
        self._squares += ((values - mean) ** 2).sum(axis=0) + step**2 * self._count * count / whole
        self._mean, self._count = self._mean + step * count / whole, whole

    @property
    def mean(self) -> NDArray[np.float32]:
        return self._mean.astype(np.float32)

    @property
    def deviation(self) -> NDArray[np.float32]:
        return np.sqrt(self._squares / self._count + 1e-8).astype(np.float32)
