"""A large world: the time to build and load it, and the memory that takes, each in a process of its own."""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path
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


_LOAD: Final = """
import json, sys, time
import drjit, mitsuba, trimesh  # what any run has imported when it comes to its meshes
from pelagos.world.build import build_world, world_config
from pelagos import jit
jit.mi
config = json.loads(sys.stdin.read())
started = time.perf_counter()
world = build_world(world_config(config))
hits = world.cast([[0.0, 0.0, 0.0], [3.0, -4.0, 0.0]], (0.0, 0.0, -1.0))
print(json.dumps({
    "seconds": time.perf_counter() - started, "triangles": world.triangles, "z": hits.position[:, 2].tolist(),
}))
"""


def _fresh(code: str, config: dict[str, Any]) -> dict[str, Any]:
    """Run code in a process of its own, which reads the world and prints what it found."""
    done = subprocess.run([sys.executable, "-c", code], input=json.dumps(config), capture_output=True, text=True)
    if done.returncode != 0:
        raise BenchError(f"the build ended with code {done.returncode}: {done.stderr.strip()[-300:]}")
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


@cache
def _run() -> dict[str, Any]:
    """Build the world in a fresh process, load it, and cast rays at it."""
    found = _fresh(_CODE, WORLD)
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


def load_1m_triangles_s() -> Measured:
    """Seconds from a mesh file to the first hit."""
    import trimesh

    sphere = trimesh.creation.icosphere(subdivisions=8, radius=10.0)  # 1.3 M triangles
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sphere.ply"
        sphere.export(path)
        thing = {"shape": "file", "path": str(path), "at_m": [0, 0, -30], "material": "rock"}
        found = _fresh(_LOAD, {"type": "built", "size_m": [100, 100], "depth_m": 60, "things": [thing]})
        size = path.stat().st_size
    expected = [-30.0 + math.sqrt(100.0 - r2) for r2 in (0.0, 25.0)]
    must(found["triangles"] > 1_000_000, f"only {found['triangles']} triangles")
    must(max(abs(a - b) for a, b in zip(found["z"], expected, strict=True)) < 0.01, "rays do not hit the sphere")
    return Measured(found["seconds"], detail=f"{found['triangles']:,} triangles, a PLY file of {size / 1e6:.0f} MB")


CASES: Final = (
    Case(
        name="load_1m_triangles_s",
        title="A mesh file of a million triangles: read, checked, loaded, first rays cast",
        measure=load_1m_triangles_s,
        unit="s",
        goal=3.0,
        better="lower",
        reference=Reference("no published figure"),
    ),
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
