"""HoloOcean's caches of octrees, which Pelagos does not have: scripts may ask for their removal all the same."""

from __future__ import annotations

import shutil
from pathlib import Path

from pelagos.compat.holoocean.exceptions import HoloOceanException
from pelagos.compat.holoocean.util import get_holoocean_path


def _folder() -> Path:
    return Path(get_holoocean_path()) / "worlds" / "Ocean" / "Octrees"


def delete_all_octrees() -> None:
    """Remove what HoloOcean itself left on this machine; nothing where there is none.

    The working directory stays as it is; HoloOcean changes it.
    """
    if _folder().is_dir():
        shutil.rmtree(_folder())


def delete_world_octrees(world: str) -> None:
    """The same of one world.

    Raises:
        HoloOceanException: a name that is no folder's.
    """
    if not world or Path(world).name != world:
        raise HoloOceanException(f"a world is named, not {world!r}")
    if (_folder() / world).is_dir():
        shutil.rmtree(_folder() / world)
