"""`pelagos run`: scenario to folder of results."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pelagos.cli.console import doing, out, shown
from pelagos.cli.doors import check_doors, doors_of, nothing_left, run_with_doors
from pelagos.cli.progress import RunProgress
from pelagos.cli.segments import Plan, run_segments
from pelagos.cli.signals import Stopping, interrupted
from pelagos.cli.trusted import load
from pelagos.cli.view import looked_at
from pelagos.config.loader import to_yaml
from pelagos.config.scenario import Scenario
from pelagos.errors import InputError, RecordingError
from pelagos.files import write_whole

if TYPE_CHECKING:
    from pelagos.report.legs import FlownLegs
    from pelagos.sim.run import RunResult
    from pelagos.sim.simulation import Simulation

LOOK_S: Final = 0.5  # how often a run sees whether its folder of results is still there


@dataclass(frozen=True)
class Options:
    """Options of the command line beside the scenario; see `pelagos run --help`."""

    duration_s: float | None = None
    seed: int | None = None
    copies: int = 1
    out: Path | None = None
    record: Path | None = None
    realtime: bool = False
    report: bool = True
    max_wall_s: float | None = None
    checkpoint_every_s: float | None = None
    resume: Path | None = None
    bridges: tuple[str, ...] = ()
    repeat: Path | None = None
    rosbag: bool = False
    trust: bool = False
    memory_limit: str | None = None
    view: bool = False
    browser: bool = True


def run_scenario(path: Path | None, changes: Sequence[str], options: Options) -> int:
    """Run, record, report.

    Returns:
        The exit code: 0, or where a signal ended the run 128 and the signal's number: 130 for Ctrl-C, 143 for SIGTERM.
    """
    _check(path, changes, options)
    with Stopping(max_wall_s=options.max_wall_s) as stopping:
        try:
            if options.resume is not None:
                return _resume(options.resume, options, stopping)
            assert path is not None
            return _run(path, changes, options, stopping)
        except BaseException as error:
            if stopping.signal is None or not interrupted(error):
                raise
            return stopping.exit_code


def _run(path: Path, changes: Sequence[str], options: Options, stopping: Stopping) -> int:
    with doing(f"loading {path}"):
        scenario = load(path, changes, overrides=_overrides(options), trust=options.trust)
    folder = results_folder(options.out, path)
    recording = options.record or folder / "mission.mcap"
    if recording.is_dir() or not (options.record is None or recording.parent.is_dir()):
        raise InputError(f"--record {recording}: give a file in a folder that exists")
    doors = doors_of(scenario, options.bridges)
    sim = _load(scenario, options.copies, options.memory_limit)
    check_doors(sim, doors)
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(folder / "scenario.yaml", to_yaml(scenario))
    stopping.guard(sim.stop)
    with looked_at(sim, view=options.view, browser=options.browser), RunProgress() as bar:
        progress = _watched(bar, folder, sim, stopping)
        if doors or options.repeat is not None:
            with nothing_left(folder, recording):
                result = run_with_doors(sim, doors, options, recording, progress)
        elif options.checkpoint_every_s is None:
            result = sim.run(options.duration_s, record=recording, progress=progress, realtime=options.realtime)
        else:
            from pelagos.sim.run_log import open_recorder

            plan = Plan(
                scenario.duration_s, options.duration_s is None, options.checkpoint_every_s,
                _seen_from(folder, recording), options.realtime,
            )  # fmt: skip
            plan.save(folder)
            with open_recorder(recording, sim) as recorder:
                result = run_segments(sim, recorder, folder, plan, stopping, progress)
    return _finish(folder, recording, sim, result, options, stopping)


def _resume(folder: Path, options: Options, stopping: Stopping) -> int:
    """Go on with the run whose results are in a folder, from its last checkpoint."""
    from pelagos.sim.resume import last_checkpoint, resumed_recorder

    plan, kept = Plan.load(folder), last_checkpoint(folder)
    if options.checkpoint_every_s is not None:
        plan = replace(plan, every_s=options.checkpoint_every_s)
    sim = _load(load(folder / "scenario.yaml", trust=options.trust), kept.n, options.memory_limit)
    sim.restore(kept)
    recording = folder / plan.recording
    stopping.guard(sim.stop)
    out.print(f"going on from {kept.time_ns * 1e-9:.1f} s", markup=False)
    with (
        looked_at(sim, view=options.view, browser=options.browser),
        resumed_recorder(recording, sim) as recorder,
        RunProgress() as bar,
    ):
        result = run_segments(sim, recorder, folder, plan, stopping, _watched(bar, folder, sim, stopping))
    return _finish(folder, recording, sim, result, options, stopping)


def _seen_from(folder: Path, recording: Path) -> str:
    """The recording's path from the folder on, or from the root where it lies elsewhere."""
    whole, base = recording.resolve(), folder.resolve()
    return str(whole.relative_to(base) if whole.is_relative_to(base) else whole)


