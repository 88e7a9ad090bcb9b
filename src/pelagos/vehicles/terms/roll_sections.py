"""Roll damping of a ship by its sections: the sections, and the load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Self

import drjit as dr
import numpy as np
from pydantic import Field, model_validator

from pelagos.errors import InputError
from pelagos.hydro.algebra import Vector, mul, neg
from pelagos.hydro.lewis import fullness_range
from pelagos.hydro.roll_damping import RollForm, roll_lift
from pelagos.hydro.roll_sections import (
    RollSection,
    RollSections,
    SectionDamping,
    eddies_at_speed,
    friction_at_speed,
    section_damping,
    waves_at_speed,
)
from pelagos.hydro.strips import Station
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, Number, PartConfig, Positive
from pelagos.vehicles.shape.floating_mesh import float_mesh
from pelagos.vehicles.shape.stations import mesh_stations, pontoon_stations

_HELD: Final = (0.8, 1.05)  # share of the displaced volume that the sections given may hold: fine ends are left out
_UNEVEN: Final = 0.01  # of the beam: what one side of a section may differ from the other
_ENDS: Final = 0.05  # of the volume, which sections without a Lewis form at a hull's ends may hold

_BEYOND: Final = 1.1  # of the hull's length, beam and height: counters, flare and keels stand out of moulded sizes


class SectionTableConfig(PartConfig):
    """A ship's sections, from the stern to the bow: each list has one number a section."""

    x_m: tuple[Number, ...] = Field(min_length=3)
    """Place forward of the origin, increasing [m]."""
    beam_m: tuple[Positive, ...]
    """At the waterline [m]."""
    draught_m: tuple[Positive, ...]
    """[m]"""
    area_m2: tuple[Positive, ...]
    """Under water, at most beam times draught [m^2]."""
    bilge_radius_m: tuple[Positive, ...] | None = None
    """[m]; left out: the one that beam, draught and area leave a flat bottom and upright sides."""

    @model_validator(mode="after")
    def _alike(self) -> Self:
        for key in ("beam_m", "draught_m", "area_m2", "bilge_radius_m"):
            given = getattr(self, key)
            if given is not None and len(given) != len(self.x_m):
                raise ValueError(f"{key} has {len(given)} numbers and x_m {len(self.x_m)}: give one a section")
        if any(b <= a for a, b in zip(self.x_m, self.x_m[1:], strict=False)):
            raise ValueError("x_m must increase, from the stern to the bow")
        for i, x in enumerate(self.x_m):
            box = self.beam_m[i] * self.draught_m[i]
            if self.area_m2[i] > box * (1 + 1e-9):
                text = f"area_m2 at x = {x:g} m is {self.area_m2[i]:g}, more than beam times draught, {box:.6g}"
                raise ValueError(text)
            widest = min(self.draught_m[i], self.beam_m[i] / 2)
            if self.bilge_radius_m is not None and self.bilge_radius_m[i] > widest:
                text = f"bilge_radius_m at x = {x:g} m is {self.bilge_radius_m[i]:g}, more than the draught or half"
                raise ValueError(f"{text} the beam, {widest:g}")
        return self

    def check_on(self, body: Body) -> None:
        """Refuse sections that are none of this hull.

        Raises:
            InputError: names the key, the section, and the hull's size.
        """
        ends = _BEYOND * body.length / 2
        for i, x in enumerate(self.x_m):
            if abs(x) > ends:
                raise InputError(
                    f"roll_damping: x_m has a section at {x:g} m, off the hull of {body.length:g} m; "
                    f"{-ends:g} to {ends:g} m are allowed"
                )
            for key, value, what, most in (
                ("beam_m", self.beam_m[i], "beam", body.beam), ("draught_m", self.draught_m[i], "height", body.height),
            ):  # fmt: skip
                if value > _BEYOND * most:
                    raise InputError(
                        f"roll_damping: {key} at x = {x:g} m is {value:g}, of a hull whose {what} is {most:g} m; "
                        f"at most {_BEYOND * most:g} m are allowed"
                    )

    def sections(self) -> tuple[RollSection, ...]:
        """Each stands for half the way to its neighbours."""
        x = np.array(self.x_m)
        width = np.diff(np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]]))
        box = np.array(self.beam_m) * np.array(self.draught_m)
        radii = self.bilge_radius_m or (None,) * len(x)
        rows = zip(x, width, self.beam_m, self.draught_m, np.minimum(self.area_m2, box), radii, strict=True)
        return tuple(RollSection(float(p), float(w), b, d, float(a), r) for p, w, b, d, a, r in rows)


def hull_sections(body: Body) -> tuple[RollSection, ...]:
    """Sections of the hull in the water.

    Raises:
        InputError: no hull in the water, more than one, or one that is not the same on both sides.
    """
    if body.afloat is None:
        raise InputError("roll_damping: sections: hull needs the hull in the water, which is `afloat` of the vehicle")
    if body.afloat.mesh is None:
        hulls = body.afloat.hulls
        stations = pontoon_stations(hulls, _volume(body) / sum(h.volume_per_draught for h in hulls))
    else:
        mesh = float_mesh(body.afloat.mesh, _volume(body))
        stations = mesh_stations(mesh.vertices, mesh.faces)
    if len({s.position for s in stations}) < len(stations):
        text = "roll_damping: sections: hull is for one hull: this vehicle has more than one beside each other"
        raise InputError(text)
    return _without_fine_ends([_section(s) for s in stations])


