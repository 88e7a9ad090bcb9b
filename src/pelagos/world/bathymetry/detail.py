"""Relief finer than a survey, invented: random, seeded, with the survey's own spectrum carried on to shorter waves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import WorldError
from pelagos.math.geodesy import GeoOrigin
from pelagos.world.bathymetry.projection import to_latlon
from pelagos.world.bathymetry.regrid import fill, sample
from pelagos.world.bathymetry.survey import Grid, Soundings
from pelagos.world.generate.relief import fractal
from pelagos.world.terrain import HeightField

_LEAST: Final = 16  # nodes along either side that a spectrum is measured on
_MOST: Final = 1024
_BAND: Final = (16.0, 3.0)  # wavelengths that the power law is fitted to, in spacings: longest, shortest


@dataclass(frozen=True)
class Spectrum:
    """A power law of relief.

    Attributes:
        level: two-dimensional power spectral density at a wave number of 1 cycle/m [m^4].
        slope: b in S(k) = level k^-b.
    """

    level: float
    slope: float

    def rms(self, longest: float, shortest: float) -> float:
        """Root mean square of the relief with wavelengths between two limits [m]: the integral of S(k) 2 pi k dk."""
        k0, k1, power = 1 / longest, 1 / shortest, 2 - self.slope
        area = np.log(k1 / k0) if abs(power) < 1e-6 else (k1**power - k0**power) / power
        return float(np.sqrt(2 * np.pi * self.level * area))


def spectrum(z: NDArray[np.float64], spacing: tuple[float, float]) -> Spectrum:
    """The power law that fits heights `(nx, ny)` on a grid [m] best between 3 and 16 spacings.

    Raises:
        WorldError: too few nodes, or no relief.
    """
    if min(z.shape) < _LEAST:
        raise WorldError(
            f"detail needs a survey of {_LEAST} x {_LEAST} nodes or more to measure its spectrum, not "
            f"{z.shape[0]} x {z.shape[1]}; take a larger crop, or leave detail out"
        )
    z, _ = fill(z[:_MOST, :_MOST])
    a, b = np.linspace(-1, 1, z.shape[0])[:, None], np.linspace(-1, 1, z.shape[1])[None, :]
    plane = np.stack([np.ones(z.size), *(np.broadcast_to(c, z.shape).ravel() for c in (a, b))], axis=1)
    z = z - (plane @ np.linalg.lstsq(plane, z.ravel(), rcond=None)[0]).reshape(z.shape)
    window = np.hanning(z.shape[0])[:, None] * np.hanning(z.shape[1])
    power = np.abs(np.fft.fft2(z * window)) ** 2 * spacing[0] * spacing[1] / (window**2).sum()
    k = np.hypot(np.fft.fftfreq(z.shape[0], spacing[0])[:, None], np.fft.fftfreq(z.shape[1], spacing[1]))
    edges = np.geomspace(1 / (_BAND[0] * max(spacing)), 1 / (_BAND[1] * max(spacing)), 9)
    which = np.digitize(k, edges)
    rings = [which == n for n in range(1, len(edges)) if (which == n).any()]
    level = np.array([power[ring].mean() for ring in rings])
    if len(level) < 3 or not (level > 1e-18).all():
        raise WorldError("detail follows the survey's relief, and this survey has none; leave detail out")
    fit = np.polyfit(np.log([k[ring].mean() for ring in rings]), np.log(level), 1)
    return Spectrum(float(np.exp(fit[1])), float(np.clip(-fit[0], 1.0, 6.0)))


def add_detail(
    ground: HeightField, survey: Grid | Soundings, origin: GeoOrigin, *, spacing: float, seed: int, strength: float
) -> tuple[HeightField, str]:
    """Ground with invented relief, and a note that says so.

    The relief is 0 at the survey's nodes, up to the share of it that bilinear interpolation on the finer grid leaves.

    Args:
        ground: the survey, interpolated to a finer grid.
        survey: what it was made from, with z upwards.
        origin: of the world.
        spacing: between the survey's values [m].
        seed: of the relief.
        strength: factor on its height; 1 carries the spectrum on.

    Raises:
        WorldError: the grid is not finer than the survey, or the survey is too small to measure its spectrum.
    """
    longest, shortest = 2 * spacing, 2 * ground.spacing
    if shortest >= 0.99 * longest:
        raise WorldError(
            f"detail is finer than the survey, whose spacing is {spacing:.4g} m: set resolution_m below that"
        )
    law = spectrum(*_measured(survey, origin, ground, spacing))
    rms = strength * law.rms(longest, shortest)
    rng = np.random.Generator(np.random.PCG64(seed))
    invented = rms * fractal(
        (ground.z.shape[0], ground.z.shape[1]), ground.spacing, rng, slope=law.slope, longest=longest, shortest=shortest
    )
    relief = replace(ground, z=invented)
    invented = invented - np.nan_to_num(sample(_at_nodes(survey, relief, origin), origin, ground.x, ground.y))
    note = (
        f"invented: relief with wavelengths from {longest:.4g} m down to {shortest:.4g} m, {rms:.3g} m root mean "
        f"square, seed {seed}; it carries on the survey's own spectrum (k^-{law.slope:.2f}) and leaves surveyed values"
    )
    return replace(ground, z=ground.z + invented), note


def _measured(
    survey: Grid | Soundings, origin: GeoOrigin, ground: HeightField, spacing: float
) -> tuple[NDArray[np.float64], tuple[float, float]]:
    """Heights to measure a spectrum on and their spacings [m]: a grid's own nodes, or soundings on a grid."""
    if isinstance(survey, Grid):
        u, v = np.meshgrid(survey.u[:2], survey.v[:2], indexing="ij")
        x, y = origin.to_xy(*to_latlon(survey.crs, u, v))
        steps = np.hypot(x[1, 0] - x[0, 0], y[1, 0] - y[0, 0]), np.hypot(x[0, 1] - x[0, 0], y[0, 1] - y[0, 0])
        return survey.z, (float(steps[0]), float(steps[1]))
    low, high = ground.bounds[0, :2], ground.bounds[1, :2]
    axes = [np.arange(a, b + spacing / 2, spacing) for a, b in zip(low, high, strict=True)]
    return sample(survey, origin, axes[0], axes[1]), (spacing, spacing)


def _at_nodes(survey: Grid | Soundings, relief: HeightField, origin: GeoOrigin) -> Grid | Soundings:
    """The survey with the relief's heights for values, 0 beyond the relief's edges."""
    u, v = (survey.u, survey.v) if isinstance(survey, Soundings) else np.meshgrid(survey.u, survey.v, indexing="ij")
    x, y = origin.to_xy(*to_latlon(survey.crs, u, v))
    return replace(survey, z=np.nan_to_num(relief.height(x, y)))
