"""Water through a hole in a compartment: Torricelli's law, and Boyle's for the air that is shut in.

Pressures are heads of water [m] over the atmosphere. Source: E. Torricelli, "De motu gravium", 1644, with a coefficient
of discharge (0.60 for a sharp edge at high Reynolds numbers: H. W. King, E. F. Brater, "Handbook of Hydraulics", 6th
ed., 1976, Chapter 4); R. Boyle, 1662, p V constant: air that is compressed slowly, at the water's temperature.
"""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos.jit import Array

ATMOSPHERE_PA: Final = 101325.0
_MOST: Final = 1e-9  # of a closed volume: air is left always


def boyle_head(water: Array, volume: Array, atmosphere: Array) -> tuple[Array, Array]:
    """Head of the air that is shut in above water, and its slope by the water's volume [1/m^2].

    Args:
        water: in the compartment [m^3].
        volume: of the compartment, which at the atmosphere's pressure is full of air [m^3].
        atmosphere: its pressure as a head of water [m].
    """
    air = dr.maximum(volume - water, _MOST * volume)
    return atmosphere * (volume / air - 1.0), atmosphere * volume / (air * air)


def boyle_limit(head: Array, volume: Array, atmosphere: Array) -> Array:
    """Water at which the air that is shut in bears an outside head [m^3]."""
    return volume * head / (head + atmosphere)


def through_orifice(head: Array, slope: Array, area: Array, h: Array, gravity: float) -> Array:
    """Volume that goes in within a time h [m^3], negative: out; it ends where no head is left.

    With Q = c sqrt(2 g |head|) and a head that falls by `slope` a volume, the root of the head falls linearly in time,
    and so its integral is exact while `slope` is constant (a box that drains, or fills, through a hole under water).

    Args:
        head: outside less inside [m].
        slope: fall of the head by volume [1/m^2].
        area: c, of the orifice, times the coefficient of discharge [m^2].
        h: time [s].
        gravity: [m/s^2].
    """
    rate = area * (2 * gravity) ** 0.5
    root = dr.sqrt(dr.abs(head))
    fall = 0.5 * rate * slope  # of the root by time [m^(1/2)/s]
    time = dr.select(fall * h > root, root / dr.maximum(fall, 1e-300), h)
    return dr.mulsign(rate * (root * time - 0.5 * fall * time * time), head)
