"""Cross-flow drag of the hull by strips."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from pelagos.hydro import crossflow
from pelagos.hydro.algebra import Vector
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, PartConfig, Positive


class CrossFlowConfig(PartConfig):
    """Two-dimensional drag of sections, summed over the hull."""

    type: Literal["cross_flow"]
    draught_m: Positive | None = None
    """Height of a section in the water [m]; left out: the hull's height."""
    beam_m: Positive | None = None
    """Width of a section [m]; left out: the hull's beam."""
    length_m: Positive | None = None
    """[m]; left out: the hull's length."""
    coefficient: NonNegative | None = None
    """Drag coefficient of a section [-]; left out: Hoerner's, by beam over twice the draught."""
    strips: Annotated[int, Field(ge=2)] = 20
    """Number of strips, unrolled when the program is made."""
    closed: bool = False
    """Strips from end to end, both ends included (Fossen's programs), not in the middles of equal parts."""
    heave: bool = True
    """Drag in heave and pitch too, with the same coefficient on the beam."""
    density_kg_m3: Positive | None = None
    """[kg/m^3]; left out: that of the water."""

    def build(self, body: Body) -> CrossFlow:
        """The term."""
        length = self.length_m or body.length
        draught, beam = self.draught_m or body.height, self.beam_m or body.beam
        density = self.density_kg_m3 or body.density
        places, width = crossflow.strips(length, self.strips, closed=self.closed)
        side = crossflow.hoerner_drag_coefficient(beam, draught) if self.coefficient is None else self.coefficient
        below = crossflow.hoerner_drag_coefficient(draught, beam) if self.coefficient is None else self.coefficient
        factors = (0.5 * density * draught * side * width, 0.5 * density * beam * below * width)
        return CrossFlow(factors, places, self.heave)


@dataclass(frozen=True)
class CrossFlow:
    """factors: rho/2 T Cd dx of one strip in sway, in heave [kg/m]; places: x of strips [m]."""

    factors: tuple[Array, Array]
    places: tuple[float, ...]
    heave: bool

    def wrench(self, flow: Flow) -> Vector:
        """Cross-flow drag (6)."""
        return crossflow.crossflow(self.factors, self.places, flow.nu_r, heave=self.heave)


class ObliqueCrossFlowConfig(PartConfig):
    """Drag of sections that sway and heave together, summed over the hull."""

    type: Literal["oblique_cross_flow"]
    side_coefficient: NonNegative
    """Drag coefficient of a section in sway, on its height [-]."""
    below_coefficient: NonNegative
    """Drag coefficient of a section in heave, on its width [-]."""
    height_m: Positive
    """Of a section [m]."""
    width_m: Positive
    """Of a section [m]."""
    strips: Annotated[int, Field(ge=2)] = 20
    """Number of strips, unrolled when the program is made."""
    closed: bool = False
    """Strips from end to end, both ends included (Fossen's programs), not in the middles of equal parts."""

    def build(self, body: Body) -> ObliqueCrossFlow:
        """The term."""
        places, width = crossflow.strips(body.length, self.strips, closed=self.closed)
        half = 0.5 * body.density * width
        factors = (half * self.height_m * self.side_coefficient, half * self.width_m * self.below_coefficient)
        return ObliqueCrossFlow(factors, places)


@dataclass(frozen=True)
class ObliqueCrossFlow:
    """factors: rho/2 h C dx of one strip in sway, in heave [kg/m]; places: x of strips [m]."""

    factors: tuple[Array, Array]
    places: tuple[float, ...]

    def wrench(self, flow: Flow) -> Vector:
        """Cross-flow drag (6)."""
        return crossflow.oblique_crossflow(self.factors, self.places, flow.nu_r)
