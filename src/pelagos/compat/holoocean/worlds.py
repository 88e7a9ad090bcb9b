"""HoloOcean's packages and worlds, and what each world is in Pelagos."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any, Final

from pelagos.compat.holoocean.exceptions import HoloOceanException, NotFoundException
from pelagos.errors import did_you_mean

PACKAGES: Final = Path(__file__).parent / "packages"
"""One folder a package: `config.json` names its worlds; the other files are its scenarios."""

_DRY: Final[dict[str, Any]] = {"wind": {"speed_mps": 0.0}}
_CLEAR: Final[dict[str, Any]] = {"temperature_c": 12.0, "salinity": 35.0, "water_type": "I", "turbidity": 0.3}
"""As clear as HoloOcean's water, in which a dam shows from 25 m away."""

_NATIVE: Final[dict[str, dict[str, Any]]] = {
    "Dam": {"world": {"type": "classic", "name": "dam"}, "ocean": _CLEAR},
    "OpenWater": {"world": {"type": "classic", "name": "open_water"}, "ocean": _CLEAR},
    "PierHarbor": {"world": {"type": "classic", "name": "pier_harbor"}, "ocean": _CLEAR},
    "Rooms": {"world": {"type": "classic", "name": "rooms"}, "ocean": _DRY},
    "SimpleUnderwater": {"world": {"type": "classic", "name": "simple_underwater"}, "ocean": _CLEAR},
    "FlatUnderwater": {"world": {"type": "classic", "name": "flat_underwater"}, "ocean": _CLEAR},
    "BusinessCampus": {"world": {"type": "classic", "name": "business_campus"}, "ocean": _DRY},
    "ExampleLevel": {"world": {"type": "classic", "name": "example_level"}, "ocean": _CLEAR},
    "TestWorld": {"world": {"type": "classic", "name": "test_world"}, "ocean": _CLEAR},
}


def package_configs() -> dict[str, dict[str, Any]]:
    """HoloOcean's `config.json` of each package, by name."""
    found = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(PACKAGES.glob("*/config.json"))]
    return {str(config["name"]): config for config in found}


def native_world(package_name: str, world: str) -> dict[str, Any]:
    """The fragment of a native scenario that stands for a world: its keys `world` and `ocean`.

    Args:
        package_name: such as "Ocean"; empty for any.
        world: such as "PierHarbor".

    Raises:
        NotFoundException: no such package.
        HoloOceanException: the package has no such world; the message names the nearest, or the package that has it.
    """
    packages = package_configs()
    if package_name and package_name not in packages:
        hint = did_you_mean(package_name, packages)
        raise NotFoundException(f"no package {package_name!r}; there are {', '.join(packages)}{hint}")
    homes = {entry["name"]: name for name, config in packages.items() for entry in config["worlds"]}
    if world not in homes:
        hint = did_you_mean(world, homes)
        raise HoloOceanException(f"no world {world!r}; there are {', '.join(homes)}{hint}")
    if package_name and homes[world] != package_name:
        raise HoloOceanException(f"the package {package_name!r} has no world {world!r}; it is in {homes[world]!r}")
    return copy.deepcopy(_NATIVE[world])
