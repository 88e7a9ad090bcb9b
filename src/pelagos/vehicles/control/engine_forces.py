"""HoloOcean's force model: a rigid body of a game engine with weight, buoyancy, one drag and engine damping.

For comparison with work that was done in HoloOcean, and for its scripts; Pelagos's own vehicles have added mass,
Coriolis forces, damping by axis and thrusters with lag. Facts: HoloOcean 2.3 (BYU FRoSt Lab, MIT licence), agents
HoveringAUV, BlueROV2, TorpedoAUV, CougUV and SurfaceVessel. FRD about the centre of mass, SI.

Its native drag is a hundredth of what its own coefficients say, because newtons go where the engine expects
kg cm/s^2 (`drag_share`: 0.01 as it is, 1 as it was meant).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, Self

import drjit as dr
import numpy as np
from pydantic import Field, model_validator

from pelagos.errors import ScenarioError
from pelagos.hydro.algebra import Vector, add, cross, dot, matvec, minus, scaled, transpose
from pelagos.jit import Array
from pelagos.vehicles.control.angle import smallest_angle
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.control.world_acceleration import from_world
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import NonNegative, PartConfig, Positive, Three

GRAVITY: Final = 9.8  # of the engine [m/s^2]
FIN_AREA: Final = 0.01  # [m^2]
FIN_SLOPE: Final = 0.1  # lift coefficient by angle
FIN_ASPECT: Final = 3.14 * 1.2 * 0.8  # pi, aspect ratio 1.2, Oswald factor 0.8
FIN_DRAG: Final = 0.01  # at no lift
FIN_RADIAN: Final = 3.14 / math.pi  # of a radian of incidence, with HoloOcean's pi
FIN_SHARE: Final = 12.0  # of the force: 0.12, with speeds in cm/s and forces in 0.01 N
FIN_LIMIT_N: Final = 3.0  # 300 of the engine's 0.01 N
FIN_CURRENT: Final = 0.01  # of a current that fins feel: m/s are taken off cm/s


class Thrust(PartConfig):
    """One thruster: instantaneous, full in air too."""

    position_m: Three
    """From the centre of mass, FRD [m]."""
    direction: Three
    """Of positive thrust, FRD, of unit length."""
    limit_n: Positive
    """Greatest thrust either way [N]."""


class Fin(PartConfig):
    """One control surface."""

    position_m: Three
    """From the centre of mass, FRD [m]."""
    lift: Three
    """Direction of the force of a positive angle when moving ahead, across the body's x axis, FRD, of unit length."""
    limit_deg: Positive = 45.0
    """Greatest angle either way [deg]."""


class EngineForcesConfig(PartConfig):
    """HoloOcean's native force model, commanded by thrusts or by a pose."""

    type: Literal["engine_forces"]
    command: Literal["thrusters", "pose", "place"]
    """Set-points: thrusts [N] (and before them angles of fins [deg]); x, y, z, roll, pitch, yaw in NWU [m], [deg]; or
    x, y [m] of a craft with two thrusters."""
    mass_kg: Positive
    """[kg]"""
    volume_m3: Positive
    """Displaced when wet everywhere [m^3]."""
    inertia_kg_m2: tuple[Positive, Positive, Positive]
    """Moments about the centre of mass, FRD."""
    inertia_products_kg_m2: Three = (0.0, 0.0, 0.0)
    """Off the tensor's diagonal: xy, xz, yz, FRD."""
    density_kg_m3: Positive = 997.0
    """Of the water [kg/m^3]."""
    center_of_buoyancy_m: Three = (0.0, 0.0, -0.05)
    """From the centre of mass, FRD [m]."""
    drag_area_m2: NonNegative
    """Drag coefficient times area [m^2], the same from all sides."""
    drag_share: NonNegative = 0.01
    """Of the drag that acts."""
    damping_1_s: NonNegative
    """Share of the velocity in the world that is lost in a second [1/s]."""
    turn_damping_1_s: NonNegative
    """Share of the rates of turn that is lost in a second [1/s]."""
    half_height_m: Positive
    """Of the box whose wet share is that of buoyancy and drag [m]."""
    thrusters: tuple[Thrust, ...] = ()
    """In the order of commands."""
    fins: tuple[Fin, ...] = ()
    """Commanded before the thrusters; these and thrust are cut above the surface where there are fins."""
    current: bool = Field(default=True)
    """Three further set-points: a current NWU [m/s], beside that of the ocean."""

    @model_validator(mode="after")
    def _pushed(self) -> Self:
        """Thrusters and fins that the set-points move, and no others."""
        if self.command == "pose" and self.thrusters:
            raise ValueError("the command 'pose' accelerates the body itself: leave out 'thrusters'")
        if self.command == "place" and len(self.thrusters) != 2:
            raise ValueError(f"the command 'place' needs two 'thrusters', left and right, not {len(self.thrusters)}")
        if self.command != "thrusters" and self.fins:
            raise ValueError(f"the command {self.command!r} moves no fins: leave out 'fins'")
        return self

    def build(self, plant: Plant) -> EngineForces:
        """The mode.

        Raises:
            ScenarioError: moments and products that no body has.
        """
        (x, y, z), (xy, xz, yz) = self.inertia_kg_m2, self.inertia_products_kg_m2
        tensor = np.array([[x, xy, xz], [xy, y, yz], [xz, yz, z]])
        if np.linalg.eigvalsh(tensor)[0] <= 0:
            raise ScenarioError(f"inertia_products_kg_m2 {self.inertia_products_kg_m2} are too great for the moments")
        return EngineForces(self, tuple(tuple(float(v) for v in row) for row in np.linalg.inv(tensor)))


