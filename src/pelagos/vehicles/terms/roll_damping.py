"""Roll damping of a ship by its form."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, Literal, Self, TypeAlias

import drjit as dr
import numpy as np
from pydantic import Field, model_validator

from pelagos.errors import InputError
from pelagos.hydro.algebra import Vector, mul, neg
from pelagos.hydro.roll_damping import RollForm, roll_damping, roll_lift
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, Number, PartConfig, Positive
from pelagos.vehicles.terms.roll_sections import SectionRollDamping, SectionTableConfig, hull_sections, ship_of

_ROUNDED: Final = 1e-9
"""Share by which the quotient of two numbers may miss a limit."""
_CENTRE_CURE: Final = "give the depth of the centre of gravity below the waterline"


class RollDampingConfig(PartConfig):
    """Friction, waves, eddies, bilge keels and lift after Ikeda; length and beam are the hull's.

    From numbers of the hull's form (`draught_m`, `block`, `midship`), by the formula that was fitted to Ikeda's method
    for cargo ships, or from its `sections`, by the method itself.
    Sources: Y. Kawahara, K. Maekawa, Y. Ikeda, doi 10.1007/978-94-007-1482-3_26; ITTC 7.5-02-07-04.5 (2011).
    """

    type: Literal["roll_damping"]
    draught_m: Positive | None = None
    """[m]; beam over draught 2.5 .. 4.5; without `sections`."""
    block: float | None = Field(default=None, ge=0.5, le=0.85)
    """Block coefficient [-]; without `sections`."""
    midship: float | None = Field(default=None, ge=0.9, le=0.99)
    """Midship section coefficient [-]; without `sections`."""
    sections: Literal["hull"] | SectionTableConfig | None = None
    """Sections of the ship as a table, or `hull`: those of the hull in the water, `afloat`."""
    gravity_depth_m: Number
    """Depth of the centre of gravity below the waterline, negative above it [m]; -1.5 .. 0.2 draughts without
    `sections`."""
    keel_length_m: NonNegative = 0.0
    """Of the bilge keels [m], 0.05 .. 0.4 of the length; 0: none."""
    keel_breadth_m: NonNegative = 0.0
    """Of the bilge keels [m], 0.01 .. 0.06 of the beam."""
    keel_middle_m: Number = 0.0
    """Middle of the bilge keels, forward of the origin [m], with `sections`."""

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        form = {"draught_m": self.draught_m, "block": self.block, "midship": self.midship}
        if self.sections is None and (left := [key for key, value in form.items() if value is None]):
            raise ValueError(f"{', '.join(left)} missing: give draught_m, block and midship, or sections")
        if self.sections is not None and (given := [key for key, value in form.items() if value is not None]):
            raise ValueError(
                f"{', '.join(given)} beside sections, which say that: leave out one or the "
                "other (null takes a key of the catalogue away)"
            )
        if self.keel_middle_m != 0 and (self.sections is None or self.keel_length_m == 0):
            raise ValueError("keel_middle_m needs sections, between which bilge keels stand, and keel_length_m")
        return self

    def build(self, body: Body) -> RollDamping | SectionRollDamping:
        """The term; the frequency is the natural one of roll, by the vehicle's stiffness and inertia.

        Raises:
            InputError: the vehicle has no stiffness in roll or no weight, or its form is beyond what the formula was
                fitted to or what the method by sections can say.
        """
        stiffness, inertia = float(body.stiffness[3]), float(body.mass_matrix[3, 3])
        if stiffness <= 0:
            raise InputError("roll_damping is for hulls that float: no term gives this one a stiffness in roll")
        if body.gravity == 0:
            raise InputError("roll_damping is for hulls that float: gravity_m_s2 of this one is 0")
        frequency = float(np.sqrt(stiffness / inertia))
        keels = self.keel_length_m, self.keel_breadth_m, self.keel_middle_m
        _check(self._keel_ranges(body), "bilge keels were tested", "give linear_damping and quadratic_damping instead")
        if self.sections is not None:
            if self.sections == "hull":
                sections = hull_sections(body)
            else:
                self.sections.check_on(body)
                sections = self.sections.sections()
            ship = ship_of(sections, body, self.gravity_depth_m, keels)
            share = self.gravity_depth_m / ship.draught
            _check([("gravity_depth_m over the draught", share, -1.5, 1)], "the method was made", _CENTRE_CURE)
            return SectionRollDamping.of(ship, frequency, body)
        assert self.draught_m is not None
        assert self.block is not None
        assert self.midship is not None
        _check(
            (
                ("beam over draught_m", body.beam / self.draught_m, 2.5, 4.5),
                ("gravity_depth_m over draught_m", self.gravity_depth_m / self.draught_m, -1.5, 0.2),
            ),
            "the formula was fitted",
            "give sections, or linear_damping and quadratic_damping instead",
        )
        least, period = 2 * np.pi * float(np.sqrt(body.beam / 2 / body.gravity)), 2 * np.pi / frequency
        if period < least:
            raise InputError(
                f"roll_damping: the natural period of roll is {period:.3g} s, by a stiffness of {stiffness:.4g} N m "
                f"and an inertia of {inertia:.4g} kg m^2; the formula was fitted for {least:.3g} s and longer at a "
                f"beam of {body.beam:g} m: give sections, or linear_damping and quadratic_damping instead"
            )
        form = RollForm(
            body.length, body.beam, self.draught_m, self.block, self.midship, self.gravity_depth_m,
            self.keel_length_m, self.keel_breadth_m,
        )  # fmt: skip
        return RollDamping(*roll_damping(form, frequency, body.density), roll_lift(form, body.density))

    def _keel_ranges(self, body: Body) -> tuple[Range, ...]:
        keels = self.keel_length_m > 0 or self.keel_breadth_m > 0
        return (
            ("keel_length_m over length", self.keel_length_m / body.length, 0.05 * keels, 0.4),
            ("keel_breadth_m over beam", self.keel_breadth_m / body.beam, 0.01 * keels, 0.06),
        )


Range: TypeAlias = tuple[str, float, float, float]
"""Name, value, and the least and largest that it may have."""


def _check(ranges: Iterable[Range], source: str, instead: str) -> None:
    """Refuse a form beyond what was fitted or tested.

    Raises:
        InputError: names the number, its value and its range.
    """
    for name, value, low, high in ranges:
        slack = _ROUNDED * max(abs(low), abs(high))
        if not low - slack <= value <= high + slack:
            raise InputError(f"roll_damping: {name} is {value:.3g}; {source} for {low:g} to {high:g}: {instead}")


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