def _watched(bar: RunProgress, folder: Path, sim: Simulation, stopping: Stopping) -> Callable[[float, float], None]:
    """Shows the progress, and ends a run that is to end, or whose folder of results is gone."""
    looked = time.monotonic()

    def progress(t_s: float, duration_s: float) -> None:
        nonlocal looked
        bar(t_s, duration_s)
        if stopping.asked:
            sim.stop()
        if time.monotonic() - looked > LOOK_S:
            looked = time.monotonic()
            if not folder.is_dir():
                raise RecordingError(f"{folder}: the folder of results was removed during the run")

    return progress


def _finish(
    folder: Path, recording: Path, sim: Simulation, result: RunResult, options: Options, stopping: Stopping
) -> int:
    if stopping.signal is not None:
        result = replace(result, ended="interrupt")
    if options.rosbag:
        from pelagos.bridges.rosbag import write_rosbag

        write_rosbag(recording, folder / "rosbag2")
    _say(result, sim.n, overdue=stopping.overdue)
    legs = _say_missions(sim, recording)
    if options.report:
        _report(folder, recording, sim, result, legs)
    out.print(f"results: {shown(folder)}", markup=False)
    for file in sorted({file.resolve() for file in (*folder.iterdir(), recording)}):
        out.print(f"  {shown(file)}", markup=False)
    return stopping.exit_code if result.ended == "interrupt" else 0


def _check(path: Path | None, changes: Sequence[str], options: Options) -> None:
    """Refuse options that exclude one another, and lengths of time that are none."""
    for name, value in (("--max-wall", options.max_wall_s), ("--checkpoint-every", options.checkpoint_every_s)):
        if value is not None and not (math.isfinite(value) and value > 0):
            raise InputError(f"{name} must be a positive number of seconds, not {value:g}")
    if not (options.browser or options.view):
        raise InputError("--no-browser is about the page of --view; give both")
    if options.resume is None:
        if path is None:
            raise InputError("give a scenario file, or --resume and a folder of results")
        return
    given = {
        "a scenario": path, "--set": changes or None, "--duration": options.duration_s, "--seed": options.seed,
        "--out": options.out, "--record": options.record, "--n": None if options.copies == 1 else options.copies,
        "--realtime": options.realtime or None,
    }  # fmt: skip
    other = [name for name, value in given.items() if value is not None]
    if other:
        raise InputError(f"--resume takes these from the folder of results; leave out {', '.join(other)}")
    if options.bridges or options.repeat is not None:
        raise InputError("--resume goes on with a run that nobody outside commands; leave out bridges and --repeat")


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


def _load(scenario: Scenario, copies: int, memory_limit: str | None) -> Simulation:
    from pelagos.sim.cost import BLOCK_S, check_memory, parsed_size

    limit = None if memory_limit is None else parsed_size(memory_limit)
    check_memory(scenario, copies, limit, block_s=BLOCK_S)
    with doing("building the world, the vehicles and their sensors"):
        from pelagos.sim.simulation import Simulation

        return Simulation.load(scenario, n=copies, memory_limit=limit)


def _say(result: RunResult, n: int, *, overdue: bool) -> None:
    words = {
        "time": "done",
        "missions": "every mission ended",
        "interrupt": "stopped; everything until here is recorded",
        "stopped": "the wall-clock time is over; everything until here is recorded" if overdue else "stopped",
    }
    copies = f" of {n} copies" if n > 1 else ""
    out.print(
        f"{words[result.ended]}: {result.simulated_s:.1f} s{copies} simulated in {result.wall_s:.1f} s, "
        f"{result.real_time_factor:.1f} x real time"
    )


def _say_missions(sim: Simulation, recording: Path) -> FlownLegs:
    """Tell how far every mission came, and how near to its way the vehicle kept."""
    if not sim.stepper.missions.guidance:
        return {}
    from pelagos.report.legs import flown_legs, legs_lines

    flown = flown_legs(sim, recording)
    for line in legs_lines(flown, sim.time_ns * 1e-9):
        out.print(f"  {line}", markup=False)
    return flown


def _report(folder: Path, recording: Path, sim: Simulation, result: RunResult, legs: FlownLegs) -> None:
    from pelagos.report.report import write_report

    with doing("writing the report"):
        write_report(folder, recording, sim, result, legs=legs)
