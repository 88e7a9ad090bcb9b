"""`Reckoning`: the way of a Doppler log from where it began, by its velocities and its own attitude."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from drjit.scalar import Array3f64, Array4f64

from pelagos.bridges.autopilot import Three
from pelagos.bridges.instruments.dvl_velocity import DvlVelocity
from pelagos.math.so3 import euler_np, multiply, rotate

ORIGIN: Final = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Reckoning:
    """Pose in the axes that the instrument had when it began: forward, right, down.

    Attributes:
        position: [m].
        euler: roll, pitch, yaw [rad].
        variance_m2: of the position: errors of single pings are independent, and add up.
        locked: the last ping had bottom lock; without it the last velocity goes on.
        began: attitude at the beginning (w, x, y, z), to the world; None before the first ping.
        t_ns: time of the last ping [ns].
        velocity: last one that was known [m/s].
    """

    position: Three = ORIGIN
    euler: Three = ORIGIN
    variance_m2: float = 0.0
    locked: bool = False
    began: tuple[float, ...] | None = None
    t_ns: int = 0
    velocity: Three = ORIGIN

    def after(self, dvl: DvlVelocity, attitude: Sequence[float]) -> Reckoning:
        """With another ping, at an attitude (w, x, y, z) of the instrument to the world: the trapezoidal rule."""
        began = tuple(attitude) if self.began is None else self.began
        w, x, y, z = began
        turned: Any = multiply(Array4f64(w, -x, -y, -z), Array4f64(*attitude))
        velocity = self.velocity
        if dvl.velocity is not None:
            north, east, down = rotate(turned, Array3f64(*dvl.velocity))
            velocity = (float(north), float(east), float(down))
        known = self.velocity if self.locked else velocity
        step_s = 0.0 if self.began is None else (dvl.t_ns - self.t_ns) * 1e-9
        ahead, right, down_m = (
            p + 0.5 * (a + b) * step_s for p, a, b in zip(self.position, known, velocity, strict=True)
        )
        roll, pitch, yaw = euler_np(np.array([float(c) for c in turned])).tolist()
        return Reckoning(
            (ahead, right, down_m), (roll, pitch, yaw),
            self.variance_m2 + (dvl.merit_mps * step_s) ** 2, dvl.velocity is not None, began, dvl.t_ns, velocity,
        )  # fmt: skip

    @property
    def std_m(self) -> float:
        """Standard deviation of the position [m]."""
        return math.sqrt(self.variance_m2)
