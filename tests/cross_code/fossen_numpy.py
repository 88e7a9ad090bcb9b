"""The equations of Fossen's programs for REMUS 100, torpedo and Otter in plain NumPy, one vehicle, one step.

Written from the description of the reference data, not from any program: it shares nothing with the package, so that
states for which nobody recorded numbers can be compared too. Angles [rad], NED and FRD.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

G, DENSITY = 9.81, 1026.0
HOERNER = (
    (0.0109, 0.1766, 0.353, 0.4519, 0.4728, 0.4929, 0.4933, 0.5585, 0.6464, 0.8336,
     0.988, 1.3081, 1.6392, 1.86, 2.3129, 2.6, 3.0088, 3.4508, 3.7379, 4.0031),
    (1.9661, 1.9657, 1.8976, 1.7872, 1.5837, 1.2786, 1.2108, 1.0836, 0.9986, 0.8796,
     0.8284, 0.7599, 0.6914, 0.6571, 0.6307, 0.5962, 0.5868, 0.5859, 0.5599, 0.5593),
)  # fmt: skip


def skew(a: np.ndarray) -> np.ndarray:
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def shift(r: np.ndarray) -> np.ndarray:
    h = np.eye(6)
    h[:3, 3:] = skew(r).T
    return h


def rotation(roll: float, pitch: float, yaw: float) -> np.ndarray:
    (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return z @ y @ x


def euler_rates(roll: float, pitch: float) -> np.ndarray:
    c, s, t = np.cos(roll), np.sin(roll), np.tan(pitch)
    return np.array([[1, s * t, c * t], [0, c, -s], [0, s / np.cos(pitch), c / np.cos(pitch)]])


def coriolis(m: np.ndarray, nu: np.ndarray) -> np.ndarray:
    p = m @ nu
    zero = np.zeros((3, 3))
    return np.block([[zero, -skew(p[:3])], [-skew(p[:3]), -skew(p[3:])]])


def current_in_body(current: np.ndarray, yaw: float, r: float) -> tuple[np.ndarray, np.ndarray]:
    speed, towards = np.hypot(current[0], current[1]), np.arctan2(current[1], current[0])
    u, v = speed * np.cos(towards - yaw), speed * np.sin(towards - yaw)
    return np.array([u, v, 0, 0, 0, 0]), np.array([r * v, -r * u, 0, 0, 0, 0])


def cross_flow(length: float, beam: float, draught: float, nu_r: np.ndarray) -> np.ndarray:
    cd = np.interp(beam / (2 * draught), *HOERNER)
    dx = length / 20
    x = -length / 2 + dx * np.arange(21)
    across = nu_r[1] + x * nu_r[5]
    f = 0.5 * 1026 * draught * cd * np.abs(across) * across * dx
    return np.array([0, -f.sum(), 0, 0, 0, -(x * f).sum()])


def propeller(n: float, nu: np.ndarray) -> np.ndarray:
    d, n = 0.14, n / 60
    advance = 0.944 * np.linalg.norm(nu[:3])
    loads = []
    for power, rest, limit in ((4, 0.4566, 0.1798), (5, 0.0700, 0.0312)):
        load = rest * abs(n) * n
        if n > 0:
            load += (limit - rest) / 0.6632 * advance / d * abs(n)
        loads.append(DENSITY * d**power * load)
    return np.array([0.9 * loads[0], 0, 0, loads[1] / 10, 0, 0])


def hull_of_the_remus(eta: np.ndarray, nu: np.ndarray, current: np.ndarray, push: Callable) -> np.ndarray:
    """nu_dot; `push(nu_r)` is the wrench of the actuators."""
    a, b, r_g = 0.8, 0.095, np.array([0, 0, 0.02])
    mass = 4 / 3 * np.pi * DENSITY * a * b * b
    ix, iy = 2 / 5 * mass * b * b, mass / 5 * (a * a + b * b)
    h = shift(r_g)
    rigid = h.T @ np.diag([mass, mass, mass, ix, iy, iy]) @ h
    e = np.sqrt(1 - (b / a) ** 2)
    log = np.log((1 + e) / (1 - e))
    alpha, beta = 2 * (1 - e**2) / e**3 * (log / 2 - e), 1 / e**2 - (1 - e**2) / (2 * e**3) * log
    k1, k2 = alpha / (2 - alpha), beta / (2 - beta)
    k3 = e**4 * (beta - alpha) / ((2 - e**2) * (2 * e**2 - (2 - e**2) * (beta - alpha)))
    added = np.diag([mass * k1, mass * k2, mass * k2, 0.3 * ix, k3 * iy, k3 * iy])
    m = rigid + added

    nu_c, rate = current_in_body(current, eta[5], nu[5])
    nu_r = nu - nu_c
    speed = np.linalg.norm(nu_r[:3])
    c_added = coriolis(added, nu_r)
    for row, column in ((5, 1), (5, 3), (6, 1), (6, 2)):
        c_added[row - 1, column - 1] = c_added[column - 1, row - 1] = 0
    w_roll, w_pitch = np.sqrt(0.02 * mass * G / m[3, 3]), np.sqrt(0.02 * mass * G / m[4, 4])
    fade = np.exp(-3 * speed)
    d = np.diag(m) * [fade / 20, fade / 20, 1 / 20, 0.6 * w_roll, 1.6 * w_pitch, 1]

    area = 0.7 * 1.6 * 0.19
    aspect = 0.19**2 / area
    angle = np.arctan2(nu_r[2], nu_r[0])
    cl = angle * np.pi * aspect / (1 + np.sqrt(1 + (aspect / 2) ** 2))
    cd = 0.42 * np.pi * b * b / area + cl**2 / (0.7 * np.pi * aspect)
    q = 0.5 * 1026 * speed**2 * area
    lift_drag = np.zeros(6)
    lift_drag[0] = q * (cl * np.sin(angle) - cd * np.cos(angle))
    lift_drag[2] = -q * (cd * np.sin(angle) + cl * np.cos(angle))

    restoring = 0.02 * mass * G * np.array([0, 0, 0, np.cos(eta[4]) * np.sin(eta[3]), np.sin(eta[4]), 0])
    forces = push(nu_r) + lift_drag + cross_flow(1.6, 0.19, 0.19, nu_r) - restoring
    forces -= (coriolis(rigid, nu_r) + c_added) @ nu_r + d * nu_r
    return rate + np.linalg.solve(m, forces)


def remus(eta, nu, act, current):
    rudder, plane, n = np.clip(act, *REMUS.limits)

    def push(nu_r):
        u, v, w = nu_r[:3]
        horizontal, vertical = 0.5 * DENSITY * (u * u + v * v) * 0.0133, 0.5 * DENSITY * (u * u + w * w) * 0.0133
        y, z = -horizontal * 0.5 * rudder, -vertical * 0.7 * plane
        x = -horizontal * 0.5 * rudder**2 - vertical * 0.7 * plane**2
        return np.array([x, y, z, 0, 0.8 * z, -0.8 * y]) + propeller(n, nu)

    return hull_of_the_remus(eta, nu, current, push)


def torpedo(eta, nu, act, current):
    def push(nu_r):
        load = propeller(np.clip(act[4], -1525, 1525), nu)
        for deflection, degrees, slope in zip(act, (270, 90, 180, 0), (0.5, 0.5, 0.7, 0.7), strict=False):
            c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
            square = nu_r[0] ** 2 + (nu_r[1] * s) ** 2 + (nu_r[2] * c) ** 2
            f = 0.5 * DENSITY * 0.00665 * slope * deflection * square
            force = np.array([0, f * s, -f * c])
            load = load + np.concatenate([force, np.cross([-0.8, 0.1 * c, 0.1 * s], force)])
        return load

    return hull_of_the_remus(eta, nu, current, push)


def otter(eta, nu, act, current):
    density, length, beam, pontoon, y_p, cw, cb = 1025.0, 2.0, 1.08, 0.25, 0.395, 0.75, 0.4
    r_h, r_p = np.array([0.2, 0, -0.2]), np.array([0.05, 0, -0.35])
    r_g = (55 * r_h + 25 * r_p) / 80
    radii = np.diag([(0.4 * beam) ** 2, (length / 4) ** 2, (length / 4) ** 2])
    inertia = 55 * radii - 55 * skew(r_g) @ skew(r_g) - 25 * skew(r_p) @ skew(r_p)
    h = shift(r_g)
    about_cg = np.zeros((6, 6))
    about_cg[:3, :3], about_cg[3:, 3:] = 80 * np.eye(3), inertia
    rigid = h.T @ about_cg @ h
    added = np.diag([5.5, 82.5, 55, 0.2 * inertia[0, 0], 0.8 * inertia[1, 1], 1.7 * inertia[2, 2]])
    m = rigid + added

    draught = 80 / density / (2 * cb * pontoon * length)
    area, volume = cw * length * pontoon, 80 / density
    i_t = (2 / 12) * length * pontoon**3 * 6 * cw**3 / ((1 + cw) * (1 + 2 * cw)) + 2 * area * y_p**2
    i_l = 0.8 * (2 / 12) * pontoon * length**3
    kb, kg = (5 * draught / 2 - volume / (2 * length * pontoon)) / 3, draught - r_g[2]
    gm_t, gm_l = kb + i_t / volume - kg, kb + i_l / volume - kg
    g_cf = np.diag([0, 0, 2 * density * G * area, density * G * volume * gm_t, density * G * volume * gm_l, 0])
    at_lcf = shift(np.array([-0.2, 0, 0]))
    stiffness = at_lcf.T @ g_cf @ at_lcf
    w3, w4, w5 = np.sqrt(np.diag(g_cf)[2:5] / np.diag(m)[2:5])
    d = np.diag(m) * [0, 1, 0.6 * w3, 0.4 * w4, 0.8 * w5, 1]
    d[0] = 24.4 * G / (6 * 0.5144)

    nu_c, rate = current_in_body(current, eta[5], nu[5])
    nu_r = nu - nu_c
    middle = np.zeros((6, 6))
    middle[:3, :3], middle[3:, 3:] = 80 * skew(nu[3:]), -skew(inertia @ nu[3:])
    c = h.T @ middle @ h + coriolis(added, nu_r)
    n = np.clip(act, *OTTER.limits)
    thrust = np.where(n > 0, 0.01108, 0.006445) * n * np.abs(n)
    forces = np.array([thrust.sum(), 0, 0, 0, 0, 0.395 * (thrust[0] - thrust[1])])
    forces += cross_flow(length, pontoon, draught, nu_r) - c @ nu_r - d * nu_r - stiffness @ eta
    forces[5] -= 10 * d[5] * abs(nu_r[5]) * nu_r[5]
    weight = rotation(*eta[3:]).T @ [0, 0, 25 * G]
    forces += np.concatenate([weight, np.cross(r_p, weight)])
    return rate + np.linalg.solve(m, forces)


@dataclass(frozen=True)
class Reference:
    """nu_dot(eta, nu, act, current) as above; limits and time constants of the actuators.

    clip: for each actuator, what its limits act on: the state before its use and its lag ("before"), the state that
    the lag returns ("after"), or the value that makes the force, alone ("force").
    """

    nu_dot: Callable
    low: tuple[float, ...]
    high: tuple[float, ...]
    lag: tuple[float, ...]
    clip: tuple[str, ...]

    @property
    def limits(self) -> tuple[np.ndarray, np.ndarray]:
        return np.array(self.low), np.array(self.high)

    def actuators_after(self, act: np.ndarray, command: np.ndarray, h: float) -> np.ndarray:
        rule = np.array(self.clip)
        start = np.where(rule == "before", np.clip(act, *self.limits), act)
        new = start + h * (command - start) / np.array(self.lag)
        return np.where(rule == "after", np.clip(new, *self.limits), new)


_FIN = np.deg2rad(15)
REMUS = Reference(remus, (-_FIN, -_FIN, -1525), (_FIN, _FIN, 1525), (0.1, 0.1, 1.0), ("before",) * 3)
TORPEDO = Reference(
    torpedo, (*[-_FIN] * 4, -1525), (*[_FIN] * 4, 1525), (0.1,) * 5, ("after",) * 4 + ("force",)
)  # fmt: skip
OTTER = Reference(
    otter,
    (-np.sqrt(0.5 * 13.6 * G / 0.006445),) * 2,
    (np.sqrt(0.5 * 24.4 * G / 0.01108),) * 2,
    (0.1, 0.1),
    ("before",) * 2,
)
BY_NAME = {"remus100": REMUS, "torpedo": TORPEDO, "otter": OTTER}


def euler_runs(
    reference: Reference, nu_dot: Callable, seconds: float, commands: list[Callable], currents: np.ndarray, h: float
) -> np.ndarray:
    """`(steps, n, columns)` of eta, nu and actuators from rest in Fossen's loop, with accelerations by `nu_dot`, one
    run for each command; `currents` `(n, 3)`, and `nu_dot` takes and gives rows.

    Velocity and actuators by explicit Euler, then the pose at the old attitude with the new velocity.
    """
    n = len(commands)
    eta, nu, act = np.zeros((n, 6)), np.zeros((n, 6)), np.zeros((n, len(reference.lag)))
    rows = []
    for i in range(round(seconds / h) + 1):
        rows.append(np.hstack([eta, nu, act]))
        new = nu + h * nu_dot(eta, nu, act, currents)
        act = reference.actuators_after(act, np.array([command(i * h) for command in commands], float), h)
        moving = zip(eta, new, strict=True)
        rates = [np.concatenate([rotation(*e[3:]) @ v[:3], euler_rates(*e[3:5]) @ v[3:]]) for e, v in moving]
        eta, nu = eta + h * np.array(rates), new
    return np.array(rows)
