"""Ditching: the forces of water on a vehicle that is made for the air."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import drjit as dr

from pelagos.hydro.algebra import Vector, cross, scaled
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, PartConfig, Positive, Three
from pelagos.vehicles.wetness import Keeps


class DitchingConfig(PartConfig):
    """Buoyancy and drag of the airframe where it is under water; rotors and wings lose what is wet of them.

    The drag in a step is that at the step's end (implicit Euler), so that water, 800 times heavier than air, stops the
    vehicle and does not throw it back.
    """

    type: Literal["ditching"]
    volume_m3: NonNegative
    """That keeps water out [m^3]."""
    center_m: Three = (0.0, 0.0, 0.0)
    """Of that volume, FRD from the origin [m]."""
    area_m2: tuple[Positive, Positive, Positive]
    """Drag coefficient times area, along x, y and z [m^2]."""
    density_kg_m3: Positive = 1025.0
    """Of the water [kg/m^3]."""

    def build(self, body: Body) -> Ditching:
        """The term."""
        size = (body.length, body.beam, body.height)
        inertia = [float(body.rigid[i, i]) for i in range(6)]
        turning = [0.5 * self.density_kg_m3 * a * (s / 4) ** 3 for a, s in zip(self.area_m2, size, strict=True)]
        linear = [0.5 * self.density_kg_m3 * a for a in self.area_m2]
        lift = self.density_kg_m3 * self.volume_m3 * body.gravity
        return Ditching(lift, list(self.center_m), [*linear, max(turning), max(turning), max(turning)], inertia)


@dataclass(frozen=True)
class Ditching:
    """buoyancy [N]; center (3) [m]; drag: quadratic (6) [kg/m], [kg m^2]; inertia (6) [kg], [kg m^2]."""

    keeps: ClassVar[Keeps] = "always"

    buoyancy: Array
    center: Vector
    drag: Vector
    inertia: Vector

    def wrench(self, flow: Flow) -> Vector:
        """Force and moment (6) by the wet share."""
        if flow.wet is None:
            return [0.0] * 6
        share, step = flow.wet.share, 0.0 if flow.step is None else flow.step
        up = scaled(-self.buoyancy * share, flow.down)
        load = [*up, *cross(self.center, up)]
        for i, (d, m, v) in enumerate(zip(self.drag, self.inertia, flow.nu, strict=True)):
            rate = share * d * dr.abs(v)
            load[i] = load[i] - rate * v / (1 + step * rate / m)
        return load
