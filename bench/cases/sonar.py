"""Sonar speed: whole pings, from motion to NumPy arrays, with coherent sum, side lobes, noise and gain.

Each case is a function without arguments; it returns value, unit, goal, better, reference, note and spread.
A case fails when its output is empty or does not depend on the scene.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.echo import look
from pelagos.sensors.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.sensors.lanes import lanes
from pelagos.sensors.multibeam import Multibeam, MultibeamConfig
from pelagos.sensors.sidescan import Sidescan, SidescanConfig
from pelagos.sensors.singlebeam import Singlebeam, SinglebeamConfig
from pelagos.world.material import MATERIALS
from pelagos.world.shapes import box, cylinder

DT_NS = 5_000_000
NPS = "NPS multibeam in DAVE, 512 beams x 114 rays, 60 m: 0.5 Hz on an RTX 2080 Ti (DAVE documentation)"
OCEANSIM = "OceanSim imaging sonar, 2500 x 384: 1.3 Hz on an RTX 3090 (its authors' record, June 2026)"
HOLOOCEAN = "HoloOcean single beam by ray casting: 12 ms a tick with a gaming GPU (arXiv 2510.06160)"


def harbour_scene() -> list[Geometry]:
    """A bottom of half a million triangles, a wall, and forty piles."""
    n = 512
    g = np.linspace(-80, 80, n)
    x, y = np.meshgrid(g, g, indexing="ij")
    z = -12 + 0.4 * np.sin(x / 7) * np.cos(y / 9) + 0.05 * np.sin(5 * x + 3 * y)
    gx, gy = np.gradient(z, g[1] - g[0])
    normals = np.stack([-gx, -gy, np.ones_like(z)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    i = np.arange(n * n, dtype=np.uint32).reshape(n, n)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])
    vertices = np.stack([x, y, z], -1).reshape(-1, 3)
    made = [Geometry(vertices, faces, 0, 1, 1, normals.reshape(-1, 3).astype(np.float32))]
    wall = box((2, 90, 16))
    made.append(Geometry(np.asarray(wall.vertices) + np.array([48, 0, -6]), wall.faces, 1, 2, 2))
    pile = cylinder(0.3, 16.0)
    for k in range(40):
        place = np.array([30 + 6 * (k % 2), -40 + 2 * k, -6])
        made.append(Geometry(np.asarray(pile.vertices) + place, pile.faces, 2, 3, 10 + k))
    return made


def context(copies: int = 1) -> Any:
    """A sensor context over `harbour_scene`."""
    materials = tuple(MATERIALS[name] for name in ("sand", "concrete", "rusted_steel"))
    return SimpleNamespace(
        path="auv0.sonar",
        seed=0,
        dt_ns=DT_NS,
        scene=Scene(harbour_scene(), copies=copies),
        world=SimpleNamespace(materials=materials, palette=materials),
        ocean=build_ocean(OceanConfig()),
        own_body=np.full(copies, NO_BODY, np.uint32),
    )


def motion(k: int, copies: int = 1) -> Any:
    """The sonar at step `k` of a slow way past the piles."""
    place = np.tile([0.02 * k, 0.0, -6.0], (copies, 1)) + np.arange(copies)[:, None] * [0.05, 0.02, 0.0]
    return lanes([k], dt_ns=DT_NS, environments=range(copies), position=place)


def timed(work: Callable[[int], Any], *, repeats: int = 25, warm: int = 4) -> tuple[float, tuple[float, float]]:
    """Median time of a call [s], and the quartiles."""
    for k in range(warm):
        work(k)
    times = []
    for k in range(repeats):
        begin = time.perf_counter()
        work(warm + k)
        times.append(time.perf_counter() - begin)
    low, middle, high = np.percentile(times, [25, 50, 75])
    return float(middle), (float(low), float(high))


def _checked(sensor: Any, copies: int = 1) -> Callable[[int], Any]:
    """A ping; refuses a sonar that hears nothing or always the same."""
    first, later = (sensor.sense(motion(k, copies)).truth for k in (0, 200))
    assert np.isfinite(first).any()
    assert np.nanstd(first) > 0
    assert not np.array_equal(first, later, equal_nan=True)
    return lambda k: sensor.sense(motion(k, copies))


def _rate(sensor: Any, goal: float, reference: str, note: str, *, copies: int = 1, repeats: int = 25) -> dict[str, Any]:
    middle, (low, high) = timed(_checked(sensor, copies), repeats=repeats)
    return {
        "value": 1 / middle, "unit": "Hz", "goal": goal, "better": "higher", "reference": reference, "note": note,
        "spread": (1 / high, 1 / low),
    }  # fmt: skip


def _imaging(beams: int, rays: int, bins: int, copies: int = 1, **options: Any) -> ImagingSonar:
    config = ImagingSonarConfig(
        beams=beams, rays_per_beam=rays, bins=bins, range_max_m=60.0, orientation_deg=(0, 12, 0), **options
    )
    return ImagingSonar(config, context(copies))


def imaging_512x114_hz() -> dict[str, Any]:
    """512 beams x 114 rays, 1024 bins, 60 m."""
    note = "coherent sum, absorption, TR 9407 bottom, beam side lobes, noise, gain; float32 image to NumPy"
    return _rate(_imaging(512, 114, 1024, horizontal_aperture_deg=120.0), 60, NPS, note)


def imaging_2500x384_hz() -> dict[str, Any]:
    """2500 x 384 rays: 512 beams of 1875 rays, 1024 bins."""
    return _rate(_imaging(512, 1875, 1024), 6, OCEANSIM, "960 000 rays; coherent sum", repeats=9)


def imaging_demo_ms() -> dict[str, Any]:
    """The demo's sonar: 256 beams, 512 bins, defaults."""
    middle, spread = timed(_checked(_imaging(256, 96, 512)))
    return {
        "value": 1e3 * middle, "unit": "ms", "goal": 15, "better": "lower", "reference": "", "note": "256 x 96 rays",
        "spread": tuple(1e3 * s for s in spread),
    }  # fmt: skip


