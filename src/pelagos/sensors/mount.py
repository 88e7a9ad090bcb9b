"""Pose and motion of a sensor, from the motion of the body that carries it.

Rigid-body kinematics, e.g. T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021),
Chapters 2 and 14. The sensor frame is forward-left-up of the mount: p_world = p_body + R(q) r, q_sensor = q
q_body_sensor.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Protocol

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.constants import GRAVITY
from pelagos.math.so3 import integrate, multiply, rotate, rotate_back

if TYPE_CHECKING:
    from pelagos.sensors.sensor import Kinematics


class Mounted(Protocol):
    """Whatever has a place on a vehicle: a sensor's configuration, or the place alone."""

    @property
    def position_m(self) -> tuple[float, float, float]:
        """In the body frame FLU [m]."""

    @property
    def q_body_sensor(self) -> tuple[float, float, float, float]:
        """Its frame in the body frame, (w, x, y, z)."""


def sensor_pose(motion: Kinematics, config: Mounted) -> tuple[Array, Array]:
    """World position `Array3f64` NWU [m] and attitude `Array4f64` (sensor frame to world) of the mount."""
    position = motion.position + rotate(motion.attitude, _arm(config))
    return position, multiply(motion.attitude, _turn(config))


def sensor_velocity(motion: Kinematics, config: Mounted) -> Array:
    """Velocity over ground of the mount in the sensor frame, `Array3f64` [m/s]: v + w x r."""
    return to_sensor(motion.velocity + dr.cross(motion.angular_velocity, _arm(config)), config)


def sensor_angular_velocity(motion: Kinematics, config: Mounted) -> Array:
    """Angular velocity in the sensor frame, `Array3f64` [rad/s]."""
    return to_sensor(motion.angular_velocity, config)


def specific_force(motion: Kinematics, config: Mounted, gravity: float = GRAVITY) -> Array:
    """Specific force at the mount, as an accelerometer feels it, `Array3f64` [m/s^2]: a + w' x r + w x (w x r) - g.

    At rest and level it is (0, 0, +gravity).
    """
    arm, w = _arm(config), motion.angular_velocity
    up = jit.Array3f64(0, 0, gravity)
    a = motion.acceleration + dr.cross(motion.angular_acceleration, arm) + dr.cross(w, dr.cross(w, arm))
    return to_sensor(a + rotate_back(motion.attitude, up), config)


def to_sensor(vector: Array, config: Mounted) -> Array:
    """A body vector seen from the sensor."""
    return rotate_back(_turn(config), vector)


def _arm(config: Mounted) -> Array:
    return jit.Array3f64(*config.position_m)


def _turn(config: Mounted) -> Array:
    return jit.Array4f64(*config.q_body_sensor)


def pose_after(motion: Kinematics, time: float | Array) -> Kinematics:
    """The pose `time` [s] later if the vehicle moves evenly; times and ticks stay."""
    attitude = integrate(motion.attitude, motion.angular_velocity, jit.Float64(time))
    return replace(
        motion, position=motion.position + rotate(motion.attitude, motion.velocity) * time, attitude=attitude
    )
