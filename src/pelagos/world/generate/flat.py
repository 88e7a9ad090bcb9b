"""A flat seabed: the world for calibration, first steps and bare navigation."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from pelagos.math.geodesy import GeoOrigin
from pelagos.world.config import Positive, WorldConfig
from pelagos.world.material import material
from pelagos.world.site import Site
from pelagos.world.terrain import HeightField
from pelagos.world.world import World


class FlatConfig(WorldConfig):
    """A flat, level seabed under open water."""

    TITLE: ClassVar[str] = "A flat, level seabed of one material under open water"

    type: Literal["flat"] = "flat"
    """The kind of world."""
    depth_m: float = Field(default=20.0, gt=0)
    """Depth of the seabed below the mean sea surface [m]."""
    size_m: tuple[Positive, Positive] = (1000.0, 1000.0)
    """Extent along x (north) and y (west), about the origin [m]."""
    material: str = "sand"
    """Material of the seabed."""

    def build(self) -> World:
        """Build it of square cells, sixteen along the shorter side."""
        site = Site(user_labels=self.labels)
        spacing = min(self.size_m) / 16
        cells = [max(1, round(s / spacing)) for s in self.size_m]
        terrain = HeightField(
            x0=-cells[0] * spacing / 2,
            y0=-cells[1] * spacing / 2,
            spacing=spacing,
            z=np.full((cells[0] + 1, cells[1] + 1), -self.depth_m),
        )
        site.ground(terrain, material(self.material))
        origin = GeoOrigin(self.latitude_deg or 0.0, self.longitude_deg or 0.0)
        return site.world(
            name="flat", description=f"flat seabed of {self.material} at {self.depth_m:g} m", origin=origin
        )
