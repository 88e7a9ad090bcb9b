"""Weight and buoyancy of a submersible, under water and at the surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from pelagos.hydro import restoring
from pelagos.hydro.algebra import Vector, mul
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, PartConfig
from pelagos.vehicles.wetness import Keeps


class SubmergedConfig(PartConfig):
    """Weight at the centre of gravity, buoyancy at the centre of buoyancy."""

    type: Literal["submerged"]
    free_surface: bool = True
    """At the surface the hull displaces what an ellipsoid of its size would; otherwise it is wet everywhere."""

    def build(self, body: Body) -> Submerged:
        """The term."""
        axes = [body.length / 2, body.beam / 2, body.height / 2]
        return Submerged(
            body.weight,
            body.buoyancy,
            [float(x) for x in body.center_of_gravity],
            [float(x) for x in body.center_of_buoyancy],
            axes if self.free_surface else None,
        )


@dataclass(frozen=True)
class Submerged:
    """weight, buoyancy [N]; their centres (3) [m]; semi_axes (3) [m], or None without a surface."""

    keeps: ClassVar[Keeps] = "always"
    weight: Array
    buoyancy: Array
    center_of_gravity: Vector
    center_of_buoyancy: Vector
    semi_axes: Vector | None

    def wrench(self, flow: Flow) -> Vector:
        """Weight and buoyancy (6)."""
        buoyancy = self.buoyancy if flow.heaviness is None else mul(flow.heaviness, self.buoyancy)
        load = restoring.submerged(self.weight, buoyancy, self.center_of_gravity, self.center_of_buoyancy, flow.down)
        if self.semi_axes is None:
            return load
        lost = restoring.emerged_ellipsoid(buoyancy, self.semi_axes, self.center_of_buoyancy, flow.down, flow.immersion)
        return [a + b for a, b in zip(load, lost, strict=True)]
