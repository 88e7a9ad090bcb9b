"""The camera's pictures: size, repeatability, exposure, noise, lamps."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

from oceans import lit_ocean
from pelagos import jit
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.camera.camera import Camera
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.camera.picture.develop import zone_mean
from pelagos.sensors.camera.picture.pixel_order import Tiling, pixels, tile_sizes
from pelagos.sensors.sensor import Kinematics, SensorContext
from pelagos.world.material import MATERIALS, material_tables


def plate(z: float, material: int = 0) -> Geometry:
    """A square of 200 m at height z."""
    corners = np.array([[-100, -100, z], [100, -100, z], [100, 100, z], [-100, 100, z]], dtype=float)
    faces = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32)
    return Geometry(corners, faces, material, 7, 1)


def context(
    *, water: str = "II", sun_deg: float = 50.0, seed: int = 1, copies: int = 1, floor: str = "sand", z: float = -8.0
) -> SensorContext:
    materials = [MATERIALS[floor]]
    world: Any = SimpleNamespace(material_tables=lambda: material_tables(materials), palette=materials)
    ocean = lit_ocean(water, np.radians(sun_deg), 2.5)
    return SensorContext(
        path="auv0.camera",
        seed=seed,
        dt_ns=5_000_000,
        scene=Scene([plate(z)], copies=copies),
        world=world,
        ocean=ocean,
        own_body=np.full(copies, NO_BODY, np.uint32),
    )


def looking_down(*, copies: int = 1, tick: int = 0, height: float = -5.0, first: int = 0) -> Kinematics:
    """At rest, nose down, `copies` lanes."""
    half = np.sqrt(0.5)
    zero = dr.zeros(jit.Float64, copies)
    u = dr.zeros(jit.UInt32, copies)
    still = jit.Array3f64(zero, zero, zero)
    motion = Kinematics(
        position=jit.Array3f64(zero, zero, zero + height),
        attitude=jit.Array4f64(zero + half, zero, zero + half, zero),
        velocity=still,
        angular_velocity=still,
        acceleration=still,
        angular_acceleration=still,
        t_ns=jit.UInt64(u) + tick * 5_000_000,
        tick=u + tick,
        environment=dr.arange(jit.UInt32, copies) + first,
        copy=dr.arange(jit.UInt32, copies),
    )
    dr.make_opaque(motion)  # one kernel serves all poses
    return motion


def camera(context: SensorContext, **keys: Any) -> Camera:
    return Camera(CameraConfig(**{"type": "camera", "width_px": 72, "height_px": 50} | keys), context)


def test_sizes_that_are_no_multiple_of_a_tile():
    got = camera(context()).sense(looking_down(copies=1))
    assert got.data.shape == got.truth.shape == (1, 50, 72, 3)
    assert got.data.dtype == np.uint8
    assert got.extras["exposure_s"].shape == (1,)
    picture = got.truth[0].astype(float)
    for axis in (0, 1):  # level sand: no row and no column stands out, at a tile's edge or the picture's
        lines = picture.mean(axis=(axis, 2))
        assert np.abs(np.diff(lines)).max() < 0.1 * lines.mean()
        assert lines.min() > 0.6 * lines.max()


def test_same_seed_same_bytes_and_another_seed_other_noise():
    motion = looking_down()
    a, b = (camera(context()).sense(motion).data for _ in range(2))
    other = camera(context(seed=2)).sense(motion)
    assert np.array_equal(a, b)
    assert not np.array_equal(a, other.data)
    assert np.array_equal(camera(context()).sense(motion).truth, other.truth)


def test_copy_of_a_fleet_gives_the_bytes_of_one():
    fleet = camera(context(copies=3)).sense(looking_down(copies=3, tick=7))
    for copy in range(3):
        alone = camera(context()).sense(looking_down(tick=7, first=copy))
        assert np.array_equal(fleet.data[copy], alone.data[0])
    assert not np.array_equal(fleet.data[0], fleet.data[1])
    assert np.array_equal(fleet.truth[0], fleet.truth[1])


def test_frozen_equals_plain_and_replays():
    one = camera(context())
    frames = [one.sense(looking_down(tick=tick)).data for tick in (0, 4, 0, 4)]
    assert np.array_equal(frames[0], frames[2])
    assert np.array_equal(frames[1], frames[3])
    assert not np.array_equal(frames[0], frames[1])
    scene = one._view._context.scene
    plain = one._measurement(*one._kernel(scene.caster, *one._arguments(looking_down(tick=4))))
    assert np.array_equal(plain.data, frames[1])


def test_meter_makes_middle_grey():
    got = camera(context(), vignette=0.0, highlight_knee=1.0).sense(looking_down())
    linear = np.where(got.truth > 10.3, ((got.truth / 255 + 0.055) / 1.055) ** 2.4, got.truth / 255 / 12.92)
    luminance = linear[0] @ [0.2126, 0.7152, 0.0722]
    assert luminance.mean() == pytest.approx(0.18, abs=0.004)  # half a step of 8 bits at 0.18 is 0.002


def test_a_glare_counts_as_white_and_no_more():
    """Of 200 zones one is 10 000 times as bright: M = (199 + M / 0.18) / 200, and not 51."""
    bright = jit.Float(np.where(np.arange(200) == 77, 1e4, 1.0))
    mean = zone_mean(256 * bright, dr.full(jit.Float, 256, 200), Tiling(320, 160))
    assert np.array(mean) == pytest.approx([0.995 / (1 - 1 / 36)], rel=1e-3)
    even = zone_mean(256 * dr.minimum(bright, 5), dr.full(jit.Float, 256, 200), Tiling(320, 160))
    assert np.array(even) == pytest.approx([1.02])  # below white all counts


def test_tiles_at_the_edge_are_smaller():
    tiling = Tiling(40, 20)
    counted = dr.block_sum(dr.select(pixels(tiling, 2).active, jit.Float(1), 0), 256)
    assert np.array_equal(np.array(tile_sizes(tiling, 2)), np.array(counted))
    assert np.array(counted).sum() == 2 * 40 * 20


def test_meter_stops_at_its_limits_in_the_dark():
    got = camera(context(sun_deg=-40.0), iso=200, iso_max=800).sense(looking_down())
    assert got.extras["iso"][0] == 800
    assert got.extras["exposure_s"][0] == pytest.approx(0.01)
    assert got.truth.mean() < 5


@pytest.mark.parametrize(("key", "factor"), [("shutter_s", 2.0), ("iso", 2.0), ("aperture", 2**-0.5)])
def test_one_stop_doubles_the_signal(key: str, factor: float):
    base: dict[str, Any] = {"exposure": "manual", "shutter_s": 2e-5, "iso": 100.0, "aperture": 2.8}
    dim = signal(base)
    bright = signal(base | {key: base[key] * factor})
    assert bright / dim == pytest.approx(2.0, rel=1e-5)


def signal(keys: dict[str, Any]) -> Any:
    one = camera(context(), **keys)
    found = {name: values for name, values, _ in one.explain(looking_down())}
    return float(found["signal"].mean())


def test_noise_variance_is_signal_and_reading_over_gain():
    """EMVA 1288: variance of electrons = electrons + read noise^2, here before the tone curve."""
    one = camera(context(z=-30.0), width_px=320, height_px=320, exposure="manual", shutter_s=0.002, iso=400.0,
                 read_noise_e=20.0, dark_current_e_per_s=0.0)  # fmt: skip
    found = {name: values for name, values, _ in one.explain(looking_down(height=-4.0))}
    capacity = 10000 * 100 / 400
    electrons = found["signal"] * capacity
    normal = (found["signal with noise"] - found["signal"]) * capacity / np.sqrt(electrons + 400)
    count = normal.size
    assert abs(normal.mean()) < 4 / np.sqrt(count)  # 4 standard errors
    assert abs(normal.var() - 1) < 4 * np.sqrt(2 / count)
    assert electrons.mean() > 50


def test_lamp_lights_what_the_night_hides():
    dark = camera(context(sun_deg=-60.0)).sense(looking_down())
    lamp = {"position_m": (0.0, 0.4, 0.0), "flux_lm": 3000.0}
    lit = camera(context(sun_deg=-60.0), lamps=[lamp]).sense(looking_down())
    assert lit.truth.mean() > dark.truth.mean() + 60


def test_explain_names_units_and_sizes():
    found = camera(context()).explain(looking_down())
    names = [name for name, _, _ in found]
    assert names[0] == "slant range"
    assert "veiling light" in names
    slant = found[0][1]
    assert np.nanmin(slant) == pytest.approx(3.0, rel=1e-3)


def test_above_water_it_sees_sky_and_sea():
    """A deep sea mirrors 2.1 % of the sky (Fresnel, index 1.34) and adds blue light of its own; sand 8 m down shines
    through, least in red; the sky itself is far brighter.
    """
    keys: dict[str, Any] = {"exposure": "manual", "shutter_s": 1e-4, "bits": 16, "tone": "linear", "vignette": 0.0}
    down, up = looking_down(height=20.0), looking_down(height=20.0)
    half = np.sqrt(0.5)
    up.attitude = jit.Array4f64(*(jit.Float64(c) for c in (half, 0, -half, 0)))
    colour = lambda where, motion: camera(where, **keys).sense(motion).truth[0].astype(float).mean(axis=(0, 1))
    deep, sand, sky = (
        colour(context(z=-60.0, floor="black"), down), colour(context(), down), np.array(colour(context(), up))
    )  # fmt: skip
    share = deep / sky
    assert 0.0211 < share[0] < share[1] < share[2] < 0.1
    through = sand - deep
    assert 0 < through[0] < 0.2 * min(through[1:])


@pytest.mark.parametrize("height", [5.0, 80.0])
def test_shallow_ground_shows_from_any_height(height: float):
    """Two metres of water hide nothing, however high the camera: white ground outshines black."""
    keys: dict[str, Any] = {"exposure": "manual", "max_range_m": 200.0}
    white, black = (
        camera(context(water="1C", floor=floor, z=-2.0), **keys).sense(looking_down(height=height)).truth.mean()
        for floor in ("white", "black")
    )
    assert white > black + 10


def test_marine_snow_hangs_in_the_water_as_densely_as_asked():
    """Cover grows with the number of flakes, and the same place in the water holds the same flakes at any time."""
    night = {"water": "IB", "sun_deg": -60.0, "floor": "black"}
    lamp = {"position_m": (0.0, 0.4, 0.0), "flux_lm": 4000.0}
    keys: dict[str, Any] = {"lamps": [lamp], "width_px": 320, "height_px": 240, "exposure": "manual", "iso": 800.0}
    plain, some, many = (
        camera(context(**night), marine_snow_per_m3=n, **keys).sense(looking_down()).truth.astype(int)
        for n in (0.0, 20.0, 80.0)
    )
    seen = [np.count_nonzero((p - plain)[..., 1] > 12) for p in (some, many)]
    assert 10 < seen[0] < 320 * 240 / 50
    assert 2 < seen[1] / seen[0] < 8  # four times as many flakes, few in number
    later = camera(context(**night), marine_snow_per_m3=20.0, **keys).sense(looking_down(tick=300)).truth
    assert np.count_nonzero(np.abs(later - some) > 12) == 0


def test_what_stands_above_the_sea_shows_in_snells_window():
    """A roof 3 m above the water hides the sky in the window, which is 48.3 degrees wide each way."""
    half = np.sqrt(0.5)
    upwards = looking_down(height=-4.0)
    upwards.attitude = jit.Array4f64(*(jit.Float64(c) for c in (half, 0, -half, 0)))
    keys: dict[str, Any] = {"horizontal_fov_deg": 130, "width_px": 96, "height_px": 96, "ripple": 0.0, "vignette": 0.0,
                            "exposure": "manual", "shutter_s": 1e-4, "bits": 16, "tone": "linear"}  # fmt: skip
    roofed = camera(context(water="I", floor="black", z=3.0), **keys).sense(upwards).truth[0].astype(float)
    free = camera(context(water="I", floor="black", z=-60.0), **keys).sense(upwards).truth[0].astype(float)
    middle = slice(40, 56)
    assert roofed[middle, middle, 1].mean() < 0.5 * free[middle, middle, 1].mean()
    # 72 degrees from the axis the surface is a mirror: only the roof's shadow in the water shows there
    assert roofed[:3, :3].mean() > 0.6 * free[:3, :3].mean()
