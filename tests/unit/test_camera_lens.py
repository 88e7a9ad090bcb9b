"""What the camera's parameters do, measured in pictures of an edge between white and black, or in closed form."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest
from pydantic import ValidationError

from oceans import lit_ocean
from pelagos import jit
from pelagos.optics.film import FilmCurve, balance_gains, film
from pelagos.optics.lens import (
    fisheye_directions,
    fisheye_intrinsics,
    kannala_brandt,
    natural_vignette,
    project_fisheye,
)
from pelagos.optics.port import GLASS_INDEX, through_dome_port, through_flat_port
from pelagos.optics.water import REFRACTIVE_INDEX
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.camera.camera import Camera
from pelagos.sensors.camera.picture import develop
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.camera.picture.pixel_order import Tiling, pixels
from pelagos.sensors.sensor import Kinematics, SensorContext
from pelagos.world.material import MATERIALS, material_tables

DISTANCE = 2.0
QUIET: dict[str, Any] = {
    "vignette": 0.0,
    "ripple": 0.0,
    "exposure": "manual",
    "shutter_s": 1e-3,
    "width_px": 160,
    "height_px": 64,
}


def half(material: int, low: float, high: float, x: float) -> Geometry:
    """A plate facing the camera from y = low to y = high, `x` ahead at 10 m depth."""
    corners = np.array([[x, high, -30], [x, low, -30], [x, low, -1], [x, high, -1]], dtype=float)
    return Geometry(corners, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32), material, 7, material + 1)


def context(x: float = DISTANCE) -> SensorContext:
    """White on the left (y > 0), black on the right."""
    materials = [MATERIALS["white"], MATERIALS["black"]]
    world: Any = SimpleNamespace(material_tables=lambda: material_tables(materials), palette=materials)
    ocean = lit_ocean("I", 1.2, math.pi)
    scene = Scene([half(0, 0.0, 40.0, x), half(1, -40.0, 0.0, x)], copies=1)
    return SensorContext("auv0.camera", 1, 5_000_000, scene, world, ocean, np.full(1, NO_BODY, np.uint32))


def ahead(*, velocity: Any = (0.0, 0.0, 0.0), spin: Any = (0.0, 0.0, 0.0)) -> Kinematics:
    zero, u = dr.zeros(jit.Float64, 1), dr.zeros(jit.UInt32, 1)

    def vector(v: Any) -> Any:
        return jit.Array3f64(*(zero + float(c) for c in v))

    motion = Kinematics(vector((0, 0, -10)), jit.Array4f64(zero + 1, zero, zero, zero), vector(velocity), vector(spin),
                        vector((0, 0, 0)), vector((0, 0, 0)), jit.UInt64(u), u + 0, u + 0, u + 0)  # fmt: skip
    dr.make_opaque(motion)  # one kernel serves all poses
    return motion


def shot(motion: Kinematics | None = None, *, x: float = DISTANCE, **keys: Any) -> Any:
    return Camera(CameraConfig(**(QUIET | keys)), context(x)).sense(motion or ahead())


def light(motion: Kinematics | None = None, *, x: float = DISTANCE, **keys: Any) -> Any:
    """Green light at the pixels `(height, width)`, from a linear picture of 16 bits."""
    return shot(motion, x=x, tone="linear", bits=16, **keys).truth[0, :, :, 1].astype(float)


def edge(row: Any) -> tuple[float, float]:
    """Place and standard deviation [px] of the step in a row, from its derivative."""
    step = -np.diff(row)
    step = np.where(np.abs(step) > 0.015 * np.abs(step).max(), step, 0.0)
    place = np.arange(len(step)) + 0.5
    mean = np.sum(step * place) / step.sum()
    return float(mean), float(np.sqrt(max(np.sum(step * (place - mean) ** 2) / step.sum(), 0.0)))


def focal(width: int = 160) -> float:
    return 0.5 * width / math.tan(math.radians(35))


def test_motion_blur_has_the_length_of_the_way():
    """Box of f v T / z pixels: variance length^2 / 12, and 1 / 12 each of the pixel and the difference."""
    picture = light(ahead(velocity=(0, 1.5, 0)), samples=64, shutter_s=0.05, iso=1)
    length = focal() * 1.5 * 0.05 / DISTANCE
    _, width = edge(picture.mean(axis=0))
    assert width == pytest.approx(math.sqrt((length**2 + 2) / 12), rel=0.03)
    _, less = edge(light(ahead(velocity=(0, 1.5, 0)), samples=64, shutter_s=0.05, iso=1, motion_blur=0.5).mean(axis=0))
    assert less == pytest.approx(math.sqrt((0.25 * length**2 + 2) / 12), rel=0.04)
    _, still = edge(light(samples=64, shutter_s=0.05, iso=1).mean(axis=0))
    assert still < 0.6


def test_turning_blurs_too():
    """A turn about up moves the middle of the picture by f w T."""
    _, width = edge(light(ahead(spin=(0, 0, 1.0)), samples=64, shutter_s=0.05, iso=1)[30:34].mean(axis=0))
    assert width == pytest.approx(math.sqrt(((focal() * 0.05) ** 2 + 2) / 12), rel=0.03)


def test_rolling_shutter_leans_the_edge():
    picture = light(ahead(velocity=(0, 1.5, 0)), rolling_shutter_s=0.04, samples=32)
    places = [edge(row)[0] for row in picture]
    lean = focal() * 1.5 * 0.04 / DISTANCE  # over the whole height; moving left, later rows see the edge further right
    slope = np.polyfit(np.arange(64), places, 1)[0] * 64
    assert slope == pytest.approx(lean, rel=0.05)


def test_circle_of_confusion():
    """Focused at zf, radius f/(2N) blurs by f_px f/(2N) |1/z - 1/zf| px; an edge deviates by half of that."""
    keys: dict[str, Any] = {
        "samples": 64,
        "iso": 10,
        "aperture": 1.4,
        "sensor_width_mm": 36.0,
        "focus_distance_m": 0.3,
    }
    config = CameraConfig(**QUIET, **keys)
    radius = focal() * config.focal_length_m / (2 * 1.4) * abs(1 / DISTANCE - 1 / 0.3)
    _, width = edge(light(**keys).mean(axis=0))
    assert width == pytest.approx(math.sqrt((radius / 2) ** 2 + 2 / 12), rel=0.03)
    _, stopped = edge(light(**(keys | {"aperture": 2.8, "shutter_s": 0.004})).mean(axis=0))
    assert stopped == pytest.approx(math.sqrt((radius / 4) ** 2 + 2 / 12), rel=0.05)
    _, focused = edge(light(**(keys | {"focus_distance_m": DISTANCE})).mean(axis=0))
    assert focused < 0.6


def test_blades_keep_the_area():
    keys: dict[str, Any] = {
        "samples": 64,
        "iso": 10,
        "aperture": 1.4,
        "sensor_width_mm": 36.0,
        "focus_distance_m": 0.6,
    }
    round_, hexagon = (light(aperture_blades=b, **keys) for b in (0, 6))
    assert hexagon.mean() == pytest.approx(round_.mean(), rel=2e-3)
    assert edge(hexagon.mean(axis=0))[1] == pytest.approx(edge(round_.mean(axis=0))[1], rel=0.05)  # 2 % apart in theory


def test_lateral_colour_grows_to_the_corner():
    """At radius r of the corner's, red is r * a larger and blue smaller."""
    turned = {
        "orientation_deg": (0, 0, -25),
        "chromatic_aberration": 0.02,
        "tone": "linear",
        "bits": 16,
        "width_px": 320,
    }
    plain = shot(**(turned | {"chromatic_aberration": 0.0})).truth[0, 31].astype(float)
    coloured = shot(**turned).truth[0, 31].astype(float)
    at = edge(plain[:, 1])[0]
    assert edge(coloured[:, 1])[0] == pytest.approx(at, abs=0.01)
    cx = 159.5
    corner = math.hypot(cx, 31.5)
    shift = (at - cx) * 0.02 * abs(at - cx) / corner
    assert edge(coloured[:, 0])[0] - edge(plain[:, 0])[0] == pytest.approx(shift, abs=0.25)
    assert edge(coloured[:, 2])[0] - edge(plain[:, 2])[0] == pytest.approx(-shift, abs=0.25)


