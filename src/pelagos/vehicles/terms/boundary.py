"""Forces of a plane nearby: bottom, wall, surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Final, Literal

from pelagos.errors import ScenarioError
from pelagos.hydro.algebra import Vector, add
from pelagos.hydro.images import Dipoles, Plane, image_added_mass, image_wrench, spheroid_dipoles
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, PartConfig
from pelagos.vehicles.wetness import Keeps

_MOMENT_S: Final = 1e-4  # differences in time: in it nothing near a plane moves by 1e-3 of its distance


class BoundaryConfig(PartConfig):
    """Added mass and suction near ground and walls, and under the surface: the image of a spheroid's dipoles.

    For hulls under water that are nearly spheroids of the vehicle's length, beam and height. In a simulation five rays
    of each vehicle a tick find the ground below and the nearest wall beside it, up to two lengths away, where the
    forces have gone; `Vehicle.accelerations` is told of them, and without that they are far.
    """

    type: Literal["boundary"]
    surface: Literal["none", "rigid", "pressure_release"] = "none"
    """The surface above as a plane: a lid, which holds at U^2 << g d, speed and depth of the hull's middle; without
    pressure, at U^2 >> g d; or not there, as between the two neither holds: waves that the hull makes are left out."""

    def build(self, body: Body) -> Boundary:
        """The term.

        Raises:
            ScenarioError: the vehicle is in the air, or floats.
        """
        if body.in_air or body.stiffness.any():
            where = "moves in the air" if body.in_air else "floats, for which there are the terms bank and squat"
            raise ScenarioError(f"a boundary term is for hulls under water; this vehicle {where}")
        half = [body.length / 2, body.beam / 2, body.height / 2]
        center = [float(x) for x in body.center_of_buoyancy]
        added, displaced = body.added.diagonal()[:3].tolist(), float(body.displaced[0, 0])
        return Boundary(spheroid_dipoles(half, center, added, displaced, body.density), _SIGNS[self.surface])


_SIGNS: Final = {"none": None, "rigid": 1.0, "pressure_release": -1.0}


@dataclass(frozen=True)
class Boundary:
    """dipoles: of the hull; surface: sign of the surface's image, None where it has none."""

    keeps: ClassVar[Keeps] = "hull"
    feels_planes: ClassVar[bool] = True
    dipoles: Dipoles
    surface: float | None

    def planes(self, flow: Flow) -> Sequence[Plane]:
        """Near the vehicle."""
        if self.surface is None:
            return flow.planes
        return [*flow.planes, Plane(flow.immersion, flow.down, self.surface)]

    def image_mass(self, flow: Flow) -> list[list[Array]]:
        """Added mass by the planes `(6, 6)`."""
        zero = [[0.0] * 6 for _ in range(6)]
        found = [zero, *(image_added_mass(self.dipoles, plane) for plane in self.planes(flow))]
        return [add(*rows) for rows in zip(*found, strict=True)]

    def wrench(self, flow: Flow) -> Vector:
        """Suction, and what the change of the added mass takes (6)."""
        found = [image_wrench(self.dipoles, plane, flow.nu_c, flow.nu, _MOMENT_S) for plane in self.planes(flow)]
        return add([0.0] * 6, *found)
