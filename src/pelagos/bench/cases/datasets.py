"""Data sets: labelled pairs of sonar and camera a second, at random poses in random worlds."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any, Final

from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.check import must

WORLDS: Final = 4
PAIRS: Final = 16
_CONFIG: Final[dict[str, Any]] = {
    "seed": 3,
    "worlds": 1 + WORLDS,
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
    """Worlds, waters, poses, readings, labels and files; the first world, which compiles kernels, is not counted."""
    from pelagos.datasets.config import load_config
    from pelagos.datasets.factory import make_dataset
    from pelagos.datasets.plan import plan_of

    marks: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        plan = plan_of(load_config(_CONFIG))
        made = make_dataset(plan, Path(folder) / "set", progress=lambda done, total: marks.append(time.perf_counter()))
        must(made.made == plan.shards and made.digest != "", "the data set is not whole")
    rate = WORLDS * PAIRS / (marks[-1] - marks[1])
    return Measured(
        rate, detail=f"{WORLDS} worlds of {PAIRS} pairs, PNG and NPY in tar; depth, labels, instances, boxes"
    )


CASES: Final = (
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