def _section(station: Station) -> RollSection:
    points = station.points
    beam = float(points[-1, 0] - points[0, 0])
    y, z = points.T
    uneven = max(abs(station.side), float(np.abs(y + y[::-1]).max()), float(np.abs(z - z[::-1]).max()))
    if uneven > _UNEVEN * beam:
        raise InputError(
            f"roll_damping: the section at x = {station.position:.4g} m is not the same on both sides: it differs by "
            f"{uneven:.3g} m of {beam:.3g} m beam, at most {_UNEVEN:.0%} are allowed"
        )
    area = float(0.5 * abs(np.sum(y[:-1] * z[1:] - y[1:] * z[:-1])))  # closed by the waterline, where z = 0
    draught = float(-z.min())
    own = tuple((float(a), float(b)) for a, b in points)
    return RollSection(station.position, station.width, beam, draught, min(area, beam * draught), None, own)


def _without_fine_ends(found: Sequence[RollSection]) -> tuple[RollSection, ...]:
    """Sections without those at either end that are too fine for a Lewis form.

    Raises:
        InputError: these hold more than a twentieth of the volume.
    """
    fits = [s.fullness >= fullness_range(s.ratio)[0] for s in found]
    first = fits.index(True) if True in fits else len(fits)
    last = len(fits) - fits[::-1].index(True) if True in fits else first
    lost = sum(s.area * s.width for s in (*found[:first], *found[last:])) / sum(s.area * s.width for s in found)
    if lost > _ENDS:
        raise InputError(
            f"roll_damping: {lost:.0%} of the hull's volume is in sections at its ends that are finer than any Lewis "
            f"form, more than {_ENDS:.0%}: give sections as a table, or draught_m, block and midship"
        )
    return tuple(found[first:last])


def _volume(body: Body) -> float:
    return body.weight / body.gravity / body.density


def ship_of(
    sections: tuple[RollSection, ...], body: Body, depth_of_gravity: float, keels: tuple[float, float, float]
) -> RollSections:
    """The ship; keels: length, breadth and middle of bilge keels [m].

    Raises:
        InputError: sections of another ship, or keels where there is no section.
    """
    volume = _volume(body)
    held = sum(s.area * s.width for s in sections)
    if not _HELD[0] <= held / volume <= _HELD[1]:
        raise InputError(
            f"roll_damping: the sections hold {held:.4g} m^3, {held / volume:.0%} of the {volume:.4g} m^3 that the "
            f"vehicle displaces; {_HELD[0]:.0%} to {_HELD[1]:.0%} are allowed"
        )
    length, breadth, middle = keels
    ends = middle - length / 2, middle + length / 2
    if breadth > 0 and not sections[0].position <= ends[0] < ends[1] <= sections[-1].position:
        raise InputError(
            f"roll_damping: bilge keels from x = {ends[0]:g} to {ends[1]:g} m are not within the sections, from "
            f"{sections[0].position:g} to {sections[-1].position:g} m"
        )
    draught = max(s.draught for s in sections)
    return RollSections(sections, body.length, body.beam, draught, volume, depth_of_gravity, breadth, ends)


@dataclass(frozen=True)
class SectionRollDamping:
    """Damping at rest by its cause; lift by speed [N s^2]; natural frequency of roll [rad/s]; length, draught [m];
    gravity [m/s^2].
    """

    still: SectionDamping
    lift: float
    frequency: float
    length: float
    draught: float
    gravity: float

    @classmethod
    def of(cls, ship: RollSections, frequency: float, body: Body) -> SectionRollDamping:
        """That of a ship.

        Raises:
            InputError: a section that is beyond the method.
        """
        try:
            still = section_damping(ship, frequency, body.density)
        except InputError as error:
            raise InputError(f"roll_damping: {error}") from error
        form = RollForm(ship.length, ship.beam, ship.draught, ship.block, ship.midship, ship.depth_of_axis)
        return cls(still, roll_lift(form, body.density), frequency, ship.length, ship.draught, body.gravity)

    def wrench(self, flow: Flow) -> Vector:
        """-(b1 + b2 |p|) p about x (6), each part at the speed ahead."""
        rate, speed = flow.nu_r[3], dr.abs(flow.nu_r[0])
        rubbed = friction_at_speed(speed, self.frequency, self.length)
        linear = self.still.friction.linear * rubbed + self.still.keels.linear + self.lift * speed
        linear = linear + self.still.waves * waves_at_speed(speed, self.frequency, self.draught, self.gravity)
        quadratic = self.still.friction.quadratic * rubbed + self.still.keels.quadratic
        quadratic = quadratic + self.still.eddies * eddies_at_speed(speed, self.frequency, self.length)
        by_rate: Array = linear + quadratic * dr.abs(rate)
        return [0.0, 0.0, 0.0, neg(mul(by_rate, rate)), 0.0, 0.0]
