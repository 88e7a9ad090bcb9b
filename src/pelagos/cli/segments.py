"""A run in segments, with a checkpoint behind each, and what it takes to go on with it in another process."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pelagos.errors import InputError
from pelagos.files import write_whole

if TYPE_CHECKING:
    from pelagos.cli.signals import Stopping
    from pelagos.sim.record import Recorder
    from pelagos.sim.run import RunResult
    from pelagos.sim.simulation import Simulation

PLAN: Final = "run.json"


@dataclass(frozen=True)
class Plan:
    """Plan of a run.

    Attributes:
        duration_s: at most [s].
        until_missions_end: it ends with its missions.
        every_s: simulated time between two checkpoints [s].
        recording: the file, from the folder of results on where it lies in it: that may be moved or copied.
        realtime: no faster than the clock.
        settling: every mission has ended, and the rest of the duration is what a run goes on after that.
    """

    duration_s: float
    until_missions_end: bool
    every_s: float
    recording: str
    realtime: bool
    settling: bool = False

    def save(self, folder: Path) -> None:
        """Write it into the folder of results."""
        write_whole(folder / PLAN, json.dumps(asdict(self), indent=2) + "\n")

    @classmethod
    def load(cls, folder: Path) -> Plan:
        """That of a folder of results.

        Raises:
            InputError: the folder is none of a run with checkpoints.
        """
        try:
            return cls(**json.loads((folder / PLAN).read_text(encoding="utf-8")))
        except (OSError, ValueError, TypeError):
            raise InputError(f"--resume {folder}: give the folder of a run with --checkpoint-every") from None


def run_segments(
    sim: Simulation,
    recorder: Recorder,
    folder: Path,
    plan: Plan,
    stopping: Stopping,
    progress: Callable[[float, float], None],
) -> RunResult:
    """Run to the end of the plan from where the simulation stands, and keep a checkpoint behind each segment."""
    from pelagos.sim.resume import keep
    from pelagos.sim.run import SETTLE_S

    whole: RunResult | None = None
    step_s = sim.dt_ns * 1e-9

    def tell(begun: float, t_s: float, asked_s: float) -> None:
        progress(begun + t_s, plan.duration_s)
        if plan.until_missions_end and sim.stepper.missions_done():
            sim.stop()

    while (now := sim.time_ns * 1e-9) < plan.duration_s - 0.5 * step_s and not stopping.asked:
        due = (now // plan.every_s + 1) * plan.every_s
        part = sim.run(
            min(due, plan.duration_s) - now, record=recorder, realtime=plan.realtime, progress=partial(tell, now)
        )
        whole = part if whole is None else _joined(whole, part)
        if plan.until_missions_end and sim.stepper.missions_done():
            plan = replace(plan, until_missions_end=False, settling=True)
            plan = replace(plan, duration_s=min(plan.duration_s, sim.time_ns * 1e-9 + SETTLE_S))
        plan.save(folder)
        keep(sim, recorder, folder)
    if whole is None:
        raise InputError(f"--resume {folder}: this run has ended already")
    return replace(whole, ended="stopped" if stopping.asked else "missions" if plan.settling else "time")


def _joined(first: RunResult, second: RunResult) -> RunResult:
    newest: dict[str, Any] = {a: {**first.observations.get(a, {}), **new} for a, new in second.observations.items()}
    return replace(
        second,
        simulated_s=first.simulated_s + second.simulated_s,
        wall_s=first.wall_s + second.wall_s,
        counts={name: first.counts.get(name, 0) + count for name, count in second.counts.items()},
        observations=newest,
    )
