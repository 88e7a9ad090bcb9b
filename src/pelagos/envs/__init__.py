"""Environments for reinforcement learning: a task, and thousands of copies of a vehicle, in one kernel a step.

    import pelagos.envs

    env = pelagos.envs.make("pelagos/Hover-v0", n=4096)  # a gymnasium.vector.VectorEnv
    observations, info = env.reset(seed=0)

Needs the extra `envs`: `pip install 'pelagos[envs]'`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pelagos.envs.draws import Draws as Draws
    from pelagos.envs.fleet import FleetEnv as FleetEnv
    from pelagos.envs.registry import make as make
    from pelagos.envs.registry import make_task as make_task
    from pelagos.envs.registry import register as register
    from pelagos.envs.registry import task_names as task_names
    from pelagos.envs.sensing import Judgement as Judgement
    from pelagos.envs.sensing import SensingEnv as SensingEnv
    from pelagos.envs.sensing import SensingTask as SensingTask
    from pelagos.envs.single import SingleEnv as SingleEnv
    from pelagos.envs.task import Outcome as Outcome
    from pelagos.envs.task import Sea as Sea
    from pelagos.envs.task import Start as Start
    from pelagos.envs.task import Task as Task
    from pelagos.envs.view import View as View

_HOMES = {
    "Draws": "draws", "FleetEnv": "fleet", "Judgement": "sensing", "Outcome": "task", "SensingEnv": "sensing",
    "Sea": "task", "SensingTask": "sensing", "SingleEnv": "single", "Start": "task", "Task": "task", "View": "view",
    "make": "registry", "make_task": "registry", "register": "registry", "task_names": "registry",
}  # fmt: skip

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        value = getattr(import_module(f"pelagos.envs.{_HOMES[name]}"), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
