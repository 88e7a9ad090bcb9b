"""Reception of targets by a sonar: at which ranges, in which directions, by which beams."""

from __future__ import annotations

import math
from dataclasses import dataclass

import drjit as dr

from pelagos import jit
from pelagos.acoustics.refraction import excess_at
from pelagos.jit import Array
from pelagos.math.so3 import rotate_back
from pelagos.sensors.sonar.ping.aperture import Aperture, Facing
from pelagos.sensors.sonar.ping.fan import Lanes, steered_directions
from pelagos.sensors.sonar.ping.water_around import STATIONS


@dataclass(frozen=True)
class Hearing:
    """Reception of targets by a sonar.

    Attributes:
        aperture: its patterns.
        beams: their number.
        rays_per_sr: of its fan.
        wave_cycles: 2 f [Hz].
        wavelength: at 1500 m/s [m].
        reach: farthest range [m].
        coupling_s: range that a chirp mistakes for a closing speed of 1 m/s, see `range_coupling` [s].
        doppler: whether motion shifts ranges.
        assumed_speed: sound speed that turns times into ranges, and phases into angles [m/s]; None: the water's.
    """

    aperture: Aperture
    beams: int
    rays_per_sr: float
    wave_cycles: float
    wavelength: float
    reach: float
    coupling_s: float
    doppler: bool
    assumed_speed: float | None = None


@dataclass(frozen=True)
class Listener:
    """A sonar that hears targets in a ping.

    Attributes:
        lanes: where it is.
        facing: where its beams look.
        hearing: how it hears.
        velocity: `Array3f64`, of the sonar by lane, world frame [m/s].
    """

    lanes: Lanes
    facing: Facing
    hearing: Hearing
    velocity: Array

    def apparent(self, direction: Array, lane: Array) -> Array:
        """A world direction in the sensor frame, as an array takes it that steers by another sound speed."""
        here = rotate_back(dr.gather(jit.Array4f, jit.Array4f(self.lanes.attitude), lane), direction)
        assumed = self.hearing.assumed_speed
        if assumed is None or not self.hearing.aperture.steered:
            return here
        return steered_directions(here, assumed / dr.gather(jit.Float, self.lanes.medium.sound_speed, lane))

    def level(self, direction: Array) -> Array:
        """A direction turned into the plane of a steered array's beams, at its own angle."""
        up = dr.gather(jit.Array3f, self.facing.up, jit.UInt32(0))
        return dr.normalize(direction - up * dr.dot(up, direction))

    def measured_range(self, distance: Array, lane: Array, other: Array, direction: Array) -> Array:
        """The range that an echo's time means [m], of what moves with velocity `other` [m/s] in a world direction."""
        distance = reduced_distance(self.lanes, lane, direction, distance)
        closing = dr.dot(jit.Array3f(dr.gather(jit.Array3f64, self.velocity, lane)) - other, direction)
        speed = dr.gather(jit.Float, self.lanes.medium.sound_speed, lane)
        if self.hearing.assumed_speed is not None:
            distance = distance * (self.hearing.assumed_speed / speed)
        if not self.hearing.doppler:
            return distance
        return distance * (1.0 - closing / speed) - self.hearing.coupling_s * closing

    def sector(self, direction: Array) -> tuple[Array, Array]:
        """The beam whose sector a direction of the sensor frame lies in, and the two-way power pattern that is no
        array's; the number of beams where it lies in none."""
        aperture, beams, facing = self.hearing.aperture, self.hearing.beams, self.facing
        beam, best = jit.UInt32(beams), jit.Float(-2.0)
        if aperture.steered:
            side, up = (dr.gather(jit.Array3f, v, jit.UInt32(0)) for v in (facing.side, facing.up))
            front = dr.cross(side, up)
            angle = dr.atan2(dr.dot(side, direction), dr.dot(front, direction))

            def edge(index: Array) -> Array:
                return _edge_angle(facing, side, front, index, beams)

            found = dr.binary_search(0, beams, lambda index: edge(index) > angle)  # beams go from left to right
            inside = (found > 0) & (found <= beams) & (angle <= edge(jit.UInt32(0))) & (angle > edge(jit.UInt32(beams)))
            beam = dr.select(inside, jit.UInt32(found) - 1, beams)
        else:
            for b in range(beams):
                along = dr.dot(dr.gather(jit.Array3f, facing.axis, jit.UInt32(b)), direction)
                beam, best = dr.select(along > best, jit.UInt32(b), beam), dr.maximum(best, along)
        row = dr.minimum(beam, beams - 1)
        power = aperture.all_ways_up(facing, row, direction)
        if not aperture.steered:
            power = power * dr.square(aperture.side_amplitude(facing, row, direction))
        ahead = dr.dot(dr.gather(jit.Array3f, facing.axis, row), direction)
        return beam, dr.select(ahead > -0.2, power, 0.0)


def reduced_distance(lanes: Lanes, lane: Array, direction: Array, distance: Array) -> Array:
    """c at the sonar times the travel time along a straight way [m], by the profiles that rays bend by.

    Where rays are straight it is `distance`.
    """
    profile, around = lanes.profile, lanes.around
    if profile is None:
        return distance
    home = dr.gather(jit.Float, profile.speed, lane)
    level = dr.sqrt(dr.square(direction.x) + dr.square(direction.y))
    total = jit.Float(0)
    for k in range(STATIONS):
        way, row = distance * ((k + 0.5) / STATIONS), lane
        if around is not None:
            profile, row = around.profile, around.row(lane, direction, way * level)
        total += home / (dr.gather(jit.Float, profile.speed, row) + excess_at(profile, row, way * direction.z)[0])
    return distance * total * (1.0 / STATIONS)


def _edge_angle(facing: Facing, side: Array, front: Array, index: Array, beams: int) -> Array:
    """Angle of the edge between sectors `index` - 1 and `index` [rad]."""

    def middle(row: Array) -> Array:
        axis = dr.gather(jit.Array3f, facing.axis, jit.UInt32(row))
        return dr.atan2(dr.dot(side, axis), dr.dot(front, axis))

    if beams == 1:
        return dr.select(index == 0, jit.Float(math.pi), jit.Float(-math.pi))
    at = dr.clip(jit.Int32(index), 1, beams - 1)
    left, right = middle(at - 1), middle(at)
    half = 0.5 * (left - right)
    edge = 0.5 * (left + right)
    return dr.select(index == 0, edge + 2.0 * half, dr.select(index >= beams, edge - 2.0 * half, edge))
