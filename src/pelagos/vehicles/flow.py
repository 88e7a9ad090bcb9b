"""Flow past a vehicle, as the terms of its model see it: attitude, velocity, and velocity relative to the water."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Literal, TypeAlias

import drjit as dr

from pelagos.hydro.algebra import Matrix, Vector, add, cross, dot, matvec, minus, total, transpose
from pelagos.hydro.images import Plane
from pelagos.jit import Array
from pelagos.vehicles.wetness import Wetness

CurrentRotation: TypeAlias = Literal["attitude", "heading"]
FAR_M: Final = 1e6
"""Distance of what is not there [m]."""
LEVEL: Final = 0.5
"""Part of a unit normal upwards, from which on a plane is ground: what is steeper than 60 degrees is a wall."""


@dataclass
class Supply:
    """voltage [V]; tables: of the thrusters, on the device."""

    voltage: Array
    tables: Any


@dataclass
class Seaway:
    """Waves at a hull: load, the wrench (6) of pressure, weight, diffraction and drift [N], [N m]; velocity (6) of the
    hull relative to the water of the waves, as a rigid sheet [m/s], [rad/s]; speed ahead through the water [m/s], where
    loads depend on it.
    """

    load: Vector
    velocity: Vector
    speed: Array | None = None


@dataclass
class Flow:
    """A vehicle in the water at one moment, components as lists (see `hydro.algebra`), NED and FRD.

    Attributes:
        position: of the body's origin, NED [m].
        immersion: how far it is below the water's surface, waves included [m].
        rotation: `(3, 3)`, FRD -> NED.
        nu: velocity over ground (6) [m/s], [rad/s].
        nu_r: velocity relative to the water (6), which turns with the line of water along the hull.
        current_rate: rate of change of the water's velocity in body axes (6) [m/s^2], [rad/s^2].
        supply: what feeds electric thrusters; None where nothing is fed.
        surface: roll and pitch at which a hull would lie level with the waves (2) [rad].
        actuators: states by name, limited; empty where no force is asked for.
        seaway: waves at a hull that floats, where pressure stands for its linear hydrostatics.
        air: velocity of the air over ground in body axes (3) [m/s] at a height above the surface [m]; None in a calm.
        heaviness: density of the water over that which the vehicle is ballasted for; None: the same.
        calm: load (6) of still water's pressure and weight on a hull that floats and is far from rest.
        far: how far a hull that floats is from rest, 0 to 1, see `wetness.Floating`.
        wet: how much of the hull is in the water; None: all coefficients hold everywhere.
        midway: what Coriolis forces are made of in the middle of the step (6), foreseen; None: as now.
        step: of the integration [s]; None where there is none.
        water_acceleration: of the water that goes along, and of the line of it along the hull, body axes (6) [m/s^2],
            [rad/s^2]; None where it is steady.
        wash: flow from ahead along the axis of the thruster that looks, which jets of others bring [m/s]; None: none.
        planes: near the vehicle, where a term feels them; empty: all are far.
        growth: of the mass matrix by what comes aboard in a step `(6, 6)` a second; None: nothing does.
    """

    position: Vector
    immersion: Array
    rotation: Matrix
    nu: Vector
    nu_r: Vector
    current_rate: Vector
    supply: Supply | None = None
    surface: Vector = (0.0, 0.0)
    actuators: Mapping[str, Array] = field(default_factory=dict)
    seaway: Seaway | None = None
    air: Callable[[float], Vector] | None = None
    heaviness: Array | None = None
    water_acceleration: Vector | None = None
    calm: Vector | None = None
    far: Array = 0.0
    wet: Wetness | None = None
    midway: Vector | None = None
    step: Array | None = None
    wash: Array | None = None
    growth: Matrix | None = None
    planes: Sequence[Plane] = ()

    @property
    def nu_c(self) -> list[Array]:
        """Velocity that Coriolis forces are made of (6): relative to the water, and the body's own rates of turn."""
        return [*self.nu_r[:3], *self.nu[3:]]

    @property
    def depth(self) -> Array:
        """Of the water at the vehicle, from its surface to the nearest ground among the planes [m]; far where there is
        none.
        """
        return self._ground[0]

    @property
    def depth_gradient(self) -> list[Array]:
        """Slope of `depth` by the place over ground, horizontal, body axes (3) [-]; 0 where no ground is near."""
        return self._ground[1]

    @property
    def _ground(self) -> tuple[Array, list[Array]]:
        """`depth` and its gradient; what nobody asks for is not computed."""
        depth: Array = FAR_M
        gradient: list[Array] = [0.0] * 3
        for plane in self.planes:
            up = -1.0 * dot(plane.normal, self.down)
            flat = dr.maximum(up, LEVEL)
            below = plane.distance / flat + self.immersion
            nearer = (up > LEVEL) & (below < depth)
            depth = dr.select(nearer, below, depth)
            slopes = (n / flat + d for n, d in zip(plane.normal, self.down, strict=True))
            gradient = [dr.select(nearer, new, old) for new, old in zip(slopes, gradient, strict=True)]
        return depth, gradient

    @property
    def down(self) -> list[Array]:
        """The direction of gravity in body axes (3)."""
        return list(self.rotation[2])

    @property
    def roll(self) -> Array:
        """[rad]."""
        return dr.atan2(self.rotation[2][1], self.rotation[2][2])

    @property
    def pitch(self) -> Array:
        """[rad]; the angle, not its clipped sine, so that its gradient is finite when the nose stands up."""
        return dr.atan2(-self.rotation[2][0], dr.sqrt(self.rotation[2][1] ** 2 + self.rotation[2][2] ** 2))

    @property
    def yaw(self) -> Array:
        """Compass heading [rad], -pi .. pi."""
        return dr.atan2(self.rotation[1][0], self.rotation[0][0])


