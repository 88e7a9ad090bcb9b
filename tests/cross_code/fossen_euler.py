"""The loop of Fossen's Python Vehicle Simulator around a Pelagos model: Euler angles, semi-implicit, explicit lags.

Step i: command from t = i h or from the control law; record; nu and actuators by explicit Euler; pose with the new
velocity at the old attitude.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.vehicles.flow import make_flow, rotation_from_euler

DATA = Path(__file__).parent / "data" / "fossen"


def table(name: str) -> tuple[list[str], np.ndarray]:
    text = (DATA / f"{name}.csv").read_text().splitlines()
    return text[0].split(","), np.array([[float(x) for x in line.split(",")] for line in text[1:]])


def current_ned(speed: float, towards_deg: float) -> list[float]:
    angle = np.deg2rad(towards_deg)
    return [float(speed * np.cos(angle)), float(speed * np.sin(angle)), 0.0]


def replay(
    vehicle,
    steps: int,
    every: int,
    *,
    command: Callable | None = None,
    control=None,
    setpoint=(),
    current=(0.0, 0.0, 0.0),
    h: float = 0.02,
) -> np.ndarray:
    """Rows (t, eta, nu, command, actuators) of every `every`-th step, of the published model, from rest.

    `command(t)` gives the commands; or `control` is a control law with constant set-points.
    """
    published = vehicle.published
    model = published.model
    k = len(model.actuators)
    width = 13 + 2 * k
    out = dr.zeros(jit.Float64, (steps // every + 1) * width)
    f64 = jit.Float64
    memory = 0 if control is None else control.memory

    def body(i, state):
        eta, nu, act, kept = state[0:6], state[6:12], state[12 : 12 + k], state[12 + k :]
        rotation = rotation_from_euler(*eta[3:])
        flow = make_flow(eta[:3], rotation, nu, current, current_rotation=published.config.current_rotation)
        t = f64(i) * h
        if control is None:
            u = [f64(c) for c in command(t)]
        else:
            demand, kept = control.act(kept, flow, [f64(s) for s in setpoint], h)
            u = [f64(demand.actuators[name]) for name in model.actuators]
        for c, value in enumerate([t, *eta, *nu, *u, *act]):
            dr.scatter(out, value, (i // every) * width + c, active=(i % every) == 0)
        start = model.limited(act)
        nu_dot = model.nu_dot(flow, start)
        new_nu = [v + h * a for v, a in zip(nu, nu_dot, strict=True)]
        rates = model.rates(start, u)
        new_act = [a + h * r for a, r in zip(start, rates, strict=True)]
        (sr, cr), (cp, tp) = dr.sincos(eta[3]), (dr.cos(eta[4]), dr.tan(eta[4]))
        p, q, r = new_nu[3:]
        moved = [sum(rotation[a][b] * new_nu[b] for b in range(3)) for a in range(3)]
        turned = [p + (q * sr + r * cr) * tp, q * cr - r * sr, (q * sr + r * cr) / cp]
        new_eta = [e + h * d for e, d in zip(eta, [*moved, *turned], strict=True)]
        return i + 1, [*new_eta, *new_nu, *new_act, *(f64(m) for m in kept)]

    start = [dr.zeros(f64, 1) for _ in range(12 + k + memory)]
    dr.while_loop((dr.zeros(jit.UInt32, 1), start), lambda i, state: i <= steps, body, mode="symbolic")
    return np.array(out).reshape(-1, width)
