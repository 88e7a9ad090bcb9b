"""HoloOcean's interface, spoken by Pelagos: names, frames and units are translated; the native parts do the work.

    import pelagos.compat.holoocean as holoocean
    env = holoocean.make("PierHarbor-Hovering", seed=7)

`install()` registers the names `holoocean` and `holoocean.*`, so that scripts that import these run here;
`pelagos holoocean SCRIPT.py` does it for one program.
"""

from __future__ import annotations

from importlib import import_module
from types import ModuleType
from typing import Any, Final

MODULES: Final = (
    "agents", "bst_graph", "command", "environments", "exceptions", "fftwaves", "flashlight", "fossen_dynamics",
    "holoocean", "holooceanclient", "joint_constraints", "lcm", "packagemanager", "sensors", "shmem", "spaces",
    "tide_cycle", "tides", "time_cycle", "util", "weather",
)  # fmt: skip
"""What scripts import as `holoocean.x`, or reach as an attribute."""
_HOMES: Final = {
    "make": "making", "install": "importing", "delete_all_octrees": "octrees", "delete_world_octrees": "octrees",
}  # fmt: skip
__all__ = ["__version__", "make", "install", "delete_all_octrees", "delete_world_octrees", *MODULES]


def _module(name: str) -> ModuleType:
    return import_module(f"{__name__}.{name}")


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return _module("util").VERSION
    if name in MODULES:
        return _module(name)
    if name in _HOMES:
        value = getattr(_module(_HOMES[name]), name)
    else:
        packages = _module("packagemanager")
        if name not in packages.__all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = getattr(packages, name)
    globals()[name] = value
    return value
