"""Common parts of both LiDARs: the pattern of their beams, and the way of a pulse through air and water.

Channels are spread evenly from the upper to the lower limit, channel 0 uppermost. A rotating scanner turns clockwise
seen from above, starting at the left edge of its horizontal field; where it points depends on time alone. A
solid-state one fires its whole field at once. Arrays are `(channels, steps)`, steps in the order of firing.
"""

from __future__ import annotations

import math
from typing import ClassVar, Final, Literal, Self

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.config.rate import Rate
from pelagos.config.strict import refusal
from pelagos.jit import Array
from pelagos.math.so3 import integrate, rotate
from pelagos.optics.interface import refract
from pelagos.optics.water import REFRACTIVE_INDEX
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Rays
from pelagos.sensors.camera.picture.sea_crossing import Crossing
from pelagos.sensors.mount import sensor_angular_velocity, sensor_pose, sensor_velocity
from pelagos.sensors.sensor import Kinematics, SensorConfig

_NEAR: Final = 1e-3  # [m], step past the sea surface


class LaserConfig(SensorConfig):
    """A scanning laser; names and defaults follow CARLA's LiDAR sensors."""

    STANDS: ClassVar[str] = "mast"
    rate_hz: Rate = 10.0
    """Samples per second [Hz]; at the rotation frequency each sample is a full turn."""
    channels: int = Field(default=32, ge=1, le=512)
    """Lasers above one another."""
    range_m: float = Field(default=100.0, gt=0)
    """Greatest distance [m]."""
    points_per_second: int = Field(default=56000, ge=1)
    """Pulses of all lasers together [1/s]."""
    rotation_hz: float = Field(default=10.0, gt=0)
    """Turns per second [Hz]."""
    upper_fov_deg: float = Field(default=10.0, ge=-90, le=90)
    """Elevation of the uppermost laser [deg]."""
    lower_fov_deg: float = Field(default=-30.0, ge=-90, le=90)
    """Elevation of the lowermost laser [deg]."""
    horizontal_fov_deg: float = Field(default=360.0, gt=0, le=360)
    """Field swept, centred on the sensor's x axis [deg]."""
    pattern: Literal["rotating", "solid_state"] = "rotating"
    """Whether the field is swept, or seen at once."""
    motion_distortion: bool = False
    """Whether a rotating scanner's own motion during a sample shows: each point is in the frame of its own moment."""
    water_points: bool = False
    """Whether the sea surface returns pulses that come from above."""
    through_water: bool = False
    """Whether pulses from above go on below the surface, refracted (a green laser, as airborne bathymetry uses)."""

    @model_validator(mode="after")
    def _field_can_be(self) -> Self:
        upper, lower, least = self.upper_fov_deg, self.lower_fov_deg, self.channels * self.rate_hz
        if upper < lower:
            raise refusal(f"'upper_fov_deg', {upper:g}, is below 'lower_fov_deg', {lower:g}")
        if self.points_per_second < least:
            raise refusal(
                f"'points_per_second' of {self.points_per_second} is less than one pulse a channel in each sample: "
                f"{self.channels} channels at {self.rate_hz:g} Hz need {least:g}"
            )
        return self

    @property
    def steps(self) -> int:
        """Pulses of one laser in a sample."""
        return round(self.points_per_second / (self.channels * self.rate_hz))

    @property
    def swept_deg(self) -> float:
        """Angle that a sample covers [deg]."""
        if self.pattern == "solid_state":
            return self.horizontal_fov_deg
        return self.horizontal_fov_deg * min(self.rotation_hz / self.rate_hz, 1.0)


@jit.struct
class Scan:
    """Pulses in the sensor's frame before it turns, a Dr.Jit struct, channel-major.

    Attributes:
        azimuth: `Float`, from the start of the sweep, clockwise [rad].
        sine, cosine: `Float`, of the elevation.
        age: `Float`, how long before the sample's time the pulse was fired [s].
    """

    azimuth: Array
    sine: Array
    cosine: Array
    age: Array


@jit.struct
class Echoes:
    """Echoes of the pulses, a Dr.Jit struct, by pulse.

    Attributes:
        valid: `Bool`.
        distance: `Float`, as the scanner measures it: the way in water counts by its index where the scanner stands
            in air [m].
        in_air, in_water: `Float`, geometric lengths of the way [m].
        direction: `Array3f`, unit, sensor frame at the moment of firing.
        label, instance, material: `UInt32`, of what was hit; instance 0 is the sea surface.
        incidence: `Float`, cosine of the angle to the surface's normal.
    """

    valid: Array
    distance: Array
    in_air: Array
    in_water: Array
    direction: Array
    label: Array
    instance: Array
    material: Array
    incidence: Array


