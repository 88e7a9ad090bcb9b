"""Legs up and down: a dive, coming up, and the yo-yo of a profile."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from pelagos.config.mission.part import BaseLeg, Levelled, Place


class Dive(Levelled):
    """Go down (or up) to a depth or an altitude, keeping the heading."""

    NEEDS_LEVEL: ClassVar[bool] = True

    type: Literal["dive"] = "dive"
    """The kind of leg."""
    speed_mps: float | None = Field(default=None, gt=0)
    """Speed through the water [m/s]; the vehicle's cruising speed where not given."""


class Surface(BaseLeg):
    """Come up to the surface."""

    type: Literal["surface"] = "surface"
    """The kind of leg."""
    speed_mps: float | None = Field(default=None, gt=0)
    """Speed through the water [m/s]; the vehicle's cruising speed where not given."""


class Profile(BaseLeg):
    """Up and down between two depths, along a heading or towards a point: a glider's flight, an AUV's yo-yo."""

    type: Literal["profile"] = "profile"
    """The kind of leg."""
    upper_depth_m: float = Field(default=3.0, ge=0)
    """Upper turning depth [m]."""
    lower_depth_m: float = Field(gt=0)
    """Lower turning depth [m]."""
    cycles: int | None = Field(default=None, ge=1)
    """How often down and up; without it, the point or `until` ends the leg."""
    heading_deg: float | None = Field(default=None, ge=-360, le=360)
    """Compass heading [deg]; the one at the leg's beginning where not given. Vehicles that hover go straight up and
    down."""
    point: Place | None = None
    """A point to go towards, instead of a heading; reaching it ends the leg: x, y [m], or latitude and longitude."""
    acceptance_m: float | None = Field(default=None, gt=0)
    """The point counts as reached within this distance [m]; the vehicle\'s own tolerance where not given."""
    glide_deg: float = Field(default=25.0, gt=5, lt=60)
    """Pitch of gliders, down and up [deg]."""
    speed_mps: float | None = Field(default=None, gt=0)
    """Speed through the water [m/s]; the vehicle's cruising speed where not given (gliders: by their buoyancy)."""

    @model_validator(mode="after")
    def _possible(self) -> Self:
        if self.upper_depth_m >= self.lower_depth_m:
            text = "upper_depth_m {upper} must be above lower_depth_m {lower}"
            raise PydanticCustomError("profile", text, {"upper": self.upper_depth_m, "lower": self.lower_depth_m})
        if self.heading_deg is not None and self.point is not None:
            raise PydanticCustomError("profile", "give either 'heading_deg' or 'point', not both")
        if self.cycles is None and self.point is None and self.until is None:
            raise PydanticCustomError("end", "give 'cycles', 'point' or 'until': nothing else ends this leg")
        return self
