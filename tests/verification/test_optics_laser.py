"""Lasers and the shadows of lamps: conservation of light, geometry of triangulation, what stands in the way."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.spatial.transform import Rotation

from cases import slow
from oceans import lit_ocean
from pelagos import jit
from pelagos.optics.laser_beam import LaserBeam, laser_at, laser_glow, laser_loss
from pelagos.optics.phase import henyey_greenstein
from pelagos.optics.water import MEAN_COSINE, WaterOptics, water_optics
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.camera.camera import Camera
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.sensor import Kinematics, SensorContext
from pelagos.world.material import MATERIALS, material_tables


def laser(fan: float | None = None, spread: float = 5e-4) -> LaserBeam:
    return LaserBeam(
        jit.Array3f(0, 0.2, 0), jit.Array3f(1, 0, 0), jit.Array3f(0, 0, 1), jit.Array3f(3.0), jit.Float(1e-3),
        jit.Float(spread), None if fan is None else jit.Float(fan),
    )  # fmt: skip


def across(light: LaserBeam, x: float, half: float, footprint: float) -> float:
    """Flux through a plane square to the axis [lm], by a sum over a fine grid."""
    n = 801
    u = np.linspace(-half, half, n)
    y, z = (a.ravel() for a in np.meshgrid(u, u if light.fan is None else u * 0.02, indexing="ij"))
    point = jit.Array3f(jit.Float(np.full(n * n, x)), jit.Float(y + 0.2), jit.Float(z))
    lux, to_laser, _ = laser_at(light, jit.Array3f(0.0), point, jit.Float(footprint))
    cell = (u[1] - u[0]) ** 2 * (1 if light.fan is None else 0.02)
    return float((np.array(lux.y) * -np.array(to_laser.x)).sum() * cell)


@pytest.mark.parametrize("footprint", [0.0, 0.02])
def test_a_dot_keeps_its_light_at_any_distance_and_size_of_pixel(footprint: float):
    """2 P / (pi w^2) exp(-2 rho^2 / w^2) integrates to P."""
    for x in (0.5, 5.0):
        assert across(laser(), x, 0.06, footprint) == pytest.approx(3.0, rel=0.01)


def test_a_line_keeps_its_light():
    """30 degrees of fan through a plane at 3 m; its edges are soft over a degree."""
    assert across(laser(math.radians(30)), 3.0, 1.2, 0.0) == pytest.approx(3.0, rel=0.02)


def test_the_dot_grows_as_its_divergence_says():
    """Half width at e^-2: w^2 = w_0^2 + (x theta)^2."""
    for x in (1.0, 10.0):
        w = math.hypot(1e-3, 5e-4 * x)
        values = [
            float(laser_at(laser(), jit.Array3f(0.0), jit.Array3f(x, 0.2 + r, 0), jit.Float(0.0))[0].y[0])
            for r in (0.0, w)
        ]
        assert values[1] / values[0] == pytest.approx(math.exp(-2), rel=2e-3)


def test_the_beam_in_water_is_the_integral_of_single_scattering():
    """A ray that crosses the beam: the sum of E(s) beta exp(-c (r + s)) over the ray, 20 000 steps; 2 %, over which
    loss and angle vary within the beam."""
    water: WaterOptics = water_optics("1C")
    light, arrays = laser(spread=5e-3), water.arrays()
    d = (np.array([4.0, 0.2, 0.002]) / math.hypot(4.0, 0.2, 0.002)).tolist()
    got = np.array(laser_glow(light, arrays, jit.Array3f(*d), jit.Float(8.0), 0.0)[0]).ravel()
    s = np.linspace(0, 8, 400_001)
    point = jit.Array3f(*(jit.Float(s * c) for c in d))
    lux, to_laser, _ = laser_at(light, laser_loss(arrays), point, jit.Float(0.0))
    turn = np.array(dr.dot(to_laser, jit.Array3f(*d)))
    beta = np.outer(water.water_scattering, np.full(len(s), 1 / (4 * math.pi)))
    beta += np.outer(water.particle_scattering, np.array(henyey_greenstein(jit.Float(turn), MEAN_COSINE)))
    kept = np.exp(-np.outer(np.array(laser_loss(arrays)).ravel(), s))
    expected = trapezoid(np.array(lux) * beta * kept, s, axis=1)
    assert got == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_sheet_in_water_is_the_integral_of_single_scattering(side: float):
    """A line laser below or above the camera, turned to every side: the sum over a ray that crosses its sheet, as of a
    beam; beyond the fan and behind the laser there is none."""
    water: WaterOptics = water_optics("1C")
    turn = Rotation.from_euler("ZYX", [25.0, side * -20.0, 35.0], degrees=True)
    axis, across = turn.apply([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    at = np.array([0.3, 0.2, -0.6 * side])
    light = LaserBeam(
        *(jit.Array3f(v.tolist()) for v in (at, axis, across)), jit.Array3f(3.0), jit.Float(1e-3), jit.Float(5e-3),
        jit.Float(math.radians(50)),
    )  # fmt: skip
    arrays = water.arrays()
    for angle in (-15.0, 0.0, 20.0, 28.0, 180.0):
        meets = at + 2.0 * (
            math.cos(math.radians(angle)) * axis + math.sin(math.radians(angle)) * turn.apply([0, 1, 0])
        )
        d = (meets / np.linalg.norm(meets)).tolist()
        seen, place = laser_glow(light, arrays, jit.Array3f(d), jit.Float(8.0), 0.0)
        got = np.array(seen).ravel()
        assert np.array(place).ravel() == pytest.approx(meets, abs=1e-4)
        if abs(angle) > 25:
            assert not got.any()
            continue
        s = np.linspace(0, 8, 200_001)
        point = jit.Array3f(*(jit.Float(s * c) for c in d))
        lux, to_laser, _ = laser_at(light, laser_loss(arrays), point, jit.Float(0.0))
        turned = np.array(dr.dot(to_laser, jit.Array3f(d)))
        beta = np.outer(water.water_scattering, np.full(len(s), 1 / (4 * math.pi)))
        beta += np.outer(water.particle_scattering, np.array(henyey_greenstein(jit.Float(turned), MEAN_COSINE)))
        kept = np.exp(-np.outer(np.array(laser_loss(arrays)).ravel(), s))
        assert got == pytest.approx(trapezoid(np.array(lux) * beta * kept, s, axis=1), rel=0.03)


def quad(corners: list[list[float]]) -> Geometry:
    return Geometry(np.array(corners, dtype=float), np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32), 0, 7, 1)


def wall(x: float, z: float = -20.0) -> Geometry:
    return quad([[x, 50, z - 50], [x, -50, z - 50], [x, -50, z + 15], [x, 50, z + 15]])


def plate(x: float, y: float, half: float, z: float = -20.0) -> Geometry:
    return quad([[x, y + half, z - half], [x, y - half, z - half], [x, y - half, z + half], [x, y + half, z + half]])


def picture(geometries: list[Geometry], **camera: Any) -> Any:
    """Light `(height, width, 3)` [cd/m^2] of a camera 20 m deep at night that looks along x."""
    materials = [MATERIALS["white"]]
    world: Any = SimpleNamespace(material_tables=lambda: material_tables(materials), palette=materials)
    ocean = lit_ocean("I", -0.5)
    scene = Scene(geometries, copies=1)
    context = SensorContext("rov0.camera", 1, 5_000_000, scene, world, ocean, np.full(1, NO_BODY, np.uint32))
    zero, u = dr.zeros(jit.Float64, 1), dr.zeros(jit.UInt32, 1)
    none = jit.Array3f64(zero, zero, zero)
    motion = Kinematics(
        jit.Array3f64(zero, zero, zero - 20), jit.Array4f64(zero + 1, zero, zero, zero), none, none, none, none,
        jit.UInt64(u), u + 0, u + 0, u + 0,
    )  # fmt: skip
    dr.make_opaque(motion)  # one kernel serves all poses
    config = CameraConfig(
        width_px=128, height_px=96, horizontal_fov_deg=60, vignette=0.0, exposure="manual", tone="linear", bits=16,
        shutter_s=0.01, iso=400, ripple=0.0, **camera,
    )  # fmt: skip
    return Camera(config, context).sense(motion).truth[0].astype(float)


def centroid(image: Any) -> tuple[float, float]:
    """Column and row of the light's middle [px], of what is over a tenth of the brightest."""
    green = image[..., 1]
    green = np.where(green > 0.1 * green.max(), green, 0)
    row, column = np.mgrid[0 : green.shape[0], 0 : green.shape[1]]
    return float((green * column).sum() / green.sum()), float((green * row).sum() / green.sum())


