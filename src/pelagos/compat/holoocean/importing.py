"""The names `holoocean` and `holoocean.*` for this process: other people's scripts import these."""

from __future__ import annotations

import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import sys
from collections.abc import Sequence
from types import ModuleType
from typing import Any, Final

OURS: Final = "pelagos.compat.holoocean"
NAME: Final = "holoocean"


class _Finder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds `holoocean.x` as `pelagos.compat.holoocean.x`: the same module under two names."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """A spec for the names that we have."""
        if fullname != NAME and not fullname.startswith(NAME + "."):
            return None
        if importlib.util.find_spec(OURS + fullname.removeprefix(NAME)) is None:
            return None
        return importlib.machinery.ModuleSpec(fullname, self, is_package=fullname == NAME)

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> ModuleType:
        """Our module itself."""
        return importlib.import_module(OURS + spec.name.removeprefix(NAME))

    def exec_module(self, module: ModuleType) -> None:
        """It has run already."""


def install(package_name: str | None = None, *arguments: Any, **keys: Any) -> None:
    """From now on `import holoocean` is Pelagos in this process; a real HoloOcean beside it is left alone until then.

    With the name of a package it is HoloOcean's own `install`, see `packagemanager.install`.

    Raises:
        ImportError: another `holoocean` was imported already.
    """
    if package_name is not None:
        from pelagos.compat.holoocean import packagemanager

        packagemanager.install(package_name, *arguments, **keys)
        return
    there = sys.modules.get(NAME)
    ours = importlib.import_module(OURS)
    if there is not None and there is not ours:
        raise ImportError(
            f"another holoocean is imported already, from {getattr(there, '__file__', '?')}; install Pelagos's first"
        )
    sys.modules[NAME] = ours
    for name, module in list(sys.modules.items()):
        if name.startswith(OURS + "."):
            sys.modules[NAME + name.removeprefix(OURS)] = module
    if not any(isinstance(f, _Finder) for f in sys.meta_path):
        sys.meta_path.insert(0, _Finder())
