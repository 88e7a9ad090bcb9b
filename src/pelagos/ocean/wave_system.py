"""Wave systems as a scenario gives them, and the component waves that stand for them.

A component has its own frequency (a random one in each of many bands, so that the sea never repeats) and one
direction; its amplitude is what the spectrum has in its band, so that the energy is exact and only phases,
frequencies and directions are random. One direction a frequency keeps the sea free of standing patterns: P. H.
Jefferys, Appl. Ocean Res. 9:2 (1987).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Final, Literal, Protocol, Self, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from pelagos.config.strict import Strict
from pelagos.math.dispersion import wavenumber
from pelagos.ocean.spectrum import (
    SEA_STATES,
    Values,
    cos2s,
    jonswap,
    ochi_hubble,
    pierson_moskowitz,
    pierson_moskowitz_peak,
    tma,
    torsethaugen,
    torsethaugen_peaks,
)

_LOWEST: Final = 0.5  # of the peak frequency: below lies 1e-8 of the energy
_HIGHEST: Final = 6.0  # of the peak frequency: above lies 0.1 % of the energy


@dataclass(frozen=True)
class Components:
    """Component waves, `(count,)` each: amplitude [m], omega [rad/s], k [1/m], angle from north to west [rad], phase
    [rad].
    """

    amplitude: Values
    omega: Values
    wavenumber: Values
    angle: Values
    phase: Values


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

    def components(self, rng: np.random.Generator, depth: float | None) -> Components:
        """The one component."""
        omega = np.array([2 * math.pi / self.period_s])
        angle, phase = np.array([-math.radians(self.towards_deg)]), np.array([math.radians(self.phase_deg)])
        return Components(np.array([self.height_m / 2]), omega, wavenumber(omega, depth), angle, phase)


class Spectrum(Protocol):
    """Spectrum that an irregular sea's components are made from."""

    @property
    def components_count(self) -> int:
        """Number of component waves."""
        ...

    @property
    def towards_deg(self) -> float:
        """Mean direction [deg]."""
        ...

    @property
    def spreading(self) -> float | None:
        """Exponent of the spreading."""
        ...

    @property
    def peak(self) -> float:
        """Peak period [s]."""
        ...

    def density(self, f: Values, depth: float | None) -> Values:
        """Spectrum at frequencies f [Hz], `[m^2/Hz]`."""
        ...

    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency [Hz]."""
        ...


class _IrregularConfig(Strict):
    towards_deg: float = Field(default=0.0, ge=-360, le=360)
    """Compass direction that the waves travel towards, in the mean [deg]: 0 north, 90 east."""
    spreading: float | None = Field(default=10.0, gt=0, le=1000)
    """Exponent s of the spreading cos^2s(angle / 2); null for long-crested waves."""
    components_count: int = Field(default=200, ge=1, le=5000)
    """Number of component waves."""
    seed: int = Field(default=0, ge=0, lt=2**63)
    """Another sea of the same kind for every number: phases, frequencies and directions are drawn anew."""

    def band(self: Spectrum) -> tuple[float, float]:
        """Lowest and highest frequency [Hz]."""
        return _LOWEST / self.peak, _HIGHEST / self.peak

    def components(self: Spectrum, rng: np.random.Generator, depth: float | None) -> Components:
        """Components whose energy is exactly that of the spectrum in the band."""
        low, high = self.band()
        edges = np.geomspace(low, high, self.components_count + 1)
        f = edges[:-1] + np.diff(edges) * rng.uniform(size=self.components_count)
        nodes, weights = np.polynomial.legendre.leggauss(8)
        half = 0.5 * np.diff(edges)[:, None]
        density = self.density((edges[:-1, None] + half * (1 + nodes)).ravel(), depth).reshape(-1, 8)
        energy = np.sum(half * weights * density, axis=1)
        if not energy.sum() > 0:
            raise ValueError(f"the spectrum has no energy between {low:g} and {high:g} Hz")
        angle = -math.radians(self.towards_deg) + _spread(self.components_count, self.spreading, rng)
        phase = rng.uniform(0, 2 * math.pi, self.components_count)
        omega = 2 * math.pi * f
        return Components(np.sqrt(2 * energy), omega, wavenumber(omega, depth), angle, phase)


class _PeakedConfig(_IrregularConfig):
    significant_height_m: float = Field(gt=0)
    """Significant wave height Hs [m]."""
    peak_period_s: float = Field(gt=0)
    """Peak period Tp [s]."""

    @property
    def peak(self) -> float:
        """Peak period [s]."""
        return self.peak_period_s


class JonswapWavesConfig(_PeakedConfig):
    """A wind sea after JONSWAP, with directional spreading."""

    type: Literal["jonswap"] = "jonswap"
    """The kind of waves."""
    gamma: float = Field(default=3.3, ge=1, le=10)
    """Peak enhancement; 1 is a fully developed sea."""

    def density(self, f: Values, depth: float | None) -> Values:
        """Spectrum at frequencies f [Hz], `[m^2/Hz]`."""
        return jonswap(f, self.significant_height_m, self.peak_period_s, self.gamma)


class TmaWavesConfig(JonswapWavesConfig):
    """A wind sea in shallow water; needs the ocean's `waves_depth_m`."""

    type: Literal["tma"] = "tma"  # type: ignore[assignment]
    """The kind of waves."""

    def density(self, f: Values, depth: float | None) -> Values:
        """Spectrum at frequencies f [Hz], `[m^2/Hz]`."""
        if depth is None:
            raise ValueError("waves of type tma need the ocean's waves_depth_m")
        return tma(f, self.significant_height_m, self.peak_period_s, self.gamma, depth)


