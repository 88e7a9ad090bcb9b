"""Floating hulls: linear hydrostatics, and damping by ratios of critical damping."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos.hydro import damping, restoring
from pelagos.hydro.algebra import Matrix, Vector, add, is_zero, scaled
from pelagos.hydro.rigid_body import moved
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, Number, PartConfig, Positive, Three, numbers
from pelagos.vehicles.wetness import Keeps


class HydrostaticConfig(PartConfig):
    """Stiffness of a floating hull about its centre of flotation."""

    type: Literal["hydrostatic"]
    heave_n_m: Positive
    """[N/m]"""
    roll_n_m: Positive
    """[N m/rad]"""
    pitch_n_m: Positive
    """[N m/rad]"""
    center_of_flotation_m: Three = (0.0, 0.0, 0.0)
    """FRD from the origin [m]."""
    vertical: bool = True
    """The force of heave points along gravity; otherwise along the body's z axis, as in linear theory."""

    @property
    def flotation(self) -> float:
        """Centre of the waterplane, forward of the origin [m]."""
        return self.center_of_flotation_m[0]

    def stiffness(self, body: Body) -> NDArray[np.float64]:
        """Diagonal of G (6) about the centre of flotation."""
        return np.array([0.0, 0.0, self.heave_n_m, self.roll_n_m, self.pitch_n_m, 0.0])

    def build(self, body: Body) -> Hydrostatic:
        """The term."""
        matrix = numbers(moved(np.diag(body.stiffness), self.center_of_flotation_m))
        return Hydrostatic(matrix, self.vertical, _bounds(body))


class TwinHullConfig(PartConfig):
    """Stiffness of two slender pontoons, F21 Section 4.2 as in Fossen's program for the Otter."""

    type: Literal["twin_hull"]
    pontoon_beam_m: Positive
    """Of one pontoon [m]."""
    pontoon_y_m: Positive
    """Centre line of a pontoon from the vehicle's [m]."""
    waterplane_coefficient: Annotated[float, Field(gt=0, le=1)]
    """Cw: waterplane area over length times beam of a pontoon [-]."""
    block_coefficient: Annotated[float, Field(gt=0, le=1)]
    """Cb: displaced volume over length, beam and draught [-]."""
    center_of_flotation_x_m: Number = 0.0
    """LCF, forward of the origin [m]."""
    vertical: bool = True
    """The force of heave points along gravity; otherwise along the body's z axis, as in linear theory."""

    @property
    def flotation(self) -> float:
        """Centre of the waterplane, forward of the origin [m]."""
        return self.center_of_flotation_x_m

    def stiffness(self, body: Body) -> NDArray[np.float64]:
        """Diagonal of G (6) about the centre of flotation."""
        length, b, cw = body.length, self.pontoon_beam_m, self.waterplane_coefficient
        mass = float(body.rigid[0, 0])
        volume = mass / body.density
        draught = volume / (2 * self.block_coefficient * b * length)
        area = cw * length * b
        transverse = (2 / 12) * length * b**3 * 6 * cw**3 / ((1 + cw) * (1 + 2 * cw)) + 2 * area * self.pontoon_y_m**2
        longitudinal = 0.8 * (2 / 12) * b * length**3
        keel_to_buoyancy = (5 * draught / 2 - volume / (2 * length * b)) / 3
        keel_to_gravity = draught - float(body.center_of_gravity[2])
        metacentre = [keel_to_buoyancy + i / volume - keel_to_gravity for i in (transverse, longitudinal)]
        weight = body.density * body.gravity * volume
        heave = 2 * body.density * body.gravity * area
        return np.array([0.0, 0.0, heave, weight * metacentre[0], weight * metacentre[1], 0.0])

    def build(self, body: Body) -> Hydrostatic:
        """The term."""
        point = (self.center_of_flotation_x_m, 0.0, 0.0)
        return Hydrostatic(numbers(moved(np.diag(body.stiffness), point)), self.vertical, _bounds(body))


def _bounds(body: Body) -> tuple[float, float]:
    """The draught, at which nothing is left but the weight, and the rest of the height."""
    draught = body.weight / float(body.stiffness[2])
    return draught, max(body.height - draught, draught)


