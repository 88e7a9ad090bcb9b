"""Plumes of something that a point source gives off: steady in a steady stream, or carried along by the currents.

Steady: the far-field solution of the advection-diffusion equation for a continuous point source, with its image above
the surface. Drifting: a chain of Gaussian puffs, each carried by the current from the moment it left the source.
Source: H. B. Fischer et al., Mixing in Inland and Coastal Waters (1979), Sections 2.3 and 2.4.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, Literal

import drjit as dr
import numpy as np
from pydantic import Field, field_validator

from pelagos import jit
from pelagos.config.strict import Strict
from pelagos.jit import Array
from pelagos.ocean.current import Current, components
from pelagos.ocean.current import total as total_current
from pelagos.ocean.site import Site

if TYPE_CHECKING:
    from pelagos.ocean.tracer import ScalarField
    from pelagos.ocean.waves import Waves

_STEPS: Final = 400  # of a puff's path


class _Source(Strict):
    source_m: tuple[float, float, float]
    """Place of the source under the surface: world x (north), y (west), z (up, so not above 0) [m]."""
    rate: float = Field(gt=0)
    """What the source gives off each second, in the tracer's unit times cubic metres."""
    spread_m2ps: float = Field(default=0.05, gt=0)
    """Horizontal turbulent diffusivity [m^2/s]."""
    spread_up_m2ps: float = Field(default=0.005, gt=0)
    """Vertical turbulent diffusivity [m^2/s]."""
    initial_m: float = Field(default=0.5, gt=0)
    """Standard deviation of the cloud where it leaves the source [m]."""

    @field_validator("source_m")
    @classmethod
    def _under_water(cls, value: tuple[float, float, float]) -> tuple[float, float, float]:
        if value[2] > 0:
            raise ValueError(
                f"the source lies {value[2]:g} m above the surface; z counts upwards: {-value[2]:g} is below"
            )
        return value


class PlumeConfig(_Source):
    """A steady plume in a steady, uniform stream, which is given here and not taken from the currents."""

    type: Literal["plume"] = "plume"
    """The kind of field."""
    speed_mps: float = Field(gt=0)
    """Speed of the stream [m/s]."""
    towards_deg: float = Field(ge=-360, le=360)
    """Compass direction that the stream moves towards [deg]."""

    def build(self, site: Site) -> ScalarField:
        """The component on the device."""
        direction = components(1.0, self.towards_deg)
        values = (*self.source_m, *direction, self.speed_mps, self.rate, self.spread_m2ps, self.spread_up_m2ps)
        return Plume(*(dr.opaque(jit.Float64, v) for v in (*values, self.initial_m**2)))


@jit.struct
class Plume:
    """Attributes: `Float64` (1): source x, y, z [m], direction (north, west), speed [m/s], rate, diffusivities [m^2/s],
    variance at the source [m^2].
    """

    x: Array
    y: Array
    z: Array
    north: Array
    west: Array
    speed: Array
    rate: Array
    across: Array
    up: Array
    initial: Array

    def value(self, position: Array, t: Array) -> Array:
        """See `ScalarField`: rate / (2 pi u s_y s_z) exp(-y^2 / 2 s_y^2 - z^2 / 2 s_z^2), s^2 = s_0^2 + 2 K x / u."""
        dx, dy = position[0] - self.x, position[1] - self.y
        along = dx * self.north + dy * self.west
        aside = dy * self.north - dx * self.west
        age = dr.maximum(along, 0.0) / self.speed
        sy2, sz2 = self.initial + 2 * self.across * age, self.initial + 2 * self.up * age
        high, image = position[2] - self.z, position[2] + self.z
        vertical = dr.exp(-0.5 * high * high / sz2) + dr.exp(-0.5 * image * image / sz2)
        level = self.rate / (2 * math.pi * self.speed * dr.sqrt(sy2 * sz2))
        return dr.select(along > 0, level * dr.exp(-0.5 * aside * aside / sy2) * vertical, 0.0)


