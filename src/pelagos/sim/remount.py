"""Sensors whose place on the vehicle differs from copy to copy: they see the motion of a body that stands for theirs.

A sensor with the place r0 and the rotation q0, moved to r1 and q1, sees what it would see on a body at o = r1 - R(d) r0
in the true one, turned by d = q1 q0*. So every kind of sensor follows; its frame and tables stay as the scenario writes
them, like a calibration that does not know better. Rigid-body kinematics as in `sensors.mount`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.rotation import conjugate, product
from pelagos.math.so3 import multiply, rotate, rotate_back, rotate_np
from pelagos.sensors.sensor import Kinematics, SensorConfig
from pelagos.sim.set_points import vectors


def remount(config: SensorConfig, position: NDArray[np.float64], orientation: NDArray[np.float64]) -> list[Array]:
    """Offsets `Array3f64` (n) FLU [m] and turns `Array4f64` (n) of the bodies that stand for those of a moved sensor.

    Args:
        config: the sensor as the scenario writes it.
        position: `(n, 3)` of the sensor, FLU [m].
        orientation: `(n, 3)` roll, pitch, yaw [deg].
    """
    new = [config.model_copy(update={"orientation_deg": tuple(o)}).q_body_sensor for o in orientation.tolist()]
    back = conjugate(np.array(config.q_body_sensor))
    turn = product(np.array(new), np.tile(back, (len(new), 1)))
    offset = position - rotate_np(turn, np.tile(config.position_m, (len(new), 1)))
    return [vectors(offset), jit.Array4f64(*(jit.from_numpy(jit.Float64, column) for column in turn.T))]


def moved(motion: Kinematics, offset: Array, turn: Array) -> Kinematics:
    """The motion of the bodies that stand for it; `offset` and `turn` by copy, see `remount`."""
    return _recorded()(motion, offset, turn)


@cache
def _recorded() -> Callable[..., Kinematics]:
    return jit.freeze(_moved)


def _moved(motion: Kinematics, offset: Array, turn: Array) -> Kinematics:
    o, d = dr.gather(jit.Array3f64, offset, motion.copy), dr.gather(jit.Array4f64, turn, motion.copy)
    w, spin_up = motion.angular_velocity, motion.angular_acceleration
    around = dr.cross(w, o)
    return replace(
        motion,
        position=motion.position + rotate(motion.attitude, o),
        attitude=multiply(motion.attitude, d),
        velocity=rotate_back(d, motion.velocity + around),
        angular_velocity=rotate_back(d, w),
        acceleration=rotate_back(d, motion.acceleration + dr.cross(spin_up, o) + dr.cross(w, around)),
        angular_acceleration=rotate_back(d, spin_up),
    )