def test_bloom_spreads_light_and_keeps_it():
    plain, glowing = light(), light(bloom=4.0)
    assert glowing.mean() == pytest.approx(plain.mean(), rel=0.02)  # edges repeat, so a little comes or goes
    assert glowing[:, 85:95].mean() > 1.3 * plain[:, 85:95].mean()
    twice = light(bloom=8.0)[:, 85:95] - plain[:, 85:95]
    assert twice == pytest.approx(2 * (glowing - plain)[:, 85:95], abs=3)  # of 65535: each is rounded


def test_flare_shows_bright_light_on_the_other_side():
    assert light(lens_flare=8.0)[:, 120:].mean() > 1.5 * light()[:, 120:].mean()


def test_vignette_is_cos_to_the_fourth():
    plain, dimmed = light(), light(vignette=1.0)
    x = -(np.arange(160) - 79.5) / focal()
    y = (31 - 31.5) / focal()
    expected = (1 + x**2 + y**2) ** -2
    assert dimmed[31, :70] / plain[31, :70] == pytest.approx(expected[:70], rel=2e-3)


def test_white_temperature_and_tint():
    assert balance_gains(6500, 0.0) == pytest.approx((1, 1, 1))
    r, g, b = balance_gains(3000, 0.0)
    assert r < g < b  # lamplight is red: red is taken back
    assert balance_gains(6500, 1.0) == pytest.approx((1, 0.5, 1))
    warm = shot(white_temperature_k=12000.0, tone="linear").truth.mean(axis=(0, 1, 2))
    cold = shot(white_temperature_k=3000.0, tone="linear").truth.mean(axis=(0, 1, 2))
    assert warm[0] / warm[2] > cold[0] / cold[2]


