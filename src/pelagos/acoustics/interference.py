"""Other sonars' pulses in a receiver: how much of them its band holds, and when they arrive.

Source: X. Lurton, An Introduction to Underwater Acoustics (2nd ed., 2010), Sections 2.3 (one-way loss) and 6.4 (matched
filters).
"""

from __future__ import annotations

import drjit as dr

from pelagos.jit import Array


def band_overlap(frequency: float, bandwidth: float, other_frequency: float, other_bandwidth: float) -> float:
    """Part of another pulse's energy, spread evenly over its band, that lies in the receiver's band; all [Hz]."""
    low = max(frequency - 0.5 * bandwidth, other_frequency - 0.5 * other_bandwidth)
    high = min(frequency + 0.5 * bandwidth, other_frequency + 0.5 * other_bandwidth)
    return max(high - low, 0.0) / other_bandwidth


def is_arriving(time: Array, travel: Array, since: Array, period: Array, duration: Array) -> Array:
    """Whether the direct pulse of a sonar that pings once in a `period` is heard at a time.

    Args:
        time: since the receiver's own ping [s].
        travel: one-way travel time [s].
        since: how long before the receiver's ping the other one had last pinged [s].
        period, duration: of its pings, of a pulse behind the receiver's filter [s].
    """
    phase = (time - travel + since) / period
    return (phase - dr.floor(phase)) * period < duration
