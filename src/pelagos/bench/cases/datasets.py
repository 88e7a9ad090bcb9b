"""Data sets: labelled pairs of sonar and camera a second, at random poses in random worlds."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.check import must

TASKS: Final = 200  # of Ray
WORLDS: Final = 8
PAIRS: Final = 16
CHANGES: Final = 4
_CONFIG: Final[dict[str, Any]] = {
    "seed": 3,
    "samples_per_world": PAIRS,
    "batch": 4,
    "formats": ["webdataset"],
    "vary": {"ocean.turbidity": {"log_uniform": [0.1, 2.0]}},
    "scenario": {
        "world": {
            "type": "generated",
            "size_m": [80, 80],
            "depth_m": 14,
            "objects": [{"kind": kind, "count": 25} for kind in ("boulder", "tyre", "barrel")],
        },
        "agents": {
            "rov": {
                "vehicle": "bluerov2_heavy",
                "sensors": {
                    "camera": {"type": "camera", "rate_hz": 2, "width_px": 640, "height_px": 480},
                    "sonar": {"type": "imaging_sonar", "rate_hz": 5, "beams": 512, "bins": 256},
                },
            }
        },
    },
}  # fmt: skip


def dataset_pairs_per_s() -> Measured:
    """Worlds, waters, poses, readings, labels and files, by a worker a core; the first world of each worker, which
    compiles kernels, is not counted."""
    from pelagos.datasets.config import load_config
    from pelagos.datasets.engine import Engine
    from pelagos.datasets.factory import make_dataset
    from pelagos.datasets.plan import plan_of

    marks: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        workers = os.cpu_count() or 1
        plan = plan_of(load_config({**_CONFIG, "worlds": workers + WORLDS}))
        made = make_dataset(
            plan,
            Path(folder) / "set",
            engine=Engine(workers),
            progress=lambda done, total: marks.append(time.perf_counter()),
        )
        must(made.made == plan.shards and made.digest != "", "the data set is not whole")
    rate = WORLDS * PAIRS / (marks[-1] - marks[workers])
    what = f"{WORLDS} worlds of {PAIRS} pairs by {workers} workers"
    return Measured(rate, detail=f"{what}; PNG and NPY in tar; depth, labels, instances, boxes")


def world_change_s() -> Measured:
    """`load_world` with another seed in the same water, until the first readings of all sensors."""
    from pelagos.sim.simulation import Simulation

    sim, took = Simulation.load(_CONFIG["scenario"]), []
    for seed in range(1, 2 + CHANGES):
        start, before = time.perf_counter(), sim.world
        readings = sim.load_world(seed=seed)["rov"]
        must(readings["camera"].data.std() > 0 and readings["sonar"].data.std() > 0, "a sensor sees nothing")
        must(sim.world is not before, "the world is the same")
        took.append(time.perf_counter() - start)
    return Measured(sorted(took[1:])[len(took[1:]) // 2], detail=f"the median of {CHANGES}; 75 things on 80 m x 80 m")


@dataclass(frozen=True)
class Nothing:
    """Work that is none: what is left is the engine's."""

    def open(self) -> Callable[[int], dict[str, Any]]:
        """Worker that does nothing."""
        return self.work

    def work(self, index: int) -> dict[str, Any]:
        """A record."""
        return {"index": index}


def ray_overhead_ms() -> Measured:
    """Pieces of work that do nothing, by two actors of a cluster on this machine, after the first two."""
    from pelagos.datasets.engine import Engine

    marks, seen = [], set()
    for record in Engine(workers=2, ray="local").run(Nothing(), range(TASKS)):
        marks.append(time.perf_counter())
        seen.add(record["index"])
    must(seen == set(range(TASKS)), "a piece of work is missing")
    return Measured(1e3 * (marks[-1] - marks[1]) / (TASKS - 2), detail=f"{TASKS} pieces, two actors, warm")


CASES: Final = (
    Case(
        name="world_change_s",
        title="Another world under a running simulation, to the first readings of camera and sonar",
        measure=world_change_s,
        unit="s",
        goal=0.5,
        better="lower",
        reference=Reference("Simulation.load of a harbour in the first spike", 2.4),
    ),
    Case(
        name="ray_overhead_ms",
        title="A piece of work by Ray, beyond the work (needs Ray)",
        measure=ray_overhead_ms,
        unit="ms",
        goal=20.0,
        better="lower",
        reference=Reference("an empty task of Ray alone, warm, in the first spike", 0.5),
    ),
    Case(
        name="dataset_pairs_per_s",
        title="Data set: sonar 512 x 256 and camera 640 x 480 with labels, random poses in random worlds",
        measure=dataset_pairs_per_s,
        unit="pairs/s",
        goal=15.0,
        better="higher",
        reference=Reference("a loop over Simulation.load in the first spike", 6.0),
    ),
)