def make_flow(
    position: Vector,
    rotation: Matrix,
    nu: Vector,
    current: Vector,
    *,
    current_rotation: CurrentRotation = "attitude",
    elevation: Array = 0.0,
    acceleration: Vector | None = None,
    surface: Vector = (0.0, 0.0),
    turning: Vector = (0.0, 0.0, 0.0),
    turning_rate: Vector = (0.0, 0.0, 0.0),
) -> Flow:
    """The flow past a vehicle in a current (3) NED [m/s] that changes with `acceleration` (3) NED [m/s^2].

    `current_rotation`: into body axes with the whole attitude, or, as Fossen's programs do, with the heading alone
    (right only while roll and pitch are small). `elevation`: of the surface above the vehicle, upwards [m]; `surface`:
    see `Flow`. `turning`, `turning_rate`: angular velocity and acceleration of the water along the hull, body axes (3)
    [rad/s], [rad/s^2].
    """
    w = nu[3:]
    if current_rotation == "attitude":
        in_body = matvec(transpose(rotation), current)
        rate = minus(cross(w, in_body))
    else:
        cos, sin = rotation[0][0], rotation[1][0]
        size = dr.sqrt(cos * cos + sin * sin)
        cos, sin = cos / size, sin / size
        in_body = [current[0] * cos + current[1] * sin, current[1] * cos - current[0] * sin, current[2]]
        rate = [w[2] * in_body[1], -w[2] * in_body[0], 0.0]
    own: list[Array] | None = None
    if acceleration is not None:
        own = [*matvec(transpose(rotation), acceleration), *turning_rate]
        rate = add(rate, own[:3])
    nu_r = [nu[0] - in_body[0], nu[1] - in_body[1], nu[2] - in_body[2], *add(w, minus(turning))]
    immersion = total(position[2], elevation)
    rates = [*rate, *turning_rate]
    return Flow(
        list(position), immersion, rotation, list(nu), nu_r, rates, surface=list(surface), water_acceleration=own
    )


def rotation_from_euler(roll: Array, pitch: Array, yaw: Array) -> list[list[Array]]:
    """R = Rz(yaw) Ry(pitch) Rx(roll)."""
    (sr, cr), (sp, cp), (sy, cy) = dr.sincos(roll), dr.sincos(pitch), dr.sincos(yaw)
    return [
        [cy * cp, cy * sp * sr - sy * cr, sy * sr + cy * cr * sp],
        [sy * cp, cy * cr + sr * sp * sy, sp * sy * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
