"""`pelagos explain`: the five stops from a line of the scenario to a sensor's numbers."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, Final

import numpy as np
from rich.markup import escape
from rich.table import Table

from pelagos.cli.console import err, out, shown
from pelagos.cli.trusted import load
from pelagos.cli.walk import Passed, last_motion, rooms, walked
from pelagos.config import registry
from pelagos.config.described import descriptions
from pelagos.config.scenario import Scenario
from pelagos.errors import InputError, LookupFailed
from pelagos.sensors.sensor import SensorConfig
from pelagos.sensors.sonar.keys.devices import device

PHYSICS: Final = ("acoustics/", "optics/", "hydro/", "ocean/")


def explain_sensor(path: Path, changes: Sequence[str], name: str, *, at_s: float, trust: bool = False) -> None:
    """Print stops, configuration, sources and one reading's intermediate arrays.

    Raises:
        InputError: the scenario has no such sensor.
    """
    scenario = load(path, changes, trust=trust)
    agent, _, sensor = name.partition(".")
    config = _find(scenario, agent, sensor)
    component = registry.find("sensor", config.type).load()
    passed, arrays, t_s = _read(scenario, agent, sensor, at_s)
    out.print(f"[bold]{agent}.{sensor}[/bold]: {escape(registry.find('sensor', config.type).title)}\n")
    _print_stops(scenario, agent, sensor, component, passed)
    _print_config(config, component.Config)
    out.print("\n[bold]Sources[/bold]")
    for source in (*getattr(component, "SOURCES", ()), *_of_device(config)):
        out.print(f"  {escape(source)}")
    _print_arrays(arrays, t_s)


def _of_device(config: SensorConfig) -> list[str]:
    """Origin of the keys of a sensor's device: its sheet, or an assumption."""
    name = getattr(config, "device", None)
    if name is None:
        return []
    found = device(config.type, name)
    guessed = f"; assumed: {', '.join(found.assumed)}" if found.assumed else ""
    return [f"device {name}, {found.title}: {found.source}{guessed}"]


def _find(scenario: Scenario, agent: str, sensor: str) -> Any:
    if agent not in scenario.members:
        raise LookupFailed("agent", agent, scenario.members)
    sensors = scenario.members[agent].sensors
    if not sensor:
        raise InputError(f"name a sensor as AGENT.SENSOR: {', '.join(f'{agent}.{known}' for known in sensors)}")
    if sensor not in sensors:
        raise LookupFailed(f"sensor of {agent}", sensor, sensors)
    return sensors[sensor]


def _print_stops(scenario: Scenario, agent: str, sensor: str, component: Any, passed: list[Passed]) -> None:
    """The five stops, with every function that one reading really ran, in the order of their first calls."""
    module = inspect.getmodule(component)
    assert module is not None
    pattern = [address(f) for f in (component.Config, *_pattern(module))]
    inside = [p.address for p in passed if p.room.startswith("sensors/")]
    stops: list[tuple[str, Sequence[str]]] = [
        ("the scenario", [scenario.where("agents", agent, "sensors", sensor)]),
        ("its configuration and its rays", pattern),
        ("one reading", list(dict.fromkeys([address(component.sense), *inside]))),
        ("rays into the world", [p.address for p in passed if p.room.startswith("raycast/")]),
        ("physics", [p.address for p in passed if p.room.startswith(PHYSICS)]),
    ]
    for number, (what, addresses) in enumerate(stops, 1):
        for row, text in enumerate(addresses or ["none"]):
            out.print(f"{f'{number}  {what}' if row == 0 else '':36}{text}", markup=False)
    out.print(f"\n{len(rooms(passed))} files in all, those of mathematics included", markup=False)


def _pattern(module: ModuleType) -> list[Any]:
    """The pure functions of a sensor's own file, in the order of the file: ray pattern and physics."""
    own = [f for _, f in inspect.getmembers(module, inspect.isfunction) if f.__module__ == module.__name__]
    public = [f for f in own if not f.__name__.startswith("_")]
    return sorted(public, key=lambda f: f.__code__.co_firstlineno)


def address(thing: Any) -> str:
    """ "file:line name" of a class or function."""
    file = inspect.getsourcefile(thing)
    assert file is not None
    return f"{shown(file)}:{inspect.getsourcelines(thing)[1]} {thing.__qualname__}"


def _print_config(config: Any, model: Any) -> None:
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    out.print("\n[bold]Configuration[/bold]")
    texts = descriptions(model)
    for key, value in config.model_dump(mode="json").items():
        table.add_row(f"  {key}", escape(str(value)), escape(texts.get(key, "")))
    out.print(table, soft_wrap=False)


def _read(scenario: Scenario, agent: str, sensor: str, at_s: float) -> tuple[list[Passed], list[Any], float]:
    """One reading without a recording: the functions that ran, the arrays (name, values, unit), and its time [s]."""
    with err.status("reading the sensor once"):
        from pelagos.sim.simulation import Simulation

        sim = Simulation.load(scenario)
        if at_s > 0:
            sim.run(at_s)
        last = sim.stepper.tick
        built: Any = sim.model.agents[agent].sensors[sensor].sensor
        motion = last_motion(sim, agent)
        explains = hasattr(built, "explain")
        passed, found = walked(lambda: built.explain(motion) if explains else built.sense(motion))
        return passed, found if explains else _reading(found), last * sim.dt_ns * 1e-9


def _print_arrays(arrays: Sequence[Any], t_s: float) -> None:
    out.print(f"\n[bold]One reading at {t_s:g} s[/bold]")
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
