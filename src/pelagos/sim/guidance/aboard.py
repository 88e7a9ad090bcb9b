"""Knowledge of a vehicle on a mission, lane by lane."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Fix:
    """Motion as navigation knows it, lane by lane.

    Attributes:
        position: `(m, 3)` world NWU [m].
        heading: `(m,)` of the compass [rad].
        velocity: `(m, 3)` over ground, world NWU [m/s].
    """

    position: Floats
    heading: Floats
    velocity: Floats

    def take(self, lanes: NDArray[np.intp]) -> Fix:
        """Some lanes."""
        return Fix(self.position[lanes], self.heading[lanes], self.velocity[lanes])


@dataclass(frozen=True)
class Aboard:
    """Things aboard that guidance may look at.

    Attributes:
        own: motion of the vehicle itself.
        t_s: time [s].
        dt_s: time since guidance was asked before [s].
        altitude: `(m,)` last measured height above the seabed [m]; infinite where none was measured.
        fixed: `(m,)` whether a position fix arrived since guidance was asked before.
        readings: newest reading of sensors that the mission looks at, `(m, k)` by "sensor" or "sensor.array"; not a
            number where there is none.
        others: motion of other agents by name.
    """

    own: Fix
    t_s: float
    dt_s: float
    altitude: Floats
    fixed: NDArray[np.bool_]
    readings: Mapping[str, Floats] = field(default_factory=dict)
    others: Mapping[str, Fix] = field(default_factory=dict)

    @property
    def xy(self) -> Floats:
        """`(m, 2)` world x, y [m]."""
        return self.own.position[:, :2]

    @property
    def depth(self) -> Floats:
        """`(m,)` below the mean sea surface [m]."""
        return np.asarray(-self.own.position[:, 2])

    def __len__(self) -> int:
        return len(self.altitude)

    def take(self, lanes: NDArray[np.intp]) -> Aboard:
        """Some lanes."""
        return replace(
            self,
            own=self.own.take(lanes),
            altitude=self.altitude[lanes],
            fixed=self.fixed[lanes],
            readings={name: values[lanes] for name, values in self.readings.items()},
            others={name: fix.take(lanes) for name, fix in self.others.items()},
        )


def wrapped(angle: Floats) -> Floats:
    """The angle in [-pi, pi) [rad]."""
    return np.asarray((angle + np.pi) % (2 * np.pi) - np.pi)


def within(values: Floats, limit: float) -> Floats:
    """Values kept between -limit and limit (a tenth of the time of `numpy.clip` for a few lanes)."""
    return np.minimum(np.maximum(values, -limit), limit)


def bearing(to: Floats) -> Floats:
    """Compass bearing [rad] of horizontal vectors `(m, 2)` NWU."""
    return np.arctan2(-to[:, 1], to[:, 0])


def ahead(course: Floats) -> Floats:
    """Unit vectors `(m, 2)` NWU of compass courses [rad]."""
    return np.stack([np.cos(course), -np.sin(course)], axis=-1)
