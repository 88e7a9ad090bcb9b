"""Currents with a formula: shear, tide, vortex, jet, gyre. All are free of divergence; none knows of walls.

Horizontal places and centres are world x (north), y (west) [m]; directions of the compass, towards which the water
moves.
"""

from __future__ import annotations

import math
from typing import Final, Literal, Self, TypeAlias

import drjit as dr
from pydantic import Field, field_validator, model_validator

from pelagos import jit
from pelagos.config.strict import Strict
from pelagos.jit import Array
from pelagos.ocean.current import Current, components
from pelagos.ocean.site import Site

TideName: TypeAlias = Literal["M2", "S2", "N2", "K2", "K1", "O1", "P1", "Q1", "M4", "S1"]

TIDE_PERIOD_H: Final[dict[str, float]] = {
    "M2": 12.4206012, "S2": 12.0, "N2": 12.65834751, "K2": 11.96723606, "K1": 23.93447213, "O1": 25.81933871,
    "P1": 24.06588766, "Q1": 26.868350, "M4": 6.210300601, "S1": 24.0,
}  # fmt: skip
"""Periods of tidal constituents [h]; P. Schureman, Manual of Harmonic Analysis and Prediction of Tides, 1958, Table
2.
"""

_LAMB: Final = 1.25643120862616962  # where (1 - exp(-a r^2)) / r is largest: 1 + 2 a = exp(a)


class ShearCurrentConfig(Strict):
    """A current that grows or falls linearly with depth."""

    type: Literal["shear"] = "shear"
    """The kind of current."""
    speed_mps: float = Field(ge=-20, le=20)
    """Speed at the surface [m/s]."""
    per_m: float = Field(ge=-10, le=10)
    """Change of the speed with each metre of depth [1/s]."""
    towards_deg: float = Field(default=0.0, ge=-360, le=360)
    """Compass direction that the water moves towards [deg]."""

    def build(self, site: Site) -> Current:
        """The component on the device."""
        return ShearCurrent(*_opaque(self.speed_mps, self.per_m, *components(1.0, self.towards_deg)))


@jit.struct
class ShearCurrent:
    """Attributes: `Float64` (1): speed at the surface, slope, direction (north, west)."""

    speed: Array
    slope: Array
    north: Array
    west: Array

    def velocity(self, position: Array, t: Array) -> Array:
        """See `Current`."""
        speed = self.speed - self.slope * position[2]
        return jit.Array3f64(speed * self.north, speed * self.west, 0.0)


class TidalCurrentConfig(Strict):
    """A tidal stream: the velocity runs around an ellipse in one period."""

    type: Literal["tidal"] = "tidal"
    """The kind of current."""
    constituent: TideName | None = None
    """Name of the constituent, which gives the period; or give `period_h`."""
    period_h: float | None = Field(default=None, gt=0)
    """Period [h]; without a constituent."""
    speed_mps: float = Field(ge=0, le=20)
    """Largest speed, along `towards_deg` [m/s]."""
    across_mps: float = Field(default=0.0, ge=-20, le=20)
    """Speed a quarter of a period later, to the left of it [m/s]; 0 for a stream that only goes to and fro."""
    towards_deg: float = Field(default=0.0, ge=-360, le=360)
    """Compass direction of the strongest stream [deg]."""
    phase_deg: float = 0.0
    """Phase lag: the stream is strongest this much of a turn after t = 0 [deg]."""

    @model_validator(mode="after")
    def _period(self) -> Self:
        tide_omega(self.constituent, self.period_h)
        return self

    def build(self, site: Site) -> Current:
        """The component on the device."""
        omega = tide_omega(self.constituent, self.period_h)
        direction = components(1.0, self.towards_deg)
        return TidalCurrent(*_opaque(self.speed_mps, self.across_mps, *direction, omega, math.radians(self.phase_deg)))


@jit.struct
class TidalCurrent:
    """Attributes: `Float64` (1): semi-axes [m/s], direction (north, west), omega [rad/s], phase [rad]."""

    major: Array
    minor: Array
    north: Array
    west: Array
    omega: Array
    phase: Array

    def velocity(self, position: Array, t: Array) -> Array:
        """See `Current`."""
        s, c = dr.sincos(self.omega * t - self.phase)
        along, left = self.major * c, self.minor * s
        return jit.Array3f64(along * self.north - left * self.west, along * self.west + left * self.north, 0.0)


class VortexCurrentConfig(Strict):
    """A Lamb-Oseen vortex: a core that turns like a body, and a swirl that falls off outside; it may drift."""

    type: Literal["vortex"] = "vortex"
    """The kind of current."""
    center_m: tuple[float, float] = (0.0, 0.0)
    """Centre at t = 0: world x (north), y (west) [m]."""
    radius_m: float = Field(gt=0)
    """Radius at which it is fastest [m]."""
    speed_mps: float = Field(ge=-20, le=20)
    """Speed there, counter-clockwise seen from above [m/s]."""
    drift_mps: float = Field(default=0.0, ge=0, le=20)
    """Speed of the centre [m/s]."""
    drift_towards_deg: float = Field(default=0.0, ge=-360, le=360)
    """Compass direction in which the centre moves [deg]."""

    def build(self, site: Site) -> Current:
        """The component on the device."""
        drift = components(self.drift_mps, self.drift_towards_deg)
        strength = self.speed_mps * self.radius_m / (1 - math.exp(-_LAMB))
        return VortexCurrent(*_opaque(*self.center_m, strength, _LAMB / self.radius_m**2, *drift))