@pytest.mark.parametrize("distance", [slow(1.0), slow(2.0), 4.0])
def test_two_parallel_dots_measure_length(distance: float):
    """Lasers 10 cm to both sides, parallel to the axis: 20 cm on the wall, as pixels f 0.2 / x apart (f = 110.85 px).

    Half a pixel: a dot's middle is found among a few pixels.
    """
    focal = 64 / math.tan(math.radians(30))
    for side in (0.1, -0.1):
        column, row = centroid(
            picture([wall(distance)], lasers=({"position_m": (0.0, side, 0.0), "flux_lm": 0.05},), max_range_m=20)
        )
        assert column == pytest.approx(63.5 - focal * side / distance, abs=0.5)
        assert row == pytest.approx(47.5, abs=0.5)


def test_a_line_on_a_step_shows_its_depth():
    """Structured light: a line from 30 cm above, 20 deg down, falls on the near plate higher than on the wall."""
    line = {"position_m": (0.0, 0.0, 0.3), "orientation_deg": (0.0, 10.0, 0.0), "fan_deg": 60.0, "flux_lm": 1.0}
    image = picture([wall(2.0), plate(1.5, 0.0, 0.3)], lasers=(line,))[..., 1]
    focal = 64 / math.tan(math.radians(30))
    for column, x in ((64, 1.5), (10, 2.0)):
        expected = 47.5 - focal * (0.3 - x * math.tan(math.radians(10))) / x
        # off the axis the sheet is still a plane through the laser: the row follows from depth alone
        assert int(image[:, column].argmax()) == pytest.approx(expected, abs=1.0)


