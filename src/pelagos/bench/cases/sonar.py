"""Sonar speed: whole pings, from motion to NumPy arrays, with coherent sum, side lobes, noise and gain."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any, Final

import drjit as dr
import numpy as np

from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.check import must
from pelagos.bench.timing import seconds, seconds_in_turns
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sensor import SensorContext
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig, fan_rays
from pelagos.sensors.sonar.multibeam import Multibeam, MultibeamConfig
from pelagos.sensors.sonar.ping.fan import cast_fan
from pelagos.sensors.sonar.ping.sounder import Sounder, Waters
from pelagos.sensors.sonar.sidescan import Sidescan, SidescanConfig
from pelagos.sensors.sonar.singlebeam import Singlebeam, SinglebeamConfig
from pelagos.world.material import MATERIALS
from pelagos.world.shapes import box, cylinder, sphere

DT_NS: Final = 5_000_000
NPS: Final = Reference("NPS multibeam in DAVE, 512 x 114 rays, 60 m, RTX 2080 Ti (its documentation)", 0.5)
OCEANSIM: Final = Reference("OceanSim imaging sonar, 2500 x 384, RTX 3090 (a fork's record, June 2026)", 1.3)
HOLOOCEAN: Final = Reference("HoloOcean single beam by ray casting, gaming GPU (arXiv 2510.06160)", 12.0)
NONE: Final = Reference("-")
DAM_TICKS: Final = 509
DAM: Final[dict[str, Any]] = {
    "name": "single beam before a dam",  # 23 m: the farthest echo that is back before the next of 30 pings a second
    "tick_rate_hz": 30,
    "world": {"type": "classic", "name": "dam"},
    "agents": {
        "auv0": {
            "vehicle": "remus100",
            "start": {"position_m": [60, 0, -12], "heading_deg": 180, "speed_mps": 1.0},
            "sensors": {
                "echo": {"type": "singlebeam", "rate_hz": 30, "range_max_m": 23.0, "bins": 200, "beamwidth_deg": 30.0}
            },
        }
    },
}


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


def context(copies: int = 1) -> SensorContext:
    """A sensor context over `harbour_scene`."""
    materials = tuple(MATERIALS[name] for name in ("sand", "concrete", "rusted_steel"))
    world: Any = SimpleNamespace(materials=materials, palette=materials, geometries=())
    return SensorContext(
        path="auv0.sonar",
        seed=0,
        dt_ns=DT_NS,
        scene=Scene(harbour_scene(), copies=copies),
        world=world,
        ocean=build_ocean(OceanConfig()),
        own_body=np.full(copies, NO_BODY, np.uint32),
    )


def motion(k: int, copies: int = 1) -> Any:
    """The sonar at step `k` of a slow way past the piles."""
    place = np.tile([0.02 * k, 0.0, -6.0], (copies, 1)) + np.arange(copies)[:, None] * [0.05, 0.02, 0.0]
    return lanes([k], dt_ns=DT_NS, environments=range(copies), position=place)


def _work(sensor: Any, copies: int = 1) -> tuple[Callable[[], Any], str]:
    """A ping that goes on from call to call, and what was checked: it hears something, and the scene changes it."""
    first, later = (sensor.sense(motion(k, copies)).truth for k in (0, 200))
    must(bool(np.isfinite(first).any() and np.nanstd(first) > 0), "the sonar hears nothing")
    must(not np.array_equal(first, later, equal_nan=True), "the sonar hears the same at another place")
    step = iter(range(1, 1_000_000))
    return lambda: sensor.sense(
        motion(next(step), copies)
    ), f"{np.isfinite(first).mean():.0%} finite, changes with place"


def _hertz(sensor: Any, copies: int = 1) -> Measured:
    work, detail = _work(sensor, copies)
    return Measured(1.0 / seconds(work), detail=detail)


def _milliseconds(sensor: Any) -> Measured:
    work, detail = _work(sensor)
    return Measured(1e3 * seconds(work), detail=detail)


def _imaging(beams: int, rays: int, bins: int, copies: int = 1, **options: Any) -> ImagingSonar:
    config = ImagingSonarConfig(
        beams=beams, rays_per_beam=rays, bins=bins, range_max_m=60.0, orientation_deg=(0, 12, 0), **options
    )
    return ImagingSonar(config, context(copies))


def imaging_demo_ms() -> Measured:
    """The demo's sonar."""
    return _milliseconds(_imaging(256, 96, 512))


