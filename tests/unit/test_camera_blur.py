"""Blur that differs from pixel to pixel: bodies that pass while the shutter is open, limits, haze, the diaphragm."""

from __future__ import annotations

import math
from dataclasses import replace
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
from pelagos.sensors.camera.picture.pixel_samples import _polygon
from pelagos.sensors.sensor import Kinematics, SensorContext
from pelagos.world.material import MATERIALS, material_tables

DISTANCE = 2.0
FOCAL = 80 / math.tan(math.radians(35))  # [px]
KEYS: dict[str, Any] = {"vignette": 0.0, "ripple": 0.0, "exposure": "manual", "shutter_s": 0.05, "width_px": 160,
                        "height_px": 96, "iso": 1, "samples": 64, "tone": "linear", "bits": 16}  # fmt: skip


def plate(x: float, half_y: float, half_z: float, material: int, instance: int) -> Geometry:
    corners = np.array([[x, half_y, -half_z], [x, -half_y, -half_z], [x, -half_y, half_z], [x, half_y, half_z]])
    return Geometry(corners, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32), material, 7, instance)


def context(velocity: tuple[float, float, float]) -> SensorContext:
    """A black wall 2.5 m ahead at 10 m depth, and a white plate 2 m ahead that moves."""
    materials = [MATERIALS["white"], MATERIALS["black"]]
    world: Any = SimpleNamespace(material_tables=lambda: material_tables(materials), palette=materials)
    ocean = lit_ocean("I", 1.2, math.pi)
    wall = plate(2.5, 40.0, 9.0, 1, 1)
    scene = Scene([Geometry(wall.vertices + np.array([0, 0, -10.0]), wall.faces, 1, 7, 1)], copies=1)
    scene.set_moving([(plate(DISTANCE, 0.3, 0.6, 0, 2), 0)])
    scene.move(np.array([[0.0, 0, -10]]), np.array([[1.0, 0, 0, 0]]), np.array([velocity]), np.zeros((1, 3)))
    return SensorContext("auv0.camera", 1, 5_000_000, scene, world, ocean, np.full(1, NO_BODY, np.uint32))


def ahead(velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Kinematics:
    zero, u = dr.zeros(jit.Float64, 1), dr.zeros(jit.UInt32, 1)
    vector = lambda v: jit.Array3f64(*(zero + float(c) for c in v))
    none = vector((0, 0, 0))
    motion = Kinematics(vector((0, 0, -10)), jit.Array4f64(zero + 1, zero, zero, zero), vector(velocity), none, none,
                        none, jit.UInt64(u), u + 0, u + 0, u + 0)  # fmt: skip
    dr.make_opaque(motion)  # one kernel serves all poses
    return motion


def row(
    velocity: tuple[float, float, float], own: tuple[float, float, float] = (0.0, 0.0, 0.0), turn: float = 0.0,
    **keys: Any,
) -> Any:  # fmt: skip
    """Mean green of the middle rows; `turn` to the left [rad/s]."""
    spin = jit.Array3f64(*(dr.opaque(jit.Float64, v) for v in (0.0, 0.0, turn)))
    motion = replace(ahead(own), angular_velocity=spin)
    picture = Camera(CameraConfig(**(KEYS | keys)), context(velocity)).sense(motion).truth[0]
    return picture[40:56, :, 1].astype(float).mean(axis=0)


def spread(values: Any) -> float:
    """Standard deviation [px] of the plate's right edge, from the derivative."""
    right = values[len(values) // 2 :]
    step = -np.diff(right)
    step = np.where(step > 0.03 * step.max(), step, 0.0)
    place = np.arange(len(step))
    mean = (step * place).sum() / step.sum()
    return float(math.sqrt((step * (place - mean) ** 2).sum() / step.sum()))


def box(length: float) -> float:
    """Deviation of a streak of that length [px]; the pixel and the difference add 1 / 12 each."""
    return math.sqrt((length**2 + 2) / 12)


def test_a_body_that_passes_leaves_a_streak_as_long_as_its_way():
    length = FOCAL * 1.2 * 0.05 / DISTANCE
    assert length > 3
    assert spread(row((0, 1.2, 0))) == pytest.approx(box(length), rel=0.05)
    assert spread(row((0, 0, 0))) < 0.6
    assert row((0, 1.2, 0)).sum() == pytest.approx(row((0, 0, 0)).sum(), rel=0.02)  # light is spread, not lost


def test_a_camera_that_moves_along_with_a_body_sees_it_sharp():
    assert spread(row((0, 1.2, 0), own=(0, 1.2, 0))) < 0.6


def test_the_limit_of_a_streak_counts_the_cameras_turn_against_a_bodys_way():
    got = spread(row((0, 1.2, 0), turn=-1.2 / DISTANCE, motion_blur_max=1.5 / 160))
    assert got == pytest.approx(box(1.5), rel=0.2)


def test_streaks_are_no_longer_than_the_limit():
    length = FOCAL * 1.2 * 0.05 / DISTANCE
    assert spread(row((0, 0, 0), own=(0, 1.2, 0))) == pytest.approx(box(length), rel=0.05)
    assert spread(row((0, 1.2, 0), motion_blur_max=1.5 / 160)) == pytest.approx(box(1.5), rel=0.1)
    got = spread(row((0, 0, 0), own=(0, 1.2, 0), motion_blur_max=1.5 / 160))
    assert got == pytest.approx(box(1.5), rel=0.15)  # the wall beside the plate is further, and its limit another


def test_small_bodies_leave_no_streak_where_so_asked():
    """The plate shows as 34 x 68 px: the radius of a disc of that area is 0.17 of the width."""
    assert spread(row((0, 1.2, 0), motion_blur_min_object=0.25)) < 0.6
    assert spread(row((0, 1.2, 0), motion_blur_min_object=0.1)) > 0.9


def test_haze_softens_what_is_far():
    """Of a disc of radius r an edge deviates by r / 2. At 2 m, ten times the distance of half, all of it shows."""
    radius = 16 * 320 / 1920
    soft = row((0, 0, 0), depth_blur_px=16, depth_blur_distance_m=0.2, width_px=320)
    assert spread(soft) == pytest.approx(math.sqrt((radius / 2) ** 2 + 2 / 12), rel=0.1)
    half = row((0, 0, 0), depth_blur_px=16, depth_blur_distance_m=2.0, width_px=320)
    assert spread(half) == pytest.approx(math.sqrt((radius / 4) ** 2 + 2 / 12), rel=0.15)
    assert spread(row((0, 0, 0), depth_blur_px=16, depth_blur_distance_m=2000.0, width_px=320)) < 0.6


def test_blades_show_as_the_diaphragm_closes():
    """Of a square, corners lie at sqrt(pi / 2) = 1.25 of the disc's radius; wide open there are none."""
    rng = np.random.default_rng(1)
    u, v = jit.Float(rng.random(20_000)), jit.Float(rng.random(20_000))
    for closed, farthest in ((0.0, 1.0), (1.0, math.sqrt(math.pi / 2)), (0.5, 0.5 + 0.5 * math.sqrt(math.pi / 2))):
        y, z = (np.array(c) for c in _polygon(u, v, 4, closed))
        assert np.hypot(y, z).max() == pytest.approx(farthest, rel=0.02)
    assert CameraConfig(aperture=2.0, aperture_widest=2.0).blades_closed == 0
    assert CameraConfig(aperture=3.0, aperture_widest=2.0).blades_closed == pytest.approx(0.5)
    assert CameraConfig(aperture=8.0, aperture_widest=2.0).blades_closed == 1
    assert CameraConfig().blades_closed == 1
