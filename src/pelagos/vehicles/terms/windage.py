"""Wind on what stands above the water."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Final, Literal

from pelagos.hydro.algebra import Vector
from pelagos.hydro.wave_load import wind_wrench
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, Fraction, NonNegative, PartConfig
from pelagos.vehicles.wetness import Keeps

_AIR: Final = 1.225  # kg/m^3


class WindageConfig(PartConfig):
    """Drag of a superstructure in the ocean's wind, by the velocity of the air past the moving hull; none in a calm."""

    type: Literal["windage"]
    frontal_m2: NonNegative
    """Area seen from ahead [m^2]."""
    lateral_m2: NonNegative
    """Area seen from abeam [m^2]."""
    height_m: NonNegative = 0.0
    """Its middle, above the origin [m]."""
    coefficients: tuple[Fraction, Fraction, Fraction] = (0.7, 0.85, 0.1)
    """Of drag from ahead and from abeam, and of the moment in yaw (Fossen 2021, Section 10.1) [-]."""

    def build(self, body: Body) -> Windage:
        """The term."""
        return Windage(self.frontal_m2, self.lateral_m2, self.height_m, body.length, self.coefficients)


@dataclass(frozen=True)
class Windage:
    """Areas [m^2], height of their middle and length [m], coefficients."""

    keeps: ClassVar[Keeps] = "always"
    frontal: Array
    lateral: Array
    height: float
    length: Array
    coefficients: tuple[Array, Array, Array]

    def wrench(self, flow: Flow) -> Vector:
        """Push of the wind (6)."""
        if flow.air is None:
            return [0.0] * 6
        past = [a - b for a, b in zip(flow.air(self.height), flow.nu[:3], strict=True)]
        return wind_wrench(_AIR, past, self.frontal, self.lateral, self.length, self.coefficients, self.height)
