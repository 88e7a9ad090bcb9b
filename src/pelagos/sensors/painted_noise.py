"""Noise painted onto a finished image, for comparison with simulators that have no other."""

from __future__ import annotations

import drjit as dr

from pelagos.jit import Array
from pelagos.math.philox import normal_pair32, uniform32
from pelagos.sensors.ping import PaintedNoise


def paint(noise: PaintedNoise, intensity: Array, words: tuple[Array, Array, Array, Array]) -> Array:
    """Intensity times 1 + N(0, multiplicative), plus Rayleigh noise; `words` are four random `UInt32` a cell.

    Source: E. Potokar et al., "HoloOcean: An Underwater Robotics Simulator", ICRA 2022,
    doi 10.1109/ICRA46639.2022.9812353, Section IV.
    """
    factor, _ = normal_pair32(words[0], words[1])
    rayleigh = dr.sqrt(-2.0 * dr.log(uniform32(words[2])))
    floor = noise.additive * 10.0 ** (noise.additive_reference_db / 10.0)
    return dr.maximum(intensity * (1.0 + noise.multiplicative * factor) + floor * rayleigh, 0.0)
