"""Legs about a place: go there, stay there, circle it, dock, land."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from pelagos.config.mission.part import Levelled, Place, Timed


class Goto(Levelled):
    """Go to points and stop at the last; vehicles that turn on the spot look where they are told to."""

    type: Literal["goto"] = "goto"
    """The kind of leg."""
    points: tuple[tuple[float, float, float] | Place, ...] = Field(min_length=1)
    """World x (north), y (west), z (up) of each point [m]; or x, y, or `latitude_deg` and `longitude_deg`, at the
    depth, altitude or height of the leg."""
    heading_deg: float | None = Field(default=None, ge=-360, le=360)
    """Compass heading on the way and at the end [deg]; along the way where not given."""
    face: Place | None = None
    """A place to look at, instead of a heading: x, y [m], or latitude and longitude."""
    speed_mps: float | None = Field(default=None, gt=0)
    """Speed [m/s]; the vehicle's cruising speed where not given."""
    acceptance_m: float | None = Field(default=None, gt=0)
    """A point counts as reached within this distance [m]; the vehicle's own tolerance where not given."""

    @model_validator(mode="after")
    def _one_way_to_look(self) -> Self:
        _look_once(self)
        return self

    @model_validator(mode="after")
    def _one_height(self) -> Self:
        deep = any(isinstance(p, tuple) and len(p) == 3 for p in self.points)
        level = next((n for n in ("depth_m", "altitude_m", "height_m") if getattr(self, n) is not None), None)
        if deep and level is not None:
            raise PydanticCustomError(
                "level", "points of three numbers have their own z; leave out '{level}'", {"level": level}
            )
        return self


class StationKeeping(Timed):
    """Stay at a place against current, waves and wind; vehicles that cannot hover circle it."""

    type: Literal["station_keeping"] = "station_keeping"
    """The kind of leg."""
    point: Place | None = None
    """World x (north), y (west) [m], or latitude and longitude; where the vehicle is at the beginning if not given."""
    heading_deg: float | None = Field(default=None, ge=-360, le=360)
    """Compass heading [deg]; the one at the leg's beginning where not given."""
    face: Place | None = None
    """A place to look at, instead of a heading: x, y [m], or latitude and longitude."""
    radius_m: float | None = Field(default=None, gt=0)
    """Of the circle of vehicles that cannot hover [m]; their turning circle where not given."""
    speed_mps: float | None = Field(default=None, gt=0)
    """Speed on the way to the place, and on the circle [m/s]; the vehicle's cruising speed where not given."""

    @model_validator(mode="after")
    def _one_way_to_look(self) -> Self:
        _look_once(self)
        return self


class Orbit(Levelled):
    """Circle a place, looking at it or along the circle."""

    type: Literal["orbit"] = "orbit"
    """The kind of leg."""
    center: Place
    """World x (north), y (west) [m], or latitude and longitude."""
    radius_m: float = Field(gt=0)
    """Of the circle [m]."""
    turns: float = Field(default=1.0, gt=0)
    """How often around."""
    direction: Literal["clockwise", "counterclockwise"] = "clockwise"
    """Seen from above."""
    look: Literal["ahead", "center"] = "ahead"
    """Where the bow points; `center` is for vehicles that move sideways."""
    speed_mps: float | None = Field(default=None, gt=0)
    """Speed [m/s]; the vehicle's cruising speed where not given."""


class Dock(Levelled):
    """Approach a dock slowly along its axis, from a point in front of it, and stop inside."""

    type: Literal["dock"] = "dock"
    """The kind of leg."""
    point: tuple[float, float, float] | Place
    """World x (north), y (west), z (up) [m] of the vehicle's origin when docked; or x, y, or latitude and longitude."""
    heading_deg: float = Field(ge=-360, le=360)
    """Compass heading of the vehicle as it goes in [deg]."""
    approach_m: float = Field(default=10.0, gt=0)
    """Length of the straight approach [m]; vehicles that cannot go sideways take eight turning circles' radii, or 25 m,
    where that is more."""
    tolerance_m: float = Field(default=0.5, gt=0)
    """Docked within this distance of the point [m]."""
    speed_mps: float | None = Field(default=None, gt=0)
    """Speed of the approach [m/s]; the vehicle's slowest where not given."""


class Land(Levelled):
    """Go down onto the seabed, or out of the air onto whatever is below, and stay there."""

    type: Literal["land"] = "land"
    """The kind of leg."""
    point: Place | None = None
    """World x (north), y (west) [m], or latitude and longitude; below where the vehicle is if not given."""
    sink_mps: float = Field(default=0.2, gt=0)
    """Speed of descent [m/s]."""

    @model_validator(mode="after")
    def _no_level(self) -> Self:
        for name in ("depth_m", "altitude_m", "height_m"):
            if getattr(self, name) is not None:
                raise PydanticCustomError(
                    "level", "a vehicle lands where the ground is; leave out '{name}'", {"name": name}
                )
        return self


def _look_once(leg: Goto | StationKeeping) -> None:
    if leg.heading_deg is not None and leg.face is not None:
        raise PydanticCustomError("look", "give either 'heading_deg' or 'face', not both")
