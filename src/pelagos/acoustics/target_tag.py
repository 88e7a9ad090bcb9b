"""Tag of the strongest echo in a cell: level, label and instance in one 64-bit word; the largest word wins."""

from __future__ import annotations

import drjit as dr

from pelagos import jit
from pelagos.jit import Array


def tag(energy: Array, label: Array, instance: Array) -> Array:
    """`UInt64`: level in 1/1000 dB above -300 dB, then label (8 bits) and instance (24 bits)."""
    level = jit.UInt32(dr.clip(10.0 * 0.30102999566 * dr.log2(dr.maximum(energy, 1e-30)) + 300.0, 0.0, 4e3) * 1000.0)
    return (jit.UInt64(level + 1) << 32) | (jit.UInt64(label & 0xFF) << 24) | jit.UInt64(instance & 0xFFFFFF)


def untag(word: Array) -> tuple[Array, Array]:
    """Label and instance, `UInt32`; 0 where there is no echo."""
    low = jit.UInt32(word & 0xFFFFFFFF)
    return low >> 24, low & 0xFFFFFF