def scan_pattern(config: LaserConfig) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """The ray pattern: azimuth within the sweep (clockwise), elevation [rad], age [s], each `(channels, steps)`."""
    swept = math.radians(config.swept_deg)
    azimuth = (np.arange(config.steps) + (0.5 if config.pattern == "solid_state" else 0)) / config.steps * swept
    elevation = np.radians(np.linspace(config.upper_fov_deg, config.lower_fov_deg, config.channels))
    age = np.zeros(config.steps)
    if config.pattern == "rotating":
        age = (
            (1 - np.arange(config.steps) / config.steps)
            * config.swept_deg
            / config.horizontal_fov_deg
            / config.rotation_hz
        )
    shape = (config.channels, config.steps)
    return np.broadcast_to(azimuth, shape), np.broadcast_to(elevation[:, None], shape), np.broadcast_to(age, shape)


def scan_struct(config: LaserConfig) -> Scan:
    """The pattern on the device."""
    azimuth, elevation, age = scan_pattern(config)
    scan = Scan(*(jit.Float(np.ascontiguousarray(v, dtype=np.float32).ravel())
                  for v in (azimuth, np.sin(elevation), np.cos(elevation), age)))  # fmt: skip
    jit.align(scan)
    return scan


def pulses(
    scan: Scan, lane: Array, pulse: Array, motion: Kinematics, own: Array, config: LaserConfig
) -> tuple[Rays, Array]:
    """Rays in the world, and their directions in the sensor's frame."""
    azimuth = dr.gather(jit.Float, scan.azimuth, pulse)
    if config.pattern == "rotating":
        turns = jit.Float64(motion.t_ns) * (1e-9 * config.rotation_hz)
        share = turns - config.swept_deg / config.horizontal_fov_deg
        start = jit.Float(share - dr.floor(share)) * math.radians(config.horizontal_fov_deg)
        azimuth += dr.gather(jit.Float, start, lane)
        full = math.radians(config.horizontal_fov_deg)
        azimuth -= dr.select(azimuth >= full - 1e-6, full, 0)
    sine, cosine = dr.sincos(0.5 * math.radians(config.horizontal_fov_deg) - azimuth)
    level = dr.gather(jit.Float, scan.cosine, pulse)
    direction = jit.Array3f(level * cosine, level * sine, dr.gather(jit.Float, scan.sine, pulse))
    position, attitude = sensor_pose(motion, config)
    origin = dr.gather(jit.Array3f64, position, lane)
    q = jit.Array4f(*(dr.gather(jit.Float, jit.Float(attitude[i]), lane) for i in range(4)))
    if config.motion_distortion:
        before = -dr.gather(jit.Float, scan.age, pulse)
        velocity = dr.gather(jit.Array3f, jit.Array3f(sensor_velocity(motion, config)), lane)
        spin = dr.gather(jit.Array3f, jit.Array3f(sensor_angular_velocity(motion, config)), lane)
        origin += jit.Array3f64(rotate(q, velocity * before))
        q = integrate(q, spin, before)
    copy = dr.gather(jit.UInt32, motion.copy, lane)
    rays = Rays(
        origin=origin,
        direction=rotate(q, direction),
        max_range=dr.full(jit.Float, config.range_m, dr.width(pulse)),
        copy=copy,
        own=dr.gather(jit.UInt32, own, copy),
    )
    return rays, direction


def echoes(caster: Caster, rays: Rays, direction: Array, sea_way: Crossing, config: LaserConfig) -> Echoes:
    """Echoes of pulses from solids, and for pulses from above from the sea surface as configured.

    Pulses are mirrored and refracted as by level water, wherever they meet the waves.
    """
    hits = caster.cast(rays)
    rise = rays.direction.z
    wet = sea_way.under
    to_sea = dr.select(~wet & (rise < 0), sea_way.way, dr.inf)
    sea = to_sea < dr.minimum(hits.t, rays.max_range)
    found, incoming, deep_way = dr.zeros(jit.Bool, 1), rays.direction, jit.Float(0)
    if config.through_water:
        below = refract(rays.direction, jit.Array3f(0, 0, 1), 1 / REFRACTIVE_INDEX)
        reach = dr.select(sea, (rays.max_range - to_sea) / REFRACTIVE_INDEX, 0)
        start = rays.origin + jit.Array3f64(rays.direction) * jit.Float64(dr.select(sea, to_sea, 0))
        start += jit.Array3f64(below) * _NEAR
        deep = caster.cast(Rays(start, below, reach, rays.copy, rays.own))
        found = sea & deep.valid
        hits = dr.select(found, deep, hits)
        incoming, deep_way = dr.select(found, below, incoming), deep.t + _NEAR
    surface = sea & ~found
    in_air = dr.select(wet, 0, dr.select(sea, to_sea, hits.t))
    in_water = dr.select(wet, hits.t, dr.select(found, deep_way, 0))
    incidence = dr.abs(dr.dot(hits.normal, incoming))
    return Echoes(
        valid=(hits.valid & ~surface) | (surface & config.water_points),
        distance=in_air + in_water * dr.select(wet, 1.0, REFRACTIVE_INDEX),
        in_air=in_air,
        in_water=in_water,
        direction=direction,
        label=hits.label,
        instance=dr.select(surface, 0, hits.instance),
        material=hits.material,
        incidence=dr.select(surface, -rise, incidence),
    )
