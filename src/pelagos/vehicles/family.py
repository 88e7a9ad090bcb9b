"""Families of vehicles by the set-points that a mission steers by, and the legs that each can do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

_LINES: Final = ("waypoints", "lawnmower", "survey")
_ALL: Final = ("goto", "station_keeping", "orbit", "follow", "hold", "gps_fix", "repeat")


@dataclass(frozen=True)
class Family:
    """Vehicles that are steered alike.

    Attributes:
        name: of the family.
        needs: set-points that its control mode must have.
        may: further set-points that it may have; a mode with any other is not for missions.
        legs: what it can do.
        stops: it can stay at a place.
        turns: it can look where it does not go.
        medium: where it is at home: "under water", "at the surface", "in the air".
    """

    name: str
    needs: tuple[str, ...]
    may: tuple[str, ...]
    legs: tuple[str, ...]
    stops: bool
    turns: bool
    medium: str

    def fits(self, names: tuple[str, ...]) -> bool:
        """Whether a mode with these set-points can be steered."""
        return set(self.needs) <= set(names) <= {*self.needs, *self.may}


FAMILIES: Final = (
    Family(
        "hover", ("x", "y", "z", "yaw", "x_speed", "y_speed", "z_speed", "drive"), ("roll", "pitch"),
        ("dive", *_LINES, *_ALL, "surface", "profile", "drift", "dock", "land"), True, True, "under water",
    ),
    Family(
        "rotor", ("x", "y", "z", "yaw", "x_speed", "y_speed", "z_speed"), (),
        ("dive", *_LINES, *_ALL, "dock", "land"), True, True, "in the air",
    ),
    Family(
        "torpedo", ("depth", "heading", "speed"), (),
        ("dive", *_LINES, *_ALL, "surface", "profile", "drift", "dock"), False, False, "under water",
    ),
    Family(
        "surface", ("heading", "speed"), (),
        (*_LINES, *_ALL, "drift", "dock"), True, False, "at the surface",
    ),
    Family("ship", ("heading",), (), (*_LINES, *_ALL), False, False, "at the surface"),
    Family(
        "glider", ("upper_depth", "depth", "glide_pitch", "heading"), (),
        ("dive", *_LINES, "goto", "station_keeping", "orbit", "hold", "gps_fix", "repeat", "surface", "profile",
         "drift"),
        False, False, "under water",
    ),
    Family(
        "airplane", ("height", "heading", "airspeed"), (),
        ("dive", *_LINES, *_ALL), False, False, "in the air",
    ),
)  # fmt: skip


def mission_mode(commands: Mapping[str, tuple[str, ...]], asked: str | None = None) -> tuple[str, Family] | None:
    """The control mode that missions steer by, and its family; None where no mode fits.

    Args:
        commands: set-points by control mode.
        asked: only this mode.
    """
    for family in FAMILIES:
        for mode, names in commands.items():
            if family.fits(names) and asked in (None, mode):
                return mode, family
    return None
