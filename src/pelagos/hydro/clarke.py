"""Linear derivatives of a ship in sway and yaw from its main dimensions, by regression over captive tests.

D. Clarke, P. Gedling, G. Hine, "The application of manoeuvring criteria in hull design using linear theory", Trans.
RINA 125:45 (1983), as T. I. Fossen's MSS toolbox prints it (`clarke83.m`, MIT); added mass in surge by H. Soeding,
"Prediction of ship steering capabilities", Schiffstechnik 29:3 (1982). Prime system by length and speed: forces by
rho/2 L^2 U^2, moments by rho/2 L^3 U^2. FRD about the middle of the hull, straight ahead in deep water. The velocity's
derivatives are those of a hull held in its tank: they contain the added mass's Coriolis forces, not the rigid body's.

The tests were of merchant ships. The paper's own table of them could not be consulted: `RANGES` are assumed, those of
conventional cargo ships, B/T as far as the paper's factors for shallow water go.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

RANGES: Final = {
    "length over beam": (4.5, 9.0),
    "beam over draught": (2.0, 4.0),
    "block coefficient": (0.5, 0.85),
}
"""Forms for which the formulas are used: least and largest."""


@dataclass(frozen=True)
class MainDimensions:
    """length between perpendiculars, beam, draught [m]; volume displaced [m^3]."""

    length: float
    beam: float
    draught: float
    volume: float

    @property
    def block(self) -> float:
        """Block coefficient [-]."""
        return self.volume / (self.length * self.beam * self.draught)

    def outside(self) -> str:
        """Ratio that is beyond `RANGES`, as a sentence; empty where none is."""
        ratios = (self.length / self.beam, self.beam / self.draught, self.block)
        for (name, (low, high)), ratio in zip(RANGES.items(), ratios, strict=True):
            if not low <= ratio <= high:
                return f"{name} is {ratio:.3g}; the regression of Clarke 1983 is for {low:g} to {high:g}"
        return ""


@dataclass(frozen=True)
class ClarkeDerivatives:
    """By length and speed, as published, with their signs [-]: of accelerations v', r' and of velocities v, r."""

    y_vdot: float
    y_rdot: float
    n_vdot: float
    n_rdot: float
    y_v: float
    y_r: float
    n_v: float
    n_r: float


def clarke_derivatives(form: MainDimensions) -> ClarkeDerivatives:
    """Derivatives of a ship within `RANGES`; the caller asks `form.outside()` first."""
    by_length, ratio, block = form.beam / form.length, form.beam / form.draught, form.block
    slenderness = form.draught / form.length
    s = -math.pi * slenderness**2
    return ClarkeDerivatives(
        y_vdot=s * (1 + 0.16 * block * ratio - 5.1 * by_length**2),
        y_rdot=s * (0.67 * by_length - 0.0033 * ratio**2),
        n_vdot=s * (1.1 * by_length - 0.041 * ratio),
        n_rdot=s * (1 / 12 + 0.017 * block * ratio - 0.33 * by_length),
        y_v=s * (1 + 0.40 * block * ratio),
        y_r=s * (-1 / 2 + 2.2 * by_length - 0.080 * ratio),
        n_v=s * (1 / 2 + 2.4 * slenderness),
        n_r=s * (1 / 4 + 0.039 * ratio - 0.56 * by_length),
    )


def surge_added_mass(form: MainDimensions, density: float) -> float:
    """-Xudot = 2.7 rho volume^(5/3)/L^2 [kg] (Soeding 1982); density of the water [kg/m^3]."""
    return 2.7 * density * math.pow(form.volume, 5 / 3) / form.length**2
