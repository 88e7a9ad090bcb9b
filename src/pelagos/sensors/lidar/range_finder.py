"""Range finder: single rays in directions of one's choice, without noise; for altimetry, bumpers and teaching."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, Literal, Self

import drjit as dr
import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.config.rate import Rate
from pelagos.jit import Array
from pelagos.raycast.rays import Hits
from pelagos.sensors.ray_sensor import Medium, RaySensor
from pelagos.sensors.recorded import Results
from pelagos.sensors.sensor import SensorConfig


class RangeFinderConfig(SensorConfig):
    """Rays from the sensor; by default one along its x axis."""

    type: Literal["range_finder"] = "range_finder"
    """The sensor's kind."""
    rate_hz: Rate = 10.0
    """Readings per second [Hz]; must divide the tick rate."""
    range_max_m: float = Field(default=50.0, gt=0)
    """Greatest distance [m]."""
    azimuth_deg: tuple[float, ...] = Field(default=(0.0,), min_length=1, max_length=65536)
    """Of each ray, from the x axis to the left [deg]."""
    elevation_deg: tuple[float, ...] = (0.0,)
    """Of each ray, upwards [deg]; one for each azimuth."""

    @model_validator(mode="after")
    def _as_many(self) -> Self:
        if len(self.azimuth_deg) != len(self.elevation_deg):
            raise ValueError(
                f"azimuth_deg and elevation_deg are of the same rays; given {len(self.azimuth_deg)} and "
                f"{len(self.elevation_deg)}"
            )
        return self


class RangeFinder(RaySensor):
    """See `RangeFinderConfig`.

    data, truth: `(m, rays)` float64, distance along each ray [m], NaN where it meets nothing; the vehicle's own hull
        and the sea surface are not met. Extra `label` `(m, rays)`, 0 for none.
    """

    TITLE: ClassVar[str] = "Range finder: distances along single rays"
    Config: ClassVar[type[SensorConfig]] = RangeFinderConfig
    SOURCES: ClassVar[tuple[str, ...]] = ()
    MAY_LACK: ClassVar[bool] = True

    def pattern(self, config: Any) -> ArrayLike:
        """Directions of the rays in the sensor frame FLU, `(r, 3)`."""
        a, e = np.radians(config.azimuth_deg), np.radians(config.elevation_deg)
        return np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=-1)

    def read(self, hits: Hits, medium: Medium, draw: Callable[[int], list[Array]], rays: int) -> Results:
        """Distances and labels."""
        lanes = dr.width(hits.t) // rays
        first = dr.arange(jit.UInt32, lanes) * rays
        distance = [
            dr.select(dr.gather(jit.Bool, hits.valid, first + i), dr.gather(jit.Float, hits.t, first + i), dr.nan)
            for i in range(rays)
        ]
        label = [dr.gather(jit.UInt32, hits.label, first + i) for i in range(rays)]
        return {"data": distance, "truth": distance, "label": label}