def multibeam_512_hz() -> dict[str, Any]:
    """512 beams x 15 rays with bottom detection."""
    config = MultibeamConfig(beams=512)
    return _rate(Multibeam(config, context()), 50, "", "512 beams x 15 rays, amplitude and phase detection")


def sidescan_2048_hz() -> dict[str, Any]:
    """2 x 1024 samples, 2 x 1024 rays."""
    return _rate(Sidescan(SidescanConfig(range_max_m=50.0), context()), 100, "", "2 x 1024 rays, 2 x 1024 bins")


def singlebeam_tick_ms() -> dict[str, Any]:
    """One sensor call of a single beam with 256 rays and 200 bins, as each of the paper's 509 ticks makes one."""
    config = SinglebeamConfig(range_max_m=30.0, bins=200, beamwidth_deg=30.0)
    middle, spread = timed(_checked(Singlebeam(config, context())), repeats=509)
    return {
        "value": 1e3 * middle, "unit": "ms", "goal": 0.5, "better": "lower", "reference": HOLOOCEAN,
        "note": "the sensor's part of a tick", "spread": tuple(1e3 * s for s in spread),
    }  # fmt: skip


def fleet_sonar_256x64x16_hz() -> dict[str, Any]:
    """256 environments, 64 beams x 16 rays, 128 bins, in one call."""
    sensor = _imaging(64, 16, 128, copies=256, side_lobe_beams=4)
    return _rate(sensor, 10, "", "262 144 rays; all environments in one call", copies=256, repeats=9)


def sonar_over_cast_ratio() -> dict[str, Any]:
    """A whole ping of 512 x 114 over casting its rays with hit normals."""
    sensor = _imaging(512, 114, 1024)
    ping, _ = timed(_checked(sensor))
    place = context()
    other = ImagingSonar(sensor.config, place)
    tables, lane, fan, surfaces, *_ = other._pinger._arguments(motion(0), None)

    def make(static: Any, moving: Any) -> Callable[..., Any]:
        def cast(tables: Any, lane: Any, fan: Any, surfaces: Any) -> Any:
            view = look(static, moving, tables, fan, lane, surfaces, max_range=67.5)
            return view.hits.t, view.sine

        return cast

    frozen = place.scene.compile(make)

    def work(k: int) -> None:
        lane.position = jit.Array3f64(0.02 * k, 0.0, -6.0)
        dr.make_opaque(lane.position)
        dr.eval(frozen(tables, lane, fan, surfaces))
        dr.sync_thread()

    cast, _ = timed(work)
    return {
        "value": ping / cast, "unit": "1", "goal": 2, "better": "lower", "reference": "casting alone, same run",
        "note": f"{1e3 * ping:.1f} ms over {1e3 * cast:.1f} ms", "spread": (ping / cast, ping / cast),
    }  # fmt: skip


CASES = {
    f.__name__: f
    for f in (
        imaging_demo_ms, imaging_512x114_hz, imaging_2500x384_hz, multibeam_512_hz, sidescan_2048_hz,
        singlebeam_tick_ms, fleet_sonar_256x64x16_hz, sonar_over_cast_ratio,
    )
}  # fmt: skip

if __name__ == "__main__":
    import sys

    for name, case in CASES.items():
        if len(sys.argv) > 1 and name not in sys.argv[1:]:
            continue
        r = case()
        low, high = r["spread"]
        print(f"{name:28s} {r['value']:10.3g} {r['unit']:4s} ({low:.3g} - {high:.3g}), goal {r['goal']}", flush=True)
