"""Environments: one kernel a step, copies of their own, Gymnasium's three ways to begin anew, and bad input."""

from __future__ import annotations

from typing import Any

import drjit as dr
import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import pelagos as pl
from pelagos import envs
from pelagos.envs.registry import register
from pelagos.envs.tasks.hover import Hover
from pelagos.envs.tasks.rov import rov
from pelagos.errors import CommandError, LookupFailed, ScenarioError

N = 3
STEPS = 7


class Short(Hover):
    """Episodes of four decisions."""

    seconds = 0.2


def actions(steps: int = STEPS, n: int = N) -> np.ndarray:
    return np.random.default_rng(4).uniform(-1.2, 1.2, (steps, n, 8)).astype(np.float32)


def fleet(autoreset: Any = "same_step", n: int = N, **options: Any) -> envs.FleetEnv:
    return envs.FleetEnv(Short(), n, autoreset=autoreset, **options)


def test_a_step_is_one_kernel() -> None:
    env = fleet()
    env.reset(seed=1)
    for a in actions()[:2]:
        env.step(a)
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        dr.kernel_history()
        for a in actions()[2:]:
            env.step(a)
        assert len(dr.kernel_history([dr.KernelType.JIT])) == STEPS - 2
        assert not [k for k in dr.kernel_history() if k["type"] != dr.KernelType.JIT]


def test_the_three_modes_give_the_same_transitions() -> None:
    """Episodes end together after four decisions; every mode has the same observations and rewards in them."""
    told: dict[str, list[Any]] = {}
    given = actions()
    for mode in ("same_step", "next_step", "disabled"):
        env = fleet(mode)
        assert env.autoreset_mode.name.lower() == mode
        seen, _ = env.reset(seed=7)
        told[mode] = [seen]
        k = 0
        while k < STEPS:
            seen, reward, terminated, truncated, info = env.step(given[k])
            done = terminated | truncated
            assert done.all() == (k == 3)
            assert not terminated.any()
            if done.any() and mode == "same_step":
                np.testing.assert_array_equal(info["_final_obs"], done)
                told[mode] += [info["final_obs"], reward]
            else:
                told[mode] += [seen, reward]
            if done.any() and mode == "next_step":
                seen, reward, terminated, truncated, _ = env.step(given[0])
                assert not reward.any()
                assert not (terminated | truncated).any()
            if done.any() and mode == "disabled":
                seen, _ = env.reset(options={"reset_mask": done})
            if done.any():
                told[mode].append(seen)
            k += 1
        np.testing.assert_array_equal(env.episode, [1, 1, 1])
    for other in ("next_step", "disabled"):
        for mine, theirs in zip(told["same_step"], told[other], strict=True):
            np.testing.assert_array_equal(mine, theirs)


def test_a_copy_is_a_fleet_of_one_and_a_partial_reset_leaves_the_others() -> None:
    given, whole, alone = actions(), fleet("disabled"), fleet("disabled", 1, environment=1)
    first, _ = whole.reset(seed=3)
    again, _ = alone.reset(seed=3)
    np.testing.assert_array_equal(first[1:2], again)
    assert len({row.tobytes() for row in first}) == N
    for k, a in enumerate(given):
        seen, reward, *_ = whole.step(a)
        mine, my_reward, *_ = alone.step(a[1:2])
        np.testing.assert_array_equal(seen[1:2], mine)
        np.testing.assert_array_equal(reward[1:2], my_reward)
        if k == 2:
            before = whole.state
            whole.reset(options={"reset_mask": np.array([True, False, True])})
            for name, value in whole.state.items():
                np.testing.assert_array_equal(value[1], before[name][1])
                if name in ("position", "attitude", "velocity", "current.x"):
                    assert (value[[0, 2]] != before[name][[0, 2]]).any()


