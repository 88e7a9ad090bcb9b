"""Surface waves: one table of components, evaluated wherever somebody asks. Linear (Airy) theory.

Elevation sum a cos(k . x - omega t + phase), e.g. L. H. Holthuijsen, Waves in Oceanic and Coastal Waters (2007),
Chapters 3 and 5. Pictures, buoyancy, sensors and sound all read this table, so they see the same sea.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Final, Literal, TypeAlias

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos import jit
from pelagos.config.strict import Strict
from pelagos.jit import Array
from pelagos.ocean.spectrum import jonswap, wavenumber

Rows: TypeAlias = NDArray[np.float64]

_LOWEST: Final = 0.5  # of the peak frequency: below lies 1e-8 of the energy
_HIGHEST: Final = 6.0  # of the peak frequency: above lies 0.06 % of the energy


class RegularWavesConfig(Strict):
    """One sinusoidal wave."""

    type: Literal["regular"] = "regular"
    """The kind of waves."""
    height_m: float = Field(gt=0)
    """From trough to crest [m]."""
    period_s: float = Field(gt=0)
    """Period [s]."""
    towards_deg: float = Field(default=0.0, ge=-360, le=360)
    """Compass direction that the waves travel towards [deg]: 0 north, 90 east."""
    phase_deg: float = 0.0
    """Phase at the world's origin at t = 0; 0 is a crest [deg]."""

    def components(self, rng: np.random.Generator) -> Rows:
        """See `component_rows`."""
        return np.array([[self.height_m / 2, 2 * math.pi / self.period_s, _direction(self.towards_deg),
                          math.radians(self.phase_deg)]])  # fmt: skip


class JonswapWavesConfig(Strict):
    """A wind sea after JONSWAP, with directional spreading."""

    type: Literal["jonswap"] = "jonswap"
    """The kind of waves."""
    significant_height_m: float = Field(gt=0)
    """Significant wave height Hs [m]."""
    peak_period_s: float = Field(gt=0)
    """Peak period Tp [s]."""
    gamma: float = Field(default=3.3, ge=1, le=10)
    """Peak enhancement; 1 is a fully developed sea (Pierson-Moskowitz)."""
    towards_deg: float = Field(default=0.0, ge=-360, le=360)
    """Compass direction that the waves travel towards, in the mean [deg]: 0 north, 90 east."""
    spreading: float | None = Field(default=10.0, gt=0)
    """Exponent s of the spreading cos^2s(angle / 2); null for long-crested waves."""
    components_count: int = Field(default=200, ge=1, le=5000)
    """Number of component waves."""

    def components(self, rng: np.random.Generator) -> Rows:
        """See `component_rows`."""
        f, df = _frequencies(self.components_count, self.peak_period_s, rng)
        energy = jonswap(f, self.significant_height_m, self.peak_period_s, self.gamma) * df
        energy *= (self.significant_height_m / 4) ** 2 / energy.sum()
        angle = _direction(self.towards_deg) + _spread(self.components_count, self.spreading, rng)
        phase = rng.uniform(0, 2 * math.pi, len(f))
        return np.stack([np.sqrt(2 * energy), 2 * math.pi * f, angle, phase], axis=-1)


WavesConfig: TypeAlias = Annotated[RegularWavesConfig | JonswapWavesConfig, Field(discriminator="type")]


@dataclass
class Waves:
    """The components: a Dr.Jit struct of `Float64`, one entry a component.

    Attributes:
        amplitude: [m].
        omega: [rad/s].
        kx, ky: wave vector in the world NWU [1/m].
        phase: [rad].
    """

    amplitude: Array
    omega: Array
    kx: Array
    ky: Array
    phase: Array

    def elevation(self, x: Array, y: Array, t: Array) -> Array:
        """Height of the surface over the mean [m] at world x, y [m] and time t [s], `Float64`."""
        count = dr.width(self.amplitude)
        zero = 0 * (x + y + t)

        def add(i: Array, height: Array) -> tuple[Array, Array]:
            a, w, kx, ky, p = (
                dr.gather(jit.Float64, v, i) for v in (self.amplitude, self.omega, self.kx, self.ky, self.phase)
            )
            return i + 1, height + a * dr.cos(kx * x + ky * y - w * t + p)

        start = (jit.UInt32(0), zero)
        return dr.while_loop(start, lambda i, _: i < count, add, mode="symbolic")[1]


def build_waves(systems: tuple[WavesConfig, ...], *, depth: float | None, seed: int) -> Waves | None:
    """The components of all wave systems together; None where there are none.

    Args:
        systems: see the configurations.
        depth: of the water, for the dispersion relation [m]; None for deep water.
        seed: of phases and directions.
    """
    if not systems:
        return None
    rows = []
    for number, system in enumerate(systems):
        rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, 0x0CEA, number])))
        rows.append(system.components(rng))
    amplitude, omega, angle, phase = np.concatenate(rows).T
    k = wavenumber(omega, depth)
    table = (amplitude, omega, k * np.cos(angle), k * np.sin(angle), phase)
    waves = Waves(*(jit.Float64(np.ascontiguousarray(column)) for column in table))
    dr.make_opaque(waves)
    return waves


def _direction(towards_deg: float) -> float:
    """Angle from north towards west, of a compass direction [rad]."""
    return -math.radians(towards_deg)


def _frequencies(count: int, peak_period: float, rng: np.random.Generator) -> tuple[Rows, Rows]:
    """One random frequency in each of `count` bands [Hz] (so that the sea does not repeat), and the bands' widths."""
    edges = np.geomspace(_LOWEST, _HIGHEST, count + 1) / peak_period
    width = np.diff(edges)
    return edges[:-1] + width * rng.uniform(size=count), width


def _spread(count: int, exponent: float | None, rng: np.random.Generator) -> Rows:
    """`count` angles about the mean direction: evenly spaced quantiles of cos^2s(angle / 2), in random order."""
    if exponent is None:
        return np.zeros(count)
    grid = np.linspace(-math.pi, math.pi, 4001)
    density = np.abs(np.cos(grid / 2)) ** (2 * exponent)
    share = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    return np.interp((rng.permutation(count) + 0.5) / count, share / share[-1], grid)
