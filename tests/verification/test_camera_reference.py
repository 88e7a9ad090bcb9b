"""The realtime view against path tracing, and path tracing against the tables."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

from oceans import lit_ocean
from pelagos import jit
from pelagos.optics.phase import sample_henyey_greenstein
from pelagos.optics.water import FORWARD_PEAK, MEAN_COSINE, WaterOptics, water_optics
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.camera.camera import Camera
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.camera.picture.pixel_order import Tiling
from pelagos.sensors.sensor import Kinematics, SensorContext
from pelagos.world.material import MATERIALS, material_tables


def light(water: str, *, floor: float, height: float, renderer: str, material: str = "white", sun_deg: float = 45.0,
          pitch_deg: float = 90.0, samples: int = 256, size: int = 32) -> Any:  # fmt: skip
    """Mean light `(3,)` [cd/m^2] of a small picture from `height` over a plate at depth `floor`."""
    return parts(water, floor, height, renderer, material, sun_deg, pitch_deg, samples, size)["light at the sensor"]


def parts(water: str, floor: float, height: float, renderer: str, material: str, sun_deg: float = 45.0,
          pitch_deg: float = 90.0, samples: int = 256, size: int = 32) -> dict[str, Any]:  # fmt: skip
    """The same, and what it is made of, by the names that `explain` gives."""
    how = {"renderer": renderer, "samples": samples if renderer == "reference" else 1}
    found = looked(water, floor, height, material, sun_deg, pitch_deg, size, how)
    return {name: values.mean(axis=1) for name, values in found.items()}


def looked(water: str, floor: float, height: float, material: str, sun_deg: float, pitch_deg: float, size: int,
           how: dict[str, Any], reach: float = 300.0) -> dict[str, Any]:  # fmt: skip
    """Light of each pixel `(3, n)` by the names that `explain` gives; the plate ends at `reach` in x."""
    z = -floor
    corners = np.array([[-300, -300, z], [reach, -300, z], [reach, 300, z], [-300, 300, z]], dtype=float)
    plate = Geometry(corners, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32), 0, 7, 1)
    materials = [MATERIALS[material]]
    world: Any = SimpleNamespace(material_tables=lambda: material_tables(materials), palette=materials)
    ocean = lit_ocean(water, math.radians(sun_deg), 2.8)
    scene = Scene([plate], copies=1)
    context = SensorContext("auv0.camera", 1, 5_000_000, scene, world, ocean, np.full(1, NO_BODY, np.uint32))
    config = CameraConfig(
        width_px=size, height_px=size, horizontal_fov_deg=20, vignette=0.0, ripple=0.0, exposure="manual",
        max_range_m=400.0, **how,
    )  # fmt: skip
    zero, u = dr.zeros(jit.Float64, 1), dr.zeros(jit.UInt32, 1)
    half = math.radians(pitch_deg) / 2
    none = jit.Array3f64(zero, zero, zero)
    motion = Kinematics(
        jit.Array3f64(zero, zero, zero + z + height),
        jit.Array4f64(zero + math.cos(half), zero, zero + math.sin(half), zero),
        none, none, none, none, jit.UInt64(u), u + 0, u + 0, u + 0,
    )  # fmt: skip
    dr.make_opaque(motion)  # one kernel serves all poses
    found = Camera(config, context).explain(motion)
    return {name: values for name, values, unit in found if unit == "cd/m^2"}


def test_a_pixel_is_the_mean_of_its_samples_and_of_one_path_where_it_has_one():
    """An edge through a column of pixels is half of either side; one path a pixel is random, a realtime picture not."""

    def picture(reach: float, **how: Any) -> Any:
        green = looked("I", 6.0, 1.5, "white", 60.0, 90.0, 32, how, reach)["light at the sensor"][1]
        return green[np.argsort(Tiling(32, 32).arrange(np.arange(1024.0).reshape(32, 32)))].reshape(32, 32)

    edge = 1.5 * math.tan(math.radians(10)) * 4.5 / 16  # in the middle of a pixel
    one, many = (picture(edge, samples=k) for k in (1, 64))
    dark, bright = np.quantile(one, (0.1, 0.9))
    assert bright > 5 * dark
    off = np.abs(many - one) / (bright - dark)
    changed = off > 0.3
    assert changed.sum() == 32
    assert sorted(len(set(k)) for k in np.nonzero(changed)) == [1, 32]
    np.testing.assert_allclose(off[changed], 0.5, atol=1 / 16)  # 64 samples of half a pixel: as far as 1 of 8 columns
    assert off[~changed].max() < 1e-3
    whole = picture(300.0)
    assert whole.std() < 2e-3 * whole.mean()
    assert picture(300.0, renderer="reference", samples=1).std() > 0.2 * whole.mean()


@pytest.mark.parametrize(("water", "tolerance"), [("I", 0.08), ("1C", 0.15)])
def test_path_tracing_finds_the_attenuation_of_the_tables(water: str, tolerance: float):
    """Kd between 2 and 6 m with the sun overhead: inherent properties alone give back Jerlov's apparent one.

    Kirk's equation, which links them, fits Monte Carlo to 5 %, and a tenth of the light is sky, whose way is 1.2.
    """
    shallow, deep = (
        light(water, floor=z, height=0.1, renderer="reference", material="black", sun_deg=89) for z in (2, 6)
    )
    kd = np.log(shallow / deep) / 4
    assert kd == pytest.approx(np.array(water_optics(water).downwelling), rel=tolerance, abs=0.003)


@pytest.mark.parametrize("height", [0.1, 3.0])
@pytest.mark.parametrize("water", ["I", "1C"])
def test_plates_are_as_bright_as_path_tracing_says(water: str, height: float):
    """12 %; light that goes back and forth between sand (albedo 0.2 to 0.36) and surface is left out."""
    here: dict[str, Any] = {"floor": 8.0, "height": height, "material": "sand"}
    reference, realtime = (light(water, renderer=r, **here) for r in ("reference", "realtime"))
    assert realtime == pytest.approx(reference, rel=0.12)


def seen_of_ground(water: WaterOptics, channel: int, height: float) -> float:
    """Share of level ground's light that reaches an eye over it, scattered or not, by 100 000 walks from the eye."""
    a, b_w, b_p = (v[channel] for v in (water.absorption, water.water_scattering, water.particle_scattering))
    rng = np.random.default_rng(channel)
    z = np.full(100_000, height)
    d = np.tile([0.0, 0.0, -1.0], (len(z), 1))
    weight, total = np.ones(len(z)), 0.0
    while len(z):
        flight = rng.exponential(1 / (b_w + b_p), len(z))
        down = np.where(d[:, 2] < 0, -z / np.minimum(d[:, 2], -1e-9), np.inf)
        weight = weight * np.exp(-a * np.minimum(flight, down))
        total += weight[down <= flight].sum()
        on = (flight < down) & (weight > 1e-4)
        z, d, weight = z[on] + d[on, 2] * flight[on], d[on], weight[on]
        u, v, pick = rng.random((3, len(z)))
        s = (1 - MEAN_COSINE**2) / (1 - MEAN_COSINE + 2 * MEAN_COSINE * u)
        forward = (1 + MEAN_COSINE**2 - s * s) / (2 * MEAN_COSINE)
        cosine = np.where(pick < b_p / (b_w + b_p), forward, 2 * u - 1)[:, None]
        x = np.cross(d, [1.0, 0.0, 0.0])
        x /= np.linalg.norm(x, axis=1)[:, None]
        turned = x * np.cos(2 * np.pi * v)[:, None] + np.cross(d, x) * np.sin(2 * np.pi * v)[:, None]
        d = cosine * d + np.sqrt(1 - cosine**2) * turned
    return total / 100_000


