"""`make`: an environment from the name of a scenario, or from the scenario itself."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pelagos.compat.holoocean import packagemanager
from pelagos.compat.holoocean.environments import HoloOceanEnvironment
from pelagos.compat.holoocean.exceptions import HoloOceanException
from pelagos.compat.holoocean.holoocean import GL_VERSION


def make(
    scenario_name: str = "",
    scenario_cfg: dict[str, Any] | None = None,
    gl_version: int = GL_VERSION.OPENGL4,
    window_res: Sequence[int] | None = None,
    verbose: bool = False,
    show_viewport: bool = True,
    ticks_per_sec: int | None = None,
    frames_per_sec: Any = None,
    copy_state: bool = True,
    start_world: bool = True,
    *,
    seed: int | None = None,
    legacy_dynamics: bool | None = None,
    strict: bool | None = None,
) -> HoloOceanEnvironment:
    """An environment, reset.

    Args:
        scenario_name: "World-Scenario"; counts before `scenario_cfg`.
        scenario_cfg: a scenario, with `package_name` and `world`.
        gl_version, window_res, show_viewport, frames_per_sec: accepted; there is no window.
        verbose: accepted.
        ticks_per_sec: instead of the scenario's.
        copy_state: states are copies; otherwise they hold every sensor's newest value, without the time.
        start_world: accepted; there is no engine to attach to.
        seed: of every random stream: the same numbers again; without one it is drawn, and `env.seed` says it.
        legacy_dynamics: HoloOcean's own force model for its native agents.
        strict: unknown keys are errors.

    Raises:
        HoloOceanException: neither a name nor a scenario, or one that cannot be.
        FileNotFoundError: no scenario of this name.
        KeyError: a key that a scenario must have is missing.
    """
    if scenario_name:
        scenario = packagemanager.get_scenario(scenario_name)
    elif scenario_cfg is not None:
        scenario = scenario_cfg
        _ = scenario["package_name"]
    else:
        raise HoloOceanException("make needs the name of a scenario, or scenario_cfg")
    steps = 2
    package = packagemanager.get_package_config_for_scenario(scenario)
    world = next(w for w in package["worlds"] if w["name"] == scenario["world"])
    steps = int(world.get("pre_start_steps", steps))
    for key in ("env_min", "env_max"):
        if key not in scenario and key in world:
            scenario[key] = world[key]
    return HoloOceanEnvironment(
        scenario=scenario, window_size=window_res, start_world=start_world, gl_version=gl_version, verbose=verbose,
        pre_start_steps=steps, show_viewport=show_viewport, ticks_per_sec=ticks_per_sec, frames_per_sec=frames_per_sec,
        copy_state=copy_state, seed=seed, legacy_dynamics=legacy_dynamics, strict=strict,
    )  # fmt: skip
