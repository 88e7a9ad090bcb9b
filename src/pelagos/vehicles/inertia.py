"""Mass, inertia, buoyancy and added mass of a vehicle, as data."""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos.hydro import added_mass, rigid_body
from pelagos.hydro.clarke import MainDimensions, clarke_derivatives, surge_added_mass
from pelagos.vehicles.nearby import GroundMass
from pelagos.vehicles.part import NonNegative, PartConfig, Positive, Six, Three


class SpheroidMass(PartConfig):
    """A homogeneous spheroid of the hull's length and diameter."""

    type: Literal["spheroid"] = "spheroid"
    mass_kg: Positive | None = None
    """[kg]; left out: as much as the water that the spheroid displaces."""
    center_of_gravity_m: Three = (0.0, 0.0, 0.0)
    """r_g, FRD from the origin [m]."""
    center_of_buoyancy_m: Three = (0.0, 0.0, 0.0)
    """r_b, FRD from the origin [m]."""


class ExplicitMass(PartConfig):
    """Mass properties as measured or published."""

    type: Literal["explicit"] = "explicit"
    mass_kg: Positive
    """[kg]"""
    inertia_kg_m2: Three
    """Ixx, Iyy, Izz about the centre of gravity [kg m^2]."""
    products_of_inertia_kg_m2: Three = (0.0, 0.0, 0.0)
    """Ixy, Ixz, Iyz: off-diagonal entries of the inertia matrix are their negatives [kg m^2]."""
    center_of_gravity_m: Three = (0.0, 0.0, 0.0)
    """r_g, FRD from the origin [m]."""
    center_of_buoyancy_m: Three = (0.0, 0.0, 0.0)
    """r_b, FRD from the origin [m]."""
    volume_m3: NonNegative | None = None
    """Displaced volume when wet [m^3]; left out: neutral, buoyancy equals weight."""


MassConfig = Annotated[SpheroidMass | ExplicitMass, Field(discriminator="type")]


class LambAddedMass(PartConfig):
    """Lamb's factors times the vehicle's own mass and inertia, as F21 Chapter 8 has it."""

    type: Literal["lamb"] = "lamb"
    roll_factor: NonNegative = 0.0
    """Added inertia in roll over the inertia in roll [-]."""


class DiagonalAddedMass(PartConfig):
    """Added mass about the origin, diagonal."""

    type: Literal["diagonal"] = "diagonal"
    diagonal: Six
    """Positive: -Xudot, -Yvdot, -Zwdot [kg], -Kpdot, -Mqdot, -Nrdot [kg m^2]."""


class MatrixAddedMass(PartConfig):
    """Added mass about the origin, the full symmetric matrix."""

    type: Literal["matrix"] = "matrix"
    matrix: tuple[Six, Six, Six, Six, Six, Six]
    """M_A [kg, kg m, kg m^2]."""
    measured: bool = False
    """Taken from tests, and therefore allowed not to be symmetric."""


class ShallowAddedMass(PartConfig):
    """Added mass about the origin, diagonal, that grows as the water under the keel gets less."""

    type: Literal["shallow"] = "shallow"
    diagonal: Six
    """In deep water; positive: -Xudot, -Yvdot, -Zwdot [kg], -Kpdot, -Mqdot, -Nrdot [kg m^2]."""
    growth: Six
    """Growth of each by draught over the water under the keel [kg], [kg m^2]."""
    draught_m: Positive
    """[m]"""
    water_depth_m: Positive | Literal["world"] | None = None
    """Of the water that the ship's forces are for, from surface to ground [m]; world: that of the world under the ship
    at every tick, which acts as 1.2 draughts where it is less; left out: deep."""
    momentum: bool = False
    """With the world's depth: over ground that slopes, the growing added mass takes its momentum from the ship and the
    water's energy pulls towards the deep (`hydro/shoaling.py`), which derivatives of one depth each do not contain."""

    @model_validator(mode="after")
    def _afloat(self) -> Self:
        if self.momentum and self.water_depth_m != "world":
            raise ValueError("momentum is of a depth that changes on the way: water_depth_m: world goes with it")
        if isinstance(self.water_depth_m, float) and self.water_depth_m <= self.draught_m:
            raise ValueError(f"water_depth_m {self.water_depth_m:g} must be more than draught_m {self.draught_m:g}")
        return self

    @property
    def shallow(self) -> float:
        """Draught over the water under the keel; 0 in deep water, and where the depth is the world's."""
        return self.draught_m / (self.water_depth_m - self.draught_m) if isinstance(self.water_depth_m, float) else 0.0

    @property
    def ground(self) -> GroundMass | None:
        """Growth with the depth of the world."""
        return GroundMass(self.draught_m, self.growth, self.momentum) if self.water_depth_m == "world" else None


