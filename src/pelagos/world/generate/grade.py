"""Ground raised or dug to a depth at chosen places: known soundings, dredged pockets, banks, islands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field, model_validator

from pelagos.config.described import Described
from pelagos.world.config import Positive
from pelagos.world.generate.relief import smoothstep
from pelagos.world.terrain import HeightField


class GradeConfig(Described):
    """A disc, or a rectangle along x and y, where the ground has a depth of its own."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    at_m: tuple[float, float]
    """Its middle x, y [m]."""
    radius_m: float | None = Field(default=None, gt=0)
    """Radius of a disc [m]."""
    size_m: tuple[Positive, Positive] | None = None
    """Extent of a rectangle along x and y [m], instead of `radius_m`."""
    depth_m: float = Field(ge=-1000, le=12000)
    """Mean depth of the ground there [m]; negative for land."""
    relief: float = Field(default=1.0, ge=0, le=1)
    """How much of the natural relief is left there: 0 for level ground."""
    blend_m: float = Field(default=20.0, gt=0)
    """Over how far from its edge the ground returns to its natural height [m]."""

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        if (self.radius_m is None) == (self.size_m is None):
            raise ValueError("give radius_m of a disc, or size_m of a rectangle")
        return self

    def distance(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """`(nx, ny)` how far each node at `x (nx,)`, `y (ny,)` lies outside the shape [m]; 0 within it."""
        dx, dy = np.abs(x - self.at_m[0])[:, None], np.abs(y - self.at_m[1])[None, :]
        if self.radius_m is not None:
            return np.asarray(np.maximum(np.hypot(dx, dy) - self.radius_m, 0.0), dtype=np.float64)
        assert self.size_m is not None
        half = self.size_m[0] / 2, self.size_m[1] / 2
        return np.asarray(np.hypot(np.maximum(dx - half[0], 0), np.maximum(dy - half[1], 0)), dtype=np.float64)


def graded(ground: HeightField, grades: Sequence[GradeConfig]) -> HeightField:
    """A ground after all grades, one after the other."""
    z = ground.z
    for grade in grades:
        distance = grade.distance(ground.x, ground.y)
        inside = distance <= float(distance.min())  # at least the nearest node
        mean = float(z[inside].mean())
        wanted = grade.relief * (z - mean) - grade.depth_m
        share = 1.0 - smoothstep(distance, 0.0, grade.blend_m)
        z = z + share * (wanted - z)
    return HeightField(ground.x0, ground.y0, ground.spacing, z)
