"""A vehicle as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from pelagos.errors import did_you_mean
from pelagos.hydro import rigid_body
from pelagos.vehicles.actuators.compartment import CompartmentConfig
from pelagos.vehicles.actuators.releasable import ReleasableConfig
from pelagos.vehicles.actuators.t200 import BatteryConfig, T200Config
from pelagos.vehicles.afloat_config import AfloatConfig
from pelagos.vehicles.envelope import EnvelopeConfig
from pelagos.vehicles.flow import CurrentRotation
from pelagos.vehicles.inertia import (
    AddedMassConfig,
    ClarkeAddedMass,
    CoriolisConfig,
    MassConfig,
    added_mass_matrix,
    mass_and_inertia,
)
from pelagos.vehicles.interaction import InteractionConfig, build_interaction
from pelagos.vehicles.kinds import ActuatorConfig, ModeConfig, TermConfig
from pelagos.vehicles.load import catalogue_data, catalogue_names, merged
from pelagos.vehicles.part import Body, NonNegative, PartConfig, Positive, Three
from pelagos.vehicles.shape.hull import HullConfig
from pelagos.vehicles.shape.parts import PartsHull, ShapePart
from pelagos.vehicles.shape.torpedo import TorpedoHull
from pelagos.vehicles.terms.clarke import ClarkeConfig
from pelagos.vehicles.terms.floating import HydrostaticConfig, TwinHullConfig

_ONCE: Final = {
    "boundary": "a hull has one image in a plane", "squat": "a hull sinks once", "clarke": "a hull has one side force",
    "roll_damping": "a hull's roll is damped once", "bank": "a hull has one image in a wall",
}  # fmt: skip
"""Terms that a vehicle may have once, and why."""


class VehicleConfig(PartConfig):
    """A vehicle: hull, mass, added mass, terms of the equation of motion, actuators and control modes.

    With a `type` of the catalogue every other key is a change to that vehicle, at any depth: `{type: remus100, mass:
    {mass_kg: 32}}`. A term, an actuator or a mode is left out by the value null. `type: custom` starts from nothing.
    """

    type: str
    """A vehicle of the catalogue, or "custom"."""
    title: str = ""
    """One line about the vehicle."""
    sources: dict[str, str] = Field(default_factory=dict)
    """Where the numbers come from."""
    density_kg_m3: Positive = 1026.0
    """Density of the water that the coefficients are for, or of the air with `medium: air`, where `inflow` of
    thrusters needs it [kg/m^3]."""
    gravity_m_s2: NonNegative = 9.81
    """[m/s^2]"""
    length_m: Positive
    """Of the hull [m]."""
    diameter_m: Positive | None = None
    """Of a round hull [m]; otherwise `beam_m` and `height_m`."""
    beam_m: Positive | None = None
    """Of the hull [m]."""
    height_m: Positive | None = None
    """Of the hull [m]."""
    mass: MassConfig
    """Mass, inertia, centres of gravity and buoyancy."""
    added_mass: AddedMassConfig
    """Added mass about the origin."""
    coriolis: CoriolisConfig = CoriolisConfig()
    """How Coriolis forces are formed."""
    terms: dict[str, TermConfig | None] = Field(default_factory=dict)
    """Damping, lift, restoring and other terms, by a name of your choice."""
    actuators: dict[str, ActuatorConfig | None] = Field(default_factory=dict)
    """By name, in the order of commands and states."""
    battery: BatteryConfig | None = None
    """What feeds T200 thrusters."""
    interaction: InteractionConfig | None = None
    """Thrusters that stand in each other's jets; left out: none does."""
    modes: dict[str, ModeConfig | None] = Field(default_factory=dict)
    """Control modes by name."""
    default_mode: str
    """The mode that commands are for when none is chosen."""
    envelope: EnvelopeConfig = EnvelopeConfig()
    """What missions may ask of it, and what they ask where a leg says nothing."""
    medium: Literal["water", "air"] = "water"
    """What moves past it: the ocean's current, or its wind."""
    integrator: Literal["conservative", "semi_implicit", "runge_kutta"] = "conservative"
    """How steps are taken: order 1 with Coriolis forces that do no work, so that a body without drag keeps its energy;
    order 1 with every force at the step's beginning, which comes closest to Fossen's programs; or order 4 at four times
    the cost."""
    current_rotation: CurrentRotation = "attitude"
    """A current is turned into body axes with the whole attitude, or with the heading only."""
    afloat: AfloatConfig | None = None
    """The hull in the water, for loads of waves."""
    seakeeping: Literal["pressure", "slope"] = "pressure"
    """In waves, what floats feels pressure on the wet hull, diffraction, radiation and wind (where `afloat` says what
    lies in the water), or its linear hydrostatics follow the surface's mean height and slope. In still water both are
    the linear hydrostatics.
    """
    hull: HullConfig | None = None
    """What it looks like."""
    materials: tuple[str, ...] = ("hull_paint",)
    """What the hull is made of."""
    hull_grip: float = Field(default=1.0, ge=0, le=1)
    """Share of the friction of whatever it touches that the hull feels: near 0 for a body on wheels or runners, whose
    resistance to rolling and to sliding sideways is then damping.
    """
    mounts: dict[str, Three] = Field(default_factory=dict)
    """Places for sensors, forward-left-up from the origin [m]."""
    variants: dict[str, dict[str, Any]] = Field(default_factory=dict)
    """Named sets of changes, such as another publication's parameters, each used as a whole."""
    variant: str | None = None
    """The set of `variants` that is laid over the vehicle before any other change."""
    as_published: dict[str, Any] = Field(default_factory=dict)
    """Changes that give the model exactly as published, where this catalogue deviates from it."""

    @model_validator(mode="before")
    @classmethod
    def _on_catalogue(cls, data: Any) -> Any:
        if not isinstance(data, Mapping) or data.get("type") not in catalogue_names():
            return data
        known, variant = catalogue_data(data["type"]).get("variants", {}), data.get("variant")
        if variant is not None and not isinstance(variant, str):
            raise ValueError(f"variant: give one name of {', '.join(known) or '(none)'}, not {variant!r}")
        if variant is not None and variant not in known:
            hint = did_you_mean(variant, known)
            raise ValueError(f"variant {variant!r} is none of {', '.join(known) or '(none)'}{hint}")
        return cls.with_catalogue(data)

    @classmethod
    def with_catalogue(cls, data: Any) -> Any:
        """Changes to a vehicle of the catalogue laid over it and its variant; other data as they are."""
        if not isinstance(data, Mapping) or data.get("type") not in catalogue_names():
            return data
        base, variant = catalogue_data(data["type"]), data.get("variant")
        changes = base.get("variants", {}).get(variant) if isinstance(variant, str) else None
        return merged(merged(base, changes or {}), data)

    @model_validator(mode="after")
    def _possible(self) -> Self:
        if self.variant is not None and self.type not in catalogue_names():
            raise ValueError(f"variant {self.variant!r}: vehicles of the catalogue have variants, {self.type} has none")
        if self.diameter_m is None and (self.beam_m is None or self.height_m is None):
            raise ValueError("give diameter_m, or beam_m and height_m")
        if self.modes.get(self.default_mode) is None:
            raise ValueError(f"default_mode {self.default_mode!r} is none of the modes {', '.join(self.modes)}")
        if self.battery is None and any(isinstance(a, T200Config) for a in self.actuators.values()):
            raise ValueError("T200 thrusters need a battery: give open_circuit_v and resistance_ohm under battery")
        for kind, why in _ONCE.items():
            alike = [name for name, term in self.terms.items() if term is not None and term.type == kind]
            if len(alike) > 1:
                raise ValueError(f"terms {' and '.join(alike)} are both of type {kind}: {why}")
        if self.interaction is not None:
            self.interaction.check(self.actuators)
        for name in () if self.afloat is None else self.afloat.calm_damping:
            if self.terms.get(name) is None:
                hint = did_you_mean(name, self.terms)
                raise ValueError(f"calm_damping: {name!r} is none of the terms {', '.join(self.terms)}{hint}")
        _check_density(self)
        _check_gravity(self)
        _check_clarke(self)
        for name, mode in self.modes.items():
            for used in getattr(mode, "uses", ()):
                if self.actuators.get(used) is None:
                    raise ValueError(f"mode {name!r} uses the actuator {used!r}, which this vehicle does not have")
        for name, part in self.actuators.items():
            for used, kind in getattr(part, "needs", {}).items():
                if getattr(self.actuators.get(used), "type", None) != kind:
                    raise ValueError(f"actuator {name!r} needs an actuator {used!r} of the type {kind}")
        body = self.body
        _check_body(body, measured=getattr(self.added_mass, "measured", False))
        if self.interaction is not None:
            named = {name: self.actuators[name] for name in self.interaction.thrusters}
            build_interaction(self.interaction, {name: part.build(body) for name, part in named.items() if part})
        self._check_carried()
        return self

    def _check_carried(self) -> None:
        """Refuse what cannot be carried: more mass than there is, or water where there is none."""
        left = self.body.rigid
        for name, part in self.actuators.items():
            if isinstance(part, CompartmentConfig) and self.medium == "air":
                raise ValueError(f"actuators.{name}: a compartment floods in water; this vehicle's medium is air")
            if isinstance(part, ReleasableConfig) and part.in_vehicle_mass:
                left = left - rigid_body.mass_matrix(part.mass_kg, np.diag(part.inertia_kg_m2), part.position_m)
                if np.linalg.eigvalsh(left).min() <= 0:
                    raise ValueError(
                        f"actuators.{name}: in_vehicle_mass, but nothing that can be is left of the vehicle's "
                        f"{float(self.body.rigid[0, 0]):g} kg and its inertia without {part.mass_kg:g} kg there"
                    )

    @property
    def beam(self) -> float:
        """[m]"""
        return float(self.beam_m or self.diameter_m or 0.0)

    @property
    def height(self) -> float:
        """[m]"""
        return float(self.height_m or self.diameter_m or 0.0)

    @property
    def shape(self) -> TorpedoHull | PartsHull:
        """The hull's shape: as configured, or an ellipsoid of length, beam and height."""
        if self.hull is not None:
            return self.hull
        body = ShapePart(type="ellipsoid", size_m=(self.length_m, self.beam, self.height))
        return PartsHull(type="parts", parts=(body,))

    @property
    def body(self) -> Body:
        """The constants that terms follow from."""
        mass, inertia, volume = mass_and_inertia(self.mass, self.density_kg_m3, self.length_m, self.beam)
        wet = self.density_kg_m3 * volume
        body = Body(
            density=self.density_kg_m3,
            gravity=self.gravity_m_s2,
            length=self.length_m,
            beam=self.beam,
            height=self.height,
            rigid=rigid_body.mass_matrix(mass, inertia, self.mass.center_of_gravity_m),
            displaced=rigid_body.mass_matrix(wet, wet / mass * inertia, self.mass.center_of_buoyancy_m),
            added=added_mass_matrix(
                self.added_mass, mass, inertia, self.length_m, self.beam, volume=volume, density=self.density_kg_m3
            ),
            weight=mass * self.gravity_m_s2,
            buoyancy=self.density_kg_m3 * volume * self.gravity_m_s2,
            center_of_gravity=np.array(self.mass.center_of_gravity_m, dtype=np.float64),
            center_of_buoyancy=np.array(self.mass.center_of_buoyancy_m, dtype=np.float64),
            stiffness=np.zeros(6),
            in_air=self.medium == "air",
            shallow=getattr(self.added_mass, "shallow", 0.0),
            ground=getattr(self.added_mass, "ground", None),
            afloat=self.afloat,
        )
        for term in self.terms.values():
            if isinstance(term, (HydrostaticConfig, TwinHullConfig)):
                body = replace(body, stiffness=term.stiffness(body), flotation=term.flotation)
        return body


