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


FOREST: Final[dict[str, Any]] = {
    "name": "kelp forest",
    "tick_rate_hz": 10,
    "world": {
        "type": "generated",
        "seed": 3,
        "size_m": [1300, 1300],
        "grid_m": 2.0,
        "depth_m": 14,
        "terrain": {"kind": "ridges", "relief_m": 2},
        "material": "rock",
        "objects": [{"kind": "kelp", "count": 36_000, "size_m": [6, 11]}],
    },
    "agents": {
        "auv0": {
            "vehicle": "bluerov2",
            "start": {"position_m": [0, 0, -9]},
            "sensors": {"camera": {"type": "camera", "rate_hz": 10, "width_px": 640, "height_px": 480}},
        }
    },
}
"""Thirty-six thousand plants of a dozen models: more than fifty million triangles."""

_FOREST: Final = """
import json, sys, time
from pelagos.sim.memory import peak_memory_mb
from pelagos.sim.simulation import Simulation
sim = Simulation.load(json.loads(sys.stdin.read()))
times, spread = [], 0.0
for _ in range(12):
    start = time.perf_counter()
    image = sim.step()["auv0"]["camera"].data
    times.append(time.perf_counter() - start)
    spread = max(spread, float(image.std()))
print(json.dumps({
    "seconds": sorted(times[2:])[5], "triangles": sim.world.triangles, "spread": spread, "mb": peak_memory_mb(),
    "notes": list(sim.world.notes),
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


@cache
def _forest() -> dict[str, Any]:
    found = _fresh(_FOREST, FOREST)
    must(found["triangles"] > 50_000_000, f"only {found['triangles']} triangles; {found['notes']}")
    must(found["spread"] > 3.0, "the picture is blank")
    return found


def forest_50m_fps() -> Measured:
    """Frames a second of a camera among them, whole ticks."""
    found = _forest()
    return Measured(1.0 / found["seconds"], detail=f"{found['triangles']:,} triangles, 640 x 480, whole ticks")


def forest_50m_mb() -> Measured:
    """Most memory of that process."""
    found = _forest()
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
        name="forest_50m_fps",
        title="A camera in a kelp forest of 50 million triangles, copies of a dozen models",
        measure=forest_50m_fps,
        unit="frames/s",
        goal=1.0,
        better="higher",
        reference=Reference("no published figure"),
    ),
    Case(
        name="forest_50m_mb",
        title="The same: most memory of the process",
        measure=forest_50m_mb,
        unit="MB",
        goal=1500.0,
        better="lower",
        reference=Reference("no published figure"),
    ),
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
