"""Wind over the sea: a mean that grows with height, and gusts.

Profile and spectrum: the Norwegian Petroleum Directorate's, ISO 19901-1:2015, Annex A.7 (O. J. Andersen and J.
Lovseth, Marine Structures 19:173, 2006, doi 10.1016/j.marstruc.2006.09.002), for strong winds; below some 10 m/s it
is an extrapolation.
"""

from __future__ import annotations

import math

import drjit as dr
import numpy as np
from pydantic import Field

from pelagos import jit
from pelagos.config.strict import Strict
from pelagos.jit import Array
from pelagos.ocean.current import components
from pelagos.ocean.site import Site
from pelagos.ocean.spectrum import Values


class WindConfig(Strict):
    """Wind, steady or gusty."""

    speed_mps: float = Field(default=0.0, ge=0, le=100)
    """Mean speed 10 m above the surface, over an hour [m/s]."""
    from_deg: float = Field(default=0.0, ge=-360, le=360)
    """Compass direction that the wind comes from [deg]: 270 is a west wind."""
    gusts: float = Field(default=0.0, ge=0, le=3)
    """Strength of the gusts: 1 is natural, 0 a steady wind."""
    gust_components: int = Field(default=60, ge=2, le=1000)
    """Number of harmonics that make the gusts."""

    def build(self, site: Site) -> Wind:
        """The wind on the device."""
        direction = components(1.0, self.from_deg + 180.0)
        count = self.gust_components if self.gusts > 0 and self.speed_mps > 0 else 0
        rng = site.rng(2)
        edges = np.geomspace(1 / 1800, 0.5, count + 1)
        f = edges[:-1] + np.diff(edges) * rng.uniform(size=count)
        amplitude = self.gusts * np.sqrt(2 * gust_spectrum(f, self.speed_mps) * np.diff(edges)) if count else f
        phase = rng.uniform(0, 2 * math.pi, count)
        rows = np.stack([amplitude, 2 * math.pi * f, phase], axis=-1).ravel() if count else np.zeros(1)
        shear = 5.73e-2 * math.sqrt(1 + 0.15 * self.speed_mps)
        speed, north, west, growth = (jit.Float64(v) for v in (self.speed_mps, *direction, shear))
        wind = Wind(speed, north, west, growth, jit.Float64(rows), count, self.speed_mps > 0)
        jit.align(wind)
        return wind


@jit.struct
class Wind:
    """Attributes: `Float64` (1): speed [m/s], direction (north, west), growth with the logarithm of height; gusts:
    amplitude [m/s], omega [rad/s], phase [rad] of each of `count` harmonics; blows: whether there is any.
    """

    speed: Array
    north: Array
    west: Array
    shear: Array
    gusts: Array
    count: int
    blows: bool

    def velocity(self, height: Array, t: Array) -> Array:
        """Velocity of the air [m/s] `height` [m] above the surface at time t [s], `Array3f64` NWU; the same at 0.5 m
        and below.
        """
        speed = self.speed * (1 + self.shear * dr.log(dr.maximum(height, 0.5) * 0.1))
        for i in range(self.count):
            a, w, p = (dr.gather(jit.Float64, self.gusts, jit.UInt32(3 * i + j)) for j in range(3))
            speed = speed + a * dr.cos(w * t + p)
        return jit.Array3f64(speed * self.north, speed * self.west, 0.0)


def gust_spectrum(f: Values, speed: float, height: float = 10.0) -> Values:
    """Spectral density of the speed along the wind [m^2/s^2/Hz] at f [Hz]; 1/600 to 0.5 Hz (ISO 19901-1, equation
    A.8).
    """
    n = 0.468
    reduced = 172.0 * f * (height / 10) ** (2 / 3) * (speed / 10) ** -0.75
    return np.asarray(320.0 * (speed / 10) ** 2 * (height / 10) ** 0.45 / (1 + reduced**n) ** (5 / (3 * n)))
