"""Counter-based random numbers: the same key and counter give the same number on any device, in any order.

Philox4x32-10 of Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011, doi 10.1145/2063384.2063405.
"""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.quick import cosine_sine, log2

_M0: Final = 0xD2511F53
_M1: Final = 0xCD9E8D57
_W0: Final = 0x9E3779B9
_W1: Final = 0xBB67AE85
_PHASE: Final = 0xADB4A92D  # multiplier whose lattice is nearly the most even one
_LN2: Final = 0.6931471805599453
_MINUS_2_LN2: Final = -1.3862943611198906


def philox(counter: tuple[Array, Array, Array, Array], key: tuple[Array, Array]) -> tuple[Array, Array, Array, Array]:
    """Four random 32-bit words for a 128-bit counter and a 64-bit key, all `UInt32`."""
    u32 = jit.UInt32
    c0, c1, c2, c3 = (u32(c) for c in counter)
    k0, k1 = u32(key[0]), u32(key[1])
    for _ in range(10):
        hi0, lo0 = dr.mul_hi(u32(_M0), c0), c0 * _M0
        hi1, lo1 = dr.mul_hi(u32(_M1), c2), c2 * _M1
        c0, c1, c2, c3 = hi1 ^ c1 ^ k0, lo1, hi0 ^ c3 ^ k1, lo0
        k0, k1 = k0 + _W0, k1 + _W1
    return c0, c1, c2, c3


def uniform64(high: Array, low: Array) -> Array:
    """Two words -> float64 uniform in (0, 1), 52 bits, never 0 or 1."""
    bits = (jit.UInt64(high) << 20) ^ jit.UInt64(low >> 12)
    return (jit.Float64(bits) + 0.5) * 2.0**-52


def uniform32(word: Array) -> Array:
    """One word -> float32 uniform in (0, 1), 23 bits, never 0 or 1."""
    return dr.fma(jit.Float(word >> 9), 2.0**-23, 2.0**-24)


def normal_pair64(words: tuple[Array, Array, Array, Array]) -> tuple[Array, Array]:
    """Four words -> two independent standard normal float64 (Box and Muller 1958, doi 10.1214/aoms/1177706645)."""
    r = dr.sqrt(-2 * dr.log(uniform64(words[0], words[1])))
    s, c = dr.sincos(2 * dr.pi * uniform64(words[2], words[3]))
    return r * c, r * s


def normal_pair32(word0: Array, word1: Array) -> tuple[Array, Array]:
    """Two words -> two independent standard normal float32; |value| <= 5.8."""
    r = dr.sqrt(_MINUS_2_LN2 * log2(uniform32(word0)))
    c, s = cosine_sine(uniform32(word1))
    return r * c, r * s


def complex_normal32(word: Array) -> tuple[Array, Array]:
    """One word -> a complex normal float32 of unit mean power, as its power, below 16.7, and its phase in +-1/2 cycle.

    The phase is the fraction of a multiple of the word: power and phase lie on a lattice that is even in two
    dimensions (D. E. Knuth, The Art of Computer Programming 2, Section 3.3.4: the spectral test).
    """
    phase = jit.Float(dr.reinterpret_array(jit.Int32, word * _PHASE)) * 2.0**-32
    return -_LN2 * log2(uniform32(word)), phase
