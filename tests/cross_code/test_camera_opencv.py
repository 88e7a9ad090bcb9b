"""OpenCV's calibration recovers our lenses from checkerboards that the camera itself took."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

from oceans import lit_ocean
from pelagos import jit
from pelagos.math.so3 import from_euler
from pelagos.optics.lens import fisheye_intrinsics, intrinsics
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.camera.camera import Camera
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.sensor import Kinematics, SensorContext
from pelagos.world.material import MATERIALS, material_tables

cv2 = pytest.importorskip("cv2")

SQUARE = 0.05  # [m]
INNER = (8, 6)  # corners where four squares meet
POSES = [  # x y z [m] of the camera, roll pitch yaw [deg]; the board is in the plane x = 0, its middle at z = -2
    ((-0.50, 0.00, -2.00), (0, 0, 0)),
    ((-0.45, 0.22, -2.00), (5, 0, -28)),
    ((-0.45, -0.22, -2.00), (-8, 0, 28)),
    ((-0.45, 0.00, -1.78), (12, 27, 0)),
    ((-0.45, 0.00, -2.22), (0, -27, 0)),
    ((-0.50, 0.18, -1.84), (30, 18, -20)),
    ((-0.50, -0.18, -2.16), (-25, -18, 20)),
]


def board() -> list[Geometry]:
    """Black and white squares with a white rim, in the plane x = 0, seen from -x."""
    columns, rows = INNER[0] + 1, INNER[1] + 1
    quads: list[list[list[float]]] = [[], []]
    for i in range(-1, columns + 1):
        for j in range(-1, rows + 1):
            inside = 0 <= i < columns and 0 <= j < rows
            y, z = (columns / 2 - i) * SQUARE, -2 + (rows / 2 - j) * SQUARE
            corners = [[0, y, z], [0, y - SQUARE, z], [0, y - SQUARE, z - SQUARE], [0, y, z - SQUARE]]
            quads[1 if inside and (i + j) % 2 == 0 else 0] += corners
    made = []
    for material, corners in enumerate(quads):
        first = np.arange(0, len(corners), 4)[:, None]
        faces = (first + np.array([[0, 1, 2, 0, 2, 3]])).reshape(-1, 3).astype(np.uint32)
        made.append(Geometry(np.array(corners, dtype=float), faces, material, 7, material + 1))
    return made


def pictures(**lens: Any) -> list[np.ndarray]:
    materials = [MATERIALS["white"], MATERIALS["black"]]
    world: Any = SimpleNamespace(material_tables=lambda: material_tables(materials), palette=materials)
    ocean = lit_ocean("I", 0.8, math.pi)
    scene = Scene(board(), copies=1)
    context = SensorContext("auv0.camera", 1, 5_000_000, scene, world, ocean, np.full(1, NO_BODY, np.uint32))
    config = CameraConfig(width_px=480, height_px=360, horizontal_fov_deg=64, samples=3, vignette=0.0, ripple=0.0,
                          read_noise_e=0.0, **lens)  # fmt: skip
    camera = Camera(config, context)
    return list(camera.sense(motion()).truth)


def motion() -> Kinematics:
    """One lane a pose."""
    zero, u = dr.zeros(jit.Float64, len(POSES)), dr.zeros(jit.UInt32, len(POSES))
    places = np.array([place for place, _ in POSES])
    turns = np.array([from_euler(*map(math.radians, angles)) for _, angles in POSES])
    none = jit.Array3f64(zero, zero, zero)
    made = Kinematics(jit.Array3f64(places.T), jit.Array4f64(turns.T), none, none, none, none, jit.UInt64(u), u + 0,
                      dr.arange(jit.UInt32, len(POSES)), u + 0)  # fmt: skip
    dr.eval(made)
    return made


def corners_of(images: list[np.ndarray]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    plane = np.zeros((INNER[0] * INNER[1], 3), np.float32)
    plane[:, :2] = np.mgrid[: INNER[0], : INNER[1]].T.reshape(-1, 2) * SQUARE
    objects, found = [], []
    for image in images:
        grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
        seen, corners = cv2.findChessboardCornersSB(grey, INNER, flags=cv2.CALIB_CB_ACCURACY)
        if seen:
            objects.append(plane)
            found.append(corners.astype(np.float32))
    return objects, found


def test_pinhole_with_distortion():
    """Focal length to 0.3 %, principal point to 0.7 px, and the radial curve to 0.1 px at 150 px from the middle."""
    distortion = (-0.22, 0.06, 0.001, -0.0015, 0.0)
    objects, found = corners_of(pictures(distortion=distortion))
    assert len(found) == len(POSES)
    truth = intrinsics(480, 360, math.radians(64))
    error, matrix, measured, _, _ = cv2.calibrateCamera(objects, found, (480, 360), None, None, flags=cv2.CALIB_FIX_K3)
    assert error < 0.1
    assert matrix[0, 0] == pytest.approx(truth.fx, rel=3e-3)
    assert matrix[1, 1] == pytest.approx(truth.fy, rel=3e-3)
    assert (matrix[0, 2], matrix[1, 2]) == pytest.approx((truth.cx, truth.cy), abs=0.7)
    r2 = (150 / truth.fx) ** 2
    k1, k2, p1, p2 = measured.ravel()[:4]
    assert 150 * r2 * (k1 + k2 * r2 - (distortion[0] + distortion[1] * r2)) == pytest.approx(0, abs=0.3)
    assert (p1, p2) == pytest.approx(distortion[2:4], abs=6e-4)


def test_fisheye():
    """Kannala and Brandt's lens: focal length to 0.5 %, principal point to 0.7 px."""
    distortion = (0.03, -0.012, 0.0, 0.0, 0.0)
    objects, found = corners_of(pictures(lens="fisheye", distortion=distortion))
    assert len(found) == len(POSES)
    truth = fisheye_intrinsics(480, 360, math.radians(64), distortion)
    shaped = [o.reshape(1, -1, 3).astype(float) for o in objects], [f.reshape(1, -1, 2).astype(float) for f in found]
    names = cv2.fisheye if hasattr(cv2.fisheye, "CALIB_FIX_SKEW") else cv2  # OpenCV 4 and 5
    flags = names.CALIB_RECOMPUTE_EXTRINSIC | names.CALIB_FIX_SKEW | names.CALIB_FIX_K3 | names.CALIB_FIX_K4
    error, matrix, _, _, _ = cv2.fisheye.calibrate(*shaped, (480, 360), np.eye(3), np.zeros((4, 1)), flags=flags)
    assert error < 0.1
    assert matrix[0, 0] == pytest.approx(truth.fx, rel=5e-3)
    assert (matrix[0, 2], matrix[1, 2]) == pytest.approx((truth.cx, truth.cy), abs=0.7)
