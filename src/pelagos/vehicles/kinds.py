"""The kinds of terms, actuators and control modes that a vehicle's configuration may name."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Field

from pelagos.vehicles.actuators.ballast import BuoyancyEngineConfig, MovingMassConfig
from pelagos.vehicles.actuators.bis import BisShipConfig
from pelagos.vehicles.actuators.channel import ChannelConfig
from pelagos.vehicles.actuators.compartment import CompartmentConfig
from pelagos.vehicles.actuators.curve import CurveThrusterConfig
from pelagos.vehicles.actuators.engine import ShipEngineConfig
from pelagos.vehicles.actuators.fin import FinConfig
from pelagos.vehicles.actuators.flap import FlapConfig
from pelagos.vehicles.actuators.mmg import MmgShipConfig
from pelagos.vehicles.actuators.nomoto import NomotoShipConfig
from pelagos.vehicles.actuators.plane import PlaneConfig, RacePropellerConfig
from pelagos.vehicles.actuators.propeller import PropellerConfig
from pelagos.vehicles.actuators.releasable import ReleasableConfig
from pelagos.vehicles.actuators.rolling import RollingShipConfig
from pelagos.vehicles.actuators.ship import ShipRudderConfig
from pelagos.vehicles.actuators.t200 import T200Config
from pelagos.vehicles.actuators.thruster import ForceThrusterConfig, ThrusterConfig
from pelagos.vehicles.control.acceleration import AccelerationConfig
from pelagos.vehicles.control.airplane import AirplaneConfig
from pelagos.vehicles.control.attitude import AttitudeConfig
from pelagos.vehicles.control.depth_heading import DepthHeadingConfig
from pelagos.vehicles.control.direct import ActuatorsConfig, WrenchConfig
from pelagos.vehicles.control.engine_forces import EngineForcesConfig
from pelagos.vehicles.control.heading_thrust import HeadingThrustConfig
from pelagos.vehicles.control.line_of_sight import LineOfSightConfig
from pelagos.vehicles.control.multirotor import MultirotorConfig
from pelagos.vehicles.control.place import PlaceConfig
from pelagos.vehicles.control.pose import PoseConfig
from pelagos.vehicles.control.rudder_heading import RudderHeadingConfig
from pelagos.vehicles.control.sawtooth import SawtoothConfig
from pelagos.vehicles.control.velocity import VelocityConfig
from pelagos.vehicles.control.world_acceleration import WorldAccelerationConfig
from pelagos.vehicles.terms.air import WingConfig
from pelagos.vehicles.terms.bank import BankConfig
from pelagos.vehicles.terms.blunt_lift import BluntLiftConfig
from pelagos.vehicles.terms.boundary import BoundaryConfig
from pelagos.vehicles.terms.clarke import ClarkeConfig
from pelagos.vehicles.terms.crossflow import CrossFlowConfig, ObliqueCrossFlowConfig
from pelagos.vehicles.terms.damping import (
    CubicDampingConfig,
    LinearDampingConfig,
    QuadraticDampingConfig,
    TimeConstantDampingConfig,
)
from pelagos.vehicles.terms.derivatives import DerivativesConfig
from pelagos.vehicles.terms.ditching import DitchingConfig
from pelagos.vehicles.terms.floating import FloatingDampingConfig, HydrostaticConfig, PayloadConfig, TwinHullConfig
from pelagos.vehicles.terms.function import FunctionConfig
from pelagos.vehicles.terms.glide import GlideConfig
from pelagos.vehicles.terms.lift import LiftDragConfig
from pelagos.vehicles.terms.modulus import ModulusConfig
from pelagos.vehicles.terms.restoring import SubmergedConfig
from pelagos.vehicles.terms.roll_damping import RollDampingConfig
from pelagos.vehicles.terms.squat import SquatConfig
from pelagos.vehicles.terms.windage import WindageConfig

TermConfig: TypeAlias = Annotated[
    BankConfig
    | BluntLiftConfig
    | BoundaryConfig
    | ClarkeConfig
    | CrossFlowConfig
    | CubicDampingConfig
    | DerivativesConfig
    | DitchingConfig
    | FloatingDampingConfig
    | FunctionConfig
    | GlideConfig
    | HydrostaticConfig
    | LiftDragConfig
    | LinearDampingConfig
    | ModulusConfig
    | ObliqueCrossFlowConfig
    | PayloadConfig
    | QuadraticDampingConfig
    | RollDampingConfig
    | SquatConfig
    | SubmergedConfig
    | TimeConstantDampingConfig
    | TwinHullConfig
    | WindageConfig
    | WingConfig,
    Field(discriminator="type"),
]

ActuatorConfig: TypeAlias = Annotated[
    BisShipConfig
    | BuoyancyEngineConfig
    | ChannelConfig
    | CompartmentConfig
    | CurveThrusterConfig
    | FinConfig
    | FlapConfig
    | ForceThrusterConfig
    | MovingMassConfig
    | NomotoShipConfig
    | PlaneConfig
    | PropellerConfig
    | RacePropellerConfig
    | MmgShipConfig
    | ReleasableConfig
    | RollingShipConfig
    | ShipEngineConfig
    | ShipRudderConfig
    | T200Config
    | ThrusterConfig,
    Field(discriminator="type"),
]

ModeConfig: TypeAlias = Annotated[
    AccelerationConfig
    | ActuatorsConfig
    | AirplaneConfig
    | AttitudeConfig
    | DepthHeadingConfig
    | EngineForcesConfig
    | HeadingThrustConfig
    | LineOfSightConfig
    | MultirotorConfig
    | PlaceConfig
    | PoseConfig
    | RudderHeadingConfig
    | SawtoothConfig
    | VelocityConfig
    | WorldAccelerationConfig
    | WrenchConfig,
    Field(discriminator="type"),
]
