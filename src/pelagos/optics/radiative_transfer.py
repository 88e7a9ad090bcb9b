"""The light field of a deep, level sea: radiance against depth and direction under sun and sky, by discrete ordinates.

The radiative transfer equation of a plane-parallel medium is solved by successive orders of scattering, with as many
Legendre moments of the phase function as directions can carry and the rest taken as unscattered (W. J. Wiscombe, J.
Atmos. Sci. 34:1408, 1977, doi 10.1175/1520-0469(1977)034<1408:TDMRYA>2.0.CO;2), in Fourier modes of azimuth about the
sun (S. Chandrasekhar, Radiative Transfer, 1950, Chapter VI). Nodes of
direction are Gauss points on both sides of the critical angle, which the sea surface mirrors past. Light that no
water has scattered yet - the sun's beam and the sky in Snell's window - is a source here and stays outside of the
result. NumPy, float64; light from direction d is what arrives there, u = d_z.

With depth z, attenuation c and phase function P of the medium so scaled,

    L(z, u > 0) = L(0, u) e^{-c z / u} + integral of J(z') e^{-c (z - z') / u} dz' / u,
    J(z, d) = b [ P(d . s) E(z) + integral of P(d . d') (L + L_sky)(z, d') d(omega') ].

Both are divided by e^{-K z}, so that what is left varies slowly and can be linear between depths.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.optics.phase import water_molecules
from pelagos.optics.water import MEAN_COSINE, REFRACTIVE_INDEX, WaterOptics, kirk

Array = NDArray[np.float64]

MODES: Final = 16  # of azimuth, and moments of the phase function
PEAK: Final = MEAN_COSINE**MODES  # share of the particles' scattering that counts as unscattered
_NODES: Final = 7  # Gauss points in each of four ranges of u
_TURNS: Final = 48  # of azimuth, on one side of the sun, for the modes of the phase function
_CRITICAL: Final = math.sqrt(1 - REFRACTIVE_INDEX**-2)
_ORDERS: Final = 400
_CONVERGED: Final = 1e-5
_NOTHING: Final = 1e-9  # of a mode: far below what the others lack when they have converged


@dataclass(frozen=True)
class WaterChannel:
    """One channel of water: absorption, scattering by water and by particles [1/m]."""

    absorption: float
    molecules: float
    particles: float

    @property
    def attenuation(self) -> float:
        """c = a + b_w + (1 - f) b_p with the peak's share f [1/m]."""
        return self.absorption + self.molecules + (1 - PEAK) * self.particles

    @property
    def decay(self) -> float:
        """K [1/m], about how daylight falls."""
        return float(kirk(*(np.array(v) for v in (self.absorption, self.molecules, self.particles))))


@dataclass(frozen=True)
class Above:
    """Light that enters one channel of the sea.

    Attributes:
        towards_sun: u of the refracted sun.
        sun: irradiance across its beam just below the surface [lx].
        window_u, window_weight: Gauss points of Snell's window and their weights.
        window: radiance of the sky in them, seen from just below [cd/m^2].
    """

    towards_sun: float
    sun: float
    window_u: Array
    window_weight: Array
    window: Array


@dataclass(frozen=True)
class Field:
    """A solved light field of one channel, over e^{-K z}.

    Attributes:
        depths: `(depths,)` [m].
        u, weight: `(nodes,)` of direction.
        radiance: `(depths, nodes, MODES)`, scattered at least once [cd/m^2].
        medium, above: what it was solved for.
    """

    depths: Array
    u: Array
    weight: Array
    radiance: Array
    medium: WaterChannel
    above: Above

    def source(self, u: Array) -> Array:
        """J over e^{-K z} for any directions `(k,)`, without the beam's: `(depths, k, MODES)` [cd/m^2 per m]."""
        kernel = _kernel(self.medium, u, self.u) * self.weight
        light = _scattered(kernel, self.radiance)
        light[:, :, 0] += _sky_source(self.medium, self.above, self.depths, u)
        return light

    def at(self, u: Array) -> Array:
        """Radiance over e^{-K z} for any directions `(k,)`, without the beam's light scattered once from there:
        `(depths, k, MODES)` [cd/m^2]."""
        up = self.source(np.abs(u))
        down = self.source(-np.abs(u))
        of_beam = _beam_source(self.medium, self.above, self.depths, -np.abs(u))
        nothing = np.zeros_like(down[0])
        path = _Path(self.depths, self.medium, -np.abs(u))
        first = path.gathered(of_beam, nothing)[0]
        from_below = path.gathered(down, nothing)
        mirrored = mirror(np.abs(u))[:, None] * (from_below[0] + first)
        from_above = _Path(self.depths, self.medium, np.abs(u)).gathered(up, mirrored)
        return np.where((u > 0)[None, :, None], from_above, from_below)