def test_film_passes_through_grey_and_bends_at_both_ends():
    x = jit.Float64(np.geomspace(1e-5, 50, 400))
    y = np.array(film(x, FilmCurve()))
    assert (np.diff(y) >= -1e-9).all()
    assert y[0] < 0.01
    assert y[-1] > 0.98
    assert float(film(jit.Float64(0.18), FilmCurve())[0]) == pytest.approx(0.18, abs=0.012)
    steep = float(film(jit.Float64(0.36), FilmCurve(slope=1.2))[0])
    assert steep > float(film(jit.Float64(0.36), FilmCurve(slope=0.6))[0])
    dark = float(film(jit.Float64(0.005), FilmCurve(toe=0.7))[0])
    assert dark < float(film(jit.Float64(0.005), FilmCurve(toe=0.3))[0])
    clipped = film(jit.Float64(0.002), FilmCurve(black_clip=0.05))
    assert float(clipped[0]) < float(film(jit.Float64(0.002), FilmCurve())[0])


def test_gamma_is_a_power():
    linear, curved = shot(tone="linear", bits=16), shot(tone="gamma", gamma=2.0, highlight_knee=1.0, bits=16)
    assert curved.truth / 65535 == pytest.approx(np.sqrt(linear.truth / 65535), abs=5e-3)


def test_bits_and_mosaic():
    full = shot(bits=12)
    assert full.data.dtype == np.uint16
    assert full.data.max() <= 4095
    raw = shot(mosaic="rggb")
    rgb = shot()
    assert raw.data.shape == (1, 64, 160)
    assert np.array_equal(raw.truth[0, ::2, ::2], rgb.truth[0, ::2, ::2, 0])
    assert np.array_equal(raw.truth[0, ::2, 1::2], rgb.truth[0, ::2, 1::2, 1])
    assert np.array_equal(raw.truth[0, 1::2, 1::2], rgb.truth[0, 1::2, 1::2, 2])


