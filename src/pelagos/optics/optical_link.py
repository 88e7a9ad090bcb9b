"""Light between a lamp and a photodiode under water: power, noise, and the current they make.

Sources: H. Kaushal and G. Kaddoum, IEEE Access 4, 1518 (2016), doi 10.1109/ACCESS.2016.2552538 (link equation, noise);
F. Hanson and S. Radic, Appl. Opt. 47, 277 (2008), doi 10.1364/AO.47.000277 (beam attenuation).
"""

from __future__ import annotations

import math
from typing import Final

ELEMENTARY_CHARGE: Final = 1.602176634e-19  # [C]
BOLTZMANN: Final = 1.380649e-23  # [J/K]


def lambert_order(half_power_angle: float) -> float:
    """m of a lamp that shines with cos^m, from the angle off its axis at which half is left [rad]."""
    return -math.log(2.0) / math.log(math.cos(half_power_angle))


def received_power(
    power: float,
    distance: float,
    attenuation: float,
    area: float,
    *,
    order: float,
    cos_lamp: float,
    cos_receiver: float,
) -> float:
    """Power on a detector [W]: P (m + 1)/(2 pi d^2) cos^m(lamp) A cos(receiver) exp(-c d).

    Args:
        power: of the lamp [W].
        distance: d [m].
        attenuation: c, beam attenuation of the water [1/m].
        area: A of the receiver's aperture [m^2].
        order: m, see `lambert_order`.
        cos_lamp, cos_receiver: cosines of the angles off both axes; nothing is received behind either.
    """
    if cos_lamp <= 0.0 or cos_receiver <= 0.0:
        return 0.0
    spread = power * (order + 1.0) / (2.0 * math.pi * distance * distance) * cos_lamp**order
    return float(spread * area * cos_receiver * math.exp(-attenuation * distance))


def noise_current(current: float, background: float, dark: float, bandwidth: float, load: float) -> float:
    """Root mean square noise of a photodiode [A]: shot noise of its currents [A], thermal noise of its load [ohm]."""
    shot = 2.0 * ELEMENTARY_CHARGE * (current + background + dark) * bandwidth
    thermal = 4.0 * BOLTZMANN * 290.0 * bandwidth / load
    return math.sqrt(shot + thermal)


def sunlight_power(irradiance: float, area: float, field_of_view: float, filter_share: float) -> float:
    """Diffuse daylight that a receiver collects [W]: radiance E/pi within a cone of half angle `field_of_view` [rad].

    Args:
        irradiance: of daylight at the receiver's depth [W/m^2].
        area: of the aperture [m^2].
        field_of_view: half angle [rad].
        filter_share: part of the daylight that the filter lets through.
    """
    return irradiance * filter_share * area * math.sin(field_of_view) ** 2
