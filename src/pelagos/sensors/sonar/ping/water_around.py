"""Water around a sonar that changes from place to place: profiles of the sound speed along the ways of its rays."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import drjit as dr

from pelagos import jit
from pelagos.acoustics.refraction import Profile
from pelagos.jit import Array
from pelagos.sensors.sonar.ping.medium import profile_of

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean

STATIONS: Final = 16  # along a way: the number of its arcs
_SECTORS: Final = 24  # of the compass


@jit.struct
class Around:
    """Profiles at stations on the ways that leave a sonar, a Dr.Jit struct.

    Attributes:
        profile: a row for each of lanes by sectors of the compass by stations.
        spacing: `Float` (1), distance between stations [m]; the first is half of it away.
    """

    profile: Profile
    spacing: Array

    def row(self, lane: Array, direction: Array, away: Array) -> Array:
        """Row of the nearest station to a place `away` [m] in a world `direction` from the sonar of a lane."""
        turn = dr.atan2(direction.y, direction.x) * (_SECTORS / (2.0 * math.pi))
        sector = jit.UInt32(jit.Int32(dr.round(turn)) + _SECTORS) % _SECTORS
        station = jit.UInt32(dr.clip(away / self.spacing, 0.0, STATIONS - 1.0))
        return (lane * _SECTORS + sector) * STATIONS + station


def profiles_around(ocean: Ocean, position: Array, t: Array, *, reach: float, bottom: float) -> Around:
    """Profiles about each place out to `reach` [m]; where no file covers the water it is as at the nearest station."""
    spacing = reach / STATIONS
    dr.eval(position, t)
    row = dr.arange(jit.UInt32, dr.width(position) * _SECTORS * STATIONS)
    lane = row // (_SECTORS * STATIONS)
    away = (jit.Float64(row % STATIONS) + 0.5) * spacing
    s, c = dr.sincos(jit.Float64(row // STATIONS % _SECTORS) * (2.0 * math.pi / _SECTORS))
    x, y, z = (dr.gather(jit.Float64, p, lane) for p in position)
    when = dr.gather(jit.Float64, t, lane) if dr.width(t) > 1 else t
    place = jit.Array3f64(x + away * c, y + away * s, z)
    known = dr.isfinite(ocean.sound_speed(place, when))
    place = dr.select(known, place, jit.Array3f64(x, y, z))
    return Around(profile_of(ocean, place, when, reach=reach, bottom=bottom), jit.Float(spacing))
