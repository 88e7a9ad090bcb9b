"""Roll damping of a ship by its form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import drjit as dr
import numpy as np
from pydantic import Field

from pelagos.errors import InputError
from pelagos.hydro.algebra import Vector, mul, neg
from pelagos.hydro.roll_damping import RollForm, roll_damping, roll_lift
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, Number, PartConfig, Positive


class RollDampingConfig(PartConfig):
    """Friction, waves, eddies, bilge keels and lift after Ikeda, from the hull's form; length and beam are the hull's.

    Sources: Y. Kawahara, K. Maekawa, Y. Ikeda, doi 10.1007/978-94-007-1482-3_26; ITTC 7.5-02-07-04.5 (2011).
    """

    type: Literal["roll_damping"]
    draught_m: Positive
    """[m]; beam over draught 2.5 .. 4.5."""
    block: float = Field(ge=0.5, le=0.85)
    """Block coefficient [-]."""
    midship: float = Field(ge=0.9, le=0.99)
    """Midship section coefficient [-]."""
    gravity_depth_m: Number
    """Depth of the centre of gravity below the waterline, negative above it [m]; -1.5 .. 0.2 draughts."""
    keel_length_m: NonNegative = 0.0
    """Of the bilge keels [m], 0.05 .. 0.4 of the length; 0: none."""
    keel_breadth_m: NonNegative = 0.0
    """Of the bilge keels [m], 0.01 .. 0.06 of the beam."""

    def build(self, body: Body) -> RollDamping:
        """The term; the frequency is the natural one of roll, by the vehicle's stiffness and inertia.

        Raises:
            InputError: the vehicle has no stiffness in roll, or its form is beyond what the formula was fitted to.
        """
        stiffness, inertia = float(body.stiffness[3]), float(body.mass_matrix[3, 3])
        if stiffness <= 0:
            raise InputError("roll_damping is for hulls that float: no term gives this one a stiffness in roll")
        frequency = float(np.sqrt(stiffness / inertia))
        self._check(body, frequency * float(np.sqrt(body.beam / 2 / body.gravity)))
        form = RollForm(
            body.length, body.beam, self.draught_m, self.block, self.midship, self.gravity_depth_m,
            self.keel_length_m, self.keel_breadth_m,
        )  # fmt: skip
        return RollDamping(*roll_damping(form, frequency, body.density), roll_lift(form, body.density))

    def _check(self, body: Body, reduced: float) -> None:
        keels = self.keel_length_m > 0 or self.keel_breadth_m > 0
        for name, value, low, high in (
            ("beam over draught_m", body.beam / self.draught_m, 2.5, 4.5),
            ("gravity_depth_m over draught_m", self.gravity_depth_m / self.draught_m, -1.5, 0.2),
            ("natural frequency of roll times sqrt(B/2g)", reduced, 0.0, 1.0),
            ("keel_length_m over length", self.keel_length_m / body.length, 0.05 * keels, 0.4),
            ("keel_breadth_m over beam", self.keel_breadth_m / body.beam, 0.01 * keels, 0.06),
        ):
            if not low <= value <= high:
                raise InputError(
                    f"roll_damping: {name} is {value:.3g}; the formula was fitted for {low:g} to {high:g}: give "
                    "linear_damping and quadratic_damping instead"
                )


@dataclass(frozen=True)
class RollDamping:
    """linear [N m s], quadratic [N m s^2], lift: linear by forward speed [N s^2]."""

    linear: float
    quadratic: float
    lift: float

    def wrench(self, flow: Flow) -> Vector:
        """-(linear + lift |u| + quadratic |p|) p about x (6)."""
        rate, ahead = flow.nu_r[3], flow.nu_r[0]
        by_rate: Array = self.linear + self.lift * dr.abs(ahead) + self.quadratic * dr.abs(rate)
        return [0.0, 0.0, 0.0, neg(mul(by_rate, rate)), 0.0, 0.0]
