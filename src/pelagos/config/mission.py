"""The legs of a mission: what to do next, as data. `sim/mission.py` turns them into commands.

Horizontal places are world x (north) and y (west) in metres, headings are of the compass. Depth is metres below the
mean sea surface, altitude metres above the seabed.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from pelagos.config.strict import Strict


class _Levelled(Strict):
    """A leg that is run at one depth, or at one altitude."""

    type: str
    """The kind of leg."""
    depth_m: float | None = Field(default=None, ge=0)
    """Depth below the mean sea surface [m]; this or `altitude_m`."""
    altitude_m: float | None = Field(default=None, gt=0)
    """Altitude above the seabed [m]; this or `depth_m`."""

    @model_validator(mode="after")
    def _one_level(self) -> Self:
        if (self.depth_m is None) == (self.altitude_m is None):
            given = "neither" if self.depth_m is None else "both"
            raise PydanticCustomError("level", "give either 'depth_m' or 'altitude_m'; {given} given", {"given": given})
        return self


class Dive(_Levelled):
    """Go down (or up) to a depth or an altitude, keeping the heading."""

    type: Literal["dive"] = "dive"
    """The kind of leg."""
    speed_mps: float | None = Field(default=None, gt=0)
    """Speed through the water [m/s]; the vehicle's cruising speed where not given."""


class Waypoints(_Levelled):
    """Pass by points, one after the other, along the lines between them."""

    type: Literal["waypoints"] = "waypoints"
    """The kind of leg."""
    points: tuple[tuple[float, float], ...] = Field(min_length=1)
    """World x (north), y (west) of each point [m]."""
    speed_mps: float | None = Field(default=None, gt=0)
    """Speed through the water [m/s]; the vehicle's cruising speed where not given."""
    acceptance_m: float = Field(default=5.0, gt=0)
    """A point counts as passed within this distance [m]."""


class Lawnmower(_Levelled):
    """Parallel lines, each in the opposite direction of the last: the usual survey."""

    type: Literal["lawnmower"] = "lawnmower"
    """The kind of leg."""
    corner: tuple[float, float]
    """World x (north), y (west) of the start of the first line [m]."""
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
    acceptance_m: float = Field(default=5.0, gt=0)
    """The end of a line counts as reached within this distance [m]."""


class Surface(Strict):
    """Come up to the surface."""

    type: Literal["surface"] = "surface"
    """The kind of leg."""
    speed_mps: float | None = Field(default=None, gt=0)
    """Speed through the water [m/s]; the vehicle's cruising speed where not given."""


class GpsFix(Strict):
    """Wait at the surface for a position fix."""

    type: Literal["gps_fix"] = "gps_fix"
    """The kind of leg."""
    timeout_s: float = Field(default=30.0, gt=0)
    """Go on without a fix after this time [s]."""


class Hold(Strict):
    """Go on with heading and depth as they are, for a time."""

    type: Literal["hold"] = "hold"
    """The kind of leg."""
    seconds: float = Field(gt=0)
    """How long [s]."""


Leg = Annotated[Dive | Waypoints | Lawnmower | Surface | GpsFix | Hold, Field(discriminator="type")]
