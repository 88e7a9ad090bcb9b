"""Forces of a ship by van Berlekom and Goddard: hull, propeller and rudder per unit of mass, in deep and shallow water.

Source of all: W. B. van Berlekom, T. A. Goddard, "Maneuvering of large tankers", Trans. SNAME 80:264 (1972), Appendix
A; as T. I. Fossen's MSS toolbox has it (`tanker.m`, MIT). Derivatives are in Norrbin's bis system: by mass, length and
gravity, velocities and angles as they are. For ships of one propeller and one rudder, ahead, amidships, FRD.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos.hydro.algebra import Vector
from pelagos.jit import Array

HULL_NAMES: Final = (
    "Xuu", "Xvv", "Xvr", "Xccdd", "Xccbd", "Xuuz", "Xvrz", "Xvvzz", "Yuv", "Yvv", "Yur", "Yccd", "Yccbbd", "YT", "Yurz",
    "Yvvz", "Yccbbdz", "Nuv", "Nvr", "Nur", "Nccd", "Nccbbd", "NT", "Nurz", "Nuvz", "Nvrz", "Nccbbdz",
)  # fmt: skip
"""u, v, r: surge, sway, yaw rate; c: flow past the rudder; b: drift angle; d: rudder angle; T: thrust; z: draught over
the water under the keel. Xvr, Yur and Nur are hydrodynamic: without the rigid body's own inertia."""
PROPELLER_NAMES: Final = ("Tuu", "Tun", "Tnn", "cun", "cnn")
"""Thrust, and the square of the flow past the rudder, by speed u and revolutions n."""
_SHALLOW_FROM: Final = 0.8
"""Draught over the water under the keel from which a sway force of its own appears (A. `Yuvz`)."""
_SHALLOW_SWAY: Final = -0.85
"""Its derivative in the shallowest water."""


@dataclass(frozen=True)
class BisShip:
    """mass [kg]; length [m]; shallow: draught over the water under the keel [-], 0 in deep water; slow: speed ahead
    below which the drift angle is no longer taken against the speed [m/s].
    """

    mass: Array
    length: Array
    shallow: Array
    slow: Array


def thrust_by_mass(c: Mapping[str, Array], length: Array, u: Array, n: Array) -> Array:
    """Thrust over mass [m/s^2] at a speed u [m/s] and revolutions n [1/s] of the propeller."""
    return c["Tuu"] * u * u / length + c["Tun"] * u * n + length * c["Tnn"] * dr.abs(n) * n


def race_squared(c: Mapping[str, Array], u: Array, n: Array) -> Array:
    """Square of the flow past the rudder [m^2/s^2], never below 0."""
    return dr.maximum(c["cun"] * u * n + c["cnn"] * n * n, 0.0)


def sway_in_shallow_water(shallow: Array) -> Array:
    """Y_uvz: 0 while more than 1.25 draughts of water are under the keel."""
    return _SHALLOW_SWAY * (1 - _SHALLOW_FROM / dr.maximum(shallow, _SHALLOW_FROM))


def ship_force(
    ship: BisShip,
    hull: Mapping[str, Array],
    propeller: Mapping[str, Array],
    motion: tuple[Array, Array, Array],
    rudder: Array,
    revolutions: Array,
) -> Vector:
    """X, Y [N] and N [N m] of hull, propeller and rudder, without the rigid body's inertia.

    Args:
        ship: its size.
        hull: derivatives by `HULL_NAMES`; propeller: by `PROPELLER_NAMES`, and the thrust deduction "t".
        motion: u, v amidships [m/s], r [rad/s], through the water.
        rudder: angle [rad], positive where its trailing edge is to starboard, so that the ship turns to port.
        revolutions: of the propeller [1/s].
    """
    u, v, r = motion
    length, z = ship.length, ship.shallow
    drift = dr.atan2(v, dr.maximum(u, ship.slow))
    thrust = length * thrust_by_mass(propeller, length, u, revolutions)
    cc = race_squared(propeller, u, revolutions)
    lift, steep = cc * rudder, cc * dr.abs(drift) * drift * dr.abs(rudder)
    uv, ur, vv, vr, drag = u * v, length * u * r, dr.abs(v) * v, length * dr.abs(v) * r, dr.abs(u) * u
    x = (
        (hull["Xuu"] + hull["Xuuz"] * z) * drag + (hull["Xvv"] + hull["Xvvzz"] * z * z) * v * v
        + (hull["Xvr"] + hull["Xvrz"] * z) * length * v * r + hull["Xccdd"] * lift * rudder
        + hull["Xccbd"] * lift * drift + (1 - propeller["t"]) * thrust
    )  # fmt: skip
    y = (
        (hull["Yuv"] + sway_in_shallow_water(z) * z) * uv + (hull["Yvv"] + hull["Yvvz"] * z) * vv
        + (hull["Yur"] + hull["Yurz"] * z) * ur + hull["Yccd"] * lift
        + (hull["Yccbbd"] + hull["Yccbbdz"] * z) * steep + hull["YT"] * thrust
    )  # fmt: skip
    n = (
        (hull["Nuv"] + hull["Nuvz"] * z) * uv + (hull["Nvr"] + hull["Nvrz"] * z) * vr
        + (hull["Nur"] + hull["Nurz"] * z) * ur + hull["Nccd"] * lift
        + (hull["Nccbbd"] + hull["Nccbbdz"] * z) * steep + hull["NT"] * thrust
    )  # fmt: skip
    return [ship.mass / length * x, ship.mass / length * y, ship.mass * n]
