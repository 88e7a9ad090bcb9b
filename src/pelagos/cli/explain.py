"""`pelagos explain`: the five stops from a line of the scenario to a sensor's numbers."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, Final

import numpy as np
from rich.markup import escape
from rich.table import Table

from pelagos.cli.console import err, out, shown
from pelagos.config import registry
from pelagos.config.loader import load_scenario
from pelagos.config.scenario import Scenario
from pelagos.errors import InputError, LookupFailed
from pelagos.sensors.sensor import SensorConfig
from pelagos.sensors.sonar.keys.devices import device

PHYSICS: Final = ("pelagos.acoustics.", "pelagos.optics.", "pelagos.hydro.", "pelagos.ocean.", "pelagos.sensors.noise")
CASTER: Final = "pelagos.raycast.caster"


def explain_sensor(path: Path, changes: Sequence[str], name: str, *, at_s: float) -> None:
    """Print stops, configuration, sources and one reading's intermediate arrays.

    Raises:
        InputError: the scenario has no such sensor.
    """
    scenario = load_scenario(path, changes=changes)
    agent, _, sensor = name.partition(".")
    config = _find(scenario, agent, sensor)
    component = registry.find("sensor", config.type).load()
    out.print(f"[bold]{agent}.{sensor}[/bold]: {escape(registry.find('sensor', config.type).title)}\n")
    _print_stops(scenario, agent, sensor, component)
    _print_config(config, component.Config)
    out.print("\n[bold]Sources[/bold]")
    for source in (*component.SOURCES, *_of_device(config)):
        out.print(f"  {escape(source)}")
    _print_arrays(scenario, agent, sensor, at_s)


def _of_device(config: SensorConfig) -> list[str]:
    """Where the keys of a sensor's device come from, and which of them no sheet says."""
    name = getattr(config, "device", None)
    if name is None:
        return []
    found = device(config.type, name)
    guessed = f"; assumed: {', '.join(found.assumed)}" if found.assumed else ""
    return [f"device {name}, {found.title}: {found.source}{guessed}"]


def _find(scenario: Scenario, agent: str, sensor: str) -> Any:
    if agent not in scenario.agents:
        raise LookupFailed("agent", agent, scenario.agents)
    sensors = scenario.agents[agent].sensors
    if not sensor:
        raise InputError(f"name a sensor as AGENT.SENSOR: {', '.join(f'{agent}.{known}' for known in sensors)}")
    if sensor not in sensors:
        raise LookupFailed(f"sensor of {agent}", sensor, sensors)
    return sensors[sensor]


def _print_stops(scenario: Scenario, agent: str, sensor: str, component: Any) -> None:
    module = inspect.getmodule(component)
    assert module is not None
    stops: list[tuple[str, Sequence[str]]] = [
        ("the scenario", [scenario.where("agents", agent, "sensors", sensor)]),
        ("its configuration and its rays", [address(f) for f in (component.Config, *_pattern(module))]),
        ("one reading", [address(component.sense)]),
        ("rays into the world", [address(f) for f in _used(module, (CASTER,))]),
        ("physics", [address(f) for f in _used(module, PHYSICS)]),
    ]
    for number, (what, addresses) in enumerate(stops, 1):
        for row, text in enumerate(addresses or ["none"]):
            out.print(f"{f'{number}  {what}' if row == 0 else '':36}{text}", markup=False)


def _pattern(module: ModuleType) -> list[Any]:
    """The pure functions of a sensor's own file, in the order of the file: ray pattern and physics."""
    own = [f for _, f in inspect.getmembers(module, inspect.isfunction) if f.__module__ == module.__name__]
    public = [f for f in own if not f.__name__.startswith("_")]
    return sorted(public, key=lambda f: f.__code__.co_firstlineno)


def _used(module: ModuleType, homes: tuple[str, ...]) -> list[Any]:
    """Functions of other modules, whose names begin with one of `homes`, that a sensor's module calls.

    It may call them through functions that it shares with other sensors.
    """
    found: dict[Any, None] = {}
    modules = [module]
    for at in modules:
        for function in _called(at):
            home = inspect.getmodule(function)
            if function.__module__.startswith(homes):
                found[function] = None
            elif home is not None and home.__name__.startswith("pelagos.sensors.") and home not in modules:
                modules.append(home)
    return sorted(found, key=lambda f: (f.__module__, f.__code__.co_firstlineno))


def _called(module: ModuleType) -> Iterator[Any]:
    """Functions of other modules that the code of a module names."""
    names = set(_names(compile(inspect.getsource(module), "", "exec")))
    for name, value in vars(module).items():
        if inspect.isfunction(value) and value.__module__ != module.__name__ and name in names:
            yield value
        elif inspect.ismodule(value) and value.__name__.startswith("pelagos.") and name in names:
            yield from (f for _, f in inspect.getmembers(value, inspect.isfunction) if f.__name__ in names)


def _names(code: CodeType) -> Iterator[str]:
    """What the functions inside some code name; not what its own statements name, which are the imports."""
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from constant.co_names
            yield from _names(constant)


def address(thing: Any) -> str:
    """ "file:line name" of a class or function."""
    file = inspect.getsourcefile(thing)
    assert file is not None
    return f"{shown(file)}:{inspect.getsourcelines(thing)[1]} {thing.__qualname__}"


def _print_config(config: Any, model: Any) -> None:
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    out.print("\n[bold]Configuration[/bold]")
    for key, value in config.model_dump(mode="json").items():
        table.add_row(f"  {key}", escape(str(value)), escape(model.model_fields[key].description or ""))
    out.print(table, soft_wrap=False)


def _print_arrays(scenario: Scenario, agent: str, sensor: str, at_s: float) -> None:
    with err.status("reading the sensor once"):
        from pelagos.sim.simulation import Simulation

        sim = Simulation.load(scenario)
        if at_s > 0:
            sim.run(at_s)
        trajectory = sim.stepper.trajectories[agent]
        last = trajectory.first_tick + trajectory.ticks - 1
        built = sim.model.agents[agent].sensors[sensor].sensor
        motion = sim.stepper.motion_of(range(last, last + 1), agent)
        arrays = built.explain(motion) if hasattr(built, "explain") else _reading(built.sense(motion))
    out.print(f"\n[bold]One reading at {last * sim.dt_ns * 1e-9:g} s[/bold]")
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for column in ("  array", "shape"):
        table.add_column(column)
    for column in ("min", "mean", "max"):
        table.add_column(column, justify="right")
    table.add_column("unit")
    for name, array, unit in arrays:
        table.add_row(f"  {escape(name)}", str(np.shape(array)), *_range(np.asarray(array)), escape(unit))
    out.print(table, soft_wrap=False)


def _reading(measurement: Any) -> list[tuple[str, Any, str]]:
    arrays = [("truth", measurement.truth, ""), ("data", measurement.data, "")]
    return arrays + [(name, values, "") for name, values in measurement.extras.items()]


def _range(array: Any) -> tuple[str, str, str]:
    if array.dtype == bool:
        array = array.astype(float)
    finite = np.abs(array[np.isfinite(array)]) if np.iscomplexobj(array) else array[np.isfinite(array)]
    if finite.size == 0:
        return ("none", "none", "none")
    return (f"{finite.min():.6g}", f"{finite.mean(dtype=np.float64):.6g}", f"{finite.max():.6g}")
