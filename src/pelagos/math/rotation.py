"""Rotations of many lanes at once, NumPy: quaternions (w, x, y, z) that turn body vectors into world vectors.

Source: J. Sola, "Quaternion kinematics for the error-state Kalman filter", arXiv 1711.02508, Sections 1 and 4.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def product(p: Floats, q: Floats) -> Floats:
    """`(n, 4)` of R(p) R(q)."""
    a, b, c, d = p.T
    w, x, y, z = q.T
    return np.stack(
        [
            a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y, a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ],
        axis=-1,
    )  # fmt: skip


def from_vector(angle: Floats) -> Floats:
    """Quaternions `(n, 4)` of turns about vectors `(n, 3)` [rad] (exponential map)."""
    size = np.sqrt((angle * angle).sum(axis=-1, keepdims=True))
    half = 0.5 * np.sinc(0.5 * size / np.pi)
    return np.concatenate([np.cos(0.5 * size), half * angle], axis=-1)


def to_vector(q: Floats) -> Floats:
    """The turn `(n, 3)` [rad] of quaternions, the short way round."""
    q = np.where(q[:, :1] < 0, -q, q)
    size = np.sqrt((q[:, 1:] ** 2).sum(axis=-1, keepdims=True))
    angle = 2 * np.arctan2(size, q[:, :1])
    return np.asarray(q[:, 1:] * np.where(size > 1e-12, angle / np.maximum(size, 1e-300), 2.0))


def conjugate(q: Floats) -> Floats:
    """The inverse turn."""
    return np.asarray(q * np.array([1.0, -1.0, -1.0, -1.0]))


def skew(v: Floats) -> Floats:
    """`(n, 3, 3)` with skew(v) u = v x u."""
    x, y, z = v.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(-1, 3, 3)


def apply(m: Floats, v: Floats) -> Floats:
    """M v of `(n, 3, 3)` or `(3, 3)`, and `(n, 3)`: one small product a lane, so that its bytes do not depend on n."""
    return np.asarray((m @ v[..., None])[..., 0])
