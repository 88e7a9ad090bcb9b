"""The water of the scene: waves, how it dims light, where the sun stands; and the settings that a page begins with."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pelagos.drawing.water import sampled
from pelagos.viewer.currents import first_current
from pelagos.viewer.sea_surface import SeaSurface


@dataclass(frozen=True)
class Water:
    """Look of the scene's water.

    Attributes:
        sea: the waves.
        attenuation: of light in red, green and blue [1/m].
        sunward: unit vector towards the sun, NWU.
        settings: what can be set of it, as it is now: `current` (speed [m/s], compass direction [deg]), `waves`
            (significant height [m], peak period [s], direction [deg]), `turbidity`, `sun` (elevation, azimuth [deg]).
    """

    sea: SeaSurface = field(default_factory=lambda: SeaSurface(np.zeros((0, 5))))
    attenuation: Sequence[float] = (0.28, 0.09, 0.075)
    sunward: Sequence[float] = (-0.5, 0.0, 0.866)
    settings: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, ocean: Any, place: NDArray[np.float64], t_s: float) -> Water:
        """The water of an ocean with the current of a place `(3,)` NWU [m]; in a thread that may use the device."""
        sea = SeaSurface.of(ocean)
        flow = sampled(first_current(ocean), np.asarray(place, dtype=np.float64)[None], np.array([t_s]))[0]
        settings = {
            "current": [round(float(np.hypot(flow[0], flow[1])), 2), round(compass(flow[0], flow[1]))],
            "waves": waves_of(sea),
            "turbidity": round(float(ocean.turbidity), 2),
            "sun": [round(math.degrees(float(a[0])), 1) for a in (ocean.sun_elevation, ocean.sun_azimuth)],
        }
        sunward = [round(float(v), 4) for v in np.array(ocean.sun_direction).ravel()]
        return cls(sea, [float(v) for v in np.array(ocean.water.attenuation)], sunward, settings)

    def message(self) -> dict[str, Any]:
        """For the page, JSON types."""
        return {
            "type": "water", "waves": np.round(self.sea.rows, 6).tolist(), "attenuation": list(self.attenuation),
            "sunward": list(self.sunward), "settings": dict(self.settings),
        }  # fmt: skip


def compass(north: float, west: float) -> float:
    """Compass direction [deg] of a horizontal vector NWU."""
    return math.degrees(math.atan2(-west, north)) % 360.0


def waves_of(sea: SeaSurface) -> list[float]:
    """Significant height [m], period [s] and compass direction [deg] of the largest component; zeros: a flat sea."""
    if not len(sea.rows) or not sea.rows[:, 4].any():
        return [0.0, 0.0, 0.0]
    kx, ky, frequency, _, _ = sea.rows[np.argmax(np.abs(sea.rows[:, 4]))]
    height = 4.0 * math.sqrt(float((sea.rows[:, 4] ** 2).sum()) / 2.0)
    return [round(height, 2), round(1.0 / float(frequency), 1), round(compass(float(kx), float(ky)))]
