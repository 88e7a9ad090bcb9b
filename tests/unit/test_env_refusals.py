"""What environments refuse before anything is compiled, and the other side of each limit."""

from __future__ import annotations

import os
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import gymnasium
import numpy as np
import pytest

from pelagos import envs
from pelagos.envs import program, sensing, team
from pelagos.envs.evaluate import evaluate
from pelagos.envs.flat import FlatSensing, as_rows, row_size
from pelagos.envs.fleet import FleetEnv, Inbox
from pelagos.envs.lerobot import save_lerobot
from pelagos.envs.picture import Track
from pelagos.envs.policy import Network
from pelagos.envs.ppo import Recipe, _Learner, train
from pelagos.envs.shared import acts_of
from pelagos.envs.single import SingleEnv
from pelagos.envs.tasks.hover import Hover
from pelagos.envs.trajectories import _rooted, collect, save_minari
from pelagos.envs.view import View
from pelagos.errors import CommandError, InputError, LookupFailed, ScenarioError


@pytest.fixture(scope="module")
def fleet() -> FleetEnv:
    """Three copies that have not begun."""
    return FleetEnv(Hover(), 3)


def test_nothing_is_known_of_copies_before_they_begin_and_after_they_are_closed(fleet: FleetEnv) -> None:
    mask = {"reset_mask": np.array([True, False, False])}
    for _ in range(2):
        for ask in (lambda: fleet.state, lambda: fleet.episode, lambda: fleet.step(np.zeros((3, 8)))):
            with pytest.raises(CommandError, match=r"the first call is reset\(\)"):
                ask()
        with pytest.raises(CommandError, match="the first reset is that of all copies; leave out reset_mask"):
            fleet.reset(options=mask)
        fleet._keeps = fleet._nothing()
        assert fleet.episode.tolist() == [2**32 - 1] * 3
        assert fleet.state["position"].shape == (3, 3)
        with pytest.raises(CommandError, match="a seed is that of all copies; leave out reset_mask"):
            fleet.reset(seed=2, options=mask)
        fleet.close()


def test_actions_are_numbers() -> None:
    box = Inbox(4)
    for given in ([["a", 1], [2, 3]], [[1, 2], [3]], [[1j, None], [1, 2]]):
        with pytest.raises(CommandError, match=r"^actions are numbers of shape \(2, 2\): "):
            box.put(given, (2, 2))
    box.put([[1, -2], [3, 4.5]], (2, 2))
    assert box.values.tolist() == [1, -2, 3, 4.5]