def _check_density(config: VehicleConfig) -> None:
    """Refuse thrusters that would draw water where there is air.

    Raises:
        ValueError: names the thruster.
    """
    if config.medium == "water" or "density_kg_m3" in config.model_fields_set:
        return
    for name, part in config.actuators.items():
        if getattr(part, "inflow", None) is not None:
            raise ValueError(
                f"inflow of {name!r} in the air needs its density: density_kg_m3 is left at {config.density_kg_m3:g}, "
                "that of water; give that of air, about 1.2"
            )


def _check_gravity(config: VehicleConfig) -> None:
    """Refuse compartments where nothing weighs: what drives water in and out is its weight.

    Raises:
        ValueError: names the compartment.
    """
    for name, part in config.actuators.items():
        if getattr(part, "type", None) == "compartment" and config.gravity_m_s2 == 0:
            raise ValueError(f"the compartment {name!r} needs a gravity_m_s2 above 0, not {config.gravity_m_s2:g}")


def _check_clarke(config: VehicleConfig) -> None:
    """Refuse Coriolis forces of the added mass beside terms that contain them, a ship without the rigid body's, which
    they do not contain, and added mass of another draught.

    Raises:
        ValueError: names the term.
    """
    added = config.added_mass
    for name, term in config.terms.items():
        if not isinstance(term, ClarkeConfig):
            continue
        if config.coriolis.added != "none":
            raise ValueError(
                f"the derivatives of {name!r} contain the Coriolis forces of the added mass: coriolis: {{added: none}} "
                "goes with them"
            )
        if config.coriolis.rigid == "none":
            raise ValueError(
                f"the derivatives of {name!r} are without the rigid body's Coriolis forces, such as m U r: coriolis: "
                "{rigid: momentum, added: none} goes with them, not {rigid: none}"
            )
        if isinstance(added, ClarkeAddedMass) and added.draught_m != term.draught_m:
            raise ValueError(
                f"{name!r} has draught_m {term.draught_m:g} and added_mass {added.draught_m:g}: a ship has one draught"
            )


