"""Readings of a Doppler velocity log, apart from how they are written."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

NO_MERIT_MPS: Final = 10.0
"""Figure of merit of a velocity that is not known, as Nortek's DVL gives it [m/s]."""


@dataclass(frozen=True)
class DvlVelocity:
    """One ping; forward, right, down of the instrument.

    Attributes:
        t_ns: simulation time [ns].
        velocity: of the instrument over ground [m/s]; None without bottom lock.
        covariance: `(3, 3)` of the velocity [(m/s)^2]; zeros without bottom lock.
        altitude_m: above the bottom; None where unknown.
        ranges_m: along each of four beams.
        beam_velocity_mps: along each beam.
        beam_valid: which beams have an echo.
    """

    t_ns: int
    velocity: tuple[float, float, float] | None
    covariance: tuple[tuple[float, ...], ...]
    altitude_m: float | None
    ranges_m: tuple[float, ...]
    beam_velocity_mps: tuple[float, ...]
    beam_valid: tuple[bool, ...]

    @property
    def merit_mps(self) -> float:
        """Standard deviation of the velocity, its greatest axis [m/s]; `NO_MERIT_MPS` without bottom lock."""
        if self.velocity is None:
            return NO_MERIT_MPS
        return math.sqrt(max(self.covariance[i][i] for i in range(3)))

    @classmethod
    def of(cls, reading: Any, beams: Any) -> DvlVelocity:
        """From a reading of the sensor `dvl` (first copy), whose beams are unit vectors `(4, 3)` FLU."""
        e = reading.extras
        v = np.asarray(reading.data[0], dtype=np.float64)
        b = np.asarray(beams, dtype=np.float64)
        flip = np.array([1.0, -1.0, -1.0])
        spread = np.linalg.inv(b.T @ b) * float((np.asarray(e["sigma"][0]) ** 2).mean()) * np.outer(flip, flip)
        x, y, z = (v * flip).tolist()
        locked = bool(reading.valid[0]) and bool(np.isfinite(v).all())
        spread = spread if locked and np.isfinite(spread).all() else np.zeros((3, 3))
        altitude = float(e["altitude"][0])
        return cls(
            reading.t_ns, (x, y, z) if locked else None, tuple(tuple(row) for row in spread.tolist()),
            altitude if math.isfinite(altitude) else None, tuple(np.asarray(e["ranges"][0], float).tolist()),
            tuple(np.asarray(e["beam_velocity"][0], float).tolist()), tuple(bool(g) for g in e["beam_valid"][0]),
        )  # fmt: skip