@pytest.mark.parametrize("pattern", ["rggb", "bggr", "grbg", "gbrg"])
def test_a_mosaic_has_the_colours_of_its_name_row_by_row(pattern: str) -> None:
    """Of 7 by 3 pixels of three unequal colours each, counted from the corner that its picture begins in."""
    row, column = (a.ravel().astype(np.uint32) for a in np.mgrid[0:3, 0:7])
    colours = 1 + 3 * np.arange(63).reshape(21, 3)[::-1]
    where: Any = SimpleNamespace(row=jit.UInt32(row), column=jit.UInt32(column))
    signal = jit.Array3f(np.ascontiguousarray(colours.T / 255, dtype=np.float32))
    found = np.array(develop._packed(signal, where, CameraConfig(mosaic=pattern, tone="linear")))
    expected = ["rgb".index(pattern[2 * (r % 2) + c % 2]) for r, c in zip(row, column, strict=True)]
    assert found.tolist() == colours[np.arange(21), expected].tolist()


@pytest.mark.parametrize("bits", [8, 12])
def test_colours_stand_side_by_side_whatever_their_bits(bits: int) -> None:
    """Four pixels stand in three words up to 8 bits, one in two beyond; two pictures of 16 by 16."""
    config = CameraConfig(bits=bits, tone="linear", width_px=16, height_px=16)
    colours = np.random.default_rng(4).integers(0, 2**bits, (512, 3))
    signal = jit.Array3f(np.ascontiguousarray(colours.T / (2**bits - 1), dtype=np.float32))
    packed = develop._packed(signal, SimpleNamespace(), config)  # type: ignore[arg-type]
    packed = develop._three_words(packed) if bits == 8 else packed
    assert develop.unpack_pictures(packed, config, 2).reshape(512, 3).tolist() == colours.tolist()


def test_colours_shift_along_both_axes_from_the_middle():
    """Of light that grows linearly, red a x + b y is there read at x (1 - g), and blue at x (1 + g): g is 3 % of the
    way from 0.2 of the corner's radius outwards.
    """
    tiling, config = Tiling(48, 32), CameraConfig(chromatic_aberration=0.03, chromatic_aberration_start=0.2)
    where = pixels(tiling, 1)
    column, row = np.array(where.column), np.array(where.row)
    x, y = column - 23.5, row - 15.5
    light = jit.Array3f(*(jit.Float(v) for v in (3.0 * x - 2.0 * y, 0.0 * x, 1.5 * x + 4.0 * y)))
    found = np.array(develop._lateral_colour(light, where, tiling, config))
    grow = 0.03 * np.clip((np.hypot(x, y) / math.hypot(23.5, 15.5) - 0.2) / 0.8, 0, 1)
    inner = (np.abs(x) < 22) & (np.abs(y) < 14)  # beyond, blue comes from outside the picture
    assert found[0][inner] == pytest.approx(((3.0 * x - 2.0 * y) * (1 - grow))[inner], abs=2e-4)
    assert found[2][inner] == pytest.approx(((1.5 * x + 4.0 * y) * (1 + grow))[inner], abs=2e-4)


def test_ghosts_lie_across_the_middle_or_before_it():
    """What is s from the middle shows at -0.6 s, at -1.3 s with a half and at 0.45 s with 0.35 of the strength."""
    tiling = Tiling(112, 80)
    where = pixels(tiling, 1)
    x, y = np.array(where.column) - 55.5, np.array(where.row) - 39.5
    tile_y, tile_x = (a.ravel() * 16.0 for a in np.mgrid[-2:3, -3:4])  # of the tiles' middles from the picture's
    coarse = jit.Array3f(*(jit.Float(v) for v in (tile_x, tile_y, 1.0 + 0.0 * tile_x)))
    found = np.array(develop._ghosts(coarse, where, tiling))
    inner = (np.abs(x) < 0.45 * 48) & (np.abs(y) < 0.45 * 32)
    share = -1.0 / 0.6 - 0.5 / 1.3 + 0.35 / 0.45
    assert found[0][inner] == pytest.approx(share * x[inner], abs=1e-4)
    assert found[1][inner] == pytest.approx(share * y[inner], abs=1e-4)
    assert found[2] == pytest.approx(1.85)