def imaging_512x114_hz() -> Measured:
    """The setting of NPS."""
    return _hertz(_imaging(512, 114, 1024, horizontal_aperture_deg=120.0))


def imaging_2500x384_hz() -> Measured:
    """The setting of OceanSim: 960 000 rays, as 512 beams of 1875."""
    return _hertz(_imaging(512, 1875, 1024))


def multibeam_512_hz() -> Measured:
    """Soundings by 512 beams."""
    return _hertz(Multibeam(MultibeamConfig(beams=512), context()))


def sidescan_2048_hz() -> Measured:
    """Two sides of 1024 samples and rays."""
    return _hertz(Sidescan(SidescanConfig(range_max_m=50.0), context()))


def singlebeam_sense_ms() -> Measured:
    """The sensor's part of a tick with a single beam."""
    config = SinglebeamConfig(range_max_m=30.0, bins=200, beamwidth_deg=30.0)
    return _milliseconds(Singlebeam(config, context()))


@cache
def _dam_ticks() -> tuple[float, float]:
    """Median time of a whole tick [s] of `DAM`, with its single beam and without any sensor."""
    from pelagos.sim.simulation import Simulation

    def run(scenario: dict[str, Any]) -> float:
        sim = Simulation.load(scenario)
        for _ in range(30):
            sim.step()
        times, echoes = [], []
        for _ in range(DAM_TICKS):
            start = time.perf_counter()
            found = sim.step()
            times.append(time.perf_counter() - start)
            echoes += [r.data for r in found["auv0"].values()]
        must(len(echoes) in (0, DAM_TICKS), "the single beam is silent in some ticks")
        must(not echoes or float(np.ptp(np.stack(echoes), axis=0).max()) > 0.0, "the single beam hears no change")
        return sorted(times)[len(times) // 2]

    silent = {**DAM, "agents": {"auv0": {**DAM["agents"]["auv0"], "sensors": {}}}}
    return run(DAM), run(silent)


def singlebeam_tick_ms() -> Measured:
    """The paper's test: a torpedo with a single beam before a dam, whole ticks through `Simulation.step`."""
    heard, silent = _dam_ticks()
    return Measured(1e3 * heard, detail=f"{DAM_TICKS} ticks at 30 a second; {1e3 * silent:.2f} ms without the sonar")


def sonar_small_target_miss() -> Measured:
    """A smooth steel sphere of 0.1 m radius (-26 dB) 40 m away, at default rays, 100 pings on a slow way: missed where
    no cell within a metre and 3 deg of it is 12 dB over the median of those cells."""
    ball = sphere(0.1, sides=96, rings=48)
    steel = (MATERIALS["steel"],)
    world: Any = SimpleNamespace(materials=steel, palette=steel, geometries=())
    scene = Scene([Geometry(np.asarray(ball.vertices) + np.array([40.0, 0, -200.0]), ball.faces, 0, 1, 1)])
    place = replace(context(), scene=scene, world=world)
    sonar = ImagingSonar(ImagingSonarConfig(scale="db"), place)
    r, azimuth = sonar.tables["range"], sonar.tables["azimuth"]
    cells = np.ix_(np.abs(azimuth) < math.radians(3.0), np.abs(r - 39.9) < 1.0)
    missed, levels = 0, []
    for k in range(100):
        at = np.array([[0.02 * k - 1.0, 0.013 * k - 0.6, -200.0]])
        image = sonar.sense(lanes([k], dt_ns=DT_NS, position=at)).data[0][cells]
        levels.append(float(image.max()))
        missed += levels[-1] < float(np.median(image)) + 12.0
    must(max(levels) > -30.0, "the sonar hears no sphere")
    return Measured(float(missed), detail=f"100 pings; level {min(levels):.1f} to {max(levels):.1f} dB")


def fleet_sonar_256x64x16_hz() -> Measured:
    """256 environments in one call."""
    return _hertz(_imaging(64, 16, 128, copies=256, side_lobe_beams=4), copies=256)


def _over_cast(rays_per_beam: int) -> Measured:
    """A whole ping over casting its rays with hit normals."""
    sensor = _imaging(512, rays_per_beam, 1024)
    work, detail = _work(sensor)
    place = context()
    rays = Sounder(sensor.config, place, fan_rays(sensor.config), Waters(750e3, 8.1))

    def fan_alone(caster: Any, lanes: Any, fan: Any, surfaces: Any) -> Any:
        view = cast_fan(caster, fan, lanes, surfaces, max_range=67.5)
        return view.hits.t, view.sine

    frozen = place.scene.compile(fan_alone)
    step = iter(range(1, 1_000_000))

    def cast_only() -> None:
        lanes_, fan, surfaces, _ = rays.arguments(motion(next(step)))
        dr.eval(frozen(lanes_, fan, surfaces))
        dr.sync_thread()

    ping, cast, told = seconds_in_turns(work, cast_only, lambda: work().truth)
    times = f"{1e3 * ping:.1f} ms over {1e3 * cast:.1f} ms; with its truth {1e3 * told:.1f} ms"
    return Measured(ping / cast, detail=f"{times}; {detail}")


def sonar_over_cast_ratio() -> Measured:
    """In the setting of NPS: nine cells of the image to a ray."""
    return _over_cast(114)


def sonar_over_cast_dense_ratio() -> Measured:
    """In the setting of OceanSim: two rays to a cell."""
    return _over_cast(1875)


CASES: Final = (
    Case("imaging_demo_ms", "imaging sonar of the demo: 256 beams x 96 rays, 512 bins", imaging_demo_ms, "ms", 15.0,
         "lower", NONE),
    Case("imaging_512x114_hz", "imaging sonar, 512 beams x 114 rays, 1024 bins, 60 m, coherent sum",
         imaging_512x114_hz, "Hz", 100.0, "higher", NPS),
    Case("imaging_2500x384_hz", "imaging sonar, 2500 x 384 rays, 1024 bins, coherent sum", imaging_2500x384_hz, "Hz",
         15.0, "higher", OCEANSIM),
    Case("multibeam_512_hz", "multibeam, 512 beams x 15 rays, bottom detection", multibeam_512_hz, "Hz", 400.0,
         "higher", NONE),
    Case("sidescan_2048_hz", "sidescan, 2 x 1024 rays and samples", sidescan_2048_hz, "Hz", 1500.0, "higher", NONE),
    Case("singlebeam_sense_ms", "single beam, 512 rays, 200 bins: the sensor's part of a tick", singlebeam_sense_ms,
         "ms", 0.5, "lower", HOLOOCEAN),
    Case("singlebeam_tick_ms", "single beam before a dam: a whole tick of the simulation", singlebeam_tick_ms, "ms",
         0.5, "lower", HOLOOCEAN),
    Case("fleet_sonar_256x64x16_hz", "256 environments, 64 beams x 16 rays, 128 bins, one call",
         fleet_sonar_256x64x16_hz, "Hz", 15.0, "higher", NONE),
    Case("sonar_small_target_miss", "misses of a -26 dB sphere at 40 m in 100 pings, default rays",
         sonar_small_target_miss, "%", 1.0, "lower", Reference("the fan's rays alone", 87.0)),
    Case("sonar_over_cast_ratio", "a ping of 512 x 114 rays over casting its rays, same run", sonar_over_cast_ratio,
         "1", 2.0, "lower", Reference("casting alone, same run", 1.0)),
    Case("sonar_over_cast_dense_ratio", "a ping of 2500 x 384 rays over casting its rays, same run",
         sonar_over_cast_dense_ratio, "1", 2.0, "lower", Reference("casting alone, same run", 1.0)),
)  # fmt: skip
