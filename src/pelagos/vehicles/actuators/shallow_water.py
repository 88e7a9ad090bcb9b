"""Shallow water's part in a ship's forces, of the depth under it at every tick."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Final

import drjit as dr
from pydantic import Field

from pelagos.errors import ScenarioError
from pelagos.hydro.shallow_water import SHALLOWEST, DepthFactors, deep_speed_ratio, depth_factors
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.nearby import shoaling
from pelagos.vehicles.part import Body, PartConfig

_CLOSE: Final = 1e-5  # differences in depth over draught: in it no factor's slope changes by 1e-6
_BROADEST: Final = 4.0  # beam over draught up to which K2 is Clarke's


class ShallowWaterConfig(PartConfig):
    """Linear derivatives and added masses in sway and yaw by Clarke (1983, 1997), resistance by Lackenby (1963), of the
    depth of the world's water under the ship. Other derivatives, wake and rudder stay as in deep water. Less than 1.2
    draughts of water acts as 1.2; `Vehicle.accelerations` is told of the ground, and without that it is far.
    """

    midship: Annotated[float, Field(gt=0, le=1)]
    """C_M: area of the wet midship section over beam times draught [-]."""
    momentum: bool = False
    """Over ground that slopes, the growing added mass takes its momentum from the ship and the water's energy pulls
    towards the deep (`hydro/shoaling.py`), which factors of one depth each do not contain. A vertical step of it takes
    nothing.
    """

    def build(self, body: Body, draught: float) -> ShallowWater:
        """The part of a ship with a draught [m].

        Raises:
            ScenarioError: the hull is beyond the factors' range.
        """
        ratio = body.beam / draught
        if ratio > _BROADEST:
            raise ScenarioError(
                f"shallow_water: beam over draught is {ratio:.3g}; factors of depth are known up to {_BROADEST:g}"
            )
        masses = float(body.added[1, 1]), float(body.added[5, 5])
        return ShallowWater(draught, ratio, self.midship * body.beam * draught, body.gravity, masses, self.momentum)


@dataclass(frozen=True)
class ShallowWater:
    """draught [m]; beam over draught; midship_area [m^2]; gravity [m/s^2]; added masses of deep water in sway [kg] and
    yaw [kg m^2]; momentum: see the configuration.
    """

    draught: float
    beam_ratio: float
    midship_area: float
    gravity: float
    masses: tuple[float, float]
    momentum: bool = False

    def factors(self, flow: Flow) -> DepthFactors:
        """At the depth under the ship."""
        return depth_factors(flow.depth / self.draught, self.beam_ratio)

    def derivatives(self, hull: dict[str, Array], flow: Flow) -> dict[str, Array]:
        """Those of the hull at the depth under the ship."""
        by, depth = self.factors(flow), dr.maximum(flow.depth, SHALLOWEST * self.draught)
        faster = deep_speed_ratio(self.midship_area, depth, flow.nu_r[0], self.gravity)
        return hull | {
            "R0": hull["R0"] * faster * faster, "Yv": hull["Yv"] * by.yv, "Yr": hull["Yr"] * by.yr,
            "Nv": hull["Nv"] * by.nv, "Nr": hull["Nr"] * by.nr,
        }  # fmt: skip

    def image_mass(self, flow: Flow) -> list[list[Array]]:
        """Added mass by the ground `(6, 6)`."""
        by = self.factors(flow)
        return self._masses(by.sway_mass - 1, by.yaw_mass - 1)

    def shoaling(self, flow: Flow) -> list[Array]:
        """Force and moment (6) of the depth's change on the way; none without `momentum`."""
        if not self.momentum:
            return [0.0] * 6
        ratio = flow.depth / self.draught
        after, before = (depth_factors(ratio + change, self.beam_ratio) for change in (_CLOSE, -_CLOSE))
        by_metre = 0.5 / (_CLOSE * self.draught)
        slope = self._masses(
            by_metre * (after.sway_mass - before.sway_mass), by_metre * (after.yaw_mass - before.yaw_mass)
        )
        return shoaling(slope, flow)

    def _masses(self, sway: Array, yaw: Array) -> list[list[Array]]:
        found: list[list[Array]] = [[0.0] * 6 for _ in range(6)]
        found[1][1], found[5][5] = self.masses[0] * sway, self.masses[1] * yaw
        return found
