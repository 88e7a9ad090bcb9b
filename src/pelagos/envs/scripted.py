"""Throttles of a vehicle's thrusters for a force and a moment, as scripted baselines need them."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from pelagos.vehicles.vehicle import Vehicle


@cache
def mixer(vehicle: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Thrusts for a wrench `(k, 6)` by the pseudo-inverse, and the largest thrust of each side `(k,)` [N]."""
    actuators = Vehicle.from_catalogue(vehicle).model.actuators.values()
    effect = np.array([a.effect for a in actuators], dtype=np.float64).T  # type: ignore[attr-defined]
    limit: NDArray[np.float64] = np.array([min(-a.thrust_limits[0], a.thrust_limits[1]) for a in actuators])  # type: ignore[attr-defined]
    return np.asarray(np.linalg.pinv(effect, rcond=1e-3), dtype=np.float64), limit


def throttles(vehicle: str, force: NDArray[np.float64], moment: NDArray[np.float64]) -> NDArray[np.float32]:
    """`(n, k)` throttles for a force and a moment on the body, FLU `(n, 3)` each [N], [N m].

    Thrust goes with the square of the throttle, nearly; beyond the limit all throttles shrink together.
    """
    mix, limit = mixer(vehicle)
    turned = np.array([1.0, -1.0, -1.0])
    thrust = np.concatenate([force * turned, moment * turned], axis=1) @ mix.T  # (n, k)
    share = thrust / limit
    share /= np.maximum(np.abs(share).max(axis=1, keepdims=True), 1.0)
    return np.asarray(np.sign(share) * np.sqrt(np.abs(share)), dtype=np.float32)
