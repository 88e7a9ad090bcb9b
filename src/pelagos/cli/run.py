"""`pelagos run`: scenario to folder of results."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pelagos.cli.console import err, out, shown
from pelagos.cli.progress import RunProgress
from pelagos.config.loader import load_scenario, to_yaml
from pelagos.config.scenario import Scenario
from pelagos.errors import InputError

if TYPE_CHECKING:
    from pelagos.sim.run import RunResult
    from pelagos.sim.simulation import Simulation


@dataclass(frozen=True)
class Options:
    """What the command line says beside the scenario; see `pelagos run --help`."""

    duration_s: float | None = None
    seed: int | None = None
    copies: int = 1
    out: Path | None = None
    record: Path | None = None
    realtime: bool = False
    report: bool = True


def run_scenario(path: Path, changes: Sequence[str], options: Options) -> int:
    """Run, record, report.

    Returns:
        The exit code: 0, or 130 where Ctrl-C ended the run.
    """
    scenario = load_scenario(path, overrides=_overrides(options), changes=changes)
    folder = results_folder(options.out, path)
    recording = options.record or folder / "mission.mcap"
    if recording.is_dir() or not (options.record is None or recording.parent.is_dir()):
        raise InputError(f"--record {recording}: give a file in a folder that exists")
    sim = _load(scenario, options)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scenario.yaml").write_text(to_yaml(scenario), encoding="utf-8")
    with RunProgress() as progress:
        result = sim.run(options.duration_s, record=recording, progress=progress, realtime=options.realtime)
    _say(result, options)
    if options.report:
        _report(folder, recording, sim, result)
    out.print(f"results: {shown(folder)}", markup=False)
    for file in sorted({*folder.iterdir(), recording}):
        out.print(f"  {shown(file)}", markup=False)
    return 130 if result.ended == "interrupt" else 0


def results_folder(asked: Path | None, scenario: Path) -> Path:
    """The folder to write to: the one asked for, or the next free `results/<scenario>-<number>`.

    Raises:
        InputError: the folder holds something already, or is a file.
    """
    if asked is None:
        number = 1
        while (Path("results") / f"{scenario.stem}-{number}").exists():
            number += 1
        return Path("results") / f"{scenario.stem}-{number}"
    if asked.exists() and not asked.is_dir():
        raise InputError(f"--out {asked}: this is a file; give a folder")
    if asked.is_dir() and any(asked.iterdir()):
        raise InputError(f"--out {asked}: the folder is not empty; give another, or empty it first")
    return asked


def _overrides(options: Options) -> dict[str, Any]:
    given: dict[str, Any] = {}
    if options.seed is not None:
        if not 0 <= options.seed < 2**63:
            raise InputError(f"--seed must be a whole number from 0 on, not {options.seed}")
        given["seed"] = options.seed
    if options.duration_s is not None:
        if not (math.isfinite(options.duration_s) and options.duration_s > 0):
            raise InputError(f"--duration must be a positive number of seconds, not {options.duration_s:g}")
        given["duration_s"] = options.duration_s
    return given


def _load(scenario: Scenario, options: Options) -> Simulation:
    with err.status("loading the simulator"):
        from pelagos.sim.simulation import Simulation
    with err.status("building the world, the vehicles and their sensors"):
        return Simulation.load(scenario, n=options.copies)


def _say(result: RunResult, options: Options) -> None:
    words = {
        "time": "done",
        "missions": "every mission ended",
        "interrupt": "stopped; everything until here is recorded",
        "stopped": "stopped by the program",
    }
    copies = f" of {options.copies} copies" if options.copies > 1 else ""
    out.print(
        f"{words[result.ended]}: {result.simulated_s:.1f} s{copies} simulated in {result.wall_s:.1f} s, "
        f"{result.real_time_factor:.1f} x real time"
    )


def _report(folder: Path, recording: Path, sim: Simulation, result: RunResult) -> None:
    from pelagos.report.report import write_report

    try:
        with err.status("writing the report (Ctrl-C to skip)"):
            write_report(folder, recording, sim, result)
    except KeyboardInterrupt:
        out.print("no report was written")