class DriftingPlumeConfig(_Source):
    """A plume that the scenario's currents carry away, and its waves by their Stokes drift, from t = 0 on."""

    type: Literal["drifting_plume"] = "drifting_plume"
    """The kind of field."""
    duration_s: float = Field(default=3600.0, gt=0)
    """How long the source is active, and how long its water is followed [s]."""
    puffs: int = Field(default=200, ge=2, le=5000)
    """Number of puffs that stand for the plume."""

    def carried(self, currents: list[Current], site: Site, waves: Waves | None = None) -> ScalarField:
        """The component on the device: each puff's path with the mean motion of the water (Runge-Kutta, fourth order).

        Waves move water to and fro, by less than their height, and carry it along by their Stokes drift: the path is
        the mean over a period.
        """
        step = self.duration_s / _STEPS
        interval = self.duration_s / self.puffs
        born = dr.arange(jit.Float64, self.puffs) * interval
        place = jit.Array3f64(*(dr.full(jit.Float64, v, self.puffs) for v in self.source_m))
        paths = [np.array(place).T]
        advance, h = jit.freeze(_advance), dr.opaque(jit.Float64, step)  # times as arrays: one kernel for all steps
        dr.make_opaque(place, born)
        for number in range(_STEPS):
            place = advance(currents, waves, place, born, dr.opaque(jit.Float64, number * step), h)
            paths.append(np.array(place).T)
        table = jit.Float64(np.ascontiguousarray(paths, dtype=np.float64).ravel())  # (steps + 1, puffs, 3)
        values = (self.rate * interval, self.spread_m2ps, self.spread_up_m2ps, self.initial_m**2, interval, 1 / step)
        amount, across, up, initial, gap, steps = (jit.Float64(v) for v in values)
        plume = DriftingPlume(table, amount, across, up, initial, gap, steps, self.puffs)
        jit.align(plume)
        return plume


@jit.struct
class DriftingPlume:
    """Attributes: paths: `Float64`, place of every puff at every step (x, y, z) [m]; `Float64` (1): amount of a puff,
    diffusivities [m^2/s], variance at the source [m^2], time between puffs [s], steps a second [1/s]; puffs: how many.
    """

    paths: Array
    amount: Array
    across: Array
    up: Array
    initial: Array
    interval: Array
    steps: Array
    puffs: int

    def value(self, position: Array, t: Array) -> Array:
        """See `ScalarField`; each puff is a Gaussian of variance s_0^2 + 2 K age, with its image above the surface."""
        cell = dr.clip(t * self.steps, 0.0, float(_STEPS) - 1e-9)
        row = dr.minimum(jit.UInt32(cell), _STEPS - 1)
        share = cell - jit.Float64(row)

        def add(i: Array, sum_: Array) -> tuple[Array, Array]:
            at = 3 * (row * self.puffs + i)
            before = [dr.gather(jit.Float64, self.paths, at + j) for j in range(3)]
            after = [dr.gather(jit.Float64, self.paths, at + 3 * self.puffs + j) for j in range(3)]
            x, y, z = (a + share * (b - a) for a, b in zip(before, after, strict=True))
            age = t - jit.Float64(i) * self.interval
            sy2 = self.initial + 2 * self.across * dr.maximum(age, 0.0)
            sz2 = self.initial + 2 * self.up * dr.maximum(age, 0.0)
            flat = (position[0] - x) ** 2 + (position[1] - y) ** 2
            vertical = dr.exp(-0.5 * (position[2] - z) ** 2 / sz2) + dr.exp(-0.5 * (position[2] + z) ** 2 / sz2)
            level = self.amount / ((2 * math.pi) ** 1.5 * sy2 * dr.sqrt(sz2))
            return i + 1, sum_ + dr.select(age > 0, level * dr.exp(-0.5 * flat / sy2) * vertical, 0.0)

        start = (jit.UInt32(0), 0 * (position[0] + t))
        return dr.while_loop(start, lambda i, _: i < self.puffs, add, mode="symbolic")[1]


def _advance(currents: list[Current], waves: Waves | None, place: Array, born: Array, t: Array, h: Array) -> Array:
    """One step of Runge and Kutta's fourth order, for the puffs that have left the source."""

    def velocity(p: Array, time: Array) -> Array:
        flow = total_current(currents, p, time)
        return dr.select(time >= born, flow if waves is None else flow + waves.drift(p[2]), 0.0)

    k1 = velocity(place, t)
    k2 = velocity(place + 0.5 * h * k1, t + 0.5 * h)
    k3 = velocity(place + 0.5 * h * k2, t + 0.5 * h)
    k4 = velocity(place + h * k3, t + h)
    return place + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
