"""Lenses as ray generators: for each pixel, the direction it looks in (sensor frame: x forward, y left, z up). NumPy,
float64.

Pixel (0, 0) is the upper left one and its centre is (0, 0), as in OpenCV; u runs right, v down. In camera coordinates
of vision (x right, y down, z forward) a point (X, Y, Z) is at u = fx x' + cx, v = fy y' + cy, with (x', y') the
distorted (X/Z, Y/Z). Sources: D. C. Brown, Photogramm. Eng. 37:855 (1971); the 5-coefficient form (k1, k2, p1, p2,
k3) of OpenCV.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_STEPS = 40
_NEWTON_STEPS = 6  # from within a thousandth: 1e-6, 1e-12


@dataclass(frozen=True)
class Intrinsics:
    """Focal lengths and principal point [px], and image size [px]."""

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int

    def matrix(self) -> NDArray[np.float64]:
        """`(3, 3)` camera matrix K."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]], dtype=np.float64)


def intrinsics(width: int, height: int, horizontal_fov: float) -> Intrinsics:
    """Square pixels and a centred axis, for a field of view across the width [rad]."""
    f = 0.5 * width / math.tan(0.5 * horizontal_fov)
    return Intrinsics(f, f, 0.5 * (width - 1), 0.5 * (height - 1), width, height)


def pixel_grid(camera: Intrinsics) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Normalised image coordinates `(height, width)` of the pixels' centres, x right and y down."""
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    return np.asarray((u - camera.cx) / camera.fx), np.asarray((v - camera.cy) / camera.fy)


def brown_conrady(
    x: NDArray[np.float64], y: NDArray[np.float64], distortion: tuple[float, ...]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Undistorted (X/Z, Y/Z) -> distorted, with (k1, k2, p1, p2, k3)."""
    k1, k2, p1, p2, k3 = distortion
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return np.asarray(u, dtype=np.float64), np.asarray(v, dtype=np.float64)


def undistort(
    xd: NDArray[np.float64], yd: NDArray[np.float64], distortion: tuple[float, ...]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Inverse of `brown_conrady` by Newton's method, to rounding; NaN where the lens model folds back on itself."""
    k1, k2, p1, p2, k3 = distortion
    radius = np.hypot(xd, yd)
    scale = _undistorted_radius(radius, distortion) / np.where(radius > 0, radius, 1)
    x, y = xd * scale, yd * scale
    with np.errstate(all="ignore"):
        for _ in range(_NEWTON_STEPS):
            r2 = x * x + y * y
            radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
            slope = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3))  # of `radial`, over x or y
            xx = radial + x * x * slope + 2 * p1 * y + 6 * p2 * x
            yy = radial + y * y * slope + 6 * p1 * y + 2 * p2 * x
            xy = x * y * slope + 2 * p1 * x + 2 * p2 * y
            back_x, back_y = brown_conrady(x, y, distortion)
            dx, dy = back_x - xd, back_y - yd
            whole = xx * yy - xy * xy
            x, y = x - (yy * dx - xy * dy) / whole, y - (xx * dy - xy * dx) / whole
        back_x, back_y = brown_conrady(x, y, distortion)
        good = (np.hypot(back_x - xd, back_y - yd) < 1e-9) & (whole > 0)
    return np.where(good, x, np.nan), np.where(good, y, np.nan)