def media(water: WaterOptics) -> list[WaterChannel]:
    """Of each channel."""
    return [
        WaterChannel(*v) for v in zip(water.absorption, water.water_scattering, water.particle_scattering, strict=True)
    ]


def gauss(low: float, high: float, count: int) -> tuple[Array, Array]:
    """Gauss-Legendre points and weights between two limits."""
    x, w = np.polynomial.legendre.leggauss(count)
    return 0.5 * (high - low) * x + 0.5 * (high + low), 0.5 * (high - low) * w


def solve(medium: WaterChannel, above: Above, depths: Array) -> Field:
    """Successive orders until nothing is added; depths `(depths,)` start at 0."""
    parts = [gauss(0, _CRITICAL, _NODES), gauss(_CRITICAL, 1, _NODES)]
    high = np.concatenate([p[0] for p in parts])
    u = np.concatenate([-high, high])
    weight = np.tile(np.concatenate([p[1] for p in parts]), 2)
    kernel = np.ascontiguousarray(_kernel(medium, u, u) * weight)  # (MODES, nodes, nodes)
    below, over = slice(0, len(high)), slice(len(high), None)
    total = np.zeros((len(depths), len(u), MODES))
    source = _beam_source(medium, above, depths, u)
    source[:, :, 0] += _sky_source(medium, above, depths, u)
    down, up = _Path(depths, medium, u[below]), _Path(depths, medium, u[over])
    reflected = mirror(high)[:, None]
    for _ in range(_ORDERS):
        light = np.empty_like(source)
        light[:, below] = down.gathered(source[:, below], np.zeros((len(high), source.shape[2])))
        light[:, over] = up.gathered(source[:, over], reflected * light[0, below])
        total[:, :, : light.shape[2]] += light
        added, brightest = np.abs(light).max(axis=(0, 1)), np.abs(total).max()  # (modes,)
        if added.max() <= _CONVERGED * brightest:
            break
        modes = int(np.flatnonzero(added > _NOTHING * brightest)[-1]) + 1  # high modes end first
        source = _scattered(kernel[:modes], light[:, :, :modes])
    return Field(depths, u, weight, total, medium, above)


def _beam_source(medium: WaterChannel, above: Above, depths: Array, u: Array) -> Array:
    """Of the beam's light when it is scattered for the first time: `(depths, k, MODES)`."""
    fall = np.exp((medium.decay - medium.attenuation / above.towards_sun) * depths)
    doubled = np.where(np.arange(MODES) == 0, 1, 2) / (2 * math.pi)
    beam = _kernel(medium, u, np.array([above.towards_sun]))[:, :, 0].T * doubled * above.sun  # (k, MODES)
    return np.asarray(fall[:, None, None] * beam)


def _sky_source(medium: WaterChannel, above: Above, depths: Array, u: Array) -> Array:
    """Of the sky's light when it is scattered for the first time: `(depths, k)`, the same all round."""
    sky = _kernel(medium, u, above.window_u)[0] * (above.window_weight * above.window)  # (k, window)
    faded = np.exp((medium.decay - medium.attenuation / above.window_u) * depths[:, None])  # (depths, window)
    return np.asarray(faded @ sky.T)


