"""Known things appear where OpenCV projects them, or where Fermat's principle says behind a port: to 0.1 px.

Squares of 30 to 40 px, turned by 20 degrees, stand across the field of view. Their outline is projected point by
point; the middle of that polygon is compared with the mean of the pixels that show the square. Counting pixels whose
middles lie inside errs by 0.29 px for each of the 150 on the outline, independently: 0.29 / sqrt(150) = 0.02 px.
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq, minimize

from pelagos import jit
from pelagos.optics.port import GLASS_INDEX
from pelagos.optics.water import REFRACTIVE_INDEX
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.camera.instance_camera import InstanceCamera, InstanceCameraConfig
from pelagos.sensors.camera.picture.camera_rays import view_intrinsics
from pelagos.sensors.sensor import Kinematics, SensorContext

cv2 = pytest.importorskip("cv2")

AHEAD = 3.0  # [m]
HALF = 0.09  # [m]
TURN = math.radians(20)
PLACES = [(y, z) for y in (-1.35, -0.7, 0.0, 0.7, 1.35) for z in (-0.9, 0.0, 0.9)]
TO_OPENCV = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]], dtype=float)  # forward left up -> right down forward


def outline(y: float, z: float) -> NDArray[np.float64]:
    """`(400, 3)` points along a square's edges, sensor frame [m]."""
    s = np.linspace(-HALF, HALF, 100, endpoint=False)
    one = np.full(100, HALF)
    around = np.concatenate([np.stack(p, 1) for p in ((s, -one), (one, s), (-s, one), (-one, -s))])
    c, s = math.cos(TURN), math.sin(TURN)
    return np.column_stack([np.full(400, AHEAD), y + around @ [c, -s], z + around @ [s, c]])


def squares() -> list[Geometry]:
    made = []
    for k, (y, z) in enumerate(PLACES):
        corners = outline(y, z)[::100] + np.array([0, 0, -10.0])
        made.append(Geometry(corners, np.array([[0, 2, 1], [0, 3, 2]], dtype=np.uint32), 0, 1, k + 1))
    return made


def middles(config: InstanceCameraConfig) -> dict[int, NDArray[np.float64]]:
    """Mean (column, row) of the pixels that show each square, with (columns, rows) away from the picture's edge."""
    zero, u = dr.zeros(jit.Float64, 1), dr.zeros(jit.UInt32, 1)
    none = jit.Array3f64(zero, zero, zero)
    motion = Kinematics(jit.Array3f64(zero, zero, zero - 10), jit.Array4f64(zero + 1, zero, zero, zero),
                        none, none, none, none, jit.UInt64(u), u, u + 0, u + 0)  # fmt: skip
    dr.make_opaque(motion)
    world: Any = SimpleNamespace(waves=None, tide=None)  # and the ocean
    scene = Scene(squares(), copies=1)
    context = SensorContext("auv0.view", 1, 5_000_000, scene, world, world, np.full(1, NO_BODY, np.uint32))
    ids = InstanceCamera(config, context).sense(motion).data[0]
    found = {}
    for k in range(1, len(PLACES) + 1):
        rows, columns = np.nonzero(ids == k)
        whole = len(rows) and rows.min() > 0 and columns.min() > 0
        if whole and rows.max() < config.height_px - 1 and columns.max() < config.width_px - 1:
            found[k] = np.array([columns.mean(), rows.mean()])
    return found


def centroid(polygon: NDArray[np.float64]) -> NDArray[np.float64]:
    """Middle of a polygon's area."""
    after = np.roll(polygon, -1, axis=0)
    cross = polygon[:, 0] * after[:, 1] - after[:, 0] * polygon[:, 1]
    return np.asarray(((polygon + after) * cross[:, None]).sum(axis=0) / (3 * cross.sum()))


def agree(config: InstanceCameraConfig, project: Any, least: int = 13) -> None:
    found = middles(config)
    assert len(found) >= least
    for k, seen in found.items():
        assert seen == pytest.approx(centroid(project(outline(*PLACES[k - 1]))), abs=0.1), PLACES[k - 1]


def matrix(config: InstanceCameraConfig) -> NDArray[np.float64]:
    lens = view_intrinsics(config)
    return np.array([[lens.fx, 0, lens.cx], [0, lens.fy, lens.cy], [0, 0, 1]])