@pytest.mark.parametrize("height", [3.0, 6.0])
def test_the_ground_sends_as_much_by_way_of_the_water_as_walks_say(height: float):
    """Light of pale ground less that of black ground: 4 %. What is scattered by less than 24 degrees counts as not
    scattered, which makes 2 % at 6 m; the rest is for the few walks of a picture."""
    water = water_optics("1C")
    names = ("sharp light", "light scattered by a few degrees", "light scattered forward", "veiling light")
    pale, black = (
        parts("1C", floor=12.0, height=height, renderer="realtime", material=m, size=480) for m in ("steel", "black")
    )
    straight, whole = (sum(pale[n] - black[n] for n in names[:k]) for k in (3, 4))
    loss = np.add(water.absorption, water.water_scattering)
    loss = loss + np.multiply(1 - FORWARD_PEAK, water.particle_scattering)
    seen = whole / straight * np.exp(-loss * height)
    assert seen == pytest.approx(np.array([seen_of_ground(water, c, height) for c in range(3)]), rel=0.04)


def test_open_water_is_as_bright_as_path_tracing_says():
    """15 % for a level view 6 m deep in coastal water; the noise of 1024 x 256 paths is 6 %."""
    here: dict[str, Any] = {"floor": 100.0, "height": 94.0, "pitch_deg": 0.0}
    reference = light("1C", renderer="reference", **here)
    realtime = light("1C", renderer="realtime", **here)
    assert realtime[1:] == pytest.approx(reference[1:], rel=0.15)


def test_sampling_follows_the_phase_function():
    """The mean cosine of samples is g."""
    u = (np.arange(100_000) + 0.5) / 100_000
    assert np.array(sample_henyey_greenstein(jit.Float64(u), 0.924)).mean() == pytest.approx(0.924, abs=1e-4)
