"""The memory of the free surface: radiation forces in the time domain after Cummins, as a small linear system.

The equation of W. E. Cummins, "The impulse response function and ship motions", Schiffstechnik 9:101 (1962): a
floating body feels A(inf) times its acceleration and the integral of K(t - s) v(s), with K(t) = 2/pi times the
integral of B(w) cos(w t) over frequency (T. F. Ogilvie, 5th Symp. Naval Hydrodynamics, 1964). The integral is
replaced by a system x' = F x + g v, mu = h x, which balanced truncation of the sampled K gives (S. Y. Kung, 12th
Asilomar Conf., 1978; E. Kristiansen, A. Hjulstad and O. Egeland, Ocean Engineering 32:2195, 2005, doi
10.1016/j.oceaneng.2005.01.009). Fitting runs on the host, once; a step on the device is one product of a small matrix.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pelagos.hydro.algebra import dot, mul, total
from pelagos.jit import Array

Values = NDArray[np.float64]


@dataclass(frozen=True)
class Memory:
    """A discrete system for steps of `step` [s]: x <- phi x + gamma v, force = -(row x).

    Attributes:
        phi: `(order, order)`.
        gamma, row: `(order,)`.
        step: [s].
        misfit: root mean square error of the kernel over that of the kernel.
    """

    phi: Values
    gamma: Values
    row: Values
    step: float
    misfit: float


def retardation(t: Values, omega: Values, damping: Values) -> Values:
    """K(t) at times t [s] from B at increasing frequencies omega [rad/s], linear between them, zero beyond the last.

    The integral over each interval is exact (Filon), so that long times need no finer frequencies.
    """
    from scipy.integrate import trapezoid

    w0, w1 = omega[:-1, None], omega[1:, None]
    b0, slope = damping[:-1, None], (np.diff(damping) / np.diff(omega))[:, None]
    late = np.where(t == 0, 1.0, t)[None, :]
    edge = (b0 + slope * (w1 - w0)) * np.sin(w1 * late) - b0 * np.sin(w0 * late)
    bend = slope * (np.cos(w1 * late) - np.cos(w0 * late)) / late
    at_zero = float(trapezoid(damping, omega))
    return np.asarray(2 / np.pi * np.where(t == 0, at_zero, np.sum((edge + bend) / late, axis=0)))


def fit_memory(kernel: Values, step: float, order: int) -> Memory:
    """A system of `order` whose response to a velocity approximates a kernel sampled every `step` [s].

    Args:
        kernel: K(0), K(step), ..., until it has died away; two thousand samples at most are taken.
        step: of the simulation [s].
        order: states; 4 to 8 are usual.
    """
    pulses = np.asarray(kernel, dtype=np.float64)[:2000] * step
    half = len(pulses) // 2
    index = np.arange(half)
    hankel = pulses[index[:, None] + index[None, :]]
    u, s, vt = np.linalg.svd(hankel)
    root = np.sqrt(s[:order])
    observe, control = u[:, :order] * root, root[:, None] * vt[:order]
    phi = np.linalg.lstsq(observe[:-1], observe[1:], rcond=None)[0]
    gamma, row = control[:, 0], observe[0]
    found, x = [], gamma
    for _ in range(len(pulses)):
        found.append(row @ x)
        x = phi @ x
    misfit = float(np.sqrt(np.mean((np.array(found) - pulses) ** 2) / np.mean(pulses**2)))
    return Memory(phi, gamma, row, step, misfit)


def radiate(memory: Memory, state: Sequence[Array], velocity: Array) -> tuple[list[Array], Array]:
    """One step of the memory: the new state, and the force on the body [N] (or moment [N m]).

    Args:
        memory: see `fit_memory`; the step of the simulation must be its own.
        state: one entry a state of the memory, zero at rest.
        velocity: of the body in this degree of freedom, in the middle of the step [m/s] or [rad/s].
    """
    new = [
        total(dot([float(p) for p in memory.phi[i]], state), mul(float(memory.gamma[i]), velocity))
        for i in range(len(memory.gamma))
    ]
    return new, -dot([float(r) for r in memory.row], new)