def test_the_kernel_moves_vehicles_as_a_simulation_does() -> None:
    """In the kernel the same sums may be rounded in another order: 1e-16 of each of some 100 terms in 35 ticks."""

    class Moving(Short):
        def draw(self, random: Any) -> Any:
            start = super().draw(random)
            start.velocity, start.angular_velocity = [0.4, -0.2, 0.13], [0.21, -0.16, 0.34]
            return start

    env = envs.FleetEnv(Moving(), N, autoreset="disabled")
    env.reset(seed=2)
    start, given = env.state, np.clip(actions(), -1, 1)
    scenario = {
        "tick_rate_hz": 100,
        "world": {"type": "flat", "depth_m": 400.0},
        "agents": {"rov": {"vehicle": rov(), "control": "actuators", "start": {"position_m": [0, 0, -10]}}},
    }
    sim = pl.Simulation.load(scenario, n=N)
    sim.ocean.set(current=np.stack([start[f"current.{a}"] for a in "xyz"], axis=-1))
    sim.set_state(
        "rov", position=start["position"], attitude=start["attitude"],
        velocity=[0.4, -0.2, 0.13], angular_velocity=[0.21, -0.16, 0.34],
    )  # fmt: skip
    for a in given:
        env.step(a)
        sim.step({"rov": a.astype(np.float64)}, ticks=5)
    state = sim.state["rov"]
    for name in ("position", "attitude", "velocity", "angular_velocity"):
        np.testing.assert_allclose(env.state[name], getattr(state, name), rtol=0, atol=1e-11, err_msg=name)
    assert (np.abs(env.state["position"] - start["position"]).max(axis=1) > 0.01).all()


def test_a_copy_that_breaks_ends_alone_with_a_finite_observation() -> None:
    class Thrown(Short):
        def draw(self, random: Any) -> Any:
            start = super().draw(random)
            start.velocity = [dr.select(start.position[0] > 0, 1e200, 0.0), 0.0, 0.0]
            return start

    env = envs.FleetEnv(Thrown(), 8, seed=1)
    env.reset(seed=1)
    thrown = env.state["position"][:, 0] > 0
    assert 0 < thrown.sum() < 8
    seen, reward, terminated, _, info = env.step(actions(1, 8)[0])
    np.testing.assert_array_equal(terminated, thrown)
    np.testing.assert_array_equal(info["not_finite"], thrown)
    assert np.isfinite(seen).all()
    assert not reward[thrown].any()
    assert env.not_finite == thrown.sum()


def test_actions_out_of_range_are_clipped_and_counted_or_refused() -> None:
    env, mild = fleet(), fleet()
    strict = fleet(out_of_range="refuse")
    wild = actions()[0]
    for e in (env, mild, strict):
        e.reset(seed=5)
    out = (np.abs(wild) > 1).any(axis=1)
    seen, *_, info = env.step(wild)
    np.testing.assert_array_equal(info["clipped"], out)
    assert env.clipped == out.sum()
    np.testing.assert_array_equal(seen, mild.step(np.clip(wild, -1, 1))[0])
    with pytest.raises(CommandError, match=r"between -1 and 1; copy 0"):
        strict.step(wild)
    strict.step(np.clip(wild, -1, 1))
    with pytest.raises(CommandError, match="action of copy 1 is not finite"):
        env.step(np.where(np.arange(N)[:, None] == 1, np.nan, wild))


def test_gymnasium_makes_and_checks_it() -> None:
    register()
    env = gymnasium.make("pelagos/Hover-v0", render_mode="rgb_array")
    check_env(env.unwrapped, skip_render_check=True)
    env.reset(seed=1)
    env.step(actions(1, 1)[0, 0].clip(-1, 1))
    picture = env.render()
    assert picture.shape == (480, 640, 3)
    assert len(np.unique(picture)) > 50
    vector = gymnasium.make_vec("pelagos/Hover-v0", num_envs=N, depth_m=12.0)
    seen, _ = vector.reset(seed=1)
    assert seen.shape == (N, 14)
    assert vector.metadata["autoreset_mode"] is gymnasium.vector.AutoresetMode.SAME_STEP
    vector = gymnasium.wrappers.vector.RecordEpisodeStatistics(envs.FleetEnv(Short(), N))
    vector.reset(seed=1)
    for a in actions()[:4]:
        info = vector.step(a)[4]
    np.testing.assert_array_equal(info["episode"]["l"], [4, 4, 4])


