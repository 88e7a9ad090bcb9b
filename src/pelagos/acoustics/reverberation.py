"""Echoes of the water itself: plankton, bubbles, sediment in suspension, by their volume backscattering strength.

Source: R. J. Urick, Principles of Underwater Sound (3rd ed., 1983), Sections 8.2-8.4: volume reverberation
RL = SL - 40 log r - 2 a r + Sv + 10 log V, with V = psi r^2 c/(2 B) and psi the equivalent two-way beam width [sr].
"""

from __future__ import annotations

from pelagos.acoustics.spreading import patch_intensity
from pelagos.jit import Array


def volume_intensity(beam: Array, distance: Array, absorption: Array, depth: float) -> Array:
    """Echo intensity of the water in one cell, re the source level at 1 m.

    Args:
        beam: integral of sv over the two-way power pattern [1/m]: sv psi in even water, sv = 10^(Sv/10).
        distance: r [m].
        absorption: a [dB/m].
        depth: of the cell in range, c/(2 B) [m].
    """
    return beam * depth * patch_intensity(distance, absorption)
