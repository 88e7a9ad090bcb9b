"""Worlds built by hand: a level bed, or none, and what the scenario puts there."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from pelagos.math.geodesy import GeoOrigin
from pelagos.world.by_hand import add
from pelagos.world.config import Positive, WorldConfig
from pelagos.world.site import Site
from pelagos.world.terrain import HeightField
from pelagos.world.world import World


class BuiltConfig(WorldConfig):
    """A flat seabed, or none, with things placed one by one."""

    TITLE: ClassVar[str] = "Built by hand: primitives, meshes (OBJ, STL, PLY, glTF), URDF, SDF and MJCF files"

    PLACES_THINGS: ClassVar[bool] = True

    type: Literal["built"] = "built"
    """The kind of world."""
    depth_m: float | None = Field(default=20.0, gt=0)
    """Depth of a flat seabed [m]; null for no seabed."""
    size_m: tuple[Positive, Positive] = (200.0, 200.0)
    """Extent of the seabed [m]."""
    material: str = "sand"
    """Material of the seabed."""

    def build(self) -> World:
        """Build it.

        Raises:
            WorldError: a file cannot be used.
            LookupFailed: an unknown material or label.
        """
        site = Site(user_labels=self.labels)
        if self.depth_m is not None:
            site.ground(level(self.size_m, self.depth_m), self.material)
        origin = GeoOrigin(self.latitude_deg or 0.0, self.longitude_deg or 0.0)
        for thing in self.things:
            add(site, thing, origin)
        return site.world(name="built", description=f"{len(site.geometries)} things placed by hand", origin=origin)


def level(size: tuple[float, float], depth: float) -> HeightField:
    """A level height field about the origin."""
    spacing = min(size) / 16
    cells = [max(1, round(s / spacing)) for s in size]
    corner = -cells[0] * spacing / 2, -cells[1] * spacing / 2
    return HeightField(*corner, spacing, np.full((cells[0] + 1, cells[1] + 1), -depth))