def _undistorted_radius(radius: NDArray[np.float64], distortion: tuple[float, ...]) -> NDArray[np.float64]:
    """Inverse of the radial part alone, to a thousandth, where it is one to one; NaN beyond."""
    k1, k2, _, _, k3 = distortion
    fold = math.sqrt(_first_root([7 * k3, 5 * k2, 3 * k1, 1.0]))

    def bent(r: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(r * (1 + r * r * (k1 + r * r * (k2 + r * r * k3))))

    most = 1.0
    while most < fold and bent(np.array(most)) < radius.max():
        most *= 1.5
    r = np.linspace(0, min(most, fold), 4096)
    return np.asarray(np.interp(radius, bent(r), r, right=np.nan))


def _first_root(polynomial: list[float]) -> float:
    """The least positive real root, of coefficients from the highest power down; infinity for none."""
    roots = np.atleast_1d(np.roots(polynomial))
    return min((float(z.real) for z in roots if abs(z.imag) < 1e-12 and z.real > 0), default=math.inf)


def pinhole_directions(camera: Intrinsics, distortion: tuple[float, ...] = (0.0,) * 5) -> NDArray[np.float64]:
    """`(height, width, 3)` unit directions in the sensor frame; NaN where the distortion has no inverse."""
    xd, yd = pixel_grid(camera)
    x, y = undistort(xd, yd, distortion) if any(distortion) else (xd, yd)
    return _unit(np.stack([np.ones_like(x), -x, -y], axis=-1))


def project(
    points: NDArray[np.float64], camera: Intrinsics, distortion: tuple[float, ...] = (0.0,) * 5
) -> NDArray[np.float64]:
    """Points `(..., 3)` in the sensor frame -> pixels `(..., 2)` (u, v); NaN behind the camera."""
    with np.errstate(all="ignore"):
        ahead = np.where(points[..., 0] > 0, points[..., 0], np.nan)
    x, y = brown_conrady(-points[..., 1] / ahead, -points[..., 2] / ahead, distortion)
    return np.stack([camera.fx * x + camera.cx, camera.fy * y + camera.cy], axis=-1)


def fisheye_intrinsics(width: int, height: int, horizontal_fov: float, distortion: tuple[float, ...]) -> Intrinsics:
    """Square pixels and a centred axis for a Kannala-Brandt lens that sees `horizontal_fov` across its width [rad]."""
    f = 0.5 * width / float(kannala_brandt(np.array(0.5 * horizontal_fov), distortion))
    return Intrinsics(f, f, 0.5 * (width - 1), 0.5 * (height - 1), width, height)


def kannala_brandt(theta: NDArray[np.float64], distortion: tuple[float, ...]) -> NDArray[np.float64]:
    """Angle to the axis [rad] -> radius on the image over the focal length, with (k1, k2, k3, k4).

    J. Kannala and S. S. Brandt, IEEE TPAMI 28:1335 (2006), doi 10.1109/TPAMI.2006.153, equation 6, k1 = 1 (OpenCV's
    fisheye).
    """
    k1, k2, k3, k4 = distortion[:4]
    t2 = theta * theta
    return np.asarray(theta * (1 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4)))))


def fisheye_reach(distortion: tuple[float, ...]) -> float:
    """Angle to the axis up to which a Kannala-Brandt lens is one to one [rad]: pi, or where its radius turns back."""
    k1, k2, k3, k4 = distortion[:4]
    return min(math.pi, math.sqrt(_first_root([9 * k4, 7 * k3, 5 * k2, 3 * k1, 1.0])))


def fisheye_directions(camera: Intrinsics, distortion: tuple[float, ...]) -> NDArray[np.float64]:
    """`(height, width, 3)` unit directions in the sensor frame; NaN beyond the lens's image circle."""
    x, y = pixel_grid(camera)
    radius = np.hypot(x, y)
    theta = _invert_radius(radius, distortion)
    scale = np.where(radius > 0, np.sin(theta) / np.where(radius > 0, radius, 1), 1.0)
    return np.stack([np.cos(theta), -x * scale, -y * scale], axis=-1)


def _invert_radius(radius: NDArray[np.float64], distortion: tuple[float, ...]) -> NDArray[np.float64]:
    """The angle of each radius by Newton's method; NaN past a half turn, or where the polynomial turns back."""
    k1, k2, k3, k4 = distortion[:4]
    theta = np.minimum(radius, math.pi)
    with np.errstate(all="ignore"):
        for _ in range(_STEPS):
            t2 = theta * theta
            slope = 1 + t2 * (3 * k1 + t2 * (5 * k2 + t2 * (7 * k3 + t2 * 9 * k4)))
            theta = theta - (kannala_brandt(theta, distortion) - radius) / slope
        good = (np.abs(kannala_brandt(theta, distortion) - radius) < 1e-9) & (theta >= 0) & (theta <= math.pi)
    return np.where(good, theta, np.nan)


def project_fisheye(
    points: NDArray[np.float64], camera: Intrinsics, distortion: tuple[float, ...]
) -> NDArray[np.float64]:
    """Points `(..., 3)` in the sensor frame -> pixels `(..., 2)` (u, v)."""
    across = np.hypot(points[..., 1], points[..., 2])
    r = kannala_brandt(np.arctan2(across, points[..., 0]), distortion) / np.where(across > 0, across, 1)
    return np.stack([camera.cx - camera.fx * r * points[..., 1], camera.cy - camera.fy * r * points[..., 2]], axis=-1)


def natural_vignette(directions: NDArray[np.float64], strength: float, *, fisheye: bool = False) -> NDArray[np.float64]:
    """`(height, width)` share of light at each pixel, to the power `strength`.

    A pinhole's is cos^4 of the angle to the axis: the pupil seen aslant, and pixels that cover less of the scene. A
    fisheye's pupil turns towards the light, and what is left is how much of the scene a pixel covers, sin(a) / a of
    an equidistant lens.
    """
    cosine = np.clip(directions[..., 0], -1, 1)
    if fisheye:
        return np.asarray(np.sinc(np.arccos(cosine) / math.pi) ** strength)
    return np.asarray(np.clip(cosine, 0, 1) ** (4 * strength))


def _unit(v: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True), dtype=np.float64)