@dataclass(frozen=True)
class EngineForces:
    """See `EngineForcesConfig`; memory: of the pose's loops, the integrals of the angles (3) [deg s].

    Attributes:
        config: numbers of the model.
        mobility: (3, 3) inverse of the tensor of inertia, FRD [1/(kg m^2)].
    """

    config: EngineForcesConfig
    mobility: tuple[tuple[float, ...], ...]

    @property
    def memory(self) -> int:
        """Number of values that it keeps."""
        return 3 if self.config.command == "pose" else 0

    @property
    def commands(self) -> tuple[str, ...]:
        """Names of the set-points."""
        c = self.config
        given: tuple[str, ...] = {
            "thrusters": (
                *(f"fin_{i}" for i in range(len(c.fins))), *(f"thrust_{i}" for i in range(len(c.thrusters))),
            ),
            "pose": ("x", "y", "z", "roll", "pitch", "yaw"),
            "place": ("x", "y"),
        }[c.command]  # fmt: skip
        return (*given, "current_x", "current_y", "current_z") if c.current else given

    def start(self, flow: Flow) -> list[Array]:
        """No integral, no errors before."""
        return [0.0] * self.memory

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """Forces and moments over mass and inertia, and the engine's damping."""
        c = self.config
        given = list(command[: len(command) - 3]) if c.current else list(command)
        own = [command[-3], -command[-2], -command[-1]] if c.current else [0.0, 0.0, 0.0]
        water = add(matvec(flow.rotation, add(flow.nu[:3], minus(flow.nu_r[:3]))), own)  # NED
        force, moment = self._hull(flow, water)
        kept: list[Array] = []
        linear: Vector = [0.0, 0.0, 0.0]
        angular: Vector = [0.0, 0.0, 0.0]
        if c.command == "pose":
            linear, angular, kept = _pose_loops(c, memory, flow, given, h)
        else:
            thrusts = given[len(c.fins) :] if c.command == "thrusters" else _place_loops(c, flow, given)
            pushes = [self._thrust(flow, thrusts), *self._fins(flow, given[: len(c.fins)], water)]
            for push, turn in pushes:
                force, moment = add(force, matvec(flow.rotation, push)), add(moment, turn)
        turning = matvec(self.mobility, moment)
        linear = add(scaled(1 / c.mass_kg, force), linear)
        angular = add(matvec(flow.rotation, turning), angular)
        return Demand(acceleration=from_world(flow, linear, angular, h, c.damping_1_s, c.turn_damping_1_s)), kept

    def _wet(self, flow: Flow) -> Array:
        """Share of the box that is under water."""
        return dr.clip(0.5 + 0.5 * flow.immersion / self.config.half_height_m, 0.0, 1.0)

    def _hull(self, flow: Flow, water: Vector) -> tuple[list[Array], list[Array]]:
        """Weight, buoyancy and drag NED (3) [N]; moment of buoyancy about the centre of mass, body axes (3)."""
        c, wet = self.config, self._wet(flow)
        lift = c.density_kg_m3 * c.volume_m3 * GRAVITY * wet
        past = add(matvec(flow.rotation, flow.nu[:3]), minus(water))
        size = dr.sqrt(dot(past, past))
        drag = scaled(-0.5 * c.density_kg_m3 * c.drag_area_m2 * c.drag_share * wet * size, past)
        force = add([0.0, 0.0, c.mass_kg * GRAVITY - lift], drag)
        up = scaled(-lift, flow.down)
        return force, cross(c.center_of_buoyancy_m, up)

    def _thrust(self, flow: Flow, thrusts: Sequence[Array]) -> tuple[list[Array], list[Array]]:
        """Force and moment of the thrusters, body axes (3)."""
        push: list[Array] = [0.0, 0.0, 0.0]
        turn: list[Array] = [0.0, 0.0, 0.0]
        for thruster, wanted in zip(self.config.thrusters, thrusts, strict=True):
            size = self._under(flow, dr.clip(wanted, -thruster.limit_n, thruster.limit_n))
            one = scaled(size, thruster.direction)
            push, turn = add(push, one), add(turn, cross(thruster.position_m, one))
        return push, turn

    def _under(self, flow: Flow, value: Array) -> Array:
        """Of vehicles with fins, nothing where the centre of mass is above z = 0, whatever the tide."""
        return dr.select(flow.position[2] >= 0, value, 0.0) if self.config.fins else value

    def _fins(self, flow: Flow, angles: Sequence[Array], water: Vector) -> list[tuple[list[Array], list[Array]]]:
        """Force and moment of each fin, body axes (3): by the flow at the fin, in the plane in which it turns.

        Lift and drag are turned by angle and incidence together, where they should lie along the flow: so HoloOcean's
        goldens of both agents with fins say, to the last digit but one.
        """
        c = self.config
        past = add(flow.nu[:3], scaled(-FIN_CURRENT, matvec(transpose(flow.rotation), water)))
        wet = self._under(flow, 1.0 + 0 * past[0])
        found = []
        for fin, wanted in zip(c.fins, angles, strict=True):
            angle = dr.clip(wanted, -fin.limit_deg, fin.limit_deg) * (math.pi / 180)
            at = add(past, cross(flow.nu[3:], fin.position_m))
            sine, cosine, normal = dr.sin(angle), dr.cos(angle), dot(fin.lift, at)
            ahead, across = cosine * at[0] + sine * normal, cosine * normal - sine * at[0]
            incidence = dr.atan2(dr.mulsign(-across, ahead), dr.abs(ahead))
            pressure = FIN_SHARE * 0.5 * c.density_kg_m3 * FIN_AREA * (ahead * ahead + across * across)
            slope = FIN_SLOPE / (1 + FIN_SLOPE / FIN_ASPECT) * FIN_RADIAN * incidence
            lift = dr.mulsign(dr.clip(pressure * slope, -FIN_LIMIT_N, FIN_LIMIT_N), ahead)
            drag = dr.mulsign(dr.minimum(pressure * (FIN_DRAG + slope * slope / FIN_ASPECT), FIN_LIMIT_N), ahead)
            sine, cosine = dr.sin(angle + incidence), dr.cos(angle + incidence)
            side, back = lift * cosine - drag * sine, lift * sine + drag * cosine
            one = scaled(wet, add(scaled(side, fin.lift), [-back, 0.0, 0.0]))
            found.append((one, cross(fin.position_m, one)))
        return found


