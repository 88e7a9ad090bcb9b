"""Legs along straight lines: points to pass, parallel lines, and an area to survey."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from pelagos.config.mission.part import Levelled, Place


class Waypoints(Levelled):
    """Pass by points, one after the other, along the lines between them."""

    type: Literal["waypoints"] = "waypoints"
    """The kind of leg."""
    points: tuple[Place, ...] = Field(min_length=1)
    """World x (north), y (west) of each point [m], or its `latitude_deg` and `longitude_deg`."""
    speed_mps: float | None = Field(default=None, gt=0)
    """Speed through the water [m/s]; the vehicle's cruising speed where not given."""
    acceptance_m: float | None = Field(default=None, gt=0)
    """A point counts as passed within this distance [m]; the vehicle\'s own tolerance where not given."""


class Lawnmower(Levelled):
    """Parallel lines, each in the opposite direction of the last: the usual survey."""

    type: Literal["lawnmower"] = "lawnmower"
    """The kind of leg."""
    corner: Place
    """World x (north), y (west) of the start of the first line [m], or its `latitude_deg` and `longitude_deg`."""
    length_m: float = Field(gt=0)
    """Length of a line [m]."""
    width_m: float = Field(ge=0)
    """From the first line to the last, to the right of the first line's heading [m]."""
    spacing_m: float = Field(gt=0)
    """Between two lines [m]."""
    heading_deg: float = Field(default=0.0, ge=-360, le=360)
    """Compass heading of the first line [deg]: 0 north, 90 east."""
    speed_mps: float | None = Field(default=None, gt=0)
    """Speed through the water [m/s]; the vehicle's cruising speed where not given."""
    acceptance_m: float | None = Field(default=None, gt=0)
    """The end of a line counts as reached within this distance [m]; the vehicle\'s own tolerance where not given."""


class Survey(Levelled):
    """Parallel lines over an area of any shape, as far apart as the sonar's swath on the seabed there asks for."""

    type: Literal["survey"] = "survey"
    """The kind of leg."""
    area: tuple[Place, ...] = Field(min_length=3)
    """Corners of the area, in order: world x (north), y (west) [m], or `latitude_deg` and `longitude_deg`."""
    spacing_m: float | None = Field(default=None, gt=0)
    """Between two lines [m]; or `swath_deg` and `overlap`."""
    swath_deg: float | None = Field(default=None, gt=0, lt=180)
    """Opening angle of the sonar across the track [deg]; with the depth below, it gives the spacing."""
    overlap: float = Field(default=0.2, ge=0, lt=1)
    """Share of a swath that the next one covers again."""
    heading_deg: float | None = Field(default=None, ge=-360, le=360)
    """Compass heading of the first line [deg]; along the longest side of the area where not given."""
    speed_mps: float | None = Field(default=None, gt=0)
    """Speed through the water [m/s]; the vehicle's cruising speed where not given."""
    acceptance_m: float | None = Field(default=None, gt=0)
    """The end of a line counts as reached within this distance [m]; the vehicle\'s own tolerance where not given."""

    @model_validator(mode="after")
    def _spaced(self) -> Self:
        if (self.spacing_m is None) == (self.swath_deg is None):
            given = "neither" if self.spacing_m is None else "both"
            raise PydanticCustomError(
                "spacing", "give either 'spacing_m' or 'swath_deg'; {given} given", {"given": given}
            )
        return self
