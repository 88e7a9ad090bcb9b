"""A ship's linear forces in sway and yaw from its main dimensions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import drjit as dr

from pelagos.errors import ScenarioError
from pelagos.hydro.algebra import Vector
from pelagos.hydro.clarke import MainDimensions, clarke_derivatives
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, PartConfig, Positive


class ClarkeConfig(PartConfig):
    """Side force and yaw moment of a ship ahead, by the regression of Clarke, Gedling and Hine 1983.

    Length, beam and displaced volume are the vehicle's. For conventional ships (`hydro/clarke.py`) about a straight
    course in deep water; resistance, roll and what grows with the square of the drift are other terms. The derivatives
    contain the added mass's Coriolis forces and not the rigid body's: `coriolis: {rigid: momentum, added: none}` goes
    with them. `added_mass: {type: clarke}` is of the same regression.
    """

    type: Literal["clarke"]
    draught_m: Positive
    """[m]"""

    def build(self, body: Body) -> Clarke:
        """The term.

        Raises:
            ScenarioError: the form is beyond the regression, or the vehicle does not float.
        """
        if not body.stiffness.any():
            raise ScenarioError("a clarke term is for ships: no term makes this vehicle float")
        form = MainDimensions(body.length, body.beam, self.draught_m, float(body.displaced[0, 0]) / body.density)
        if form.outside():
            raise ScenarioError(f"clarke: {form.outside()}")
        found = clarke_derivatives(form)
        scale = 0.5 * body.density * body.length**2
        side, turn = (found.y_v, found.y_r * body.length), (found.n_v * body.length, found.n_r * body.length**2)
        return Clarke((scale * side[0], scale * side[1]), (scale * turn[0], scale * turn[1]))


@dataclass(frozen=True)
class Clarke:
    """side: by U v [kg/m] and u r [kg]; turn: by u v [kg] and U r [kg m]."""

    side: tuple[Array, Array]
    turn: tuple[Array, Array]

    def wrench(self, flow: Flow) -> Vector:
        """Side force and yaw moment (6).

        Yv and Nr damp and go with the speed; Yr and Nv, of the momentum of the water along the hull, with the speed
        ahead, so that they turn round astern.
        """
        u, v, r = flow.nu_r[0], flow.nu_r[1], flow.nu_r[5]
        speed = dr.sqrt(u * u + v * v)
        y = self.side[0] * speed * v + self.side[1] * u * r
        n = self.turn[0] * u * v + self.turn[1] * speed * r
        return [0.0, y, 0.0, 0.0, 0.0, n]