def _pose_loops(
    c: EngineForcesConfig, memory: Sequence[Array], flow: Flow, goal: Sequence[Array], h: Array
) -> tuple[list[Array], list[Array], list[Array]]:
    """Accelerations NED (3), (3) of HoloOcean's loops for a pose, and their memory.

    Position: P 100, D 50, each axis at most 1 m/s^2; angles in degrees: P 0.2, I 0.001, D 0.15, at most 1 rad/s^2; the
    moment of buoyancy is added as an angular acceleration.
    """
    velocity = matvec(flow.rotation, flow.nu[:3])
    at = [flow.position[i] for i in range(3)]
    wanted = [goal[0], -goal[1], -goal[2]]
    linear = [dr.clip(100 * (w - p) - 50 * v, -1.0, 1.0) for w, p, v in zip(wanted, at, velocity, strict=True)]
    now = [flow.roll, flow.pitch, flow.yaw]  # FRD in NED
    aims = [goal[3], -goal[4], -goal[5]]
    spin = flow.nu[3:]
    integral, turns = [], []
    for i in range(3):
        error = smallest_angle(aims[i] * (math.pi / 180) - now[i]) * (180 / math.pi)
        integral.append(dr.clip(memory[i] + h * error, -1e3, 1e3))
        turns.append(dr.clip(0.2 * error + 0.001 * integral[i] - 0.15 * (180 / math.pi) * spin[i], -1.0, 1.0))
    return linear, matvec(flow.rotation, turns), integral


def _place_loops(c: EngineForcesConfig, flow: Flow, goal: Sequence[Array]) -> list[Array]:
    """Thrusts (left, right) [N] of the loops of HoloOcean's surface vessel: 100 N/m of distance, 15 N m by degree of
    bearing with 7 N m s of rate, each at most 1000; split over arms of 1 m."""
    x, y = goal[0] - flow.position[0], -goal[1] - flow.position[1]
    pull = dr.clip(100 * dr.sqrt(x * x + y * y), 0.0, 1000.0)
    error = smallest_angle(dr.atan2(y, x) - flow.yaw)  # clockwise
    turn = dr.clip((15 * error - 7 * flow.nu[5]) * (180 / math.pi), -1000.0, 1000.0)
    return [0.5 * pull + 0.5 * turn, 0.5 * pull - 0.5 * turn]