def test_the_middle_weighs_e_times_as_much_as_what_is_035_of_half_the_picture_off():
    tiling = Tiling(200, 120)
    where: Any = SimpleNamespace(column=jit.UInt32([100, 135, 100, 30]), row=jit.UInt32([60, 60, 39, 81]))
    found = np.array(develop.meter_weight(where, tiling, CameraConfig(metering="centre")))
    u, v = (np.array([100, 135, 100, 30]) + 0.5) / 100 - 1, (np.array([60, 60, 39, 81]) + 0.5) / 60 - 1
    assert found == pytest.approx(np.exp(-(u * u + v * v) / 0.35**2), rel=1e-4)
    assert np.array(develop.meter_weight(where, tiling, CameraConfig())).tolist() == [1.0] * 4


@pytest.mark.parametrize(("rate", "longest"), [(20.0, 0.05), (2.0, 0.2)])
def test_an_exposure_ends_before_the_next_frame(rate: float, longest: float) -> None:
    """In the dark, whatever time the meter would like."""
    dim: dict[str, Any] = {"exposure": "auto", "shutter_s": 0.2, "rate_hz": rate, "aperture": 16.0, "iso": 1.0}
    assert shot(x=30.0, **dim).extras["exposure_s"] == pytest.approx(longest, rel=1e-6)


def test_grey_worlds_make_the_channels_means_alike():
    """Gains G/R and G/B of each picture, to 4 and a quarter at most."""
    tiling, config = Tiling(20, 16), CameraConfig(white_balance="grey_world")
    where = pixels(tiling, 2)
    first = np.array(where.image) == 0
    part = np.where(np.array(where.row) < 8, 1.5, 0.5)
    light = jit.Array3f(*(jit.Float(part * np.where(first, a, b)) for a, b in ((0.5, 6.0), (1.0, 2.0), (3.0, 0.1))))
    gains = np.array(develop.balance(light, where, tiling, config)).T
    np.testing.assert_allclose(gains[first], np.tile([2.0, 1.0, 1 / 3], (first.sum(), 1)), rtol=1e-5)
    np.testing.assert_allclose(gains[~first], np.tile([1 / 3, 1.0, 4.0], ((~first).sum(), 1)), rtol=1e-5)


def test_meter_that_believes_one_luminance_is_fixed():
    keys: dict[str, Any] = {"exposure": "auto", "meter_min_cd_m2": 500.0, "meter_max_cd_m2": 500.0}
    near, far = shot(x=1.0, **keys), shot(x=6.0, **keys)
    assert near.extras["exposure_s"] == pytest.approx(far.extras["exposure_s"])
    centre = shot(exposure="auto", metering="centre", orientation_deg=(0, 0, 20))
    average = shot(exposure="auto", orientation_deg=(0, 0, 20))
    assert centre.extras["exposure_s"] < average.extras["exposure_s"]  # the middle is white


def test_pixels_are_no_wider_off_the_axis():
    """One pixel's box and the difference's, (1 + 1)/12, and a little of the water's scattering, where the edge is 50
    degrees off a pinhole's axis too; rays over the angle of the middle's pixels would make 2.4 px and 0.76.
    """
    aside = {"position_m": (0.0, 2.4, 0.0), "horizontal_fov_deg": 120, "samples": 64}
    place, width = edge(light(**aside)[26:38].mean(axis=0))
    assert place == pytest.approx(79.5 + 80 / math.tan(math.radians(60)) * 2.4 / DISTANCE, abs=0.2)
    assert math.sqrt(2 / 12) < width < 0.55


def test_vignette_of_a_fisheye_leaves_light_at_a_right_angle():
    """sin(a)/a, 64 % at 90 degrees, where cos^4 leaves none."""
    angle = math.radians(90)
    directions = np.array([[[1.0, 0.0, 0.0], [math.cos(angle), math.sin(angle), 0.0]]])
    assert natural_vignette(directions, 1.0, fisheye=True)[0] == pytest.approx([1.0, 2 / math.pi])
    assert natural_vignette(directions, 0.5)[0] == pytest.approx([1.0, 0.0], abs=1e-12)


