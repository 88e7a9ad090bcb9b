"""Lift and drag of a slender hull in the vertical plane."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from pelagos.hydro import lift
from pelagos.hydro.algebra import Vector
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, PartConfig, Positive


class LiftDragConfig(PartConfig):
    """The hull as a wing of low aspect ratio; the reference area is a fraction of length times diameter."""

    type: Literal["lift_drag"]
    area_fraction: Positive
    """S over length times diameter [-]."""
    frontal_drag: NonNegative
    """Parasitic drag coefficient on the frontal area [-]."""
    oswald: Positive
    """Oswald efficiency factor [-]."""
    density_kg_m3: Positive | None = None
    """[kg/m^3]; left out: that of the water."""
    astern: Literal["mirrored", "unbounded"] = "mirrored"
    """Flow from astern: sees the same body from behind, or raises the angle of attack up to pi (Fossen's programs)."""

    def build(self, body: Body) -> LiftDrag:
        """The term; the diameter is the hull's beam."""
        area = self.area_fraction * body.length * body.beam
        aspect = body.beam**2 / area
        polar = lift.Polar(
            area=area,
            slope=lift.helmbold_slope(aspect),
            parasitic=self.frontal_drag * math.pi * (body.beam / 2) ** 2 / area,
            induced=lift.induced_factor(aspect, self.oswald),
        )
        return LiftDrag(polar, self.density_kg_m3 or body.density, self.astern == "mirrored")


@dataclass(frozen=True)
class LiftDrag:
    """polar: coefficients; density [kg/m^3]; mirrored: see `hydro.lift.lift_and_drag`."""

    polar: lift.Polar
    density: Array
    mirrored: bool

    def wrench(self, flow: Flow) -> Vector:
        """Lift and drag (6)."""
        return lift.lift_and_drag(self.polar, self.density, flow.nu_r, mirrored=self.mirrored)