@pytest.mark.parametrize("distortion", [(0.0,) * 5, (-0.18, 0.05, 0.002, -0.0015, -0.004)])
def test_pinhole_and_brown_conrady(distortion: tuple[float, ...]):
    config = InstanceCameraConfig(width_px=640, height_px=480, horizontal_fov_deg=66, distortion=distortion)

    def project(points: NDArray[np.float64]) -> NDArray[np.float64]:
        seen, _ = cv2.projectPoints(
            points @ TO_OPENCV.T, np.zeros(3), np.zeros(3), matrix(config), np.array(distortion)
        )
        return np.asarray(seen.reshape(-1, 2))

    agree(config, project)


def test_fisheye_of_kannala_and_brandt():
    distortion = (0.04, -0.015, 0.003, -0.0005, 0.0)
    config = InstanceCameraConfig(
        width_px=640, height_px=480, horizontal_fov_deg=80, lens="fisheye", distortion=distortion
    )

    def project(points: NDArray[np.float64]) -> NDArray[np.float64]:
        seen, _ = cv2.fisheye.projectPoints(
            (points @ TO_OPENCV.T).reshape(-1, 1, 3), np.zeros(3), np.zeros(3), matrix(config), np.array(distortion[:4])
        )
        return np.asarray(seen.reshape(-1, 2))

    agree(config, project)


def test_flat_port():
    """The angle in air at which a ray through air, glass and water comes out at the point: one root."""
    distance, thickness = 0.03, 0.012
    port = {"type": "flat", "distance_m": distance, "thickness_m": thickness}
    config = InstanceCameraConfig(width_px=640, height_px=480, horizontal_fov_deg=80, port=port)
    lens = view_intrinsics(config)

    def reaches(sine: float, x: float, radius: float) -> float:
        tan = [s / math.sqrt(1 - s * s) for s in (sine, sine / GLASS_INDEX, sine / REFRACTIVE_INDEX)]
        return distance * tan[0] + thickness * tan[1] + (x - distance - thickness) * tan[2] - radius

    def project(points: NDArray[np.float64]) -> NDArray[np.float64]:
        seen = []
        for x, y, z in points[::5]:
            radius = math.hypot(y, z)
            sine = brentq(reaches, 0, 0.99, args=(x, radius), xtol=1e-12) if radius > 1e-9 else 0.0
            slope = sine / math.sqrt(1 - sine * sine) / max(radius, 1e-9)
            seen.append((lens.cx - lens.fx * slope * y, lens.cy - lens.fy * slope * z))
        return np.array(seen)

    agree(config, project)


def test_dome_port_off_its_centre():
    """Fermat: light takes the way of least time from the point through both faces to the pupil."""
    inner, thickness, offset = 0.06, 0.008, 0.015
    port = {"type": "dome", "radius_m": inner, "thickness_m": thickness, "offset_m": (offset, 0, 0)}
    config = InstanceCameraConfig(width_px=640, height_px=480, horizontal_fov_deg=68, port=port)
    lens = view_intrinsics(config)

    def slope(radius: float) -> float:
        """Of the ray in the dry, to a point so far from the axis."""

        def time(angles: NDArray[np.float64]) -> float:
            dry, wet = (
                np.array([offset + r * math.cos(a), r * math.sin(a)])
                for r, a in zip((inner, inner + thickness), angles, strict=True)
            )
            legs = np.hypot(*dry), np.hypot(*(wet - dry)), math.hypot(AHEAD - wet[0], radius - wet[1])
            return float(legs[0] + GLASS_INDEX * legs[1] + REFRACTIVE_INDEX * legs[2])

        first = math.atan2(radius, AHEAD)
        best = minimize(time, [first, first], method="Nelder-Mead",
                        options={"xatol": 1e-9, "fatol": 1e-16, "maxiter": 4000})  # fmt: skip
        return inner * math.sin(best.x[0]) / (offset + inner * math.cos(best.x[0]))

    radii = np.linspace(0.0, 2.0, 21)  # the squares lie up to 1.8 m off the axis; smooth between these
    slopes = CubicSpline(radii, [slope(r) for r in radii])

    def project(points: NDArray[np.float64]) -> NDArray[np.float64]:
        radius = np.hypot(points[:, 1], points[:, 2])
        ratio = slopes(radius) / radius
        return np.column_stack([lens.cx - lens.fx * ratio * points[:, 1], lens.cy - lens.fy * ratio * points[:, 2]])

    agree(config, project)
