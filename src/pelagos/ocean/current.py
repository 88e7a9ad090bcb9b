"""Currents: components that are summed. Each has its configuration, and a Dr.Jit struct with `velocity(position, t)`.

Positions are world NWU [m], z up from the mean surface; velocities NWU [m/s]; t in seconds of simulation. Scenario
files say a speed and the compass direction that the water moves towards.
"""

from __future__ import annotations

import math
from typing import Literal, Protocol, Self

import drjit as dr
import numpy as np
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.config.strict import Strict
from pelagos.jit import Array
from pelagos.math.lookup import locate
from pelagos.ocean.site import Site


class Current(Protocol):
    """One component of the current, a Dr.Jit struct."""

    def velocity(self, position: Array, t: Array) -> Array:
        """`Array3f64` NWU [m/s] at `position` (`Array3f64` NWU [m]) and time `t` (`Float64` [s])."""
        ...


class UniformCurrentConfig(Strict):
    """The same current everywhere and always."""

    type: Literal["uniform"] = "uniform"
    """The kind of current."""
    speed_mps: float = Field(ge=0, le=20)
    """Speed [m/s]."""
    towards_deg: float = Field(default=0.0, ge=-360, le=360)
    """Compass direction that the water moves towards [deg]: 0 north, 90 east."""
    up_mps: float = Field(default=0.0, ge=-20, le=20)
    """Vertical speed, upwards positive [m/s]."""

    def build(self, site: Site) -> Current:
        """The component on the device."""
        north, west = components(self.speed_mps, self.towards_deg)
        return UniformCurrent(dr.opaque(jit.Array3f64, [north, west, self.up_mps]))


@jit.struct
class UniformCurrent:
    """Attributes: value: `Array3f64` (1) NWU [m/s]."""

    value: Array

    def velocity(self, position: Array, t: Array) -> Array:
        """See `Current`."""
        return self.value


class ProfileCurrentConfig(Strict):
    """A current that depends on depth: a table, linear between its rows, held beyond them."""

    type: Literal["profile"] = "profile"
    """The kind of current."""
    depth_m: tuple[float, ...] = Field(min_length=2)
    """Depths of the rows, increasing [m]."""
    speed_mps: tuple[float, ...] = Field(min_length=2)
    """Speed in each row [m/s]."""
    towards_deg: tuple[float, ...] = Field(min_length=2)
    """Compass direction that the water moves towards in each row [deg]: 0 north, 90 east."""

    @model_validator(mode="after")
    def _rows(self) -> Self:
        if not len(self.depth_m) == len(self.speed_mps) == len(self.towards_deg):
            lengths = f"{len(self.depth_m)}, {len(self.speed_mps)} and {len(self.towards_deg)}"
            raise ValueError(f"depth_m, speed_mps and towards_deg must have the same number of rows, not {lengths}")
        if any(b <= a for a, b in zip(self.depth_m, self.depth_m[1:], strict=False)):
            raise ValueError(f"depth_m must increase from row to row, not {self.depth_m}")
        if min(self.speed_mps) < 0:
            raise ValueError(f"speed_mps must not be negative, not {min(self.speed_mps)}")
        return self

    def build(self, site: Site) -> Current:
        """The component on the device."""
        rows = [components(s, d) for s, d in zip(self.speed_mps, self.towards_deg, strict=True)]
        north, west = np.array(rows).T
        current = ProfileCurrent(*(jit.Float64(np.array(a, dtype=np.float64)) for a in (self.depth_m, north, west)))
        jit.align(current)
        return current


@jit.struct
class ProfileCurrent:
    """Attributes: depth [m], north and west [m/s]: `Float64`, one entry a row."""

    depth: Array
    north: Array
    west: Array

    def velocity(self, position: Array, t: Array) -> Array:
        """See `Current`."""
        i, fraction = locate(self.depth, -position[2])
        north0, west0 = (dr.gather(jit.Float64, a, i) for a in (self.north, self.west))
        north1, west1 = (dr.gather(jit.Float64, a, i + 1) for a in (self.north, self.west))
        return jit.Array3f64(north0 + fraction * (north1 - north0), west0 + fraction * (west1 - west0), 0.0)


def components(speed: float, towards_deg: float) -> tuple[float, float]:
    """(north, west) of a speed towards a compass direction."""
    a = math.radians(towards_deg)
    return speed * math.cos(a), -speed * math.sin(a)


def total(currents: list[Current], position: Array, t: Array) -> Array:
    """Sum of all components, `Array3f64` NWU [m/s]."""
    velocity = jit.Array3f64(0.0)
    for current in currents:
        velocity = velocity + current.velocity(position, t)
    return velocity
