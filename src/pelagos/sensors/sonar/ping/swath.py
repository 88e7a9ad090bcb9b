"""Directions of the beams of a moving multibeam: transmit and receive attitudes beam by beam, sectors, stabilisation.

A pulse goes out in the attitude of the ping; each echo is heard in that of its arrival. The fan that was designed for a
sounder at rest keeps its steering angles, and each ray goes to where both arrays' cones cross (`mills_cross`).

Source: J. R. Hughes Clarke (2018), see `mills_cross`; Kongsberg Maritime, EM datagram formats (850-160692), on sectors
and stabilisation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.echo import Patches
from pelagos.acoustics.mills_cross import aberration, crossing, turned
from pelagos.jit import Array
from pelagos.math.so3 import integrate, multiply, rotate
from pelagos.raycast.caster import Caster
from pelagos.sensors.sonar.ping.fan import Aim, Fan, FanHits, Lanes, cast_along
from pelagos.sensors.sonar.ping.surface_scattering import Surfaces

_STEEREST: Final = 0.174  # sine of the farthest that a transmitter steers, 10 deg; assumed
_UNDER_WAY: Final = 0.3  # [m/s], speed from which a course is known
_ROUNDS: Final = 4  # of travel times that change where beams look, which changes the travel times


@dataclass(frozen=True)
class Swath:
    """Directions of a multibeam's beams.

    Attributes:
        beams: of a ping, those of both swaths.
        rays: of a beam; the middle one lies on its axis.
        moves: whether motion counts while the sound is under way.
        held: axes that beams are held about: "roll", "pitch", "yaw".
        assumed_speed: sound speed by which the receiver is steered [m/s]; None: that of the water.
        coupling_s: see `range_coupling`.
    """

    beams: int
    rays: int
    moves: bool
    held: tuple[str, ...]
    assumed_speed: float | None
    coupling_s: float

    @property
    def plain(self) -> bool:
        """Whether beams look where the fan does, whatever the sounder does."""
        return not self.moves and not self.held


@jit.struct
class Sectors:
    """Constants of beams, `Float` by beam: a Dr.Jit struct.

    Attributes:
        sine, cosine: of the angle from straight down to the middle of the sector that each was sent in.
        loss: absorption at its frequency over that at the sounder's.
    """

    sine: Array
    cosine: Array
    loss: Array


@jit.struct
class Motion:
    """The sounder's motion in a ping, one lane a ping: a Dr.Jit struct of `Array3f`, world frame.

    Attributes:
        ahead, left: unit vectors of the sensor frame at transmission.
        course: unit vector along the course over ground, level; along the heading where there is none.
        velocity: [m/s].
        spin: [rad/s].
    """

    ahead: Array
    left: Array
    course: Array
    velocity: Array
    spin: Array


def sectors_of(angles: NDArray[np.float64], count: int, losses: NDArray[np.float64]) -> Sectors:
    """Equal parts of the swath; `angles` `(beams,)` from straight down [rad], `losses` `(count,)`."""
    edge = np.linspace(angles.max(), angles.min(), count + 1)
    sector = np.clip(np.searchsorted(-edge, -angles, side="right") - 1, 0, count - 1)
    middle = (0.5 * (edge[1:] + edge[:-1]))[sector]
    made = Sectors(*(jit.Float(v.astype(np.float32)) for v in (np.sin(middle), np.cos(middle), losses[sector])))
    jit.align(made)
    return made


def motion_of(lanes: Lanes, velocity: Array, spin: Array) -> Motion:
    """See `Motion`; `velocity` and `spin` `Array3f64` in the sensor frame."""
    q = lanes.attitude
    ahead, left = rotate(q, jit.Array3f64(1, 0, 0)), rotate(q, jit.Array3f64(0, 1, 0))
    v, w = rotate(q, velocity), rotate(q, spin)
    under_way = dr.square(v.x) + dr.square(v.y) > _UNDER_WAY**2
    level = dr.select(under_way, jit.Array3f64(v.x, v.y, 0.0), jit.Array3f64(ahead.x, ahead.y, 0.0))
    made = Motion(*(jit.Array3f(a) for a in (ahead, left, dr.normalize(level), v, w)))
    dr.eval(made)
    return made


def cast_swath(
    caster: Caster, swath: Swath, sectors: Sectors, fan: Fan, lanes: Lanes, surfaces: Surfaces, motion: Motion,
    *, max_range: float,
) -> FanHits:  # fmt: skip
    """Cast the fan as it is sent and heard under way."""
    count = dr.width(lanes.position)
    row = dr.arange(jit.UInt32, swath.beams * count)
    axis = row % swath.beams * swath.rays + swath.rays // 2
    lane = row // swath.beams
    delay = dr.zeros(jit.Float, swath.beams * count)
    if swath.moves:
        aim = _aim(swath, sectors, fan, lanes, motion, lane, axis, row, delay)
        first = cast_along(caster, aim, lanes, surfaces, max_range=max_range)
        dr.eval(first)
        speed = dr.gather(jit.Float, lanes.medium.sound_speed, lane)
        straight = dr.abs(dr.dot(first.hits.normal, first.direction))
        reach = dr.select(first.hits.valid, first.hits.t, 0.0)
        delay = reach * (2.0 / speed)
        for _ in range(_ROUNDS):  # where the turned beam meets the plane that the first one met
            now = _aim(swath, sectors, fan, lanes, motion, lane, axis, row, delay).direction
            met = dr.abs(dr.dot(first.hits.normal, now))
            longer = dr.clip(straight / dr.maximum(met, 0.02), 0.5, 2.0)
            closing = dr.dot(dr.gather(jit.Array3f, motion.velocity, lane), now) / speed
            delay = reach * longer * (1.0 - closing) * (2.0 / speed)
        dr.eval(delay)
    index = dr.arange(jit.UInt32, dr.width(fan.beam) * count)
    beam = index // swath.rays
    time = dr.gather(jit.Float, delay, beam)
    lane, ray = index // dr.width(fan.beam), index % dr.width(fan.beam)
    aim = _aim(swath, sectors, fan, lanes, motion, lane, ray, beam, time)
    view = cast_along(caster, aim, lanes, surfaces, max_range=max_range)
    view.loss = view.loss * dr.gather(jit.Float, sectors.loss, beam % swath.beams)
    return view


def _aim(
    swath: Swath, sectors: Sectors, fan: Fan, lanes: Lanes, motion: Motion, lane: Array, ray: Array, row: Array,
    delay: Array,
) -> Aim:  # fmt: skip
    """Directions of rays, given the travel time of each [s]; `row` is the beam's among all lanes'."""
    beam = row % swath.beams
    own = dr.gather(jit.Array3f, fan.direction, ray)
    axis = dr.gather(jit.Array3f, fan.direction, beam * swath.rays + swath.rays // 2)
    sent, heard = steering(swath, sectors, motion, lane, beam, axis, delay)
    receiver = _receiver(swath, motion, lane, delay)
    ahead = dr.gather(jit.Array3f, motion.ahead, lane)
    sent, heard = sent + (own.x - axis.x), heard + (own.y - axis.y)
    speed = dr.gather(jit.Float, lanes.medium.sound_speed, lane)
    if swath.assumed_speed is not None:
        heard *= speed * (1.0 / swath.assumed_speed)
    direction = crossing(ahead, receiver, sent, heard)
    if swath.moves:
        velocity = dr.gather(jit.Array3f, motion.velocity, lane)
        heard -= aberration(velocity, direction, receiver, speed)
        direction = crossing(ahead, receiver, sent, heard)
    along = dr.normalize(dr.cross(ahead, direction))
    return Aim(lane, ray, direction, along, dr.zeros(jit.Array3f, dr.width(ray)))


def steering(
    swath: Swath, sectors: Sectors, motion: Motion, lane: Array, beam: Array, axis: Array, delay: Array
) -> tuple[Array, Array]:
    """Sines of the steering angles of a beam's axis: of the transmitter, and of the receiver after `delay` [s].

    Beams that are held keep to a plane through the vertical: that square to the course ("yaw") or to the heading.
    `axis` is where the fan looks, in the sensor frame.
    """
    ahead = dr.gather(jit.Array3f, motion.ahead, lane)
    heading = dr.normalize(jit.Array3f(ahead.x, ahead.y, 0.0))
    course = dr.gather(jit.Array3f, motion.course, lane) if "yaw" in swath.held else heading
    port = jit.Array3f(-course.y, course.x, 0.0)
    sent = jit.Float(axis.x)
    if "yaw" in swath.held:
        sent += dr.gather(jit.Float, sectors.sine, beam) * dr.dot(port, ahead)
    if "pitch" in swath.held:
        sent -= dr.gather(jit.Float, sectors.cosine, beam) * ahead.z
    sent = dr.clip(sent, -_STEEREST, _STEEREST)
    heard = jit.Float(axis.y)
    if "roll" in swath.held:
        receiver = _receiver(swath, motion, lane, delay)
        across = dr.rsqrt(dr.maximum(dr.square(axis.y) + dr.square(axis.z), 1e-12))
        heard = across * (axis.y * dr.dot(port, receiver) + axis.z * receiver.z)
    return sent, heard


def _receiver(swath: Swath, motion: Motion, lane: Array, delay: Array) -> Array:
    left = dr.gather(jit.Array3f, motion.left, lane)
    return turned(left, dr.gather(jit.Array3f, motion.spin, lane) * delay) if swath.moves else left


def delay_ranges(patches: Patches, view: FanHits, lanes: Lanes, motion: Motion, swath: Swath) -> None:
    """Ranges as times tell them, in place: r (1 - v/c) for things that close at v, and a chirp's coupling."""
    if not swath.moves:
        return
    velocity = view.of_lane(motion.velocity)
    closing = dr.dot(velocity - view.hits.velocity, view.direction)
    factor = 1.0 - closing * view.of_lane(1.0 / lanes.medium.sound_speed)
    shift = swath.coupling_s * closing
    for name in ("near", "far", "distance"):
        setattr(patches, name, getattr(patches, name) * factor - shift)