@dataclass(frozen=True)
class Hydrostatic:
    """Restoring forces near the surface.

    Attributes:
        matrix: G `(6, 6)` about the origin, whose equilibrium is at the surface.
        vertical: see the configuration.
        bounds: highest rise and deepest sinking that still change the force [m]; None: without end.
    """

    keeps: ClassVar[Keeps] = "always"
    matrix: Matrix
    vertical: bool
    bounds: tuple[float, float] | None = None

    def wrench(self, flow: Flow) -> Vector:
        """-G eta (6)."""
        heave, roll, pitch = flow.immersion, flow.roll - flow.surface[0], flow.pitch - flow.surface[1]
        if self.bounds is not None and flow.wet is not None:
            share = flow.wet.share
            heave = dr.clip(heave, -self.bounds[0], self.bounds[1])
            roll, pitch = share * restoring.righting_angle(roll), share * restoring.righting_angle(pitch)
        load = restoring.hydrostatic(self.matrix, heave, roll, pitch)
        if self.vertical:
            load[:3] = scaled(load[2], flow.down)
        return load


class PayloadConfig(PartConfig):
    """The weight of a payload that the hydrostatics do not balance.

    Its mass is that of the vehicle already: what adds its mass to it is a `releasable` actuator.
    """

    type: Literal["payload"]
    mass_kg: NonNegative
    """[kg]"""
    position_m: Three
    """FRD from the origin [m]."""

    def build(self, body: Body) -> Payload:
        """The term."""
        return Payload(self.mass_kg * body.gravity, list(self.position_m))


@dataclass(frozen=True)
class Payload:
    """weight [N]; position (3) [m]."""

    weight: Array
    position: Vector

    def wrench(self, flow: Flow) -> Vector:
        """The weight at its place (6)."""
        return restoring.weight_at(self.weight, self.position, flow.down)


@dataclass(frozen=True)
class Surplus:
    """surplus: weight beyond that at which the hydrostatics are in balance [N]; center: of gravity (3) [m]."""

    keeps: ClassVar[Keeps] = "always"
    surplus: Array
    center: Vector

    def wrench(self, flow: Flow) -> Vector:
        """The weight at its place (6)."""
        return restoring.weight_at(self.surplus, self.center, flow.down)


class FloatingDampingConfig(PartConfig):
    """Linear damping of a floating hull: time constants, and ratios of critical damping in heave, roll and pitch."""

    type: Literal["floating_damping"]
    surge_kg_s: NonNegative
    """[kg/s]"""
    sway_s: Positive
    """[s]"""
    heave_ratio: NonNegative
    """[-]"""
    roll_ratio: NonNegative
    """[-]"""
    pitch_ratio: NonNegative
    """[-]"""
    yaw_s: Positive
    """[s]"""
    yaw_quadratic_s: NonNegative = 0.0
    """Further damping in yaw: this times the linear coefficient times |r| r [s]."""

    def build(self, body: Body) -> FloatingDamping:
        """The term; natural frequencies follow from the hydrostatics and M."""
        m, g = np.diag(body.mass_matrix), body.stiffness
        ratios = (self.heave_ratio, self.roll_ratio, self.pitch_ratio)
        critical = [2 * z * math.sqrt(g[i] / m[i]) * m[i] for i, z in zip((2, 3, 4), ratios, strict=True)]
        yaw = m[5] / self.yaw_s
        diagonal = np.diag([self.surge_kg_s, m[1] / self.sway_s, *critical, yaw])
        return FloatingDamping(numbers(diagonal), float(self.yaw_quadratic_s * yaw))


@dataclass(frozen=True)
class FloatingDamping:
    """matrix: D `(6, 6)`; yaw: quadratic coefficient [kg m^2]."""

    matrix: Matrix
    yaw: Array

    def wrench(self, flow: Flow) -> Vector:
        """-D nu_r (6), and the quadratic part in yaw."""
        linear = damping.linear_damping(self.matrix, flow.nu_r)
        if is_zero(self.yaw):
            return linear
        quadratic = damping.quadratic_damping([0.0, 0.0, 0.0, 0.0, 0.0, self.yaw], flow.nu_r)
        return add(linear, quadratic)
