"""Water of a whole world, looked at when a sonar is built: how its sound speed changes by depth, place and time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.refraction import displacements

if TYPE_CHECKING:
    from pelagos.sensors.sensor import SensorContext

_GRID: Final = 9  # places each way over the world
_LEAST: Final = 2.0  # of a sonar's reach: half the size of what is looked at, however small the world is
_DEPTHS: Final = 65  # places of the water column
_HOURS: Final = (0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 24.0)


@dataclass(frozen=True)
class WaterSurvey:
    """Sound speed anywhere in a world, at any time of a day.

    Attributes:
        displacement: largest bend of a level ray aside over a reach, in parts of it.
        variation: largest change of the sound speed with the place, within a reach at one depth, in parts of it.
    """

    displacement: float
    variation: float


def survey(context: SensorContext, reach: float, bottom: float) -> WaterSurvey:
    """Look at water above `bottom` for rays of `reach` [m]; places and times that no file covers do not count."""
    depth = np.linspace(0.0, max(-bottom, 1.0), _DEPTHS)
    place = _places(context, reach)
    ways = np.array([(0.0, 0.0), (reach, 0.0), (-reach, 0.0), (0.0, reach), (0.0, -reach)])
    around = place[:, None, :] + ways  # (places, ways, 2)
    speeds = _speeds(context, around.reshape(-1, 2), depth).reshape(len(_HOURS), *around.shape[:2], _DEPTHS)
    here = speeds[:, :, 0]
    worst = displacements(depth, here.reshape(-1, _DEPTHS), reach)
    change = np.abs(speeds - here[:, :, None]) / here[:, :, None]
    return WaterSurvey(_largest(worst), _largest(change))


def _largest(values: NDArray[np.float64]) -> float:
    return float(np.max(values, initial=0.0, where=np.isfinite(values)))


def _places(context: SensorContext, reach: float) -> NDArray[np.float64]:
    """Places of the world `(places, 2)`: its origin, and a grid over its bounds, or over some reach."""
    low, high = np.full(2, -_LEAST * reach), np.full(2, _LEAST * reach)
    if context.world.geometries:
        bounds = context.world.bounds[:, :2]
        if np.isfinite(bounds).all():
            low, high = np.minimum(bounds[0], low), np.maximum(bounds[1], high)
    x, y = (low[k] + (high[k] - low[k]) * np.linspace(0.02, 0.98, _GRID) for k in range(2))
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    return np.concatenate([np.zeros((1, 2)), grid])


def _speeds(context: SensorContext, place: NDArray[np.float64], depth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sound speed `(hours, places, depths)` [m/s]."""
    hour, which, level = (
        a.ravel() for a in np.meshgrid(np.array(_HOURS), np.arange(len(place)), -depth, indexing="ij")
    )
    x, y, z = (np.ascontiguousarray(a) for a in (*place[which.astype(np.int64)].T, level))
    at = jit.Array3f64(jit.Float64(x), jit.Float64(y), jit.Float64(z))
    found = np.array(context.ocean.sound_speed(at, jit.Float64(hour * 3600.0)))
    return np.broadcast_to(found, hour.shape).reshape(len(_HOURS), len(place), len(depth))
