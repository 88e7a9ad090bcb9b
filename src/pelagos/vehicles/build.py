"""From a vehicle's configuration to its model and its control modes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pelagos.vehicles.actuators.t200 import Battery, BatteryConfig, current_exponent
from pelagos.vehicles.config import VehicleConfig
from pelagos.vehicles.control.controller import Controller
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.model import Model, inertia_of
from pelagos.vehicles.seakeeping import compile_seakeeping
from pelagos.vehicles.terms.floating import HydrostaticConfig, TwinHullConfig


def build_model(config: VehicleConfig) -> Model:
    """The equation of motion."""
    body = config.body
    sea = None
    if config.afloat is not None and config.seakeeping == "pressure":
        sea = compile_seakeeping(config.afloat, body)
    return Model(
        inertia=inertia_of(body, config.coriolis),
        terms={name: term.build(body) for name, term in config.terms.items() if term is not None},
        actuators={name: part.build(body) for name, part in config.actuators.items() if part is not None},
        battery=None if config.battery is None else battery(config.battery),
        sea=sea,
        sea_inertia=None if sea is None else inertia_of(replace(body, added=np.array(sea.added)), config.coriolis),
        still=frozenset(
            name for name, term in config.terms.items() if isinstance(term, (HydrostaticConfig, TwinHullConfig))
        ),
    )


def battery(config: BatteryConfig) -> Battery:
    """What feeds T200 thrusters."""
    return Battery(config.open_circuit_v, config.resistance_ohm, current_exponent())


def build_modes(config: VehicleConfig, model: Model) -> dict[str, Controller]:
    """Control laws by name."""
    plant = Plant(model, config.body)
    return {name: mode.build(plant) for name, mode in config.modes.items() if mode is not None}