def test_samples_smooth_the_edge():
    hard, soft = light(samples=1), light(samples=32)
    between = lambda p: np.mean((p > 0.2 * p.max()) & (p < 0.8 * p.max()))
    assert between(soft) >= between(hard)
    assert soft.mean() == pytest.approx(hard.mean(), rel=0.02)


def test_fisheye_is_equidistant_and_inverts():
    straight = fisheye_intrinsics(640, 640, math.radians(180), (0.0,) * 5)
    assert straight.fx == pytest.approx(640 / math.pi)
    k = (-0.02, 0.004, -0.001, 0.0, 0.0)
    camera = fisheye_intrinsics(640, 640, math.radians(180), k)
    d = fisheye_directions(camera, k)
    v, u = np.mgrid[:640, :640]
    seen = np.isfinite(d[..., 0])
    uv = project_fisheye(d * 3.0, camera, k)
    assert np.abs(uv[..., 0] - u)[seen].max() < 1e-6
    assert np.abs(uv[..., 1] - v)[seen].max() < 1e-6
    edge_angle = math.acos(d[320, 0, 0])
    assert float(kannala_brandt(np.array(edge_angle), k)) == pytest.approx(319.5 / camera.fx, rel=1e-3)


def test_flat_port_refracts_as_snell_says():
    """A ray 40 degrees off the axis in air leaves at asin(sin 40 / n), from d tan 40 + t tan(angle in glass)."""
    angle = math.radians(40)
    d = np.array([[math.cos(angle), math.sin(angle), 0.0]])
    start, out = through_flat_port(d, distance=0.03, thickness=0.012)
    glass = math.asin(math.sin(angle) / GLASS_INDEX)
    assert out[0] == pytest.approx([math.sqrt(1 - out[0, 1] ** 2), math.sin(angle) / REFRACTIVE_INDEX, 0], abs=1e-12)
    assert start[0] == pytest.approx([0.042, 0.03 * math.tan(angle) + 0.012 * math.tan(glass), 0], abs=1e-12)


def test_dome_around_the_pupil_bends_nothing():
    rng = np.random.default_rng(0)
    d = rng.normal(size=(50, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    start, out = through_dome_port(d, radius=0.05, thickness=0.006, offset=(0.0, 0.0, 0.0))
    assert out == pytest.approx(d, abs=1e-12)
    assert start == pytest.approx(d * 0.056, abs=1e-12)
    _, bent = through_dome_port(d, radius=0.05, thickness=0.006, offset=(0.01, 0.0, 0.0))
    assert np.abs(bent - d).max() > 1e-3


def test_flat_port_magnifies_the_picture():
    """The edge of a plate at y = 0.3 m moves outwards by about the index of water."""
    keys: dict[str, Any] = {"orientation_deg": (0, 0, 0), "position_m": (0.0, -0.25, 0.0), "width_px": 320}
    dry = edge(light(**keys)[31])[0] - 159.5
    wet = edge(light(port={"type": "flat"}, **keys)[31])[0] - 159.5
    assert wet / dry == pytest.approx(REFRACTIVE_INDEX, rel=0.03)


def test_unknown_keys_and_wrong_values_are_refused():
    with pytest.raises(ValidationError):
        CameraConfig(ISO=100)
    with pytest.raises(ValidationError):
        CameraConfig(bits=17)


@pytest.mark.parametrize(("width", "fov"), [(6.4, 70.0), (13.2, 90.0), (5.0, 178.0)])
def test_the_focal_length_spans_half_the_sensor_over_half_the_view(width: float, fov: float):
    """f = w / (2 tan(fov / 2)), of at most 175 degrees; a sensor of 13.2 mm that sees 90 degrees has one of 6.6 mm."""
    config = CameraConfig(sensor_width_mm=width, horizontal_fov_deg=fov, focus_distance_m=2.0, lens="fisheye")
    half = np.radians(min(fov, 175.0) / 2)
    assert config.focal_length_m == pytest.approx(width / 2000 * np.cos(half) / np.sin(half))
