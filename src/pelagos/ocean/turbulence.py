"""Turbulence: a frozen-in field of random Fourier modes, free of divergence, with Kolmogorov's spectrum.

R. H. Kraichnan, "Diffusion by a random velocity field", Phys. Fluids 13:22 (1970), doi 10.1063/1.1692799: each mode's
velocity is perpendicular to its wave vector, so that every sum of modes is free of divergence. Energy per octave
falls as k^(-2/3) (E(k) ~ k^(-5/3)); each mode changes in its own turnover time.
"""

from __future__ import annotations

from typing import Literal, Self

import drjit as dr
import numpy as np
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.config.strict import Strict
from pelagos.jit import Array
from pelagos.ocean.current import Current
from pelagos.ocean.site import Site


class TurbulentCurrentConfig(Strict):
    """Random eddies of many sizes."""

    type: Literal["turbulence"] = "turbulence"
    """The kind of current."""
    rms_mps: float = Field(gt=0, le=10)
    """Root mean square of each component of the velocity [m/s]."""
    largest_m: float = Field(default=50.0, gt=0)
    """Wavelength of the largest eddies [m]."""
    smallest_m: float = Field(default=2.0, gt=0)
    """Wavelength of the smallest eddies [m]."""
    modes: int = Field(default=64, ge=4, le=2000)
    """Number of Fourier modes."""

    @model_validator(mode="after")
    def _sizes(self) -> Self:
        if self.smallest_m > self.largest_m:
            raise ValueError(f"smallest_m ({self.smallest_m:g}) must not be larger than largest_m ({self.largest_m:g})")
        return self

    def build(self, site: Site) -> Current:
        """The component on the device."""
        rng = site.rng(1, self.modes)
        share = (np.arange(self.modes) + rng.uniform(size=self.modes)) / self.modes
        k = 2 * np.pi / self.largest_m * (self.largest_m / self.smallest_m) ** share
        direction = rng.normal(size=(self.modes, 3))
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        across = np.cross(direction, rng.normal(size=(self.modes, 3)))
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        energy = k ** (-2 / 3)
        amplitude = across * np.sqrt(6 * self.rms_mps**2 * energy / energy.sum())[:, None]
        omega = 0.5 * k * np.linalg.norm(amplitude, axis=1) * np.sqrt(self.modes / np.log2(k.max() / k.min() + 2))
        columns = (*(direction * k[:, None]).T, *amplitude.T, omega, rng.uniform(0, 2 * np.pi, self.modes))
        current = TurbulentCurrent(jit.Float64(np.ascontiguousarray(np.stack(columns, axis=-1)).ravel()))
        jit.align(current)
        return current


@jit.struct
class TurbulentCurrent:
    """Attributes: modes: `Float64`, by mode: wave vector (3) [1/m], velocity (3) [m/s], omega [rad/s], phase [rad]."""

    modes: Array

    def velocity(self, position: Array, t: Array) -> Array:
        """See `Current`."""
        count = dr.width(self.modes) // 8
        nothing = 0 * (position[0] + t)

        def add(i: Array, u: Array, v: Array, w: Array) -> tuple[Array, ...]:
            k0, k1, k2, a0, a1, a2, omega, phase = (dr.gather(jit.Float64, self.modes, 8 * i + j) for j in range(8))
            wave = dr.cos(k0 * position[0] + k1 * position[1] + k2 * position[2] - omega * t + phase)
            return i + 1, u + a0 * wave, v + a1 * wave, w + a2 * wave

        start = (jit.UInt32(0), nothing, nothing, nothing)
        _, u, v, w = dr.while_loop(start, lambda i, *_: i < count, add, mode="symbolic")
        return jit.Array3f64(u, v, w)