@pytest.mark.parametrize(
    ("package", "ask", "words"),
    [
        ("torch", lambda: FleetEnv(Hover(), arrays="torch"), r"arrays='torch' needs torch: .*pelagos\[learn\]"),
        ("torch", lambda: train(Copies(), Recipe()), r"learning needs torch: .*pelagos\[learn\]"),  # type: ignore[arg-type]
        ("gymnasium", lambda: envs.make("pelagos/Hover-v0"), r"environments need Gymnasium: .*pelagos\[envs\]"),
        ("minari", lambda: save_minari([], Copies(), "a-v0"), r"need Minari: .*pelagos\[minari\]"),  # type: ignore[arg-type]
        ("pyarrow", lambda: lerobot([]), r"LeRobot's format needs Apache Arrow: .*pelagos\[datasets\]"),
    ],
)
def test_a_package_that_is_missing_is_named(
    package: str, ask: Any, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(CommandError, match=words):
        ask()


def lerobot(episodes: Any) -> Any:
    return save_lerobot(episodes, Copies(), Path("nowhere"), task="it")  # type: ignore[arg-type]


class Copies:
    """Copies whose episodes last a step."""

    def __init__(self, **other: Any) -> None:
        self.num_envs, self.autoreset, self.arrays, self.task = 2, "same_step", "numpy", Hover()
        vars(self).update(other)

    def reset(self, *, seed: int | None = None) -> Any:
        return np.zeros((2, 1)), {}

    def step(self, actions: Any) -> Any:
        info = {"final_info": {}, "final_obs": np.ones((2, 1))}
        return np.zeros((2, 1)), np.array([1.0, -2.0]), np.ones(2, bool), np.zeros(2, bool), info


@pytest.mark.parametrize("ask", [evaluate, collect])
def test_scores_and_trajectories_need_episodes_and_ends_that_are_seen(ask: Any) -> None:
    policy = lambda seen: np.zeros((2, 1))
    for other in ({"autoreset": "disabled"}, {"autoreset": "next_step"}, {"arrays": "torch"}):
        with pytest.raises(CommandError, match="need an environment with autoreset='same_step' and arrays='numpy'"):
            ask(Copies(**other), policy)
    for episodes in (0, -1):
        with pytest.raises(CommandError, match=f"episodes is a number from 1 on, not {episodes}"):
            ask(Copies(), policy, episodes=episodes)
    assert evaluate(Copies(), policy, episodes=1).returns.tolist() == [1.0, -2.0]  # type: ignore[arg-type]


def test_a_data_set_has_episodes() -> None:
    pytest.importorskip("pyarrow")
    with pytest.raises(CommandError, match="a data set of no episodes: collect some first"):
        lerobot([])


def test_minaris_folder_is_what_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for before in (None, "there"):
        monkeypatch.delenv("MINARI_DATASETS_PATH", raising=False)
        if before is not None:
            monkeypatch.setenv("MINARI_DATASETS_PATH", before)
        with _rooted(tmp_path) as part:
            assert os.environ["MINARI_DATASETS_PATH"] == str(part)
        assert os.environ.get("MINARI_DATASETS_PATH") == before
    assert not list(tmp_path.iterdir())


def test_a_file_that_is_no_policy_is_named(tmp_path: Path) -> None:
    np.savez(tmp_path / "other.npz", weight0=np.ones(3))
    np.save(tmp_path / "array.npy", np.ones(3))
    (tmp_path / "words.npz").write_text("policy")
    (tmp_path / "empty.npz").write_text("")
    (tmp_path / "cut.npz").write_bytes((tmp_path / "other.npz").read_bytes()[:40])
    for name in ("other.npz", "array.npy", "words.npz", "empty.npz", "cut.npz", "nowhere.npz"):
        with pytest.raises(InputError, match=rf"{name} is no policy that `pelagos train` wrote: "):
            Network.load(tmp_path / name)


def test_a_single_environment_is_one_copy_that_is_not_reset_by_itself(fleet: FleetEnv) -> None:
    one: Any = SimpleNamespace(num_envs=1, autoreset="disabled", task=Hover())
    one.single_observation_space = one.single_action_space = None
    with pytest.raises(LookupFailed, match=r"render mode 'human'.*rgb_array"):
        SingleEnv(one, render_mode="human")
    for other in ({"num_envs": 2}, {"autoreset": "same_step"}):
        with pytest.raises(CommandError, match="a fleet of one with autoreset='disabled'"):
            SingleEnv(SimpleNamespace(**{**vars(one), **other}))  # type: ignore[arg-type]
    with pytest.raises(LookupFailed, match="option of reset 'where'"):
        SingleEnv(one).reset(options={"where": 1})


def test_networks_take_rows() -> None:
    row, picture = (gymnasium.spaces.Box(0, 1, shape) for shape in ((3,), (4, 5)))
    assert row_size(row) == 3
    assert row_size(gymnasium.spaces.Dict({"a": row, "b": gymnasium.spaces.Box(0, 1, (2,))})) == 5
    for space, name in ((picture, "observation"), (gymnasium.spaces.Dict({"a": row, "sonar": picture}), "sonar")):
        with pytest.raises(
            CommandError, match=rf"'{name}' has shape \(4, 5\); the networks of pelagos train take rows"
        ):
            row_size(space)
    seen = {"a": np.array([[1, 2]]), "b": np.array([[3]])}
    assert as_rows(seen).tolist() == [[1, 2, 3]]
    with pytest.raises(CommandError, match="train needs an environment with autoreset='same_step'"):
        FlatSensing(Copies(autoreset="disabled"))  # type: ignore[arg-type]


def test_members_act_by_their_own_rows() -> None:
    seen = {"a": np.array([2.0, 3.0], np.float32), "b": np.array([5.0, 7.0], np.float32)}
    made = acts_of(lambda rows: rows @ np.diag([1, 10, 100, 1000]), seen)
    assert {k: v.tolist() for k, v in made.items()} == {"a": [2, 30, 100, 0], "b": [5, 70, 0, 1000]}


def test_a_formation_has_2_to_50_vehicles(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(team.Simulation, "load", lambda scenario: scenario)
    for count in (1, 51):
        with pytest.raises(CommandError, match=f"a formation has 2 to 50 vehicles, not {count}"):
            team.FormationEnv(count)
    for count in (2, 50):
        assert len(team.FormationEnv(count).possible_agents) == count


def test_a_chart_shows_the_goal_of_its_episode() -> None:
    track = Track([1, 2, 3])
    here = {"position": np.zeros((1, 3)), "attitude": np.array([[1.0, 0, 0, 0]])}
    track.note(here)
    assert track._goal is not None
    assert track._goal.tolist() == [1, 2, 3]
    track.note(
        here | {f"task.goal_{axis}": np.array([v, 9.0]) for axis, v in zip("xyz", (4.0, -5.0, 6.0), strict=True)}
    )
    assert track._goal.tolist() == [4, -5, 6]


def test_a_view_has_the_surface_over_its_own_place_and_time() -> None:
    view: Any = View.__new__(View)
    view._position, view.t = (3.0, -4.0, -5.0), 0.5
    view._ocean = SimpleNamespace(elevation=lambda x, y, t: x + 10 * y + 100 * t)
    assert view.surface == 3 - 40 + 50


def test_a_term_in_numpy_has_no_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    made = SimpleNamespace(model=SimpleNamespace(on_host=True), check_mode=lambda mode: None)
    for door in ("from_catalogue", "from_dict"):
        monkeypatch.setattr(program.Vehicle, door, lambda given: made)
    with pytest.raises(ScenarioError, match="Hover: a vehicle with a term in NumPy cannot be compiled into a kernel"):
        program._vehicle(Hover())
    made.model.on_host = False
    assert program._vehicle(Hover()) is made


def test_names_of_the_package_are_listed() -> None:
    assert dir(envs) == sorted(envs.__all__)
    assert {"FleetEnv", "make", "View"} <= set(dir(envs))


# tasks with sensors


class Watch:
    """A task whose copies break when told to."""

    agent, rate_hz, seconds, actions = "auv", 5.0, 1.0, 2
    space = gymnasium.spaces.Dict({"state": gymnasium.spaces.Box(-1, 1, (1,))})

    def __init__(self, **other: Any) -> None:
        vars(self).update(other)

    def scenario(self) -> dict[str, Any]:
        return {}

    def start(self, random: Any, sim: Any) -> dict[str, Any]:
        return {"position": [0.0, 0.0, 0.0]}

    def observe(self, sim: Any, readings: Any) -> dict[str, Any]:
        return {"state": np.zeros((3, 1), np.float32)}

    def command(self, actions: Any, sim: Any) -> Any:
        return actions

    def judge(self, sim: Any, actions: Any, began: Any) -> Any:
        return envs.Judgement(np.full(3, 2.0), np.zeros(3, bool), {})


@pytest.fixture
def sim(monkeypatch: pytest.MonkeyPatch) -> Any:
    made = SimpleNamespace(model=SimpleNamespace(agents={"auv": None}), dt_ns=10_000_000, ended=np.zeros(3, bool))
    made.reset = made.step = lambda *_, **__: {"auv": {}}
    monkeypatch.setattr(sensing.Simulation, "load", lambda *_, **__: made)
    return made


@pytest.mark.parametrize(
    ("task", "keys", "kind", "words"),
    [
        ({}, {"autoreset": "samestep"}, LookupFailed, "autoreset mode 'samestep' .did you mean 'same_step'"),
        ({"agent": "auv0"}, {}, LookupFailed, "Watch.*agent 'auv0' .did you mean 'auv'"),
        ({"rate_hz": 7.0}, {}, CommandError, "Watch: rate_hz 7 is no whole number of ticks"),
    ],
)
def test_a_task_with_sensors_that_cannot_be(task: Any, keys: Any, kind: Any, words: str, sim: Any) -> None:
    with pytest.raises(kind, match=words):
        envs.SensingEnv(Watch(**task), 3, **keys)


@pytest.mark.parametrize("mode", ["same_step", "next_step"])
def test_a_copy_with_sensors_that_breaks_is_counted_once(mode: Any, sim: Any) -> None:
    env = envs.SensingEnv(Watch(), 3, autoreset=mode)
    with pytest.raises(LookupFailed, match=r"option of reset 'mask' .did you mean 'reset_mask'"):
        env.reset(options={"mask": np.ones(3, bool)})
    env.reset(seed=1)
    assert "not_finite" not in env.step(np.zeros((3, 2)))[4]
    sim.ended[1] = True
    _, reward, terminated, truncated, info = env.step(np.zeros((3, 2)))
    assert (reward.tolist(), terminated.tolist(), truncated.any()) == ([2, 0, 2], [False, True, False], False)
    assert (info["not_finite"].tolist(), env.not_finite) == ([False, True, False], 1)
    if mode == "next_step":  # the copy begins anew in this step, and was told of already
        assert "not_finite" not in env.step(np.zeros((3, 2)))[4]
        assert env.not_finite == 1


# other libraries' environments, without the libraries


def brought(monkeypatch: pytest.MonkeyPatch, **modules: dict[str, Any]) -> None:
    """Modules that hold no more than what is named, for this test."""
    for name, held in modules.items():
        made: Any = ModuleType(name.replace("_1_", "."))
        vars(made).update(held)
        monkeypatch.setitem(sys.modules, made.__name__, made)


def adapter(name: str) -> Any:
    """A module of `envs` as it is with those, which no other test sees."""
    spec = spec_from_file_location(f"{name}_alone", Path(envs.__file__).with_name(f"{name}.py"))
    assert spec is not None
    assert spec.loader is not None
    made = module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


class Told(Copies):
    """Copies whose second one's episode ends with the step; observations by name or not."""

    def __init__(self, named: bool = False, **other: Any) -> None:
        super().__init__(**other)
        self.named, self.seeds, self.open = named, list[Any](), True
        self.single_observation_space = gymnasium.spaces.Dict({"a": gymnasium.spaces.Box(0, 1, (2,))})
        self.single_action_space = gymnasium.spaces.Box(-1, 1, (1,))
        self.task.actions = 1

    def _seen(self, at: float) -> Any:
        rows = at + np.arange(4.0).reshape(2, 2)
        return {"a": rows} if self.named else rows

    def reset(self, *, seed: int | None = None) -> Any:
        self.seeds.append(seed)
        return self._seen(10), {}

    def step(self, actions: Any) -> Any:
        self.given, done = actions, np.array([False, True])
        metrics = {"far_m": np.array([0.5, 7.0]), "near_m": np.array([3.0, 4.0])}
        info = {**metrics, "final_obs": self._seen(50), "_final_obs": done, "final_info": metrics, "not_finite": ~done}
        return self._seen(20), np.array([1.0, -2.0]), np.array([False, False]), done, info

    def close(self) -> None:
        self.open = False


def test_rows_for_a_learner_are_those_of_the_names(monkeypatch: pytest.MonkeyPatch) -> None:
    brought(monkeypatch, torch={"from_numpy": lambda values: [*values]})
    env = Told(named=True)
    flat = FlatSensing(env)  # type: ignore[arg-type]
    assert (flat.num_envs, flat.size, flat.actions, flat.metrics) == (2, 2, 1, ["far_m", "near_m"])
    seen, info = flat.reset(seed=4)
    assert ([row.tolist() for row in seen], info, env.seeds) == ([[10, 11], [12, 13]], {}, [0, 4])
    seen, reward, terminated, truncated, told = flat.step(SimpleNamespace(numpy=lambda: "acts"))
    assert (env.given, [row.tolist() for row in seen], reward) == ("acts", [[20, 21], [22, 23]], [1, -2])
    assert (terminated, truncated) == ([False, False], [False, True])
    assert [row.tolist() for row in told.pop("final_obs")] == [[50, 51], [52, 53]]
    assert told == {"far_m": [0.5, 7.0], "near_m": [3.0, 4.0]}


@pytest.mark.parametrize("named", [False, True])
def test_stable_baselines3_is_told_of_ends_by_copy(named: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    class Base:
        def __init__(self, num_envs: int, observation_space: Any, action_space: Any) -> None:
            self.num_envs = num_envs

        def _get_indices(self, indices: Any) -> Any:
            return range(self.num_envs) if indices is None else indices

    vec = {"VecEnv": Base}
    brought(monkeypatch, stable_baselines3={}, stable_baselines3_1_common={}, stable_baselines3_1_common_1_vec_env=vec)
    sb3 = adapter("sb3")
    for other in ({"arrays": "torch"}, {"autoreset": "next_step"}):
        with pytest.raises(
            CommandError, match="Stable-Baselines3 takes a fleet with arrays='numpy' and autoreset='same"
        ):
            sb3.SB3Env(Told(**other))
    fleet = Told(named)
    env = sb3.SB3Env(fleet)
    assert env.seed(5) == [5, 5]
    env.reset()
    assert (env.reset() if named else {"a": env.reset()})["a"].tolist() == [[10, 11], [12, 13]]
    assert (fleet.seeds, env.reset_infos) == ([5, None], [{}, {}])
    env.step_async("acts")
    _, reward, done, infos = env.step_wait()
    assert (fleet.given, reward.tolist(), done.tolist()) == ("acts", [1, -2], [False, True])
    assert infos[0] == {"far_m": 0.5, "near_m": 3.0}
    last = infos[1].pop("terminal_observation")
    assert (last["a"] if named else last).tolist() == [52, 53]
    assert infos[1] == {"far_m": 7.0, "near_m": 4.0, "TimeLimit.truncated": True}
    assert env.get_attr("rate_hz") == [20.0, 20.0]
    assert env.get_attr("named", [1]) == [named]
    assert (env.env_is_wrapped(object), env.env_is_wrapped(object, [0])) == ([False, False], [False])
    with pytest.raises(CommandError, match="rate_hz cannot be set: copies share a compiled task"):
        env.set_attr("rate_hz", 3)
    with pytest.raises(CommandError, match=r"draw\(\) cannot be called on copies"):
        env.env_method("draw")
    env.close()
    assert fleet.open is False


def test_rsl_rl_takes_tensors_of_copies_that_begin_anew_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    brought(monkeypatch, torch={}, tensordict={"TensorDict": dict}, rsl_rl={}, rsl_rl_1_env={"VecEnv": object})
    rsl_rl = adapter("rsl_rl")
    for arrays, mode in (("numpy", "same_step"), ("torch", "disabled")):
        with pytest.raises(CommandError, match="RSL-RL takes a fleet with arrays='torch' and autoreset='same_step'"):
            rsl_rl.RslRlEnv(SimpleNamespace(arrays=arrays, program=SimpleNamespace(autoreset=mode)))


class Numbers(np.ndarray):
    """Rows as tensors are, as far as advantages take them."""

    def float(self) -> np.ndarray:
        return self.astype(np.float64)


def test_advantages_are_the_decayed_errors_until_an_episode_ends() -> None:
    """J. Schulman et al. 2016 (arXiv 1506.02438), equation 16: A_t = sum of (gamma lambda)^k of delta_{t+k}, with
    delta = r + gamma V' - V, no further than the end, where V' is 0."""
    rng, discount, trace = np.random.default_rng(6), 0.83, 0.61
    reward, value = rng.normal(size=(2, 5, 3))
    last = rng.normal(size=3)
    over = np.zeros((5, 3), dtype=bool)
    over[1, 0] = over[3, 1] = over[4, 2] = True
    rows = lambda a: [row.view(Numbers) for row in a]
    kept = {"reward": rows(reward), "value": rows(value), "over": rows(over),
            **{k: rows(rng.normal(size=(5, 3))) for k in ("seen", "action", "log")}}  # fmt: skip
    torch = SimpleNamespace(zeros_like=np.zeros_like, stack=np.stack, cat=np.concatenate)
    learner = SimpleNamespace(_torch=torch, _recipe=SimpleNamespace(horizon=5, discount=discount, trace=trace))
    found = _Learner._advantages(learner, kept, last)
    after = np.concatenate([value[1:], last[None]])
    expected = np.zeros((5, 3))
    for t in range(5):
        for copy in range(3):
            for k in range(t, 5):
                ends = over[k, copy]
                delta = reward[k, copy] + discount * (0 if ends else after[k, copy]) - value[k, copy]
                expected[t, copy] += (discount * trace) ** (k - t) * delta
                if ends:
                    break
    np.testing.assert_allclose(found["advantage"], expected.ravel(), rtol=1e-12)
    np.testing.assert_allclose(found["goal"], (expected + value).ravel(), rtol=1e-12)
    np.testing.assert_array_equal(found["action"], np.concatenate(kept["action"]))