def test_bad_input_is_told() -> None:
    with pytest.raises(LookupFailed, match=r"did you mean 'pelagos/Hover-v0'"):
        envs.make("pelagos/Hovr-v0")
    with pytest.raises(LookupFailed, match=r"option of pelagos/Hover-v0 'reech_m' \(did you mean 'reach_m'"):
        envs.make("pelagos/Hover-v0", reech_m=3)
    with pytest.raises(LookupFailed, match="autoreset mode 'samestep'"):
        fleet("samestep")
    with pytest.raises(CommandError, match="n is the number of copies"):
        fleet(n=0)
    with pytest.raises(ScenarioError, match="a seed is a whole number"):
        fleet(seed=-1)
    env = fleet()
    with pytest.raises(CommandError, match=r"first call is reset"):
        env.step(actions()[0])
    env.reset()
    with pytest.raises(CommandError, match=r"shape \(3, 8\); given \(3, 7\)"):
        env.step(np.zeros((3, 7)))
    with pytest.raises(CommandError, match=r"reset_mask is \(3,\) bool"):
        env.reset(options={"reset_mask": np.zeros(3, dtype=bool)})
    with pytest.raises(LookupFailed, match="option of reset 'mask'"):
        env.reset(options={"mask": np.ones(3, dtype=bool)})


def test_a_task_that_contradicts_itself_is_told() -> None:
    class Blind(Hover):
        observations = ("one", "two")

    class Odd(Hover):
        rate_hz = 30.0

    class Varied(Hover):
        vary = {"quadratic_dampin": (0.5, 2.0)}  # noqa: RUF012

    class Forgetful(Hover):
        def reward(self, now: Any, action: Any) -> Any:
            outcome = super().reward(now, action)
            outcome.memory = {"before": now.t}
            return outcome

    class Brief(Hover):
        seconds, rate_hz = 0.024, 20.0

    class Generous(Hover):
        def command(self, action: Any, now: Any) -> Any:
            return action[:-1]

    for task, message in (
        (Brief, "Brief: seconds 0.024 at rate_hz 20 is less than a step"),
        (Generous, "Generous: command gives 7 set-points of .*, which has "),
        (Blind, "observe gives 14 numbers, but observations names 2"),
        (Odd, "tick_rate_hz 100 is no whole multiple of rate_hz 30"),
        (Varied, "did you mean 'quadratic_damping'"),
        (Forgetful, "reward changes before, which draw does not put into the memory"),
    ):
        with pytest.raises((CommandError, LookupFailed), match=message):
            envs.FleetEnv(task(), 2)


def test_parameters_differ_from_copy_to_copy_and_act() -> None:
    """With thrusters at rest the first acceleration is weight less buoyancy over mass and added mass."""

    class Heavy(Short):
        vary = {"mass": (1.1, 1.6), "added_mass": (0.5, 2.0), "lag": (0.5, 2.0), "thrust": (0.8, 1.2)}  # noqa: RUF012
        tick_rate_hz = 1000.0
        rate_hz = 1000.0

        def draw(self, random: Any) -> Any:
            start = super().draw(random)
            start.attitude, start.current = [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
            return start

    env = envs.FleetEnv(Heavy(), 4, seed=2)
    env.reset(seed=2)
    mass, added = env.state["vary.mass"], env.state["vary.added_mass"]
    assert len(set(mass)) == 4
    env.step(np.zeros((4, 8)))
    weight, buoyancy = 13.5 * 9.82, 1000 * 0.0134 * 9.82
    expected = -(mass * weight - buoyancy) / (mass * 13.5 + added * 18.68) * 1e-3
    np.testing.assert_allclose(env.state["velocity"][:, 2], expected, rtol=1e-9)
