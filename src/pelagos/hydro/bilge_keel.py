"""Damping of a ship's roll by bilge keels: the force on them, and the pressure of their eddies on the hull.

Y. Ikeda, Y. Himeno, N. Tanaka, On roll damping force of ship: effects of friction of hull and normal force of bilge
keels, J. Kansai Soc. Naval Arch. 161 (1976), and the pressure on the hull 165 (1977), as ITTC procedure 7.5-02-07-04.5
(2011), 2.2.5.1, has them; equation numbers are those of S. Chakrabarti, Empirical calculation of roll damping for ships
and barges, Ocean Engineering 28:915 (2001), doi 10.1016/S0029-8018(00)00036-6. Per length of keels on both bilges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_FRONT = 1.2  # pressure coefficient before the keel


@dataclass(frozen=True)
class Bilge:
    """A section where a bilge keel stands.

    Attributes:
        ratio: half the beam over the draught, H0 [-].
        draught: [m].
        fullness: area coefficient of the section [-].
        radius: of the bilge [m], at most the draught and half the beam.
        depth_of_axis: of the roll axis below the waterline [m], negative above it.
    """

    ratio: float
    draught: float
    fullness: float
    radius: float
    depth_of_axis: float

    @property
    def distance(self) -> float:
        """From the roll axis to the bilge (equation 60) [m]."""
        d, cut = self.draught, 0.293 * self.radius / self.draught
        return float(d * np.hypot(self.ratio - cut, 1 - self.depth_of_axis / d - cut))

    @property
    def flow_factor(self) -> float:
        """Of the flow round the bilge: velocity there over that of the bilge itself (equation 49)."""
        return float(1 + 0.3 * np.exp(-160 * (1 - self.fullness)))


def keel_force_damping(bilge: Bilge, breadth: float, amplitude: float, frequency: float, density: float) -> float:
    """Equivalent linear damping of the force on keels of a breadth [m], per length [N s] (equations 47 and 48).

    Args:
        amplitude: of roll [rad], above 0.
        frequency: of roll [rad/s].
        density: of the water [kg/m^3].
    """
    r, f = bilge.distance, bilge.flow_factor
    drag = 22.5 * breadth / (np.pi * r * amplitude * f) + 2.4
    return float(8 / (3 * np.pi) * density * r**3 * breadth * frequency * amplitude * f**2 * drag)


def keel_pressure_damping(bilge: Bilge, breadth: float, amplitude: float, frequency: float, density: float) -> float:
    """Equivalent linear damping of the pressure on the hull about keels, per length [N s] (equations 50 to 58).

    Args: see `keel_force_damping`.
    """
    r, f = bilge.distance, bilge.flow_factor
    behind = -22.5 * breadth / (np.pi * r * f * amplitude) - 1.2
    wake = 0.3 * np.pi * f * r * amplitude + 1.95 * breadth
    moment = _FRONT * moment_before(bilge) - behind * moment_behind(bilge, wake)
    scale = 4 / (3 * np.pi) * density * r**2 * bilge.draught**2 * frequency * amplitude * f**2
    return float(scale * moment)


def moment_behind(bilge: Bilge, wake: float) -> float:
    """Moment of a unit pressure in the wakes of both keels, over the draught squared (equations 51, 53, 56 and 57).

    wake: its length along the hull from the bilge's middle [m]: up the side at one bilge, along the bottom at the
    other.
    """
    m1, m2 = bilge.radius / bilge.draught, bilge.depth_of_axis / bilge.draught
    m3, m4 = 1 - m1 - m2, bilge.ratio - m1
    if wake > 0.25 * np.pi * bilge.radius:
        m7 = wake / bilge.draught - 0.25 * np.pi * m1
        m8 = m7 + 0.414 * m1
    else:
        m7 = 0.0
        m8 = 1.414 * (1 - float(np.cos(wake / bilge.radius))) * m1
    return (m3 + m4) * m8 - m7**2


def moment_before(bilge: Bilge) -> float:
    """Moment of the pressures before both keels, over the draught squared (equations 52 to 55).

    They fall from 1 at the bilge's middle to 0 at the waterline at one bilge, at the middle of the bottom at the other.
    """
    h, m1, m2 = bilge.ratio, bilge.radius / bilge.draught, bilge.depth_of_axis / bilge.draught
    m3, m4 = 1 - m1 - m2, h - m1
    bottom, side = h - 0.215 * m1, 1 - 0.215 * m1
    m5 = (0.414 * h + 0.0651 * m1**2 - (0.382 * h + 0.0106) * m1) / (bottom * side)
    m6 = (0.414 * h + 0.0651 * m1**2 - (0.382 + 0.0106 * h) * m1) / (bottom * side)
    return m4**3 / (3 * bottom) + (1 - m1) ** 2 * (2 * m3 - m2) / (6 * side) + m1 * (m3 * m5 + m4 * m6)
