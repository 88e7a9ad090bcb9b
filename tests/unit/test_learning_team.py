"""A team of vehicles as PettingZoo's `ParallelEnv`."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from pettingzoo.test import parallel_api_test

from pelagos.envs.team import _RANGE_NOISE_M, FormationEnv
from pelagos.errors import CommandError


@pytest.mark.filterwarnings("ignore")
def test_pettingzoo_checks_it_and_the_script_keeps_the_ring() -> None:
    env = FormationEnv(3, seconds=16.0)
    parallel_api_test(env, num_cycles=4)
    first, _ = env.reset(seed=4)
    middle = -first["rov1"][:2]  # at the beginning the middle is the origin
    assert np.hypot(*middle) == pytest.approx(np.hypot(*env.sim.state["rov1"].position[0, :2]), abs=1e-5)
    seen, info, steps = first, {}, 0
    while env.agents:
        seen, reward, terminated, truncated, info = env.step(env.script(seen))
        steps += 1
    assert steps == 80
    assert all(truncated.values())
    assert not any(terminated.values())
    assert info["rov2"]["ring_error_m"] < 0.3
    assert info["rov2"]["range_error_m"] < 0.3
    assert reward["rov0"] > 0.4
    again, _ = env.reset(seed=4)
    for name, value in first.items():
        np.testing.assert_array_equal(again[name], value)
    with pytest.raises(CommandError, match="actions are those of rov0, rov1, rov2"):
        env.step({"rov0": np.zeros(3)})


def test_members_see_their_own_motion_and_the_others_from_where_they_are() -> None:
    """Speeds, sine and cosine of the yaw, then the ranges to the others in order, within five deviations."""
    env = FormationEnv(3, seconds=16.0)
    env.reset(seed=4)
    acts = {"rov0": [0.6, 0.1, 0.3], "rov1": [-0.2, 0.5, -0.4], "rov2": [0.1, -0.3, 0.8]}
    for _ in range(6):
        seen = env.step({name: np.array(act, dtype=np.float32) for name, act in acts.items()})[0]
    states = {name: env.sim.state[name] for name in acts}
    ranges = []
    for name, own in states.items():
        yaw = own.euler[0, 2]
        assert seen[name][2:6] == pytest.approx([*own.velocity[0, :2], np.sin(yaw), np.cos(yaw)], abs=1e-5)
        away = [np.linalg.norm(s.position[0] - own.position[0]) for other, s in states.items() if other != name]
        assert seen[name][6:] == pytest.approx(away, abs=5.0 * _RANGE_NOISE_M)
        ranges.append(away)
    assert np.ptp(ranges, axis=0).min() > 0.3  # else nobody would see them mixed


def test_teams_that_differ_share_no_policy() -> None:
    from pelagos.envs.shared import SharedTeams

    with pytest.raises(CommandError, match="2 kinds"):
        SharedTeams([FormationEnv(2), FormationEnv(3)])
    with pytest.raises(CommandError, match="at least one"):
        SharedTeams([])


class Pair:
    """A team of two that is over after `lasts` steps; its members see the seed of the episode and their steps."""

    possible_agents = ("left", "right")

    def __init__(self, lasts: int) -> None:
        self._lasts, self.agents = lasts, list(self.possible_agents)

    def observation_space(self, agent: str) -> Any:
        return SimpleNamespace(shape=(2,))

    def action_space(self, agent: str) -> Any:
        return SimpleNamespace(shape=(3,))

    def reset(self, seed: int = -1) -> tuple[Any, Any]:
        self._seed, self._step, self.agents = seed, 0, list(self.possible_agents)
        return self._seen(), {}

    def _seen(self) -> dict[str, np.ndarray]:
        return {name: np.array([self._seed, self._step + 10 * k]) for k, name in enumerate(self.possible_agents)}

    def step(self, actions: Any) -> tuple[Any, ...]:
        self._step += 1
        over = self._step == self._lasts
        self.agents = [] if over else self.agents
        by_name = lambda values: dict(zip(self.possible_agents, values, strict=True))
        given = [float(actions[name].sum()) for name in self.possible_agents]
        infos = by_name([{"far": 2 * g} for g in given])
        return self._seen(), by_name(given), by_name([over, False]), by_name([False, over]), infos


def test_teams_side_by_side_begin_other_episodes_and_each_anew_when_it_is_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows of a team are its members', each with its place in the team behind what it sees."""
    from pelagos.envs import shared

    monkeypatch.setattr(shared, "_tensor", lambda values: values)
    teams: Any = [Pair(2), Pair(5), Pair(1)]
    made = shared.SharedTeams(teams)
    assert (made.num_envs, made.size, made.actions, made.metrics) == (6, 4, 3, ["far"])
    seen, _ = made.reset(seed=40)
    assert seen.tolist() == [
        [40, 0, 1, 0], [40, 10, 0, 1], [41, 0, 1, 0], [41, 10, 0, 1], [42, 0, 1, 0], [42, 10, 0, 1],
    ]  # fmt: skip
    acts = np.arange(18.0).reshape(6, 3) - 7
    given = SimpleNamespace(numpy=lambda: acts)
    seen, reward, terminated, truncated, info = made.step(given)
    assert seen[:, :2].tolist() == [[40, 1], [40, 11], [41, 1], [41, 11], [-1, 0], [-1, 10]]
    assert info["final_obs"][:, :2].tolist() == [[40, 1], [40, 11], [41, 1], [41, 11], [42, 1], [42, 11]]
    assert reward == pytest.approx(acts.sum(axis=1))
    assert info["far"] == pytest.approx(2 * acts.sum(axis=1))
    assert terminated.tolist() == [False] * 4 + [True, False]
    assert truncated.tolist() == [False] * 5 + [True]
    assert made.step(given)[0][:, 1].tolist() == [0, 10, 2, 12, 0, 10]