def _kernel(medium: WaterChannel, u: Array, v: Array) -> Array:
    """Integral over azimuth of b P(u, v, psi) cos(m psi): `(MODES, len(u), len(v))` [1/m]."""
    psi = (np.arange(_TURNS) + 0.5) * (math.pi / _TURNS)
    across = np.sqrt((1 - u**2)[:, None] * (1 - v**2))
    cosine = (u[:, None] * v)[..., None] + across[..., None] * np.cos(psi)
    spread: Any = medium.molecules * water_molecules(cosine) + medium.particles * _truncated(cosine)
    modes = np.cos(np.arange(MODES)[:, None] * psi) * (2 * math.pi / _TURNS)
    return np.moveaxis(spread @ modes.T, 2, 0)


def _truncated(cosine: Array) -> Array:
    """Henyey and Greenstein's phase function without its peak, times the share that is left: moments g^l - g^MODES."""
    order = np.arange(MODES)
    moments = (2 * order + 1) / (4 * math.pi) * (MEAN_COSINE**order - PEAK)
    return np.asarray(np.polynomial.legendre.legval(cosine, moments))


def mirror(u: Array) -> Array:
    """Fresnel's reflectance from below."""
    eta = 1 / REFRACTIVE_INDEX
    sin2 = (1 - u * u) / eta**2
    far = np.sqrt(np.maximum(1 - sin2, 0))
    s, p = (u - eta * far) / (u + eta * far), (eta * u - far) / (eta * u + far)
    return np.where(sin2 >= 1, 1.0, 0.5 * (s * s + p * p))


def _scattered(kernel: Array, light: Array) -> Array:
    """Light `(depths, nodes, MODES)` that `kernel` `(MODES, k, nodes)` turns: `(depths, k, MODES)`."""
    made: Array = np.ascontiguousarray(np.moveaxis(light, 2, 0)) @ np.swapaxes(kernel, 1, 2)  # (MODES, depths, k)
    return np.moveaxis(made, 0, 2)


class _Path:
    """Ways of light through the depths in directions `u` `(k,)` of one sign.

    What comes of a source is linear in it, so that its weights are found once for all orders of scattering.
    """

    def __init__(self, depths: Array, medium: WaterChannel, u: Array) -> None:
        every = np.broadcast_to(np.eye(len(depths))[:, None], (len(depths), len(u), len(depths)))
        weights = _along(depths, medium, u, every, np.zeros((len(u), len(depths))))
        self._weights = np.ascontiguousarray(weights.transpose(1, 0, 2))  # (k, depths, depths of the source)
        self._kept = _along(depths, medium, u, np.zeros((len(depths), len(u), 1)), np.ones((len(u), 1)))

    def gathered(self, source: Array, start: Array) -> Array:
        """Radiance `(depths, k, MODES)` from a source of that shape, and from what comes in `(k, MODES)`."""
        light: Array = self._weights @ np.ascontiguousarray(source.transpose(1, 0, 2))
        return light.transpose(1, 0, 2) + self._kept * start


def _along(depths: Array, medium: WaterChannel, u: Array, source: Array, start: Array) -> Array:
    """Radiance from directions `u` `(k,)` of one sign, from where light comes in: `(depths, k, MODES)`."""
    h = np.diff(depths)[:, None]
    downward = u[0] > 0
    rate = medium.attenuation / np.abs(u) + (-medium.decay if downward else medium.decay)  # (k,)
    x = rate * h  # (steps, k)
    kept = np.exp(-x)
    whole = -np.expm1(-x)
    # exact for a source that is linear between depths: weights of its far and near end
    small = x < 1e-3
    safe = np.where(small, 1, x)
    near = np.where(small, h * (0.5 - x / 6), (h / safe) * (1 - whole / safe))
    far = np.where(small, h * (0.5 - x / 3), (h / safe) * (whole / safe - kept))
    scale = 1 / np.abs(u)[:, None]
    kept, near, far = (v[..., None] for v in (kept, near, far))
    light = np.empty_like(source)
    if downward:
        light[0] = start
        added = scale * (near * source[1:] + far * source[:-1])  # of all steps at once: only the sum goes step by step
        for i in range(len(h)):
            light[i + 1] = kept[i] * light[i] + added[i]
        return light
    light[-1] = source[-1] * scale / rate[:, None]  # below the last depth all falls as e^{-K z}
    added = scale * (near * source[:-1] + far * source[1:])
    for i in reversed(range(len(h))):
        light[i] = kept[i] * light[i + 1] + added[i]
    return light