class PiersonMoskowitzWavesConfig(_IrregularConfig):
    """A fully developed sea by its wind."""

    type: Literal["pierson_moskowitz"] = "pierson_moskowitz"
    """The kind of waves."""
    wind_mps: float = Field(gt=0, le=60)
    """Wind speed 19.5 m above the surface [m/s]."""

    @property
    def peak(self) -> float:
        """Peak period [s]."""
        return pierson_moskowitz_peak(self.wind_mps)

    def density(self, f: Values, depth: float | None) -> Values:
        """Spectrum at frequencies f [Hz], `[m^2/Hz]`."""
        return pierson_moskowitz(f, self.wind_mps)


class OchiHubbleWavesConfig(_PeakedConfig):
    """One peak of a two-peaked sea after Ochi and Hubble, its height and period; give two for swell and wind sea."""

    type: Literal["ochi_hubble"] = "ochi_hubble"
    """The kind of waves."""
    sharpness: float = Field(default=3.0, ge=0.5, le=20)
    """Shape lambda: 1 is a fully developed sea, swell is 3 or more."""

    def density(self, f: Values, depth: float | None) -> Values:
        """Spectrum at frequencies f [Hz], `[m^2/Hz]`."""
        return ochi_hubble(f, self.significant_height_m, self.peak_period_s, self.sharpness)


class TorsethaugenWavesConfig(_PeakedConfig):
    """Swell and wind sea in one, two-peaked, after Torsethaugen and Haver; North Sea, both in one direction."""

    type: Literal["torsethaugen"] = "torsethaugen"
    """The kind of waves."""
    significant_height_m: float = Field(gt=0, le=20)
    """Significant wave height of both together [m]."""
    peak_period_s: float = Field(gt=0, lt=25)
    """Peak period of the larger [s]; up to 6.6 Hs^(1/3) that is wind sea, above it swell."""

    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency [Hz]; the tail is slow, and above this band lies 0.06 % of the energy."""
        periods = [p.period for p in torsethaugen_peaks(self.significant_height_m, self.peak_period_s) if p.height > 0]
        return _LOWEST / max(periods), 2 * _HIGHEST / min(periods)

    def density(self, f: Values, depth: float | None) -> Values:
        """Spectrum at frequencies f [Hz], `[m^2/Hz]`."""
        return torsethaugen(f, self.significant_height_m, self.peak_period_s)


class SeaStateWavesConfig(_IrregularConfig):
    """A sea by its state: height and period of the North Atlantic (NATO STANAG 4194), spectrum of Pierson and
    Moskowitz.
    """

    type: Literal["sea_state"] = "sea_state"
    """The kind of waves."""
    state: int = Field(ge=0, le=9)
    """Sea state, 0 to 9."""

    @property
    def peak(self) -> float:
        """Peak period [s]."""
        return SEA_STATES[self.state][1]

    def density(self, f: Values, depth: float | None) -> Values:
        """Spectrum at frequencies f [Hz], `[m^2/Hz]`."""
        height, period = SEA_STATES[self.state]
        return jonswap(f, height, period, 1.0)

    def components(self, rng: np.random.Generator, depth: float | None) -> Components:
        """None for a calm."""
        if self.state == 0:
            nothing = np.zeros(0)
            return Components(nothing, nothing, nothing, nothing, nothing)
        return super().components(rng, depth)


class TableWavesConfig(_IrregularConfig):
    """A spectrum of your own."""

    type: Literal["table"] = "table"
    """The kind of waves."""
    frequency_hz: tuple[float, ...] = Field(min_length=2)
    """Frequencies, increasing [Hz]."""
    density_m2phz: tuple[float, ...] = Field(min_length=2)
    """Spectral density of the elevation at each, linear between [m^2/Hz]."""

    @model_validator(mode="after")
    def _rows(self) -> Self:
        if len(self.frequency_hz) != len(self.density_m2phz):
            text = f"{len(self.frequency_hz)} and {len(self.density_m2phz)}"
            raise ValueError(f"frequency_hz and density_m2phz must have as many entries, not {text}")
        if self.frequency_hz[0] <= 0 or any(
            b <= a for a, b in zip(self.frequency_hz, self.frequency_hz[1:], strict=False)
        ):
            raise ValueError("frequency_hz must be positive and increase from entry to entry")
        if min(self.density_m2phz) < 0 or max(self.density_m2phz) <= 0:
            raise ValueError("density_m2phz must not be negative, and somewhere positive")
        return self

    @property
    def peak(self) -> float:
        """Peak period [s]."""
        return 1 / self.frequency_hz[int(np.argmax(self.density_m2phz))]

    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency [Hz]."""
        return self.frequency_hz[0], self.frequency_hz[-1]

    def density(self, f: Values, depth: float | None) -> Values:
        """Spectrum at frequencies f [Hz], `[m^2/Hz]`."""
        return np.interp(f, self.frequency_hz, self.density_m2phz)


WavesConfig: TypeAlias = Annotated[
    RegularWavesConfig
    | JonswapWavesConfig
    | TmaWavesConfig
    | PiersonMoskowitzWavesConfig
    | OchiHubbleWavesConfig
    | TorsethaugenWavesConfig
    | SeaStateWavesConfig
    | TableWavesConfig,
    Field(discriminator="type"),
]


def _spread(count: int, exponent: float | None, rng: np.random.Generator) -> Values:
    """`count` angles about the mean direction: evenly spaced quantiles of cos^2s(angle / 2), in random order."""
    if exponent is None:
        return np.zeros(count)
    grid = np.linspace(-math.pi, math.pi, 8001)
    density = cos2s(grid, exponent)
    share = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    return np.interp((rng.permutation(count) + 0.5) / count, share / share[-1], grid)
