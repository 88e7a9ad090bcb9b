"""HoloOcean's frames to Pelagos's, and back: angles of fixed axes in degrees, headings, quaternions.

Both worlds are right-handed with x north, y west and z up, in metres; so only angles and orders change.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pelagos.math.so3 import from_euler

Array = NDArray[np.float64]


def matrix_of(rotation: Sequence[float] | Array) -> Array:
    """`(3, 3)` R = Rz Ry Rx of roll, pitch, yaw [deg]: sensor or body to what it stands in."""
    r, p, y = (math.radians(float(a)) for a in rotation)
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(a), math.cos(a)) for a in (r, p, y))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def degrees_of(matrix: Array) -> Array:
    """Roll, pitch, yaw [deg] of R = Rz Ry Rx; where the nose stands up or down, yaw is 0."""
    sin = -matrix[2, 0]
    if abs(sin) > 1 - 1e-12:
        roll = math.atan2(math.copysign(1.0, sin) * matrix[0, 1], matrix[1, 1])
        return np.degrees([roll, math.copysign(math.pi / 2, sin), 0.0])
    return np.degrees(
        [
            math.atan2(matrix[2, 1], matrix[2, 2]),
            math.asin(min(max(sin, -1.0), 1.0)),
            math.atan2(matrix[1, 0], matrix[0, 0]),
        ]
    )


def quaternion_of(rotation: Sequence[float] | Array) -> Array:
    """(w, x, y, z) of roll, pitch, yaw [deg]."""
    return np.array([float(c) for c in from_euler(*(math.radians(float(a)) for a in rotation))])


def start_of(location: Sequence[float], rotation: Sequence[float]) -> dict[str, Any]:
    """The native `start` of an agent: compass heading and nose-up pitch."""
    roll, pitch, yaw = degrees_of(matrix_of(rotation))
    return {
        "position_m": [float(v) for v in location],
        "heading_deg": -float(yaw),
        "pitch_deg": -float(pitch),
        "roll_deg": float(roll),
        "anywhere": True,
    }
