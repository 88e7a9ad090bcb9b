"""Flying a vehicle alone: `Vehicle.step` in one symbolic loop, as the simulator does it."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.math.frames import flip_quaternion_np, flip_yz_np


@dataclass
class Still:
    """An ocean with one uniform current, and a wind, NWU [m/s]."""

    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    breeze: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def wind(self, position, t):
        return jit.Array3f64(*self.breeze)

    def current(self, position, t, copy=None):
        return jit.Array3f64(*self.velocity)

    def elevation(self, x, y, t):
        return jit.Float64(0.0)


@dataclass
class Shear:
    """A northward current that grows towards the west [1/s], and a vertical one that grows northwards."""

    rate: float = 0.0

    def current(self, position, t, copy=None):
        return jit.Array3f64(0.0, self.rate * position[0], 0.0)

    def elevation(self, x, y, t):
        return jit.Float64(0.0)


@dataclass
class Flight:
    """Everything in NED and FRD, `(steps + 1, ...)`; angles of attitude as quaternions."""

    t: np.ndarray
    position: np.ndarray
    attitude: np.ndarray
    nu: np.ndarray
    actuators: np.ndarray

    @property
    def euler(self) -> np.ndarray:
        w, x, y, z = self.attitude.T
        roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
        pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1, 1))
        yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
        return np.stack([roll, pitch, yaw], axis=-1)


def quaternion(roll=0.0, pitch=0.0, yaw=0.0) -> np.ndarray:
    """FRD -> NED (4,)."""
    cr, sr, cp, sp, cy, sy = (f(a / 2) for a in (roll, pitch, yaw) for f in (np.cos, np.sin))
    return np.array([
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ])  # fmt: skip


def fly(
    vehicle,
    seconds: float,
    *,
    h: float = 0.02,
    mode: str | None = None,
    command=None,
    position=(0.0, 0.0, 50.0),
    attitude=(1.0, 0.0, 0.0, 0.0),
    nu=(0.0,) * 6,
    ocean=None,
    force=(0.0, 0.0, 0.0),
    moment=(0.0, 0.0, 0.0),
    actuators=None,
) -> Flight:
    """One vehicle from NED `position`, FRD -> NED `attitude`, `nu`; command and wrench (FRD) constant."""
    mode = mode or vehicle.default_mode
    names = vehicle.command_names(mode)
    command = [0.0] * len(names) if command is None else command
    nu = np.asarray(nu, dtype=float)
    state = vehicle.initial_state(
        flip_yz_np(np.array([position], dtype=float)),
        flip_quaternion_np(np.array([attitude], dtype=float)),
        flip_yz_np(nu[None, :3]),
        flip_yz_np(nu[None, 3:]),
    )
    if actuators is not None:
        state.actuators = [jit.Float64(float(a)) for a in actuators]
    steps = round(seconds / h)
    k = len(vehicle.actuator_names)
    width = 13 + k
    out = dr.zeros(jit.Float64, (steps + 1) * width)
    wrench = (jit.Array3f64(*map(float, force)), jit.Array3f64(*map(float, moment)))
    setpoint = [jit.Float64(float(c)) for c in command]
    dr.make_opaque(wrench, setpoint, state)  # data, not program: other values need no other kernel

    def keep(i, s):
        row = [*s.position, *s.attitude, *s.velocity, *s.angular_velocity, *s.actuators[:k]]
        for c, value in enumerate(row):
            dr.scatter(out, jit.Float64(value), i * width + c)

    def body(i, s):
        keep(i, s)
        t = jit.Float64(i) * h
        return i + 1, vehicle.step(s, setpoint, ocean, t, wrench, jit.Float64(h), mode)

    i, state = dr.while_loop((dr.zeros(jit.UInt32, 1), state), lambda i, s: i < steps, body, mode="symbolic")
    dr.eval(i, state)  # once: every scatter below would be a kernel of its own that repeats the loop
    keep(i, state)
    rows = np.array(out).reshape(-1, width)
    return Flight(np.arange(steps + 1) * h, rows[:, :3], rows[:, 3:7], rows[:, 7:13], rows[:, 13:])
