"""Environments for reinforcement learning: steps a second of all copies, and the time of one."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.cases.vehicles import Fleet
from pelagos.bench.check import must
from pelagos.bench.timing import seconds, seconds_in_turns

COPIES: Final = 4096
OCEANSCALE: Final = Reference("OceanScale on an RTX 5090, as published", 4.59)
_COMMAND: Final = [0.3, 0.2, 0.25, 0.3, 0.1, -0.1, 0.2, 0.1]


def _hover(n: int) -> tuple[Any, Any]:
    """Copies that have begun, and actions for them."""
    from pelagos import envs

    env = envs.make("pelagos/Hover-v0", n)
    env.reset(seed=1)
    actions = np.random.default_rng(2).uniform(-1, 1, (16, n, 8)).astype(np.float32)
    for given in actions:
        env.step(given)
    return env, actions


def env_hover_4096_msteps() -> Measured:
    """Vehicle, current, reward and resets in one call; what comes back is NumPy."""
    env, actions = _hover(COPIES)
    bare, count, ended = Fleet("bluerov2_heavy", n=COPIES, steps=env.program.ticks, command=_COMMAND), 0, 0

    def step() -> None:
        nonlocal count, ended
        _, _, terminated, truncated, _ = env.step(actions[count % len(actions)])
        ended += int((terminated | truncated).sum())
        count += 1

    took, peer = seconds_in_turns(step, bare.block, at_least_s=3.0)
    must(ended >= COPIES or count < 200, "no episode has ended")
    must(env.not_finite == 0, "a copy is not finite")
    limit = Reference("the physics alone in the bare kernel", COPIES / peer * 1e-6)
    return Measured(COPIES / took * 1e-6, limit, f"{env.program.ticks} ticks a step; {ended} episodes ended")


def env_hover_1_us() -> Measured:
    """One copy, as a `FleetEnv` of one."""
    env, actions = _hover(1)
    count = 0

    def step() -> None:
        nonlocal count
        env.step(actions[count % len(actions)])
        count += 1

    return Measured(1e6 * seconds(step, at_least_s=2.0), detail=f"{env.program.ticks} ticks a step, NumPy out")


def env_sonar_256_ksteps() -> Measured:
    """Wall inspection: vehicle, contact, DVL and an imaging sonar of 64 beams x 16 rays every step."""
    from pelagos import envs

    env: Any = envs.make("pelagos/WallInspection-v0", 256)
    seen, _ = env.reset(seed=1)

    def step() -> None:
        nonlocal seen
        seen, *_ = env.step(env.task.script(seen))

    took = seconds(step, at_least_s=5.0)
    share = float((seen["sonar"].std(axis=(1, 2)) > 0).mean())
    must(share > 0.9, f"{1 - share:.0%} of the sonars' pictures are empty")
    return Measured(0.256 / took, detail=f"10 ticks of 20 ms a step, and the script's; {share:.0%} see the wall")


def env_camera_64_ksteps() -> Measured:
    """Pipeline following: vehicle, DVL, altimeter and a camera of 84 x 84 every step."""
    from pelagos import envs

    env: Any = envs.make("pelagos/PipelineFollowing-v0", 64)
    seen, _ = env.reset(seed=1)

    def step() -> None:
        nonlocal seen
        seen, *_ = env.step(env.task.script(seen))

    took = seconds(step, at_least_s=5.0)
    must(float(seen["camera"].std(axis=(1, 2, 3)).min()) > 1.0, "a camera's picture is empty")
    return Measured(0.064 / took, detail="10 ticks of 20 ms a step, and the script's")


def ppo_hover_s() -> Measured:
    """PPO from nothing until hover's episodes end within 0.3 m of the pose, on average."""
    from pelagos import envs
    from pelagos.envs.ppo import Recipe, train

    env: Any = envs.make("pelagos/Hover-v0", 512, arrays="torch")
    made = train(env, Recipe(until=("distance_m", 0.3)))
    must(made.reached, "hover was not learned in 2 million steps")
    last = made.curve[-1]
    return Measured(last["seconds"], detail=f"{last['steps'] * 1e-6:.2f} M steps; {last['distance_m']:.2f} m")


CASES: Final = (
    Case(
        name="env_sonar_256_ksteps",
        title="256 environments: BlueROV2 Heavy before a wall, sonar 64 x 16 and DVL every step",
        measure=env_sonar_256_ksteps,
        unit="k env-steps/s",
        goal=8.0,
        better="higher",
        reference=Reference("nobody publishes one"),
    ),
    Case(
        name="env_camera_64_ksteps",
        title="64 environments: BlueROV2 Heavy over a pipe, camera 84 x 84, DVL and altimeter every step",
        measure=env_camera_64_ksteps,
        unit="k env-steps/s",
        goal=0.8,
        better="higher",
        reference=Reference("nobody publishes one"),
    ),
    Case(
        name="ppo_hover_s",
        title="PPO learns to hover to 0.3 m (needs torch)",
        measure=ppo_hover_s,
        unit="s",
        goal=60.0,
        better="lower",
        reference=Reference("a first trial, to 0.22 m on two busy cores", 47.0),
    ),
    Case(
        name="env_hover_4096_msteps",
        title="4096 environments: BlueROV2 Heavy hovers, five ticks a step, resets inside",
        measure=env_hover_4096_msteps,
        unit="M env-steps/s",
        goal=6.0,
        better="higher",
        reference=OCEANSCALE,
    ),
    Case(
        name="env_hover_1_us",
        title="One environment: BlueROV2 Heavy hovers, five ticks a step",
        measure=env_hover_1_us,
        unit="us",
        goal=40.0,
        better="lower",
        reference=Reference("one vehicle, 100 steps a second of the physics"),
    ),
)
