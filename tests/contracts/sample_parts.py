"""Parts that no vehicle of the catalogue has, or has in this form, each on a vehicle that can carry it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, get_args

import numpy as np
from pydantic import BaseModel, TypeAdapter

import pelagos as pl
from pelagos.vehicles.kinds import ActuatorConfig, ModeConfig, TermConfig
from pelagos.vehicles.load import catalogue_names
from pelagos.vehicles.terms.function import NumpyFlow

UNIONS: Mapping[str, Any] = {"terms": TermConfig, "actuators": ActuatorConfig, "modes": ModeConfig}
DISC = {"type": "disc", "wake_fraction": 0.2, "thrust_deduction": 0.1, "tunnel_loss_s2_m2": 0.3}
FORCE = {
    "type": "force_thruster", "position_m": [-0.3, 0.5, 0.2], "direction": [2.0, 1.0, -0.5], "low_n": -50.0,
    "high_n": 60.0, "torque_m": 0.02, "time_constant_s": 0.1, "diameter_m": 0.12, "inflow": DISC,
}  # fmt: skip
SHAFT = {
    "type": "thruster", "position_m": [-0.3, 0.5, 0.2], "direction": [2.0, 1.0, -0.5], "forward": 2.1e-3,
    "reverse": 1.5e-3, "low": -400.0, "high": 400.0, "unit": "rad/s", "torque_m": 0.02, "time_constant_s": 0.1,
    "diameter_m": 0.12,
}  # fmt: skip
SERIES = {**DISC, "type": "b_series", "pitch_ratio": 1.1, "area_ratio": 0.5, "blades": 5}
CURVE = {
    "type": "curve_thruster", "position_m": [-0.3, 0.5, 0.2], "direction": [2.0, 1.0, -0.5],
    "commands": [-1.1, -0.3, 0.1, 0.9], "thrusts_n": [-40.0, -7.0, 3.0, 50.0], "gain": 1.1, "speed_share": 0.8,
    "torque_m": 0.02, "time_constant_s": 0.1, "diameter_m": 0.12,
}  # fmt: skip
TANK = {
    "type": "compartment", "size_m": [0.4, 0.3, 0.2], "position_m": [0.2, -0.05, 0.03], "permeability": 0.8,
    "hole_m": [0.35, -0.15, 0.1], "orifice_m2": 1e-4, "discharge_coefficient": 0.55, "pump_m3_s": 2e-4,
}  # fmt: skip
WEIGHT = {
    "type": "releasable", "mass_kg": 1.3, "position_m": [0.2, -0.05, 0.03], "volume_m3": 2e-4,
    "inertia_kg_m2": [0.01, 0.02, 0.015], "duration_s": 3.0, "release_after_s": 5.0,
}  # fmt: skip
NATIVE = {
    "type": "engine_forces", "command": "thrusters", "mass_kg": 16.0, "volume_m3": 0.0165,
    "inertia_kg_m2": [0.3, 1.2, 1.4], "inertia_products_kg_m2": [0.02, -0.03, 0.01],
    "center_of_buoyancy_m": [0.01, -0.02, -0.05], "drag_area_m2": 0.06, "drag_share": 0.5, "damping_1_s": 0.3,
    "turn_damping_1_s": 0.4, "half_height_m": 0.9,
}  # fmt: skip
PUSHED = {**NATIVE, "thrusters": [
    {"position_m": [-0.4, 0.2, 0.1], "direction": [0.8, 0.36, -0.48], "limit_n": 9.0},
    {"position_m": [-0.4, -0.2, 0.1], "direction": [0.8, -0.36, -0.48], "limit_n": 11.0},
]}  # fmt: skip
STEERED = {**PUSHED, "fins": [{"position_m": [-0.7, 0.1, 0.05], "lift": [0.0, 0.6, 0.8], "limit_deg": 12.0}]}
SAMPLES: Mapping[str, tuple[tuple[Any, Mapping[str, Any]], ...]] = {
    "terms": (
        ("hovering_auv", {"type": "boundary", "surface": "rigid"}),
        ("hovering_auv", {"type": "boundary", "surface": "pressure_release"}),
        ("dsrv", {"type": "cubic_damping", "diagonal": [3.0, 400.0, 500.0, 60.0, 700.0, 800.0]}),
        ("remus100", {"type": "function", "target": f"{__name__}:push", "parameters": {"share": 0.3}}),
        ("bluerov2", {"type": "blunt_lift", "size_m": [0.5, 0.4, 0.3]}),
        ("otter", {"type": "blunt_lift", "size_m": [0.5, 0.4, 0.3]}),
        ("bluerov2", {"type": "quadratic_damping", "diagonal": [100.0, 140.0, 190.0, 2.0, 1.5, 1.7],
                      "oblique": "frame", "size_m": [0.5, 0.4, 0.3], "center_m": [0.03, -0.02, 0.05]}),
        ("kvlcc2", {"type": "squat", "sinkage": 1.3, "trim": -0.6}),
        ("kvlcc2", {"type": "clarke", "draught_m": 20.8}),
        ("kvlcc2", {"type": "roll_damping", "draught_m": 20.8, "block": 0.8, "midship": 0.97, "gravity_depth_m": 2.0,
                    "keel_length_m": 60.0, "keel_breadth_m": 1.0}),
        ("kvlcc2", {"type": "bank", "draught_m": 20.8}),
    ),
    "actuators": (
        ("bluerov2", {"type": "channel", "low": -2.0, "high": 3.0, "time_constant_s": 0.4}),
        ("bluerov2", CURVE | {"zero_thrust_m_s": 2.1}),
        ("bluerov2", CURVE | {"inflow": DISC}),
        ("bluerov2", FORCE),
        ("bluerov2", SHAFT | {"inflow": DISC}),
        ("bluerov2", SHAFT | {"inflow": SERIES}),
        ("bluerov2", {"type": "t200", "position_m": [-0.3, 0.5, 0.2], "direction": [2.0, 1.0, -0.5],
                      "time_constant_s": 0.1, "inflow": DISC}),
        ("remus100", TANK | {"opens_after_s": 6.0, "vent_m": [0.1, -0.15, -0.05]}),
        ("remus100", TANK | {"valve": True}),
        ("remus100", WEIGHT),
        ("remus100", WEIGHT | {"start": "absent"}),
        ("remus100", WEIGHT | {"in_vehicle_mass": True, "for_good": False, "duration_s": 0.0}),
    ),
    "modes": (
        ("quadrotor", {"type": "attitude", "frequency_rad_s": 1.2, "turn_frequency_rad_s": 8.0}),
        ("wamv", {"type": "place", "pull_n_m": 20.0, "brake_kg_s": 30.0, "pull_limit_n": 150.0, "turn_n_m": 60.0,
                  "turn_damping": 40.0, "turn_limit_n_m": 90.0}),
        ("hovering_auv", {"type": "world_acceleration", "limit_m_s2": 0.7, "turn_limit_rad_s2": 0.4}),
        ("hovering_auv", {**NATIVE, "command": "pose"}),
        ("hovering_auv", {**PUSHED, "command": "place", "current": False}),
        ("hovering_auv", STEERED),
    ),
}  # fmt: skip
"""By group of kinds: a vehicle of the catalogue, and the part."""
ROLLS = {
    "draught_m": None, "block": None, "midship": None, "keel_length_m": 70.0, "keel_breadth_m": 1.0,
    "keel_middle_m": 9.0, "sections": {
        "x_m": [-120.0, -50.0, 40.0, 125.0], "beam_m": [50.0, 58.0, 57.0, 52.0], "draught_m": [20.5, 20.8, 20.7, 20.6],
        "area_m2": [760.0, 1190.0, 1165.0, 950.0], "bilge_radius_m": [5.0, 3.0, 4.0, 6.0],
    },
}  # fmt: skip
CHANGED: tuple[tuple[str, Mapping[str, Any]], ...] = (
    ("tanker", {"added_mass": {"water_depth_m": 26.0}}),
    ("kvlcc2", {"beam_m": 66.0, "terms": {"roll": ROLLS}}),
)
"""Vehicles of the catalogue where some of their numbers matter that otherwise don't: coefficients of shallow water,
sections of a ship.
"""


def push(flow: Any, parameters: Mapping[str, float]) -> Any:
    """A force against the flow, weaker on the host, as a user might write it."""
    if isinstance(flow, NumpyFlow):
        return -0.5 * parameters["share"] * np.asarray(flow.nu_r)
    return [-parameters["share"] * v for v in flow.nu_r]


def kinds(group: str) -> set[str]:
    """Names of all kinds of terms, actuators or modes."""
    return {get_args(c.model_fields["type"].annotation)[0] for c in get_args(get_args(UNIONS[group])[0])}


def samples(group: str, vehicle: str) -> list[BaseModel]:
    """Samples of a group that are for a vehicle of the catalogue."""
    return [TypeAdapter(UNIONS[group]).validate_python(part) for of, part in SAMPLES[group] if of == vehicle]


def parts(group: str) -> Iterator[tuple[pl.Vehicle, list[BaseModel]]]:
    """Vehicles, each with its parts of a group and the samples that are for it."""
    for name in sorted(catalogue_names()):
        vehicle = pl.Vehicle.from_catalogue(name)
        own = [part for part in getattr(vehicle.config, group).values() if part is not None]
        yield vehicle, own + samples(group, name)
    for name, changes in CHANGED:
        vehicle = pl.Vehicle.from_catalogue(name, **changes)
        yield vehicle, [part for part in getattr(vehicle.config, group).values() if part is not None]
