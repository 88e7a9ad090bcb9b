"""States of a vehicle as a control law is told of them, in many lanes at once, and what a test makes of its answer."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.vehicles.flow import Flow

LANES = 200
H = 0.04
ECHO: Any = SimpleNamespace(commands=lambda wrench: dict(enumerate(wrench)))  # gives back what it is asked for


def lanes(values: Any) -> Any:
    return jit.Float64(np.ascontiguousarray(np.broadcast_to(values, LANES), dtype=np.float64))


def number(values: Any) -> np.ndarray:
    return np.broadcast_to(np.array(values, dtype=np.float64), LANES)


def drawn(seed: int, *sizes: float) -> list[np.ndarray]:
    random = np.random.default_rng(seed)
    return [size * random.uniform(-1, 1, LANES) for size in sizes]


def short(angle: Any) -> np.ndarray:
    return np.arctan2(np.sin(angle), np.cos(angle))


class Scene:
    """Motions of both signs and any heading, as a law is told of them."""

    def __init__(self, seed: int = 1, fast: float = 2.0) -> None:
        random = np.random.default_rng(seed)
        self.place = random.uniform(-30, 30, (LANES, 3))
        self.euler = random.uniform(-1, 1, (LANES, 3)) * [0.6, 0.5, np.pi]
        self.nu = random.uniform(-1, 1, (LANES, 6)) * [fast, 0.4 * fast, 0.4 * fast, 0.5, 0.4, 0.6]
        self.water = random.uniform(-0.6, 0.6, (LANES, 3))
        self.rotation = Rotation.from_euler("ZYX", self.euler[:, ::-1]).as_matrix()  # FRD to NED

    @property
    def flow(self) -> Flow:
        nu = [lanes(v) for v in self.nu.T]
        nu_r = [*(lanes(v) for v in (self.nu[:, :3] - self.water).T), *nu[3:]]
        rotation = [[lanes(self.rotation[:, i, j]) for j in range(3)] for i in range(3)]
        place = [lanes(v) for v in self.place.T]
        return Flow(place, place[2], rotation, nu, nu_r, [lanes(0.0)] * 6)


def held(free: np.ndarray, old: np.ndarray, step: np.ndarray) -> np.ndarray:
    """An integral that stands still where it is not free; there must be lanes of both kinds."""
    assert 0.1 < free.mean() < 0.9
    return np.where(free, old + step, old)
