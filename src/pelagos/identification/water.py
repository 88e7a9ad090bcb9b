"""Water of a fit: under a flat surface, in uniform currents, over level ground, as the scenario has it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.config.loader import load_scenario
from pelagos.config.scenario import Scenario
from pelagos.errors import InputError
from pelagos.identification.record import Record
from pelagos.jit import Array
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.current import UniformCurrentConfig, components
from pelagos.ocean.ocean import Ocean
from pelagos.ocean.wind import WindConfig
from pelagos.sim.boundaries import reach_below_m
from pelagos.vehicles.model import Model
from pelagos.vehicles.tables import Tables
from pelagos.vehicles.vehicle import Vehicle
from pelagos.vehicles.wetness import Submersible
from pelagos.world.build import build_world
from pelagos.world.generate.flat import FlatConfig

_MOST_ASTRAY: Final = 0.5  # of the rows: a vehicle that jumps, dives or lands comes back
_MOVING: Final = ("waves", "tide")  # keys of the ocean that move its surface


@jit.struct
class Surroundings:
    """ocean: at rest; tables: of the vehicle; depth of level ground and how far it is felt [m], `Float64` (1), or None
    where nothing is to be felt.
    """

    ocean: Ocean
    tables: Tables | None
    depth: Array | None = None
    reach: Array | None = None


@dataclass(frozen=True)
class Water:
    """Water and ground that a fit sees.

    Attributes:
        ocean: its density; without currents, waves, tide and wind.
        current: of all the water, north and east [m/s].
        depth: of level ground below z = 0 [m]; None: there is none within reach.
        ground: type of the scenario's world, where its ground is not level.
        left_out: keys of the scenario's ocean that a fit does not see.
    """

    ocean: Ocean
    current: tuple[float, float] = (0.0, 0.0)
    depth: float | None = None
    ground: str = ""
    left_out: tuple[str, ...] = ()

    @property
    def outside(self) -> dict[str, float]:
        """Values that are known beside the vehicle, by their paths in a plan."""
        return dict(zip(("current.north", "current.east"), self.current, strict=True))

    def around(self, vehicle: Vehicle) -> Surroundings:
        """Arguments of a vehicle's step."""
        depth = reach = None
        if self.depth is not None and vehicle.model.feels_planes:
            depth = dr.opaque(jit.Float64, self.depth)
            reach = dr.opaque(jit.Float64, reach_below_m(vehicle))
        return jit.without_constants(Surroundings(self.ocean, vehicle.tables, depth, reach))


def water_of(scenario: Scenario | Mapping[str, Any] | str | Path | None) -> Water:
    """Water of a scenario; None: open sea of one density, deep and at rest.

    Raises:
        ScenarioError: there is no such scenario, or a file that its water needs is wrong.
    """
    if scenario is None:
        return Water(build_ocean(OceanConfig()))
    scenario = load_scenario(scenario)
    given: OceanConfig = scenario.ocean
    still = {"currents": (), "waves": (), "tide": (), "tracers": {}, "wind": WindConfig()}
    varied = not isinstance(given.temperature_c, float) or not isinstance(given.salinity, float)
    world = build_world(scenario.located_world) if varied else None
    ocean = build_ocean(given.model_copy(update=still), world, seed=scenario.seed)
    steady, other = _currents(given)
    left_out = [*other, *(f"ocean.{key}" for key in _MOVING if getattr(given, key))]
    if given.wind.speed_mps > 0:
        left_out.append("ocean.wind")
    flat = isinstance(scenario.world, FlatConfig)
    depth = scenario.world.depth_m if flat else None
    return Water(ocean, steady, depth, "" if flat else scenario.world.type, tuple(left_out))


def _currents(given: OceanConfig) -> tuple[tuple[float, float], list[str]]:
    """The steady current of all the water, north and east [m/s], and keys of all others."""
    north = east = 0.0
    left_out = []
    for k, current in enumerate(given.currents):
        if isinstance(current, UniformCurrentConfig) and current.up_mps == 0:
            northward, westward = components(current.speed_mps, current.towards_deg)
            north, east = north + northward, east - westward
        else:
            left_out.append(f"ocean.currents[{k}]")
    return (north, east), left_out


def depth_told(record: Record, model: Model) -> None:
    """Refuse a vehicle under water or in the air whose depth nothing says, or that is on the other side of the surface.

    Raises:
        InputError: says what is missing, or how much of the record is on the wrong side.
    """
    if not isinstance(model.wetting, Submersible):
        return
    depth = record.values("depth")
    if depth is None and "depth" not in record.assumed:
        said = "in the air, and nothing says how high" if model.in_air else "submerged, and nothing says how deep"
        example = -20 if model.in_air else 5
        raise InputError(
            f"plan: the vehicle is {said}: name a column for depth, or that which it kept, such as "
            f"start: {{depth: {example}}}"
        )
    given = (
        np.array([record.assumed["depth"]]) if depth is None else np.concatenate([depth[a:b] for a, b in record.runs])
    )
    size = max(model.wetting.semi_axes)
    astray = given > size if model.in_air else given < -size
    if astray.mean() > _MOST_ASTRAY:
        side = "below" if model.in_air else "above"
        raise InputError(
            f"depth counts from the surface downwards, and {100 * astray.mean():.0f} % of the rows that are used lie "
            f"{side} the surface ({given.min():.4g} to {given.max():.4g} m), where this vehicle does not move; if it "
            f"counts upwards, give its column scale: -1"
        )
