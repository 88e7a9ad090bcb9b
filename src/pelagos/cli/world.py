"""`pelagos world`: the world of a scenario as numbers, pictures, a page, or files that other programs read."""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from rich.markup import escape
from rich.table import Table

from pelagos.cli.console import err, out, shown
from pelagos.cli.stages import Stages
from pelagos.cli.trusted import load
from pelagos.config.scenario import Scenario
from pelagos.errors import InputError, LookupFailed, WorldError
from pelagos.files import write_whole
from pelagos.sim.memory import peak_memory_mb

if TYPE_CHECKING:
    from pelagos.world.world import World

SUFFIXES: Final = (".png", ".html", ".glb", ".npz", ".json")
"""What `--out` may end in; without a suffix it is a folder."""


def show_world(
    path: Path, changes: Sequence[str], outs: Sequence[Path], *, samples: int, at_s: float = 0.0, trust: bool = False
) -> None:
    """Build the world, print its statistics, and write what was asked for, movers where they are at `at_s` [s].

    Raises:
        InputError: an output of an unknown kind, or in a folder that does not exist.
        WorldError: the world cannot be built.
    """
    _check(outs)
    scenario = load(path, changes, trust=trust)
    pictures = any(o.suffix.lower() in (".png", ".html") for o in outs)
    steps = 1 + len(outs) + (5 + bool(scenario.world.movers) if pictures else 0)
    with Stages(steps) as stage, tempfile.TemporaryDirectory() as folder:
        stage("building the world")
        started = time.perf_counter()
        world = _built(scenario)
        seconds = time.perf_counter() - started
        from pelagos.world.large.picture import pictured
        from pelagos.world.preview import statistics

        stats = statistics(world) | {"generation_s": seconds, "peak_memory_mb": peak_memory_mb() or 0.0}
        still = pictured(world.at_time(at_s)) if outs else world
        drawn = _pictures(still, Path(folder), stage, samples) if pictures else (Path(), [])
        for target in outs:
            stage(f"writing {shown(target)}")
            _write(world, stats, drawn, target, title=scenario.name, at_s=at_s)
    _print(scenario, world, stats)
    for target in outs:
        out.print(f"written: {shown(target)}", markup=False)


def _check(outs: Sequence[Path]) -> None:
    for target in outs:
        if target.suffix and target.suffix.lower() not in SUFFIXES:
            kinds = ", ".join(SUFFIXES)
            raise InputError(f"--out {target}: the suffix says what is written: {kinds}, or none for a folder of all")
        if target.suffix and target.is_dir():
            raise InputError(f"--out {target}: this is a folder; give a file")
        if not target.suffix and target.exists() and (not target.is_dir() or any(target.iterdir())):
            raise InputError(f"--out {target}: give a new or empty folder")
        if not target.parent.is_dir():
            raise InputError(f"--out {target}: the folder {target.parent} does not exist")


def _built(scenario: Scenario) -> World:
    from pelagos.world.build import build_world

    try:
        return build_world(scenario.located_world)
    except (WorldError, LookupFailed) as error:
        raise WorldError(f"{scenario.where('world')}: {error}") from error


def _pictures(
    world: World, folder: Path, stage: Callable[[str], None], samples: int
) -> tuple[Path, list[tuple[str, Path]]]:
    """The map and the views, as files in a folder."""
    from pelagos.world.preview import draw_map, render
    from pelagos.world.viewpoint import unroofed, viewpoints

    stage("drawing the map")
    world = unroofed(world)
    chart = draw_map(world, folder / "map.png")
    views = []
    for number, view in enumerate(viewpoints(world)):
        stage(f"drawing a view: {view.name}")
        file = folder / f"view{number}.png"
        render(world, file, eye=view.eye, target=view.target, samples=samples, exaggeration=view.exaggeration)
        views.append((view.name, file))
    return chart, views


def _write(
    world: World,
    stats: dict[str, Any],
    drawn: tuple[Path, list[tuple[str, Path]]],
    target: Path,
    *,
    title: str,
    at_s: float,
) -> None:
    from pelagos.world.export import export, save, save_glb
    from pelagos.world.large.picture import pictured
    from pelagos.world.sheet import draw_sheet, summary

    suffix = target.suffix.lower()
    if suffix == ".png":
        lines = [f"{what}: {value}" for what, value in summary(stats)]
        draw_sheet(target, title=world.description or title, map_png=drawn[0], views=drawn[1], lines=lines)
    elif suffix == ".html":
        from pelagos.report.world import world_page

        write_whole(target, world_page(world, stats, drawn[0], drawn[1], title=title))
    elif suffix == ".glb":
        save_glb(pictured(world.at_time(at_s)), target)
    elif suffix == ".npz":
        save(world, target)
    elif suffix == ".json":
        write_whole(target, json.dumps(stats, indent=1))
    else:
        export(world, target, t=at_s)


def _print(scenario: Scenario, world: World, stats: dict[str, Any]) -> None:
    from pelagos.world.sheet import summary

    out.print(f"[bold]{escape(scenario.name)}[/bold]: {escape(world.description or world.name)}")
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column(style="bold")
    table.add_column()
    for what, value in summary(stats):
        table.add_row(what, escape(value))
    out.print(table)
    for note in world.notes:
        err.print(f"note: {note}", markup=False)
