"""HoloOcean's caches of octrees, which Pelagos does not need: empty folders where scripts look for them."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pelagos.compat.holoocean.exceptions import HoloOceanException
from pelagos.compat.holoocean.packagemanager import get_package_config_for_scenario
from pelagos.compat.holoocean.util import get_holoocean_path, get_os_key


def _folder(package: str = "Ocean") -> Path:
    return Path(get_holoocean_path()) / "worlds" / package / get_os_key() / "Holodeck" / "Octrees"


def leave_folder(scenario: Mapping[str, Any]) -> None:
    """Make the empty folder of the cache that a scenario with `octree_min` and `octree_max` asks for.

    It is named by both sizes in centimetres. A home that can't be written to is left as it is.
    """
    if "octree_min" not in scenario or "octree_max" not in scenario:
        return
    package = str(get_package_config_for_scenario(dict(scenario))["name"])
    least, most = (int(float(scenario[f"octree_{key}"]) * 100) for key in ("min", "max"))
    try:
        (_folder(package) / str(scenario["world"]) / f"min{least}_max{most}").mkdir(parents=True, exist_ok=True)
    except OSError:
        return


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
    if world in ("", "..") or Path(world).name != world:
        raise HoloOceanException(f"a world is named, not {world!r}")
    if (_folder() / world).is_dir():
        shutil.rmtree(_folder() / world)
