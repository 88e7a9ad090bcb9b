"""A large world: the time to build and load it, and the memory that takes, each in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from functools import cache
from typing import Any, Final

from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.check import BenchError, must

WORLD: Final[dict[str, Any]] = {
    "type": "generated",
    "seed": 7,
    "size_m": [2000, 2000],
    "grid_m": 1.0,
    "depth_m": 30,
    "terrain": {"kind": "mixed", "relief_m": 8},
    "patches": ["mud", "gravel"],
    "objects": [
        {"kind": "wreck_boat", "count": 3},
        {"kind": "pipeline", "count": 1},
        {"kind": "boulder", "density_per_ha": 2, "cluster": 0.4},
    ],
}
"""2 km x 2 km at 1 m: 8 million triangles of ground, and what stands on it."""

_CODE: Final = """
import json, sys, time
started = time.perf_counter()
from pelagos.sim.memory import peak_memory_mb
from pelagos.world.build import build_world, world_config
world = build_world(world_config(json.loads(sys.stdin.read())))
built = time.perf_counter()
hits = world.cast([[0.0, 0.0, 5.0], [700.3, -512.7, 5.0]], (0.0, 0.0, -1.0))
error = abs(hits.position[:, 2] - world.height([0.0, 700.3], [0.0, -512.7])).max()
print(json.dumps({
    "seconds": time.perf_counter() - started, "built": built - started, "triangles": world.triangles,
    "error_m": float(error), "hit": bool(hits.valid.all()),
    "mb": peak_memory_mb(),
}))
"""


@cache
def _run() -> dict[str, Any]:
    """Build the world in a fresh process, load it, and cast rays at it."""
    done = subprocess.run(
        [sys.executable, "-c", _CODE], input=json.dumps(WORLD), capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise BenchError(f"the build ended with code {done.returncode}: {done.stderr.strip()[-300:]}")
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    must(found["triangles"] > 8_000_000, f"only {found['triangles']} triangles")
    must(found["hit"] and found["error_m"] < 0.01, "rays do not hit the ground where it is")
    return found


def world_2km_1m_s() -> Measured:
    """Seconds from the first import until the first hit."""
    found = _run()
    return Measured(
        found["seconds"], detail=f"{found['triangles']:,} triangles, {found['built']:.1f} s of it until built"
    )


def world_2km_1m_mb() -> Measured:
    """Most memory of that process."""
    found = _run()
    return Measured(found["mb"], detail=f"{1e6 * found['mb'] / found['triangles']:.0f} bytes a triangle, all included")


CASES: Final = (
    Case(
        name="world_2km_1m_s",
        title="2 km x 2 km at 1 m with sediments and objects: imported, built, loaded, first rays cast",
        measure=world_2km_1m_s,
        unit="s",
        goal=15.0,
        better="lower",
        reference=Reference("no published figure"),
    ),
    Case(
        name="world_2km_1m_mb",
        title="The same: most memory of the process",
        measure=world_2km_1m_mb,
        unit="MB",
        goal=1500.0,
        better="lower",
        reference=Reference("no published figure"),
    ),
)
