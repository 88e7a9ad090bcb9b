"""Measurements of an error-state filter: what each sensor should read, and how that depends on the errors.

Every function returns the Jacobian `(n, k, 22)` and the innovation `(n, k)`. Levers are from the inertial unit, body
FLU [m]; `turn`: `(3, 3)`, sensor vectors to body vectors. Source: see `error_state`; lever arms: T. I. Fossen, Handbook
of Marine Craft Hydrodynamics and Motion Control, 2nd ed. (2021), Section 14.1.
"""

from __future__ import annotations

import numpy as np

from pelagos.math.rotation import Floats, apply, skew
from pelagos.math.so3 import cross_np, matrix_np
from pelagos.navigation.error_state import (
    ATTITUDE,
    DEPTH,
    GYROSCOPE,
    MAGNETOMETER,
    POSITION,
    SATELLITE,
    SIZE,
    VELOCITY,
    Lanes,
)

Expected = tuple[Floats, Floats]


def bottom_velocity(lanes: Lanes, measured: Floats, lever: Floats, turn: Floats) -> Expected:
    """Velocity over ground `(n, 3)` [m/s] of a DVL, in its own frame."""
    world = matrix_np(lanes.attitude)
    back = np.swapaxes(world, 1, 2)
    own = apply(back, lanes.velocity)
    arm = np.broadcast_to(lever, own.shape)
    h = np.zeros((len(own), 3, SIZE))
    h[:, :, VELOCITY] = turn.T @ back
    h[:, :, ATTITUDE] = turn.T @ skew(own)
    h[:, :, GYROSCOPE] = turn.T @ skew(arm)
    return h, measured - apply(turn.T, own + cross_np(lanes.rate, arm))


def satellite_position(lanes: Lanes, measured: Floats, lever: Floats) -> Expected:
    """Position `(n, 3)` NWU [m] of an antenna, slow error included."""
    world = matrix_np(lanes.attitude)
    arm = np.broadcast_to(lever, lanes.position.shape)
    h = np.zeros((len(world), 3, SIZE))
    h[:, :, POSITION] = np.eye(3)
    h[:, :, ATTITUDE] = -world @ skew(arm)
    h[:, :, SATELLITE] = np.eye(3)
    return h, measured - (lanes.position + apply(world, arm) + lanes.slow[:, :3])


def depth(lanes: Lanes, measured: Floats, lever: Floats) -> Expected:
    """Depth `(n,)` [m] of a pressure gauge, offset included."""
    world = matrix_np(lanes.attitude)
    arm = np.broadcast_to(lever, lanes.position.shape)
    h = np.zeros((len(world), 1, SIZE))
    h[:, 0, 2] = -1.0
    h[:, :, ATTITUDE] = (world @ skew(arm))[:, 2:3]
    h[:, 0, DEPTH] = 1.0
    expected = -(lanes.position[:, 2] + apply(world, arm)[:, 2]) + lanes.slow[:, 3]
    return h, (measured - expected)[:, None]


def magnetic_field(lanes: Lanes, measured: Floats, field: Floats, turn: Floats) -> Expected:
    """Magnetic flux density `(n, 3)` [T] in the sensor's frame, own iron taken off; field: the Earth's, NWU [T]."""
    own = apply(np.swapaxes(matrix_np(lanes.attitude), 1, 2), np.broadcast_to(field, lanes.position.shape))
    h = np.zeros((len(own), 3, SIZE))
    h[:, :, ATTITUDE] = turn.T @ skew(own)
    h[:, :, MAGNETOMETER] = np.eye(3)
    return h, measured - (apply(turn.T, own) + lanes.slow[:, 4:7])


def curvature(lanes: Lanes, field: Floats) -> Floats:
    """Variance `(n,)` [T^2] that the attitude's uncertainty adds to a field's direction beyond its linear part.

    Second-order filter, variance of a quadratic form: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, Estimation with
    Applications to Tracking and Navigation (2001), Section 10.3.2; here its upper bound 1/2 (|B| tr P)^2.
    """
    spread = np.trace(lanes.covariance[:, ATTITUDE, ATTITUDE], axis1=1, axis2=2)
    return np.asarray(0.5 * (field @ field) * spread**2)


def beacon_range(lanes: Lanes, measured: Floats, lever: Floats, beacon: Floats) -> Expected:
    """Distance `(n,)` [m] to a beacon at a known place, NWU [m]."""
    world = matrix_np(lanes.attitude)
    arm = np.broadcast_to(lever, lanes.position.shape)
    apart = lanes.position + apply(world, arm) - beacon
    distance = np.sqrt((apart**2).sum(axis=-1))
    unit = apart / np.maximum(distance, 1e-6)[:, None]
    h = np.zeros((len(world), 1, SIZE))
    h[:, 0, POSITION] = unit
    h[:, :, ATTITUDE] = -unit[:, None, :] @ world @ skew(arm)
    return h, (measured - distance)[:, None]


def beacon_place(lanes: Lanes, measured: Floats, lever: Floats, turn: Floats, beacon: Floats, age: Floats) -> Expected:
    """Place `(n, 3)` [m] of a beacon in the sensor's own frame, as an array finds it.

    beacon: `(n, 3)` NWU [m]; age: `(n,)` since the answer was sent, in which the vehicle went on [s].
    """
    back = np.swapaxes(matrix_np(lanes.attitude), 1, 2)
    own = apply(back, beacon - lanes.position + age[:, None] * lanes.velocity)
    h = np.zeros((len(own), 3, SIZE))
    h[:, :, POSITION] = -turn.T @ back
    h[:, :, VELOCITY] = age[:, None, None] * (turn.T @ back)
    h[:, :, ATTITUDE] = turn.T @ skew(own)
    return h, measured - apply(turn.T, own - lever)