def test_a_laser_ends_at_what_it_meets():
    """A plate before the wall takes the dot, and the beam in the water behind it."""
    beam = ({"position_m": (0.0, 0.5, 0.0), "flux_lm": 30.0},)
    free = picture([wall(6.0)], lasers=beam)
    held = picture([wall(6.0), plate(2.0, 0.5, 0.1)], lasers=beam)
    focal = 64 / math.tan(math.radians(30))
    dot = round(63.5 - focal * 0.5 / 6.0)
    assert free[47:49, dot - 1 : dot + 2, 1].max() > 50 * max(held[47:49, dot - 1 : dot + 2, 1].max(), 1.0)
    beyond = round(63.5 - focal * 0.5 / 4.0)
    assert free[47:49, beyond, 1].max() > 10 * max(held[47:49, beyond, 1].max(), 1.0)


def test_lamps_cast_shadows():
    """A plate a metre before the wall, a lamp 0.4 m to the left: the shadow lies to the right of the plate."""
    lamp = ({"position_m": (0.0, 0.4, 0.0), "beam_angle_deg": 120.0, "flux_lm": 500.0},)
    bare = picture([wall(3.0)], lamps=lamp)
    image = picture([wall(3.0), plate(2.0, 0.0, 0.15)], lamps=lamp)
    focal = 64 / math.tan(math.radians(30))
    middle = -0.4 * 0.5  # the ray from (0, 0.4) through (2, 0) meets x = 3 at y = -0.2
    column = round(63.5 - focal * (middle - 0.1) / 3.0)
    assert image[48, column, 1] < 0.2 * bare[48, column, 1]
    lit = round(63.5 - focal * 0.6 / 3.0)
    assert image[48, lit, 1] == pytest.approx(bare[48, lit, 1], rel=0.02)