def axes_heard(
    swath: Swath, sectors: Sectors, fan: Fan, lanes: Lanes, motion: Motion, distance: Array
) -> tuple[Array, Array, Array]:
    """Range of each beam as a sounder that knows its motion has it: direction in the world, `Array3f`, range from
    where it sent its pulse [m], and the sine by which the transmitter was steered."""
    row = dr.arange(jit.UInt32, dr.width(distance))
    lane, beam = row // swath.beams, row % swath.beams
    speed = dr.gather(jit.Float, lanes.medium.sound_speed, lane)
    if swath.assumed_speed is not None:
        speed = dr.full(jit.Float, swath.assumed_speed, dr.width(row))
    delay = dr.select(dr.isfinite(distance), distance, 0.0) * (2.0 / speed)
    axis = dr.gather(jit.Array3f, fan.direction, beam * swath.rays + swath.rays // 2)
    sent, heard = steering(swath, sectors, motion, lane, beam, axis, delay)
    receiver = _receiver(swath, motion, lane, delay)
    ahead = dr.gather(jit.Array3f, motion.ahead, lane)
    direction = crossing(ahead, receiver, sent, heard)
    if not swath.moves:
        return direction, distance, sent
    velocity = dr.gather(jit.Array3f, motion.velocity, lane)
    direction = crossing(ahead, receiver, sent, heard - aberration(velocity, direction, receiver, speed))
    return direction, distance / (1.0 - dr.dot(velocity, direction) / speed), sent


def attitudes_heard(swath: Swath, lanes: Lanes, spin: Array, distance: Array) -> Array:
    """The sensor's attitude when each beam's echo came back, `Array4f64`; `spin` in the sensor frame [rad/s]."""
    row = dr.arange(jit.UInt32, dr.width(distance))
    lane = row // swath.beams
    delay = jit.Float64(dr.select(dr.isfinite(distance), distance, 0.0)) * 2.0
    delay /= jit.Float64(dr.gather(jit.Float, lanes.medium.sound_speed, lane))
    q = dr.gather(jit.Array4f64, lanes.attitude, lane)
    rate = dr.gather(jit.Array3f64, spin, lane)
    return integrate(q, rate, delay) if swath.moves else multiply(q, jit.Array4f64(1, 0, 0, 0))
