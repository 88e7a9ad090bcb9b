"""Between frames. Inside, Pelagos has one: world NWU, body FLU (x forward, y left, z up).

Fossen's formulas: world NED, body FRD. ROS: world ENU, body FLU. Only callers of `hydro`, `bridges` and `compat`
convert.
The first functions are for Dr.Jit arrays of components, those that end in `_np` for NumPy arrays `(..., 3)` and
`(..., 4)`.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.jit import Array

_HALF: Final = float(np.sqrt(0.5))


def flip_yz(v: Array) -> Array:
    """NWU <-> NED, and FLU <-> FRD: a half turn about x, its own inverse."""
    return type(v)(v[0], -v[1], -v[2])


def flip_quaternion(q: Array) -> Array:
    """q of (NWU, FLU) <-> q of (NED, FRD): both frames make a half turn about x."""
    return type(q)(q[0], q[1], -q[2], -q[3])


def flip_yz_np(v: NDArray[np.float64]) -> NDArray[np.float64]:
    """NWU <-> NED, and FLU <-> FRD, `(..., 3)`."""
    return np.asarray(v * np.array([1.0, -1.0, -1.0]))


def flip_quaternion_np(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """q of (NWU, FLU) <-> q of (NED, FRD), `(..., 4)` w first."""
    return np.asarray(q * np.array([1.0, 1.0, -1.0, -1.0]))


def nwu_to_enu_np(v: NDArray[np.float64]) -> NDArray[np.float64]:
    """NWU `(..., 3)` -> ENU."""
    return np.stack([-v[..., 1], v[..., 0], v[..., 2]], axis=-1)


def quaternion_nwu_to_enu_np(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Attitude (FLU to NWU) -> (FLU to ENU), `(..., 4)` w first: a quarter turn about up from the left."""
    w, x, y, z = (q[..., i] for i in range(4))
    return np.stack([w - z, x - y, x + y, w + z], axis=-1) * _HALF


def enu_to_nwu_np(v: NDArray[np.float64]) -> NDArray[np.float64]:
    """ENU `(..., 3)` -> NWU."""
    return np.stack([v[..., 1], -v[..., 0], v[..., 2]], axis=-1)


def quaternion_enu_to_nwu_np(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Attitude (FLU to ENU) -> (FLU to NWU), `(..., 4)` w first."""
    w, x, y, z = (q[..., i] for i in range(4))
    return np.stack([w + z, x + y, y - x, z - w], axis=-1) * _HALF
