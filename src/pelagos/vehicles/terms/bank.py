"""Bank suction and quay cushion: forces of upright walls beside a hull that floats."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Final, Literal

import drjit as dr

from pelagos.errors import ScenarioError
from pelagos.hydro.algebra import Vector, add, dot
from pelagos.hydro.bank import Wall, bank_added_mass, bank_wrench, floating_dipoles
from pelagos.hydro.images import Dipoles
from pelagos.hydro.shallow_water import SHALLOWEST
from pelagos.jit import Array
from pelagos.vehicles.flow import FAR_M, LEVEL, Flow
from pelagos.vehicles.part import Body, PartConfig, Positive, check_floats
from pelagos.vehicles.wetness import Keeps

WALLS: Final = 2
"""Most walls that a ship feels at once: those of a quay and of what is opposite, or of a channel."""

_BLOCK: Final = (0.25, 1.02)  # least and largest block coefficient: of fine yachts, and of boxes with some rounding
_LEVEL: Final = (0, 1, 5)  # surge, sway and yaw among six


class BankConfig(PartConfig):
    """Suction of upright walls beside a ship, and the added mass in surge, sway and yaw that grows before them.

    For monohulls that float. Double-body flow: the image in a wall of the dipoles of the hull and of its mirror image
    above the waterline, in the depth of the water (`hydro/bank.py`). Not in it: the moment that turns the bow away
    from a bank, which is the propeller's and the stern's, banks that slope, and the cushion under a keel that nearly
    touches, which pushes ships off. In a simulation rays of each vehicle a tick find the nearest wall, up to two
    lengths away, and what is opposite; `Vehicle.accelerations` is told of them, and without that they are far.
    """

    type: Literal["bank"]
    draught_m: Positive
    """[m]; less than 1.2 of it of water acts as 1.2. By it, length and beam the block coefficient is 0.25 to 1."""

    def build(self, body: Body) -> Bank:
        """The term.

        Raises:
            ScenarioError: the vehicle does not float, or on hulls beside each other, or its draught is not that of a
                hull of its size and mass.
        """
        check_floats(body, "bank")
        if body.afloat is not None and any(hull.mirror for hull in body.afloat.hulls):
            raise ScenarioError("a bank term is for monohulls; this vehicle floats on hulls beside each other")
        added, displaced = body.added.diagonal()[:2].tolist(), float(body.displaced[0, 0])
        volume, (finest, fullest) = displaced / body.density, _BLOCK
        least = volume / (body.length * body.beam)
        if not finest <= least / self.draught_m <= fullest:
            raise ScenarioError(
                f"bank: draught_m: {self.draught_m:g} m is not that of one hull of {body.length:g} m x {body.beam:g} m "
                f"that displaces {volume:.4g} m^3: a block coefficient of {least / self.draught_m:.3g}; "
                f"give {least / fullest:.3g} to {least / finest:.3g} m"
            )
        ahead = float(body.center_of_buoyancy[0])
        hull = floating_dipoles(body.length, body.beam, self.draught_m, ahead, added, displaced, body.density)
        return Bank(hull, SHALLOWEST * self.draught_m)


@dataclass(frozen=True)
class Bank:
    """dipoles: of the hull; shallowest: least depth of water that counts [m]."""

    keeps: ClassVar[Keeps] = "hull"
    feels_planes: ClassVar[bool] = True
    feels_depth: ClassVar[bool] = False
    whole_coriolis: ClassVar[bool] = True
    dipoles: Dipoles
    shallowest: float

    def walls(self, flow: Flow) -> Sequence[Wall]:
        """The nearest upright planes, in the depth of the water."""
        depth = dr.maximum(flow.depth, self.shallowest)
        near: list[Wall] = []
        for plane in flow.planes:
            upright = dr.abs(dot(plane.normal, flow.down)) <= LEVEL
            ahead, aside = plane.normal[:2]
            level = dr.select(upright, dr.sqrt(dr.square(ahead) + dr.square(aside)), 1.0)
            normal = [dr.select(upright, ahead / level, 1.0), dr.select(upright, aside / level, 0.0)]
            near = _sorted_in(near, Wall(dr.select(upright, plane.distance / level, FAR_M), normal, depth))[:WALLS]
        return near

    def image_mass(self, flow: Flow) -> list[list[Array]]:
        """Added mass by the walls `(6, 6)`: of surge, sway and yaw."""
        whole = [[0.0] * 6 for _ in range(6)]
        for wall in self.walls(flow):
            for row, found in zip(_LEVEL, bank_added_mass(self.dipoles, wall), strict=True):
                for column, mass in zip(_LEVEL, found, strict=True):
                    whole[row][column] = whole[row][column] + mass
        return whole

    def wrench(self, flow: Flow) -> Vector:
        """Suction, and what the change of the added mass takes (6): surge, sway and yaw."""
        through, over = ([nu[k] for k in _LEVEL] for nu in (flow.nu_c, flow.nu))
        x, y, n = add([0.0] * 3, *(bank_wrench(self.dipoles, wall, through, over) for wall in self.walls(flow)))
        return [x, y, 0.0, 0.0, 0.0, n]


def _sorted_in(walls: Sequence[Wall], new: Wall) -> list[Wall]:
    """Walls by distance, with one more."""
    found = []
    for wall in walls:
        first = new.distance < wall.distance
        found.append(_either(first, new, wall))
        new = _either(first, wall, new)
    return [*found, new]


def _either(first: Array, a: Wall, b: Wall) -> Wall:
    """Of two walls, the first where `first` is true."""
    normal = [dr.select(first, m, n) for m, n in zip(a.normal, b.normal, strict=True)]
    return Wall(dr.select(first, a.distance, b.distance), normal, a.depth)