@jit.struct
class VortexCurrent:
    """v = strength / r (1 - exp(-decay r^2)); P. G. Saffman, Vortex Dynamics (1992), Section 13.1.

    Attributes: `Float64` (1): centre x, y [m], strength [m^2/s], decay [1/m^2], drift x, y [m/s].
    """

    x: Array
    y: Array
    strength: Array
    decay: Array
    drift_x: Array
    drift_y: Array

    def velocity(self, position: Array, t: Array) -> Array:
        """See `Current`."""
        dx, dy = position[0] - self.x - self.drift_x * t, position[1] - self.y - self.drift_y * t
        q = self.decay * (dx * dx + dy * dy)
        small = q < 1e-6
        swirl = self.decay * dr.select(small, 1 - 0.5 * q, (1 - dr.exp(-q)) / dr.select(small, 1.0, q)) * self.strength
        return jit.Array3f64(-swirl * dy, swirl * dx, 0.0)


class JetCurrentConfig(Strict):
    """A Bickley jet: fastest on its axis, falling off as 1 / cosh^2 of the distance."""

    type: Literal["jet"] = "jet"
    """The kind of current."""
    through_m: tuple[float, float] = (0.0, 0.0)
    """A point of the axis: world x (north), y (west) [m]."""
    towards_deg: float = Field(default=0.0, ge=-360, le=360)
    """Compass direction that the water moves towards [deg]."""
    speed_mps: float = Field(ge=0, le=20)
    """Speed on the axis [m/s]."""
    width_m: float = Field(gt=0)
    """Distance from the axis at which 42 % of the speed is left [m]."""
    depth_m: float | None = Field(default=None, gt=0)
    """Depth at which 37 % of the speed is left (exponential) [m]; the same at all depths where not given."""

    def build(self, site: Site) -> Current:
        """The component on the device."""
        direction = components(1.0, self.towards_deg)
        decay = 0.0 if self.depth_m is None else 1 / self.depth_m
        return JetCurrent(*_opaque(*self.through_m, *direction, self.speed_mps, 1 / self.width_m, decay))


@jit.struct
class JetCurrent:
    """Attributes: `Float64` (1): point x, y [m], direction (north, west), speed [m/s], 1 / width, 1 / depth [1/m]."""

    x: Array
    y: Array
    north: Array
    west: Array
    speed: Array
    sharpness: Array
    decay: Array

    def velocity(self, position: Array, t: Array) -> Array:
        """See `Current`; W. G. Bickley, Phil. Mag. 23:727 (1937), doi 10.1080/14786443708561847."""
        aside = (position[1] - self.y) * self.north - (position[0] - self.x) * self.west
        fall = 1 / dr.cosh(dr.minimum(dr.abs(aside * self.sharpness), 300.0))
        speed = self.speed * fall * fall * dr.exp(self.decay * dr.minimum(position[2], 0.0))
        return jit.Array3f64(speed * self.north, speed * self.west, 0.0)


class GyreCurrentConfig(Strict):
    """A gyre: inside its radius the water turns like a body, outside the speed falls off as 1 / r."""

    type: Literal["gyre"] = "gyre"
    """The kind of current."""
    center_m: tuple[float, float] = (0.0, 0.0)
    """Centre: world x (north), y (west) [m]."""
    radius_m: float = Field(gt=0)
    """Radius of the part that turns like a body [m]."""
    period_s: float
    """Time of one turn [s]; counter-clockwise from above where positive, clockwise where negative."""

    @field_validator("period_s")
    @classmethod
    def _turns(cls, value: float) -> float:
        if value == 0:
            raise ValueError("the period of a gyre cannot be 0")
        return value

    def build(self, site: Site) -> Current:
        """The component on the device."""
        return GyreCurrent(*_opaque(*self.center_m, self.radius_m**2, 2 * math.pi / self.period_s))


@jit.struct
class GyreCurrent:
    """Attributes: `Float64` (1): centre x, y [m], radius squared [m^2], omega [rad/s]."""

    x: Array
    y: Array
    radius2: Array
    omega: Array

    def velocity(self, position: Array, t: Array) -> Array:
        """See `Current`; the Rankine vortex, e.g. P. G. Saffman, Vortex Dynamics (1992), Section 1.3."""
        dx, dy = position[0] - self.x, position[1] - self.y
        omega = self.omega * dr.minimum(1.0, self.radius2 / dr.maximum(dx * dx + dy * dy, 1e-12))
        return jit.Array3f64(-omega * dy, omega * dx, 0.0)


def tide_omega(constituent: str | None, period_h: float | None) -> float:
    """Angular frequency of a constituent by name, or by period [rad/s]."""
    if (constituent is None) == (period_h is None):
        raise ValueError("give either 'constituent' or 'period_h'")
    hours = TIDE_PERIOD_H[constituent] if constituent is not None else period_h
    return 2 * math.pi / (3600.0 * float(hours or math.nan))


def _opaque(*values: float) -> list[Array]:
    return [dr.opaque(jit.Float64, float(v)) for v in values]
