"""Tasks by name, for Pelagos itself and for `gymnasium.make` and `gymnasium.make_vec`."""

from __future__ import annotations

import inspect
import math
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

from pelagos.envs.task import Task
from pelagos.errors import CommandError, LookupFailed

if TYPE_CHECKING:
    from pelagos.envs.fleet import FleetEnv
    from pelagos.envs.sensing import SensingEnv
    from pelagos.envs.single import SingleEnv

PREFIX: Final = "pelagos/"
TASKS: Final = {
    "Hover-v0": ("hover", "Hover"),
    "MarineGymHover-v0": ("marinegym_hover", "MarineGymHover"),
    "OceanScaleHover-v0": ("oceanscale_hover", "OceanScaleHover"),
    "Waypoint-v0": ("waypoint", "Waypoint"),
    "PathInCurrent-v0": ("path", "PathInCurrent"),
    "DepthHeading-v0": ("depth_heading", "DepthHeading"),
    "Docking-v0": ("docking", "Docking"),
    "StationKeeping-v0": ("station_keeping", "StationKeeping"),
    "GyreTransect-v0": ("gyre", "GyreTransect"),
    "WallInspection-v0": ("wall_inspection", "WallInspection"),
    "PipelineFollowing-v0": ("pipeline", "PipelineFollowing"),
    "TerrainFollowing-v0": ("terrain", "TerrainFollowing"),
    "ObstacleAvoidance-v0": ("obstacles", "ObstacleAvoidance"),
}
_OF_THE_FLEET: Final = ("seed", "environment", "autoreset", "arrays", "out_of_range")


def task_names() -> tuple[str, ...]:
    """Every task, as `make` takes it."""
    return tuple(PREFIX + name for name in TASKS)


def task_class(name: str) -> type[Any]:
    """The class of a task.

    Raises:
        LookupFailed: no such task.
    """
    short = name.removeprefix(PREFIX)
    if short not in TASKS:
        known = {f"{PREFIX}{k}" for k in TASKS}
        raise LookupFailed("task", name if name.startswith(PREFIX) else PREFIX + name, known)
    module, cls = TASKS[short]
    found: type[Any] = getattr(import_module(f"pelagos.envs.tasks.{module}"), cls)
    return found


def has_sensors(name: str) -> bool:
    """Whether a task has sensors in the loop: `make` gives a `SensingEnv` then.

    Raises:
        LookupFailed: no such task.
    """
    from pelagos.envs.sensing import SensingTask

    return SensingTask in task_class(name).__mro__


def make_task(name: str, **options: Any) -> Task:
    """A task by name, with its own options (`Hover(reach_m=...)`).

    Raises:
        LookupFailed: no such task, or option.
        CommandError: an option is no number, or below 0.
    """
    cls = task_class(name)
    known = [p for p in inspect.signature(cls).parameters if cls.__init__ is not object.__init__]
    for option, value in options.items():
        if option not in known:
            raise LookupFailed(f"option of {PREFIX}{name.removeprefix(PREFIX)}", option, [*known, *_OF_THE_FLEET])
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not number or not 0 <= value < math.inf:
            raise CommandError(f"{PREFIX}{name.removeprefix(PREFIX)}: {option} is a number from 0 on, not {value!r}")
    made: Task = cls(**options)
    return made


def make(name: str, n: int = 1, **options: Any) -> FleetEnv | SensingEnv:
    """`n` copies of a task as a `gymnasium.vector.VectorEnv`.

    Args:
        name: "pelagos/Hover-v0", see `task_names`.
        n: copies.
        options: of `FleetEnv` (seed, environment, autoreset, arrays, out_of_range) or `SensingEnv` (the first three),
            the others of the task.

    Raises:
        LookupFailed: no such task, or option.
        CommandError: Gymnasium is not installed, or an option cannot be.
    """
    _gymnasium()
    from pelagos.envs.fleet import FleetEnv
    from pelagos.envs.sensing import SensingEnv

    mine = {k: options.pop(k) for k in _OF_THE_FLEET if k in options}
    if not has_sensors(name):
        return FleetEnv(make_task(name, **options), n, **mine)
    for option in ("arrays", "out_of_range"):
        if option in mine:
            raise LookupFailed(f"option of {name}, a task with sensors,", option, ["seed", "environment", "autoreset"])
    made: Any = make_task(name, **options)
    return SensingEnv(made, n, **mine)


def make_vec(task: str, num_envs: int = 1, **options: Any) -> FleetEnv | SensingEnv:
    """Entry point of `gymnasium.make_vec`."""
    return make(task, num_envs, **options)


def make_single(task: str, render_mode: str | None = None, **options: Any) -> SingleEnv:
    """Entry point of `gymnasium.make`."""
    _gymnasium()
    from pelagos.envs.single import SingleEnv

    return SingleEnv(make(task, 1, autoreset="disabled", **options), render_mode=render_mode)


def register() -> None:
    """Tell Gymnasium about all tasks; its plug-in mechanism does so where Pelagos is installed."""
    from gymnasium.envs.registration import register as enter
    from gymnasium.envs.registration import registry

    here = "pelagos.envs.registry"
    for name in task_names():
        if name not in registry:
            enter(
                name,
                entry_point=f"{here}:make_single",
                vector_entry_point=f"{here}:make_vec",
                kwargs={"task": name},
                order_enforce=True,
            )


def _gymnasium() -> None:
    try:
        import gymnasium  # noqa: F401
    except ImportError:
        raise CommandError("environments need Gymnasium: pip install 'pelagos[envs]'") from None
