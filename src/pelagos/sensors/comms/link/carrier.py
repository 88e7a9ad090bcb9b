"""Links that do not run on sound: light between lamps and diodes, and radio above the water."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.math.so3 import rotate_np
from pelagos.ocean.ocean import Ocean
from pelagos.optics.optical_link import lambert_order, noise_current, received_power, sunlight_power
from pelagos.sensors.comms.link.budget import NOTHING, HeardSignal
from pelagos.world.world import World

LIGHT_SPEED: Final = 299_792_458.0  # [m/s]
_INDEX: Final = 1.34  # of sea water
_HULL: Final = 1.5  # [m] before the other end, within which what stands in the way is its own vehicle; assumed
_NIGHT_DB: Final = -400.0

Pair = tuple[int, int, int]


class PoseOf(Protocol):
    """Pose of an end in every copy."""

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]


class Carrier(Protocol):
    """Carrier of packets between ends of the same kind."""

    def hear(self, pair: Pair, poses: Mapping[int, Any], t: float, at: Any) -> HeardSignal:
        """Level of what this sends at a receiver of the same kind, `at`: (sender, receiver, copy)."""

    def noise(self) -> float:
        """Level of the noise in the band, in the same decibels."""


def _lost(why: str) -> HeardSignal:
    return HeardSignal(0.0, NOTHING, NOTHING, 0.0, 1.0, why, None)


def _height(ocean: Ocean, position: NDArray[np.float64], t: float, copy: int) -> float:
    """Of a place in a copy over the surface, waves included [m]."""
    x, y, z = (float(v) for v in position)
    return z - float(np.array(ocean.elevation(jit.Float64(x), jit.Float64(y), jit.Float64(t), jit.UInt32(copy)))[0])


def _stands_between(world: World, a: NDArray[np.float64], b: NDArray[np.float64], copy: int, own: int) -> bool:
    way = b - a
    distance = float(np.linalg.norm(way))
    if distance <= 2.0 * _HULL:
        return False
    hits = world.cast(
        a, way, max_range=distance - _HULL, copy=np.array([copy]), own_body=np.array([own], dtype=np.uint32)
    )
    return bool(hits.valid[0])


@dataclass(frozen=True)
class Light:
    """Light under water; levels are of electrical power [dB re 1 A^2].

    Attributes:
        world, ocean: where.
        power_w: of the lamp.
        half_angle: off its axis, at which half the light is left [rad].
        field_of_view: half angle of the receiver [rad].
        area: of its aperture [m^2].
        responsivity: [A/W].
        bandwidth: [Hz].
        channel: of the water's optics: 0 red, 1 green, 2 blue.
        filter_share: part of daylight that the filter lets through.
        own: rows of the vehicle's own hull, by copy.
    """

    world: World
    ocean: Ocean
    power_w: float
    half_angle: float
    field_of_view: float
    area: float
    responsivity: float
    bandwidth: float
    channel: int
    filter_share: float
    own: NDArray[np.uint32]

    def hear(self, pair: Pair, poses: Mapping[int, PoseOf], t: float, at: Light) -> HeardSignal:
        """Straight light from this lamp's axis x to the receiver `at`'s axis x."""
        sender, receiver, c = poses[pair[0]], poses[pair[1]], pair[2]
        a, b = sender.position[c], receiver.position[c]
        heights = _height(self.ocean, a, t, c), _height(self.ocean, b, t, c)
        if max(heights) > 0.0:
            return _lost("in air")
        way = b - a
        distance = max(float(np.linalg.norm(way)), 0.05)
        ahead = way / distance
        axis = np.array([[1.0, 0.0, 0.0]])
        cos_lamp = float(rotate_np(sender.attitude[c : c + 1], axis)[0] @ ahead)
        cos_receiver = float(-rotate_np(receiver.attitude[c : c + 1], axis)[0] @ ahead)
        if cos_lamp <= 0.0 or cos_receiver < math.cos(at.field_of_view):
            return _lost("out of beam")
        if _stands_between(self.world, a, b, c, int(self.own[c])):
            return _lost("blocked")
        attenuation = float(self.ocean.water.attenuation[self.channel])
        order = lambert_order(self.half_angle)
        power = received_power(
            self.power_w, distance, attenuation, at.area, order=order, cos_lamp=cos_lamp, cos_receiver=cos_receiver
        )
        current = at.responsivity * power
        # the excess of shot noise by signal and daylight over the noise of the dark is taken from the signal
        excess = at._noise(current, at._daylight(-heights[1])) / at._noise(0.0, 0.0)
        level = 20.0 * math.log10(max(current, 1e-30)) - 20.0 * math.log10(excess)
        return HeardSignal(distance * _INDEX / LIGHT_SPEED, level, NOTHING, 0.0, 1.0, "", None)

    def noise(self) -> float:
        """Of diode and amplifier in the dark."""
        return 20.0 * math.log10(self._noise(0.0, 0.0))

    def _noise(self, current: float, background: float) -> float:
        return noise_current(current, background, 1e-9, self.bandwidth, 1_000.0)

    def _daylight(self, depth: float) -> float:
        """Current by daylight [A]: 1000 W/m^2 under the sun straight above, fading with the water's Kd."""
        high = max(math.sin(float(np.array(self.ocean.sun_elevation)[0])), 0.0)
        fading = math.exp(-float(self.ocean.water.downwelling[self.channel]) * max(depth, 0.0))
        collected = sunlight_power(1000.0 * high * fading, self.area, self.field_of_view, self.filter_share)
        return self.responsivity * collected


@dataclass(frozen=True)
class Radio:
    """Radio above the water; levels are [dB re 1 mW].

    Two rays, straight and by the sea; nothing beyond the radio horizon of 4/3 of the Earth's radius, 4.12 km
    (sqrt(h1) + sqrt(h2)), h in metres.

    Source: T. S. Rappaport, Wireless Communications (2nd ed., 2002), Sections 4.2 and 4.6; ITU-R P.310 (horizon).

    Attributes:
        world, ocean: where.
        frequency: [Hz].
        power_dbm: sent, with the antenna's gain.
        noise_dbm: of receiver and surroundings in the band.
        own: rows of the vehicle's own hull, by copy.
    """

    world: World
    ocean: Ocean
    frequency: float
    power_dbm: float
    noise_dbm: float
    own: NDArray[np.uint32]

    def hear(self, pair: Pair, poses: Mapping[int, PoseOf], t: float, at: Radio) -> HeardSignal:
        """From antenna to antenna; what the receiver `at` is like is in its noise."""
        sender, receiver, c = poses[pair[0]], poses[pair[1]], pair[2]
        a, b = sender.position[c], receiver.position[c]
        heights = _height(self.ocean, a, t, c), _height(self.ocean, b, t, c)
        if min(heights) <= 0.0:
            return _lost("submerged")
        distance = max(float(np.linalg.norm(b - a)), 1.0)
        if distance > 4120.0 * sum(math.sqrt(h) for h in heights):
            return _lost("out of range")
        if _stands_between(self.world, a, b, c, int(self.own[c])):
            return _lost("blocked")
        free = 20.0 * math.log10(4.0 * math.pi * distance * self.frequency / LIGHT_SPEED)
        two_rays = 40.0 * math.log10(distance) - 20.0 * math.log10(heights[0] * heights[1])
        return HeardSignal(distance / LIGHT_SPEED, self.power_dbm - max(free, two_rays), NOTHING, 0.0, 1.0, "", None)

    def noise(self) -> float:
        """Of the receiver."""
        return self.noise_dbm
