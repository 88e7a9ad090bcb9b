"""Nearness of a motion to the surface: what stays deep is differentiated without it, in half the time."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import drjit as dr

from pelagos import jit
from pelagos.hydro.algebra import cross, dot, matvec
from pelagos.jit import Array
from pelagos.vehicles.integrate import Rigid
from pelagos.vehicles.model import Model
from pelagos.vehicles.vehicle import Vehicle
from pelagos.vehicles.wetness import Floating, shares_of

if TYPE_CHECKING:
    from pelagos.identification.water import Surroundings


def deep_model(model: Model) -> Model | None:
    """The same equation of motion far below the surface, or at rest in it; None where the surface is always felt, or
    never.
    """
    parts = [*model.terms.values(), *(actuator.site for actuator in model.actuators.values())]
    airy = any(getattr(part, "keeps", "hull") == "dry" for part in parts)
    if model.wetting is None or model.in_air or airy:
        return None
    return replace(model, wetting=None)


def near_surface(vehicle: Vehicle, x: list[Array], around: Surroundings, within: Array) -> Array:
    """1 where a vehicle in the state `x` (see `shots`) feels the surface, now or within a time [s]; 0 elsewhere."""
    rigid = Rigid(list(x[0:3]), jit.Array4f64(*x[3:7]), list(x[7:13]))
    flow = vehicle.flow(rigid, around.ocean, jit.Float64(0.0), around.tables)
    sinks, tilts = matvec(flow.rotation, x[7:10])[2], cross(x[10:13], flow.down)
    moves = within * (dr.abs(sinks) + vehicle.config.length_m * dr.sqrt(dot(tilts, tilts)))
    wetting, sites = vehicle.model.wetting, [actuator.site for actuator in vehicle.model.actuators.values()]
    assert wetting is not None
    near = dr.zeros(jit.Float64, dr.width(x[0]))
    for side in (-1.0, 1.0):
        there = replace(flow, immersion=flow.immersion + side * moves)
        there.wet = wetting.of(there)
        for share in (there.wet.share, *shares_of(sites, there)):
            near = dr.select(jit.Float64(share) < 1, 1.0, near)
        if isinstance(wetting, Floating):
            near = dr.select(wetting.far(there) > 0, 1.0, near)
    return near
