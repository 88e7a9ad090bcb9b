"""The legs of a mission: what to do next, as data. `sim/guidance` turns them into commands.

Horizontal places are world x (north) and y (west) in metres, or latitude and longitude; headings are of the compass.
Depth is metres below the mean sea surface, altitude metres above the seabed, height metres above the mean sea surface.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from pelagos.config.mission.follow import Follow
from pelagos.config.mission.lines import Lawnmower, Survey, Waypoints
from pelagos.config.mission.part import BaseLeg, EarthPoint, Levelled, Until
from pelagos.config.mission.place import Dock, Goto, Land, Orbit, StationKeeping
from pelagos.config.mission.vertical import Dive, Profile, Surface
from pelagos.config.mission.wait import Drift, GpsFix, Hold, Repeat

__all__ = [
    "BaseLeg", "Dive", "Dock", "Drift", "EarthPoint", "Follow", "Goto", "GpsFix", "Hold", "Land", "Lawnmower", "Leg",
    "Levelled", "Orbit", "Profile", "Repeat", "StationKeeping", "Surface", "Survey", "Until", "Waypoints",
]  # fmt: skip

Leg = Annotated[
    Dive
    | Waypoints
    | Lawnmower
    | Surface
    | GpsFix
    | Hold
    | Goto
    | StationKeeping
    | Orbit
    | Survey
    | Follow
    | Profile
    | Drift
    | Dock
    | Land
    | Repeat,
    Field(discriminator="type"),
]