def _check_body(body: Body, *, measured: bool) -> None:
    """Refuse what no body can be.

    Raises:
        ValueError: says what is impossible and why.
    """
    mass = float(body.rigid[0, 0])
    shift = rigid_body.skew(body.center_of_gravity)
    inertia = body.rigid[3:, 3:] + mass * shift @ shift
    principal = np.sort(np.linalg.eigvalsh(inertia))
    if principal[0] <= 0:
        raise ValueError(f"the inertia matrix has the principal moment {principal[0]:.4g} kg m^2; all must be positive")
    if principal[2] > (principal[0] + principal[1]) * (1 + 1e-9):
        raise ValueError(
            f"principal moments {principal[0]:.4g}, {principal[1]:.4g}, {principal[2]:.4g} kg m^2 break the triangle "
            "inequality: no distribution of mass has one moment larger than the sum of the others"
        )
    if not measured and not np.allclose(body.added, body.added.T, rtol=1e-9, atol=0):
        raise ValueError("the added mass matrix must be symmetric (or measured: true)")
    least = float(np.linalg.eigvalsh((body.mass_matrix + body.mass_matrix.T) / 2).min())
    if least <= 0:
        raise ValueError(f"mass plus added mass is not positive definite (least eigenvalue {least:.4g})")
    half = np.array([body.length, body.beam, body.height]) / 2
    for name, point in (("buoyancy", body.center_of_buoyancy), ("gravity", body.center_of_gravity)):
        if (np.abs(point) > half).any():
            raise ValueError(
                f"the centre of {name} {tuple(float(x) for x in point)} m lies outside the hull, whose half sizes are "
                f"{half[0]:g}, {half[1]:g}, {half[2]:g} m"
            )
