"""`pelagos check`: what a scenario would simulate, without a device."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import Final

from rich.markup import escape
from rich.table import Table

from pelagos.cli.console import out
from pelagos.cli.doors import check_doors, door_place
from pelagos.cli.trusted import load
from pelagos.config.agent import Agent, Start
from pelagos.config.loader import to_yaml
from pelagos.config.mission import (
    Dive,
    Dock,
    Drift,
    Follow,
    Goto,
    GpsFix,
    Hold,
    Land,
    Lawnmower,
    Leg,
    Levelled,
    Orbit,
    Profile,
    Repeat,
    StationKeeping,
    Surface,
    Survey,
    Until,
    Waypoints,
)
from pelagos.config.scenario import Scenario
from pelagos.config.swarm import member_names
from pelagos.errors import DeviceError

SHOWN: Final = 20
"""Agents of a scenario that are printed one by one."""


def check_scenario(
    path: Path, changes: Sequence[str], *, resolved: bool, trust: bool = False, build: bool = True
) -> None:
    """Print a summary, or the scenario with every default written out.

    With `build`, everything is built once as `pelagos run` builds it; the parts that need a device only where there is
    one.
    """
    show_check(load(path, changes, trust=trust), str(path), resolved=resolved, build=build)


def show_check(scenario: Scenario, title: str, *, resolved: bool = False, build: bool = True) -> None:
    """Check what is known without a world, and print as `check_scenario` does."""
    from pelagos.sim.control import first_mode
    from pelagos.sim.model import check_hearing, vehicles_of

    _check_ocean(scenario)
    check_hearing(scenario)
    modes = {name: first_mode(scenario, name, vehicle) for name, vehicle in vehicles_of(scenario).items()}
    if resolved:
        out.print(to_yaml(scenario), end="", markup=False)
        return
    built = _built(scenario) if build else False
    note = "" if built else " (sensors and starts are not built: " + ("no device)" if build else "--no-build)")
    out.print(f"{escape(title)}: [green]a valid scenario[/green]{note}")
    out.print(_summary(scenario))
    for name, agent in islice(scenario.agents.items(), SHOWN):
        many = "" if agent.count is None else f", {agent.count} of them: {name}\\[0] to {name}\\[{agent.count - 1}]"
        out.print(f"\n[bold]{name}[/bold]{many}")
        out.print(_agent(agent, modes[member_names(name, agent.count)[0]]))
        if agent.sensors:
            out.print(_sensors(agent, scenario.tick_rate_hz))
    if len(scenario.agents) > SHOWN:
        out.print(f"\nand {len(scenario.agents) - SHOWN} more agents; --resolved prints every one")
    if scenario.bridges:
        out.print()
        out.print(_doors(scenario))


def _doors(scenario: Scenario) -> Table:
    """The scenario's bridges, and where they are."""
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for column in ("bridge", "type", "place"):
        table.add_column(column)
    for name, config in scenario.bridges.items():
        table.add_row(escape(name), config.type, escape(door_place(config)))
    return table


def _built(scenario: Scenario) -> bool:
    """Build what a run would build, and refuse what it would refuse; False where a device was missing for that."""
    from pelagos.sim.simulation import Simulation
    from pelagos.world.build import build_world

    try:
        check_doors(Simulation.load(scenario), scenario.bridges)
    except DeviceError:
        build_world(scenario.located_world)
        return False
    return True


def _check_ocean(scenario: Scenario) -> None:
    """Refuse files of the ocean that a run would refuse, as far as the world is known before it is built."""
    from pelagos.math.geodesy import GeoOrigin
    from pelagos.ocean.config import check_files
    from pelagos.ocean.site import Site

    place = scenario.origin or scenario.world
    latitude, longitude = getattr(place, "latitude_deg", None), getattr(place, "longitude_deg", None)
    if latitude is not None and longitude is not None:
        around = ((-1.0, -1.0, -1.0), (1.0, 1.0, 0.0))
        check_files(scenario.ocean, Site(GeoOrigin(latitude, longitude), around, duration_s=scenario.duration_s))


def _summary(scenario: Scenario) -> Table:
    table = _grid()
    table.add_row("name", escape(scenario.name))
    if scenario.description:
        table.add_row("", escape(" ".join(scenario.description.split())))
    table.add_row("world", scenario.world.type)
    if scenario.origin is not None:
        place = scenario.origin
        table.add_row("origin", f"latitude {place.latitude_deg:g} deg, longitude {place.longitude_deg:g} deg")
    ticks = math.floor(scenario.duration_s * scenario.tick_rate_hz + 1e-6)
    table.add_row("duration", f"at most {scenario.duration_s:g} s: {ticks} ticks of {scenario.dt_ns * 1e-6:g} ms")
    table.add_row("seed", str(scenario.seed))
    return table


