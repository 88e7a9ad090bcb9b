"""Poses in description files: a rotation `(3, 3)` and a place `(3,)`, written in half a dozen ways."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Pose: TypeAlias = tuple[NDArray[np.float64], NDArray[np.float64]]


def identity() -> Pose:
    """Neither turned nor shifted."""
    return np.eye(3), np.zeros(3)


def compose(a: Pose, b: Pose) -> Pose:
    """b, given in a's frame, in the frame of a."""
    return a[0] @ b[0], a[0] @ b[1] + a[1]


def numbers(text: str, count: int | None = None) -> NDArray[np.float64]:
    """The numbers of an attribute.

    Raises:
        ValueError: a word that is none, or not as many as `count`.
    """
    found = np.array([float(v) for v in text.split()], dtype=np.float64)
    if count is not None and len(found) != count:
        raise ValueError(f"{text!r} is not {count} numbers")
    return found


def from_quaternion(w: float, x: float, y: float, z: float) -> NDArray[np.float64]:
    """The rotation of a quaternion of any length but zero."""
    from scipy.spatial.transform import Rotation  # a quarter of the time that all imports take

    return np.asarray(Rotation.from_quat([x, y, z, w]).as_matrix())


def from_axis(axis: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """A turn about an axis of any length [rad]."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix())


def from_euler(angles: NDArray[np.float64], order: str) -> NDArray[np.float64]:
    """Turns about x, y, z in this order [rad]: small letters about the turned axes, capitals about the fixed ones."""
    from scipy.spatial.transform import Rotation

    moving = order.islower()  # SciPy writes it the other way round
    return np.asarray(Rotation.from_euler(order.upper() if moving else order.lower(), angles).as_matrix())


def from_columns(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation whose first two columns point along x and, about, along y."""
    a = x / np.linalg.norm(x)
    b = y - (y @ a) * a
    b = b / np.linalg.norm(b)
    return np.stack([a, b, np.cross(a, b)], axis=1)


def to_axis(z: NDArray[np.float64]) -> NDArray[np.float64]:
    """The shortest turn that takes the z axis along a direction."""
    along = z / np.linalg.norm(z)
    axis = np.cross([0.0, 0.0, 1.0], along)
    length = float(np.linalg.norm(axis))
    if length < 1e-12:
        return np.diag([1.0, math.copysign(1.0, along[2]), math.copysign(1.0, along[2])])
    return from_axis(axis, math.atan2(length, float(along[2])))
