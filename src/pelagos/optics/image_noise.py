"""Noise of an image sensor: photons arrive at random, and reading them out adds a little (EMVA Standard 1288, release
4.0, Section 2).

Variance in electrons is signal + read noise^2 + dark current * time; a normal law stands in for Poisson's (signals of
tens of electrons on).
"""

from __future__ import annotations

import drjit as dr

from pelagos.jit import Array


def noisy_signal(
    signal: Array, normal: Array, *, iso: Array, full_well: float, read_noise: float, dark: Array
) -> Array:
    """A pixel's value with noise, in units of a full pixel.

    Args:
        signal: noise-free value, 1 is full; `Float` or `Array3f`.
        normal: standard normal number(s), the same shape.
        iso: speed; at ISO 100 a full pixel holds `full_well` electrons, at ISO 200 half of that.
        full_well: [e-].
        read_noise: standard deviation of reading out [e-].
        dark: electrons that came without light, `Float` [e-].
    """
    capacity = full_well * 100 / iso
    electrons = dr.maximum(signal, 0) * capacity
    return (electrons + normal * dr.sqrt(electrons + read_noise**2 + dark)) / capacity