class ClarkeAddedMass(PartConfig):
    """Added mass of a ship from its main dimensions: sway and yaw by Clarke, Gedling and Hine 1983, surge by Soeding
    1982; for the forms of `hydro/clarke.py`, about the middle of the hull.
    """

    type: Literal["clarke"] = "clarke"
    draught_m: Positive
    """[m]; length, beam and displaced volume are the vehicle's."""
    heave_kg: NonNegative
    """Not given by the formulas [kg]."""
    roll_kg_m2: NonNegative
    """Not given by the formulas [kg m^2]."""
    pitch_kg_m2: NonNegative
    """Not given by the formulas [kg m^2]."""

    @property
    def measured(self) -> bool:
        """Each coefficient was fitted by itself: Yrdot and Nvdot differ."""
        return True

    def matrix(self, length: float, beam: float, volume: float, density: float) -> NDArray[np.float64]:
        """M_A `(6, 6)`: length, beam [m], displaced volume [m^3], density of the water [kg/m^3].

        Raises:
            ValueError: the form is beyond the regression.
        """
        form = MainDimensions(length, beam, self.draught_m, volume)
        if form.outside():
            raise ValueError(f"added_mass: {form.outside()}")
        found, scale = clarke_derivatives(form), 0.5 * density * length**3
        made = np.diag([surge_added_mass(form, density), 0.0, self.heave_kg, self.roll_kg_m2, self.pitch_kg_m2, 0.0])
        made[1, 1], made[1, 5] = -scale * found.y_vdot, -scale * length * found.y_rdot
        made[5, 1], made[5, 5] = -scale * length * found.n_vdot, -scale * length**2 * found.n_rdot
        return made


class NoAddedMass(PartConfig):
    """In air."""

    type: Literal["none"] = "none"


AddedMassConfig = Annotated[
    LambAddedMass | DiagonalAddedMass | MatrixAddedMass | ShallowAddedMass | ClarkeAddedMass | NoAddedMass,
    Field(discriminator="type"),
]


class CoriolisConfig(PartConfig):
    """Form of the Coriolis forces."""

    rigid: Literal["momentum", "angular", "none"] = "momentum"
    """The rigid body's part from its momentum, or without linear velocity (F21 Section 3.3); none: none at all."""
    added: Literal["momentum", "none"] = "momentum"
    """The added mass's part from its momentum; none: the terms contain it, as those of tank tests do."""
    without: tuple[tuple[Annotated[int, Field(ge=1, le=6)], Annotated[int, Field(ge=1, le=6)]], ...] = ()
    """Entries (row, column), from 1, that a published model removes from the added mass's part."""


def mass_and_inertia(
    config: SpheroidMass | ExplicitMass, density: float, length: float, diameter: float
) -> tuple[float, NDArray[np.float64], float]:
    """Mass [kg], inertia `(3, 3)` about the centre of gravity [kg m^2], displaced volume [m^3]."""
    if isinstance(config, SpheroidMass):
        a, b = length / 2, diameter / 2
        displaced = density * rigid_body.spheroid_volume(a, b)
        mass = displaced if config.mass_kg is None else config.mass_kg
        return mass, rigid_body.spheroid_inertia(mass, a, b), displaced / density
    ixy, ixz, iyz = config.products_of_inertia_kg_m2
    inertia = np.diag(config.inertia_kg_m2) - np.array([[0, ixy, ixz], [ixy, 0, iyz], [ixz, iyz, 0]])
    volume = config.mass_kg / density if config.volume_m3 is None else config.volume_m3
    return config.mass_kg, inertia, volume


def added_mass_matrix(
    config: AddedMassConfig,
    mass: float,
    inertia: NDArray[np.float64],
    length: float,
    diameter: float,
    *,
    volume: float,
    density: float,
) -> NDArray[np.float64]:
    """M_A `(6, 6)` about CO; `volume`: displaced [m^3], `density`: of the water [kg/m^3]."""
    if isinstance(config, ClarkeAddedMass):
        return config.matrix(length, diameter, volume, density)
    if isinstance(config, DiagonalAddedMass):
        return np.diag(np.array(config.diagonal, dtype=np.float64))
    if isinstance(config, ShallowAddedMass):
        return np.diag(np.array(config.diagonal) + config.shallow * np.array(config.growth))
    if isinstance(config, MatrixAddedMass):
        return np.array(config.matrix, dtype=np.float64)
    if isinstance(config, NoAddedMass):
        return np.zeros((6, 6))
    k = added_mass.lamb_factors(length / 2, diameter / 2)
    across = k.rotary * inertia[1, 1]
    return np.diag(
        [k.axial * mass, k.lateral * mass, k.lateral * mass, config.roll_factor * inertia[0, 0], across, across]
    )
