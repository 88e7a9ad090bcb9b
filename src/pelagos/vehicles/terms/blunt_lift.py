"""Lift of a box-shaped body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from pelagos.hydro import frame
from pelagos.hydro.algebra import Vector
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, PartConfig, Positive


class BluntLiftConfig(PartConfig):
    """Lift at the base of a box, from its added mass: what a frame feels of Munk's moment is half, and it is steadied.

    Source: H. J. Allen and E. W. Perkins, NACA Report 1048, 1951, equations 8 and 10.
    """

    type: Literal["blunt_lift"]
    size_m: tuple[Positive, Positive, Positive] | None = None
    """Length, beam and height [m]; left out: the hull's."""

    def build(self, body: Body) -> BluntLift:
        """The term."""
        return BluntLift(frame.blunt_pairs(body.added, self.size_m or (body.length, body.beam, body.height)))


@dataclass(frozen=True)
class BluntLift:
    """pairs: see `hydro.frame.blunt_pairs`."""

    pairs: Sequence[frame.Pair]

    def wrench(self, flow: Flow) -> Vector:
        """Lift and its moment (6)."""
        return frame.blunt_lift(self.pairs, flow.nu_r)
