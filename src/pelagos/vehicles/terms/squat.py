"""Squat of a ship in shallow water, as the force and moment that sink and trim it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from pelagos.hydro.algebra import Vector, scaled
from pelagos.hydro.squat import squat
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, Number, PartConfig, check_floats
from pelagos.vehicles.wetness import Keeps


class SquatConfig(PartConfig):
    """Sinkage and trim of a ship under way in shallow open water, by its speed through the water and the depth below.

    For hulls that float. The force and the moment are those that sink and trim the hydrostatics at rest by the formula
    of slender bodies (`hydro/squat.py`), up to a Froude number of the depth of 0.7; faster ships are held at that. In a
    simulation a ray of each vehicle a tick finds the ground; `Vehicle.accelerations` is told of it, and without that it
    is far.
    """

    type: Literal["squat"]
    sinkage: NonNegative = 1.46
    """Of the centre of flotation, over volume/length^2 F^2/sqrt(1 - F^2) (Hooft 1974) [-]."""
    trim: Number = 1.0
    """Bow down, over volume/length^3 F^2/sqrt(1 - F^2) (Hooft 1974); below 0 for hulls that trim by the stern [-]."""

    def build(self, body: Body) -> Squat:
        """The term.

        Raises:
            ScenarioError: the vehicle does not float.
        """
        check_floats(body, "squat")
        return Squat(
            coefficients=(self.sinkage, self.trim),
            volume=float(body.displaced[0, 0]) / body.density,
            length=body.length,
            gravity=body.gravity,
            stiffness=(float(body.stiffness[2]), float(body.stiffness[4])),
            flotation=body.flotation,
        )


@dataclass(frozen=True)
class Squat:
    """coefficients of sinkage and trim; volume [m^3]; length [m]; gravity [m/s^2]; stiffness in heave [N/m] and pitch
    [N m/rad] about the centre of flotation, which is `flotation` forward of the origin [m].
    """

    keeps: ClassVar[Keeps] = "hull"
    feels_planes: ClassVar[bool] = True
    coefficients: tuple[Array, Array]
    volume: Array
    length: Array
    gravity: float
    stiffness: tuple[Array, Array]
    flotation: Array

    def wrench(self, flow: Flow) -> Vector:
        """Force downwards and moment bow down (6)."""
        sinkage, trim = squat(self.coefficients, self.volume, self.length, flow.nu_r[0], flow.depth, self.gravity)
        force = self.stiffness[0] * sinkage
        return [*scaled(force, flow.down), 0.0, -1.0 * (self.stiffness[1] * trim + self.flotation * force), 0.0]
