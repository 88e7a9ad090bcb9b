"""From a vehicle's configuration to its model and its control modes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pelagos.errors import ScenarioError
from pelagos.vehicles.actuators.t200 import Battery, BatteryConfig, current_exponent
from pelagos.vehicles.config import VehicleConfig
from pelagos.vehicles.control.besides import Besides
from pelagos.vehicles.control.controller import Controller
from pelagos.vehicles.control.direct import ActuatorsConfig
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.forward_speed import compile_forward_speed
from pelagos.vehicles.interaction import build_interaction
from pelagos.vehicles.model import Model, inertia_of
from pelagos.vehicles.part import numbers
from pelagos.vehicles.seakeeping import Seakeeping, compile_seakeeping
from pelagos.vehicles.terms.floating import Hydrostatic, HydrostaticConfig, TwinHullConfig
from pelagos.vehicles.terms.restoring import SubmergedConfig
from pelagos.vehicles.wetness import Floating, Submersible, Wetting


def build_model(config: VehicleConfig) -> Model:
    """The equation of motion."""
    body = config.body
    sea = None
    if config.afloat is not None and config.seakeeping == "pressure":
        sea = compile_seakeeping(config.afloat, body)
        sea = replace(sea, ahead=compile_forward_speed(config.afloat, body, config.coriolis, sea.added))
    actuators = {name: part.build(body) for name, part in config.actuators.items() if part is not None}
    return Model(
        trim=None if sea is None else _trim(config, sea),
        inertia=inertia_of(body, config.coriolis),
        terms={name: term.build(body) for name, term in config.terms.items() if term is not None},
        actuators=actuators,
        interaction=build_interaction(config.interaction, actuators),
        battery=None if config.battery is None else battery(config.battery),
        sea=sea,
        sea_inertia=None if sea is None else inertia_of(replace(body, added=np.array(sea.added)), config.coriolis),
        wetting=_wetting(config),
        in_air=config.medium == "air",
        ground=body.ground,
        still=frozenset(
            name for name, term in config.terms.items() if isinstance(term, (HydrostaticConfig, TwinHullConfig))
        ),
        calm_damping=frozenset(() if config.afloat is None else config.afloat.calm_damping),
    )


def _trim(config: VehicleConfig, sea: Seakeeping) -> Hydrostatic | None:
    """Part of the hydrostatic term beyond the hull's own pressure."""
    assert config.afloat is not None
    if config.afloat.restoring == "hull":
        return None
    body = config.body
    found = [t.build(body) for t in config.terms.values() if isinstance(t, (HydrostaticConfig, TwinHullConfig))]
    if not found:
        return None
    given = np.sum([np.array(t.matrix, dtype=np.float64) for t in found], axis=0)
    return Hydrostatic(numbers(given - sea.stiffness), found[0].vertical)


def _wetting(config: VehicleConfig) -> Wetting | None:
    """Wetness of the hull, by the shape that its buoyancy has too."""
    body = config.body
    half = [body.length / 2, body.beam / 2, body.height / 2]
    if body.stiffness.any():
        draught = body.weight / float(body.stiffness[2])
        above = max([h.freeboard_m for h in config.afloat.hulls] or [draught]) if config.afloat else draught
        half[2] = (draught + above) / 2
        return Floating(half, [0.0, 0.0, (draught - above) / 2], draught / 2, min(draught, above))
    for term in config.terms.values():
        if isinstance(term, SubmergedConfig) and term.free_surface:
            return Submersible(half, [float(x) for x in body.center_of_buoyancy])
    return Submersible(half, [0.0, 0.0, 0.0]) if body.in_air else None


def battery(config: BatteryConfig) -> Battery:
    """Battery that feeds T200 thrusters."""
    return Battery(config.open_circuit_v, config.resistance_ohm, current_exponent())


def build_modes(config: VehicleConfig, model: Model) -> dict[str, Controller]:
    """Control laws by name."""
    plant = Plant(model, config.body)
    modes: dict[str, Controller] = {name: mode.build(plant) for name, mode in config.modes.items() if mode is not None}
    carried = tuple(model.carriers)
    if not carried:
        return modes
    return {
        name: mode if isinstance(config.modes[name], ActuatorsConfig) else _besides(name, mode, carried)
        for name, mode in modes.items()
    }


def _besides(name: str, mode: Controller, carried: tuple[str, ...]) -> Controller:
    for actuator in carried:
        if actuator in mode.commands:
            raise ScenarioError(
                f"the actuator {actuator!r} has the name of a set-point of the mode {name!r}: rename it"
            )
    return Besides(mode, carried)
