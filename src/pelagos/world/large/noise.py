"""Relief that can be asked for anywhere: a sum of gradient noises, a function of place and seed alone.

A spectrum that is synthesised on a grid needs the whole grid; a world of 100 km at 10 m has 10^8 nodes. Here every
octave is gradient noise on its own lattice, whose gradients come from a hash of the lattice's indices.

Source: K. Perlin, "Improving noise", ACM Trans. Graph. 21 (2002) 681-682, doi 10.1145/566654.566636 (the fade curve);
the hash is the finaliser of MurmurHash3 (A. Appleby, public domain), which changes every bit of the result with
probability one half when one bit of its input changes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

_CHUNK: Final = 8192  # places at a time: the intermediate arrays stay in the cache of a core
_RMS: Final = (193670 / 6243237) ** 0.5
"""Of one octave, 0.1761. A gradient's components are even between -1 and 1, of variance 1/3, independent from corner
to corner: the mean square is 8/3 of the integral of s^2 (1 - t)^2 times that of s^2, where s = 6 t^5 - 15 t^4 + 10 t^3.
"""


@dataclass(frozen=True)
class Fractal:
    """Relief with a power-law spectrum between two wavelengths.

    Attributes:
        seed: of the hash.
        rms_m: root mean square height [m].
        longest_m, shortest_m: the first octave's lattice spacing, and the last one's at least [m].
        slope: of the two-dimensional power spectrum, S(k) ~ k^-slope: 2 is rough, 4 is smooth.
    """

    seed: int
    rms_m: float
    longest_m: float
    shortest_m: float
    slope: float

    @cached_property
    def octaves(self) -> tuple[tuple[float, float, float, float], ...]:
        """(wavelength [m], amplitude [m], cosine and sine of the lattice's turn) of each octave."""
        count = 1 + max(0, int(np.floor(np.log2(self.longest_m / self.shortest_m) + 1e-9)))
        wavelengths = [self.longest_m / 2**k for k in range(count)]
        # the variance of an octave is the integral of k^-slope over a ring: proportional to wavelength^(slope - 2)
        weights = np.array([w ** ((self.slope - 2) / 2) for w in wavelengths])
        weights *= self.rms_m / (_RMS * float(np.sqrt((weights**2).sum())))
        turns = [2.399963 * k for k in range(count)]  # [rad], the golden angle: no two lattices line up
        return tuple(
            (w, float(a), float(np.cos(t)), float(np.sin(t)))
            for w, a, t in zip(wavelengths, weights, turns, strict=True)
        )

    def heights(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Height [m] at places of equal shape [m]."""
        flat_x, flat_y = np.ravel(x), np.ravel(y)
        out = np.empty(flat_x.size)
        for start in range(0, flat_x.size, _CHUNK):
            part = slice(start, start + _CHUNK)
            out[part] = self._chunk(flat_x[part], flat_y[part])
        return out.reshape(np.shape(x))

    def _chunk(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        total = np.zeros(len(x))
        for k, (wavelength, amplitude, cosine, sine) in enumerate(self.octaves):
            u = (x * cosine - y * sine) / wavelength
            v = (x * sine + y * cosine) / wavelength
            total += amplitude * gradient_noise(u, v, (self.seed * 1013 + k) & 0xFFFFFFFF)
        return total


def gradient_noise(u: NDArray[np.float64], v: NDArray[np.float64], seed: int) -> NDArray[np.float64]:
    """Smooth noise with zero mean at places in units of its lattice, 0 on the nodes; second derivatives continuous."""
    i, j = np.floor(u), np.floor(v)
    a, b = u - i, v - j
    ii, jj = i.astype(np.int64).astype(np.uint32), j.astype(np.int64).astype(np.uint32)
    along = a * a * a * (a * (a * 6 - 15) + 10)
    across = b * b * b * (b * (b * 6 - 15) + 10)
    one = np.uint32(1)
    z00, z10 = _corner(ii, jj, seed, a, b), _corner(ii + one, jj, seed, a - 1, b)
    z01, z11 = _corner(ii, jj + one, seed, a, b - 1), _corner(ii + one, jj + one, seed, a - 1, b - 1)
    low = z00 + along * (z10 - z00)
    high = z01 + along * (z11 - z01)
    return np.asarray(low + across * (high - low))


def _corner(
    i: NDArray[np.uint32], j: NDArray[np.uint32], seed: int, a: NDArray[np.float64], b: NDArray[np.float64]
) -> NDArray[np.float64]:
    h = i * np.uint32(0x9E3779B1) ^ (j + np.uint32(seed)) * np.uint32(0x85EBCA77) ^ np.uint32(seed)
    h ^= h >> np.uint32(16)
    h *= np.uint32(0x85EBCA6B)
    h ^= h >> np.uint32(13)
    h *= np.uint32(0xC2B2AE35)
    h ^= h >> np.uint32(16)
    gx = (h & np.uint32(0xFFFF)) * (2 / 65535) - 1
    gy = (h >> np.uint32(16)) * (2 / 65535) - 1
    return np.asarray(gx * a + gy * b)