def _agent(agent: Agent, mode: str) -> Table:
    table = _grid()
    table.add_row("vehicle", agent.vehicle.type)
    table.add_row("start", _start(agent.start))
    table.add_row("control", mode)
    if agent.command is not None:
        table.add_row("command", ", ".join(f"{c:g}" for c in agent.command))
    for number, leg in enumerate(agent.mission, 1):
        table.add_row("mission" if number == 1 else "", f"{number}. {describe(leg)}")
    return table


def _sensors(agent: Agent, tick_rate_hz: float) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for column in ("sensor", "type"):
        table.add_column(column)
    for column in ("rate [Hz]", "every"):
        table.add_column(column, justify="right")
    table.add_column("place x, y, z [m]")
    for name, config in agent.sensors.items():
        every = round(tick_rate_hz / config.rate_hz)
        place = ", ".join(f"{c:g}" for c in config.position_m)
        table.add_row(name, config.type, f"{config.rate_hz:g}", f"{every} tick{'s' if every > 1 else ''}", place)
    return table


def describe(leg: Leg) -> str:
    """One leg of a mission in words."""
    return _words(leg) + ("" if leg.until is None else f", until {_until(leg.until)}")


def _words(leg: Leg) -> str:
    match leg:
        case Dive():
            return f"dive to {_level(leg)}"
        case Waypoints() | Goto():
            plural = "s" if len(leg.points) > 1 else ""
            verb = "pass" if leg.type == "waypoints" else "go to"
            return f"{verb} {len(leg.points)} point{plural}{_at(leg)}{_speed(leg.speed_mps)}"
        case Lawnmower():
            lines = math.floor(leg.width_m / leg.spacing_m + 1e-9) + 1
            return (
                f"lawn-mower pattern: {lines} lines of {leg.length_m:g} m, {leg.spacing_m:g} m apart, "
                f"heading {leg.heading_deg:g} deg,{_at(leg)}{_speed(leg.speed_mps)}"
            )
        case Survey():
            apart = f"{leg.spacing_m:g} m" if leg.spacing_m is not None else f"a swath of {leg.swath_deg:g} deg"
            return f"survey an area of {len(leg.area)} corners, lines {apart} apart{_at(leg)}{_speed(leg.speed_mps)}"
        case Orbit():
            return f"circle {leg.turns:g} times at {leg.radius_m:g} m, {leg.direction}{_at(leg)}{_speed(leg.speed_mps)}"
        case Profile():
            return f"up and down between {leg.upper_depth_m:g} and {leg.lower_depth_m:g} m depth"
        case Follow():
            what = leg.agent or (leg.pipeline if leg.wall is None else f"the wall that {leg.wall} sees")
            return f"follow {what}{_at(leg)}{_for(leg.seconds)}"
        case StationKeeping() | Drift():
            return f"{leg.type.replace('_', ' ')}{_at(leg)}{_for(leg.seconds)}"
        case Hold():
            return f"hold for {leg.seconds:g} s"
        case GpsFix():
            return f"wait for a position fix, at most {leg.timeout_s:g} s"
        case Repeat():
            last = "all legs before" if leg.last is None else f"the last {leg.last} legs"
            return f"repeat {last}, {leg.times} times"
        case Surface() | Dock() | Land():
            return leg.type


def _level(leg: Levelled) -> str:
    if leg.height_m is not None:
        return f"{leg.height_m:g} m height"
    return f"{leg.altitude_m:g} m altitude" if leg.depth_m is None else f"{leg.depth_m:g} m depth"


def _at(leg: Levelled) -> str:
    free = leg.depth_m is None and leg.altitude_m is None and leg.height_m is None
    return "" if free else f" at {_level(leg)}"


def _for(seconds: float | None) -> str:
    return "" if seconds is None else f" for {seconds:g} s"


def _until(until: Until) -> str:
    name = until.sensor if until.value is None else f"{until.sensor}.{until.value}"
    limits = [f"{word} {v:g}" for word, v in (("above", until.above), ("below", until.below)) if v is not None]
    return f"{name} is {' or '.join(limits)}"


def _speed(speed_mps: float | None) -> str:
    return "" if speed_mps is None else f", {speed_mps:g} m/s"


def _start(start: Start) -> str:
    x, y = start.position_m[:2]
    if len(start.position_m) == 3:
        height = f"z {start.position_m[2]:g} m"
    elif start.altitude_m is not None:
        height = f"altitude {start.altitude_m:g} m"
    else:
        height = f"depth {start.depth_m or 0:g} m"
    return f"x {x:g} m north, y {y:g} m west, {height}, heading {start.heading_deg:g} deg, {start.speed_mps:g} m/s"


def _grid() -> Table:
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column(style="dim", no_wrap=True)
    table.add_column()
    return table
