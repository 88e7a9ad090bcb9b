"""Errors of digital modulations against noise, and of packets made of them.

Sources: J. G. Proakis and M. Salehi, Digital Communications (5th ed., 2008), Eqs. 4.3-13 (coherent PSK), 4.5-43 to -45
(non-coherent orthogonal signals), 4.5-68 (DPSK), 13.3-13 and -18 (fading); chirp spread spectrum as M-ary orthogonal
signals: T. Elshabrawy and J. Robert, IEEE Commun. Lett. 22, 1778 (2018), doi 10.1109/LCOMM.2018.2849718; error of an
arrival time: H. L. Van Trees, Detection, Estimation, and Modulation Theory III (2001), Section 10.2.
"""

from __future__ import annotations

import math
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Modulation = Literal["bpsk", "qpsk", "dpsk", "fsk", "mfsk", "ofdm", "chirp"]
MODULATIONS: Final[tuple[Modulation, ...]] = ("bpsk", "qpsk", "dpsk", "fsk", "mfsk", "ofdm", "chirp")

_NODES: Final = np.linspace(-8.0, 8.0, 401)  # of an integral over a normal distribution


def bit_error_rate(modulation: Modulation, snr_per_bit: ArrayLike, *, order: int = 2) -> NDArray[np.float64]:
    """Errors of uncoded bits in white noise.

    Args:
        modulation: `bpsk`, `qpsk` and `ofdm` (whose carriers are QPSK) coherent; `dpsk` binary differential; `fsk` and
            `mfsk` non-coherent orthogonal; `chirp` the same with 2^spreading factor signals.
        snr_per_bit: Eb/N0 as a ratio, not in decibels.
        order: number of signals M of `mfsk` and `chirp`.
    """
    from scipy.special import erfc  # a sixth of the time that all imports take

    g = np.maximum(np.asarray(snr_per_bit, np.float64), 0.0)
    if modulation in ("bpsk", "qpsk", "ofdm"):
        return np.asarray(0.5 * erfc(np.sqrt(g)))
    if modulation == "dpsk":
        return np.asarray(0.5 * np.exp(-g))
    return _orthogonal(g, 2 if modulation == "fsk" else order)


def _orthogonal(g: NDArray[np.float64], order: int) -> NDArray[np.float64]:
    """Non-coherent M-ary orthogonal signals; for many signals the sum is replaced by its integral.

    1 - P = integral of (1 - e^{-r^2/2})^{M-1} over Rice's density of the right signal's envelope r.
    """
    bits = math.log2(order)
    symbol = g * bits
    if order <= 16:
        terms = [
            (-1) ** (n + 1) / (n + 1) * math.comb(order - 1, n) * np.exp(-n / (n + 1) * symbol) for n in range(1, order)
        ]
        wrong = np.asarray(sum(terms))
    else:
        mean = np.sqrt(2.0 * symbol + 1.0)[..., None]  # Rice's envelope is nearly normal where M is large
        envelope = np.maximum(mean + _NODES, 1e-6)
        weight = np.exp(-0.5 * _NODES**2)
        wrong = 1.0 - (np.exp((order - 1) * np.log1p(-np.exp(-0.5 * envelope**2))) * weight).sum(-1) / weight.sum()
    return np.asarray(np.clip(wrong, 0.0, 1.0) * (order / 2) / (order - 1))


def packet_success(bit_errors: ArrayLike, bits: ArrayLike) -> NDArray[np.float64]:
    """Probability that all bits of a packet are right: (1 - p)^n."""
    return np.asarray(np.exp(np.asarray(bits) * np.log1p(-np.minimum(np.asarray(bit_errors), 1.0 - 1e-12))))


def aloha_throughput(load: ArrayLike, *, slotted: bool = False) -> NDArray[np.float64]:
    """Packets that get through in the time of one packet, of `load` offered: G e^{-2G}, or G e^{-G} in slots.

    Source: N. Abramson, AFIPS Conf. Proc. 37, 281 (1970), doi 10.1145/1478462.1478502; L. G. Roberts, ACM SIGCOMM CCR
    5(2), 28 (1975), doi 10.1145/1024916.1024920.
    """
    g = np.asarray(load, np.float64)
    return np.asarray(g * np.exp(-(1.0 if slotted else 2.0) * g))


def arrival_time_error(snr: float, bandwidth: float, duration: float) -> float:
    """Standard deviation of an arrival time [s]: 1/(2 pi B_rms sqrt(2 E/N0)), B_rms = B/sqrt(12) for a flat spectrum.

    Args:
        snr: in the band, as a ratio.
        bandwidth: B [Hz].
        duration: of the signal that is correlated [s].
    """
    energy = max(2.0 * snr * bandwidth * duration, 1e-12)
    return math.sqrt(12.0) / (2.0 * math.pi * bandwidth * math.sqrt(energy))
