"""Thrusters in the jets of others, and jets that a hull's own way bends.

Sources: J. Dang, H. Laheij, "Hydrodynamic aspects of steerable thrusters", Dynamic Positioning Conference, Houston
2004, Section 5.2, whose formulas the rules of classification societies took over (ABS, "Guide for Dynamic Positioning
Systems"). A. R. Palmer, G. E. Hearn, P. Stevenson, "Modelling tunnel thrusters for autonomous underwater vehicles",
IFAC workshop NGCUV, Killaloe 2008, after measurements of M. S. Chislett, O. Bjorheden (Hydro- og Aerodynamisk
Laboratorium Hy-8, 1966) and of A. Saunders, M. Nahon (OCEANS 2002).
"""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos.jit import Array

OPEN_WATER: Final = 0.80
UNDER_HULL: Final = 0.75
"""Base of the tandem formula where the jet runs along a flat bottom, which slows the spreading of its one side."""
_STEERED: Final = 130.0  # [deg^3]
LEAST_DISTANCE: Final = 1.0
"""Diameters between two thrusters, below which the formula has no data."""
LARGEST_RATIO: Final = 1.1
"""Ratio of the diameters of two thrusters up to which they count as equal, which the formula is for: whichever of the
two x/D takes then moves the share by at most 2/(3 e) ln 1.1 = 0.024."""


def tandem_share(distance: float, base: float = OPEN_WATER) -> float:
    """t = 1 - base^((x/D)^(2/3)): thrust of a thruster straight behind an equal one, both at the same command and at
    rest, over that without it.

    `distance`: x/D [-]. Measured from about 2 to 16 diameters; refused here below `LEAST_DISTANCE`.
    """
    return float(1 - base ** (distance ** (2 / 3)))


def steered_share(tandem: float, angle_deg: float) -> float:
    """t + (1 - t) phi^3/(130/t^3 + phi^3): the same with the jet turned away by phi [deg], 0 to 90."""
    cube = abs(angle_deg) ** 3
    return tandem + (1 - tandem) * cube / (_STEERED / tandem**3 + cube)


def tunnel_share(crossing: Array, loss: Array) -> Array:
    """exp(-c U^2): share of a tunnel thruster's force left where the hull moves across its jet with U^2 [m^2/s^2].

    `loss`: c [s^2/m^2], of one vehicle and one jet, such as 0.35 for the 70 mm thrusters of Delphin2 up to 1 m/s. It is
    the suction of the bent jet on the hull, not the momentum in the tunnel, that takes the force away: where the hull
    is faster than the jet a part of it comes back (Chislett and Bjorheden), which this form does not have.
    """
    return dr.exp(-loss * crossing)
