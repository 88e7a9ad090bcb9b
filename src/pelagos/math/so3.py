"""Rotations as unit quaternions, scalar first (w, x, y, z): q turns body vectors into world vectors.

Arguments are Dr.Jit arrays (`Array4f64` or any 4-array; `Array3f64` or any 3-array); lanes are independent rotations.
Source: J. Sola, "Quaternion kinematics for the error-state Kalman filter", arXiv 1711.02508, Sections 1 and 4.
"""

from __future__ import annotations

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos.jit import Array


def rotate(q: Array, v: Array) -> Array:
    """R(q) v: a body vector seen from the world."""
    axis = type(v)(q[1], q[2], q[3])
    t = 2 * dr.cross(axis, v)
    return v + q[0] * t + dr.cross(axis, t)


def rotate_back(q: Array, v: Array) -> Array:
    """R(q)^T v: a world vector seen from the body."""
    axis = type(v)(-q[1], -q[2], -q[3])
    t = 2 * dr.cross(axis, v)
    return v + q[0] * t + dr.cross(axis, t)


def multiply(p: Array, q: Array) -> Array:
    """The quaternion of R(p) R(q)."""
    return type(p)(
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


def normalize(q: Array) -> Array:
    """The unit quaternion along q."""
    return q / dr.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])


def integrate(q: Array, omega: Array, h: Array) -> Array:
    """q after turning with body rates omega [rad/s] for h [s], exactly for constant rates (exponential map)."""
    half = 0.5 * h
    angle2 = dr.squared_norm(omega) * half * half
    angle = dr.sqrt(angle2)
    small = angle2 < 1e-12
    sinc = dr.select(small, 1 - angle2 / 6, dr.sin(angle) / dr.select(small, 1.0, angle))
    s = half * sinc
    return normalize(multiply(q, type(q)(dr.cos(angle), s * omega[0], s * omega[1], s * omega[2])))


def from_euler(roll: Array, pitch: Array, yaw: Array) -> tuple[Array, Array, Array, Array]:
    """(w, x, y, z) of R = Rz(yaw) Ry(pitch) Rx(roll), angles in rad, in whichever frame pair they were meant."""
    cr, sr = dr.cos(roll / 2), dr.sin(roll / 2)
    cp, sp = dr.cos(pitch / 2), dr.sin(pitch / 2)
    cy, sy = dr.cos(yaw / 2), dr.sin(yaw / 2)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def matrix(q: Array) -> list[list[Array]]:
    """R(q) by rows, of numbers or of arrays of any kind."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    return [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]


def matrix_np(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """R(q) in NumPy: `(..., 4)` -> `(..., 3, 3)`."""
    return np.stack([np.stack(row, axis=-1) for row in matrix(np.moveaxis(q, -1, 0))], axis=-2)


def euler_np(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Roll, pitch, yaw [rad] of R = Rz(yaw) Ry(pitch) Rx(roll) in NumPy: `(..., 4)` -> `(..., 3)`."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
    return np.stack([roll, pitch, yaw_np(q)], axis=-1)


def yaw_np(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """The last of `euler_np` alone: `(..., 4)` -> `(...)`."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    return np.asarray(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


def rotate_np(q: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    """R(q) v in NumPy: `(..., 4)`, `(..., 3)` -> `(..., 3)`."""
    t = 2 * cross_np(q[..., 1:], v)
    return np.asarray(v + q[..., :1] * t + cross_np(q[..., 1:], t))


def rotate_back_np(q: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    """R(q)^T v in NumPy, to the body's own axes: `(..., 4)`, `(..., 3)` -> `(..., 3)`."""
    return rotate_np(q * [1.0, -1.0, -1.0, -1.0], v)


def cross_np(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """a x b for NumPy rows `(..., 3)`: the bytes of `np.cross`, which takes six times as long for a few rows."""
    ax, ay, az, bx, by, bz = (c[..., i] for c in (a, b) for i in range(3))
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)
