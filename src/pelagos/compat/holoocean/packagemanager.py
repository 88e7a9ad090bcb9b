"""HoloOcean's package manager: packages and scenarios come with Pelagos, so that nothing is ever downloaded.

Scenarios of a user's own are found where HoloOcean keeps them: `{World}-{Name}.json` in any folder below `worlds` of
`util.get_holoocean_path()`. A shipped scenario of the same name comes first.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pelagos.compat.holoocean import util
from pelagos.compat.holoocean.exceptions import HoloOceanException, NotFoundException
from pelagos.compat.holoocean.worlds import PACKAGES, package_configs
from pelagos.errors import did_you_mean

__all__ = [
    "available_packages",
    "get_binary_path_for_package",
    "get_binary_path_for_scenario",
    "get_package_config_for_scenario",
    "get_scenario",
    "install",
    "installed_packages",
    "load_scenario_file",
    "package_info",
    "prune",
    "remove",
    "remove_all_packages",
    "scenario_info",
    "set_world_version",
    "world_info",
]


def available_packages() -> list[str]:
    """Names of the packages; all of them are installed."""
    return list(package_configs())


def installed_packages() -> list[str]:
    """Names of the packages."""
    return list(package_configs())


def install(package_name: str, url: str | None = None, branch: str | None = None, commit: str | None = None) -> None:
    """Say that the package is there already, or which packages there are; nothing is downloaded.

    Args:
        package_name: such as "Ocean".
        url, branch, commit: where HoloOcean would load it from; without effect, and the message says so.
    """
    packages = package_configs()
    if package_name not in packages:
        hint = did_you_mean(package_name, packages)
        print(f"There is no package {package_name!r}; Pelagos has {', '.join(packages)}{hint}")
        return
    asked = [name for name, value in (("url", url), ("branch", branch), ("commit", commit)) if value is not None]
    unused = f" ({', '.join(asked)}: without effect)" if asked else ""
    print(f"{package_name} comes with Pelagos: nothing to install{unused}.")


def remove(package_name: str) -> None:
    """Say that the package comes with Pelagos and stays.

    Raises:
        NotFoundException: no such package.
    """
    _config(package_name)
    print(f"{package_name} comes with Pelagos and stays: nothing was removed.")


def remove_all_packages() -> None:
    """Say of each package that it stays."""
    for name in package_configs():
        remove(name)


def prune() -> None:
    """Say that no older versions are kept."""
    print("Packages come with Pelagos, in one version: there is nothing to prune.")


def package_info(package_name: str) -> None:
    """Print a package: its version, its worlds and their scenarios.

    Raises:
        NotFoundException: no such package.
    """
    config = _config(package_name)
    print(f"Package: {config['name']}")
    print(f"  Platform: {config['platform']}")
    print(f"  Version: {config['version']}")
    print("  Worlds:")
    for entry in config["worlds"]:
        world_info(entry["name"], world_config=entry, base_indent=4)


def world_info(world_name: str, world_config: dict[str, Any] | None = None, base_indent: int = 0) -> None:
    """Print a world and its scenarios.

    Args:
        world_name: such as "Dam".
        world_config: its entry in the package's `config.json`; found by name where not given.
        base_indent: blanks before each line.

    Raises:
        HoloOceanException: no such world.
    """
    entry = _world_entry(world_name)[1] if world_config is None else world_config
    print(" " * base_indent + str(entry["name"]))
    print(" " * (base_indent + 2) + f"Bounds [m]: {entry['env_min']} to {entry['env_max']}")
    print(" " * (base_indent + 2) + "Scenarios:")
    for scenario, _ in _iter_scenarios(world_name):
        scenario_info(scenario=scenario, base_indent=base_indent + 4)


def scenario_info(scenario_name: str = "", scenario: dict[str, Any] | None = None, base_indent: int = 0) -> None:
    """Print a scenario: its agents and their sensors.

    Args:
        scenario_name: such as "Dam-Hovering"; used where no scenario is given.
        scenario: the scenario.
        base_indent: blanks before each line.

    Raises:
        FileNotFoundError: no scenario has this name.
    """
    told = get_scenario(scenario_name) if scenario is None else scenario
    print(" " * base_indent + f"{told['world']}-{told['name']}")
    print(" " * (base_indent + 2) + "Agents:")
    for agent in told.get("agents", ()):
        print(" " * (base_indent + 4) + f"Name: {agent.get('agent_name', '')}")
        print(" " * (base_indent + 4) + f"Type: {agent.get('agent_type', '')}")
        print(" " * (base_indent + 4) + "Sensors:")
        for sensor in agent.get("sensors", ()):
            kind = sensor.get("sensor_type", "")
            name = sensor.get("sensor_name", kind)
            print(" " * (base_indent + 6) + (kind if name == kind else f"{name} ({kind})"))


def get_scenario(scenario_name: str) -> dict[str, Any]:
    """A fresh copy of a scenario, by "World-Name".

    Raises:
        FileNotFoundError: no scenario has this name; the message names the nearest.
    """
    files = _files()
    if scenario_name not in files:
        hint = did_you_mean(scenario_name, files)
        raise FileNotFoundError(f"no scenario {scenario_name!r}{hint}; there are {', '.join(sorted(files))}")
    return load_scenario_file(files[scenario_name])


def load_scenario_file(scenario_path: str | Path) -> dict[str, Any]:
    """A scenario from a file of JSON.

    Raises:
        FileNotFoundError: no such file.
        HoloOceanException: the file is not a scenario in JSON; the message names the line.
    """
    try:
        loaded = json.loads(Path(scenario_path).read_text(encoding="utf-8"))
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise HoloOceanException(f"{scenario_path}: not JSON: {error}") from None
    if not isinstance(loaded, dict):
        raise HoloOceanException(f"{scenario_path}: a scenario is a mapping, not a {type(loaded).__name__}")
    return loaded


def get_binary_path_for_package(package_name: str) -> str:
    """The folder of a package's data: Pelagos has no binaries.

    Raises:
        NotFoundException: no such package.
    """
    _config(package_name)
    return str(PACKAGES / package_name)


def get_binary_path_for_scenario(scenario_name: str) -> str:
    """The folder of the package that has the scenario's world.

    Raises:
        FileNotFoundError: no scenario has this name.
        HoloOceanException: no package has its world.
    """
    return get_binary_path_for_package(get_package_config_for_scenario(get_scenario(scenario_name))["name"])


def get_package_config_for_scenario(scenario: dict[str, Any]) -> dict[str, Any]:
    """`config.json` of the package that has the scenario's world.

    Raises:
        KeyError: the scenario names no world.
        HoloOceanException: no package has this world; the message names the nearest.
    """
    return _world_entry(scenario["world"])[0]


def set_world_version(version: str) -> str:
    """The version of the packages that go with a version of HoloOcean: from 2.1.0 on patches share their worlds."""
    numbers = version.split(".")
    if len(numbers) == 3 and all(n.isdigit() for n in numbers) and (int(numbers[0]), int(numbers[1])) >= (2, 1):
        return f"{numbers[0]}.{numbers[1]}.0"
    return version


def _config(package_name: str) -> dict[str, Any]:
    packages = package_configs()
    if package_name not in packages:
        hint = did_you_mean(package_name, packages)
        raise NotFoundException(f"no package {package_name!r}; there are {', '.join(packages)}{hint}")
    return packages[package_name]


def _world_entry(world_name: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """The package's configuration and the world's entry in it."""
    packages = package_configs()
    for config in packages.values():
        for entry in config["worlds"]:
            if entry["name"] == world_name:
                return config, entry
    worlds = [entry["name"] for config in packages.values() for entry in config["worlds"]]
    hint = did_you_mean(world_name, worlds)
    raise HoloOceanException(f"no package has a world {world_name!r}; there are {', '.join(worlds)}{hint}")


def _iter_packages() -> Iterator[tuple[dict[str, Any], str]]:
    """`config.json` and folder of each package."""
    for name, config in package_configs().items():
        yield config, str(PACKAGES / name)


def _iter_scenarios(world_name: str) -> Iterator[tuple[dict[str, Any], str]]:
    """Scenario and file of each scenario of a world: the shipped ones, then the user's own with other names."""
    for name, path in _files().items():
        if name.split("-")[0] == world_name:
            yield load_scenario_file(path), str(path)


def _files() -> dict[str, Path]:
    """The file of each scenario by "World-Name"."""
    found: dict[str, Path] = {}
    for folder in (PACKAGES, Path(util.get_holoocean_path()) / "worlds"):
        for path in sorted(folder.glob("*/*-*.json")):
            found.setdefault(path.stem, path)
    return found
