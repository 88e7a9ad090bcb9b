"""A manoeuvre that was run, and its track."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pelagos.manoeuvres.measures import Measure


@dataclass(frozen=True)
class Track:
    """Record of a trial: time [s], position NED `(n, 3)` [m], attitude roll, pitch, heading (unwrapped) `(n, 3)` [rad],
    velocity in body axes FRD `(n, 3)` [m/s], rates FRD `(n, 3)` [rad/s], commands `(n, k)`.
    """

    time: NDArray[np.float64]
    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    velocity: NDArray[np.float64]
    rates: NDArray[np.float64]
    commands: NDArray[np.float64]


@dataclass(frozen=True)
class Trial:
    """A manoeuvre that was run: its name, what was ordered, the ship's size, the track, its numbers, when the helm was
    ordered [s], a spiral's steady states `(n, 2)` in the order of the run: helm [deg], yaw rate [deg/s]; the rudder's
    column of the track's commands; the vehicle's variant.
    """

    name: str
    ordered: str
    vehicle: str
    length_m: float
    beam_m: float
    track: Track
    measures: list[Measure]
    switched_s: NDArray[np.float64]
    steady: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 2)))
    rudder: int = 0
    variant: str | None = None

    @property
    def title(self) -> str:
        """One line: vehicle and variant, manoeuvre, what was ordered."""
        variant = "" if self.variant is None else f", variant {self.variant}"
        return f"{self.vehicle}{variant}: {self.name}, {self.ordered}"
