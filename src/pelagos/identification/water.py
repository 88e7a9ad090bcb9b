"""Water of a fit: under a flat surface, in uniform currents, over level ground, as the scenario has it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Final

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.config.loader import load_scenario
from pelagos.config.scenario import Scenario
from pelagos.config.vary import parse
from pelagos.errors import InputError
from pelagos.identification.record import Record
from pelagos.jit import Array
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.current import UniformCurrent, UniformCurrentConfig, components
from pelagos.ocean.ocean import Ocean
from pelagos.ocean.wind import Wind, WindConfig
from pelagos.sim.boundaries import reach_below_m
from pelagos.vehicles.model import Model
from pelagos.vehicles.tables import Tables
from pelagos.vehicles.vehicle import Vehicle
from pelagos.vehicles.wetness import Submersible
from pelagos.world.build import build_world
from pelagos.world.generate.flat import FlatConfig

_MOST_ASTRAY: Final = 0.5  # of the rows: a vehicle that jumps, dives or lands comes back
_MOVING: Final = ("waves", "tide")  # keys of the ocean that move its surface
_VARIED: Final = ("factors", "current")  # groups of keys of `vary`; others do not change how a vehicle moves


@jit.struct
class Surroundings:
    """ocean: still, or in one uniform current; tables: of the vehicle; depth of level ground and how far it is felt
    [m], `Float64` (1), or None where nothing is to be felt.
    """

    ocean: Ocean
    tables: Tables | None
    depth: Array | None = None
    reach: Array | None = None

    def in_current(self, north: Array, east: Array, *, in_air: bool) -> Surroundings:
        """The same where all the water moves, or for what flies the air, north and east [m/s]."""
        moving: dict[str, Any] = {"currents": [UniformCurrent(jit.Array3f64(north, -east, 0.0))]}
        if in_air:
            one, none = jit.Float64(1.0), jit.Float64(0.0)
            moving = {
                "air": Wind(one, jit.Float64(north), jit.Float64(-east), shear=none, gusts=none, count=0, blows=True)
            }
        kept = {f.name: getattr(self.ocean, f.name) for f in fields(Ocean)}
        return Surroundings(Ocean(**{**kept, **moving}), self.tables, self.depth, self.reach)


@dataclass(frozen=True)
class Water:
    """Water and ground that a fit sees.

    Attributes:
        ocean: its density; without currents, waves, tide and wind.
        current: of all the water, north and east [m/s].
        depth: of level ground below z = 0 [m]; None: there is none within reach.
        ground: type of the scenario's world, where its ground is not level.
        left_out: keys of the scenario's ocean that a fit does not see.
        varied: keys of the scenario's `vary` that the motion of a vehicle depends on.
    """

    ocean: Ocean
    current: tuple[float, float] = (0.0, 0.0)
    depth: float | None = None
    ground: str = ""
    left_out: tuple[str, ...] = ()
    varied: tuple[str, ...] = ()

    def outside(self, *, in_air: bool = False) -> dict[str, float]:
        """Values that are known beside the vehicle, by their paths in a plan; of the air, none."""
        if in_air:
            return {}
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
    layered = not isinstance(given.temperature_c, float) or not isinstance(given.salinity, float)
    world = build_world(scenario.located_world) if layered else None
    ocean = build_ocean(given.model_copy(update=still), world, seed=scenario.seed)
    steady, other = _currents(given)
    left_out = [*other, *(f"ocean.{key}" for key in _MOVING if getattr(given, key))]
    if given.wind.speed_mps > 0:
        left_out.append("ocean.wind")
    flat = isinstance(scenario.world, FlatConfig)
    depth = scenario.world.depth_m if flat else None
    varied = tuple(key for key in scenario.vary if parse(key).group in _VARIED)
    return Water(ocean, steady, depth, "" if flat else scenario.world.type, tuple(left_out), varied)


def doubts_of_vary(water: Water) -> tuple[str, ...]:
    """Numbers that a run draws, and a fit takes as the scenario has them."""
    if not water.varied:
        return ()
    return (
        f"vary: {', '.join(water.varied)}: drawn anew in each run, and a fit takes the scenario's own numbers; give "
        "those of this run instead",
    )


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
