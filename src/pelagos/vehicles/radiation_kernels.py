"""Radiation kernels as sums of exponentials, fitted to a panel method's damping."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos.hydro.algebra import Vector
from pelagos.hydro.radiation import fit_memory, retardation
from pelagos.jit import Array
from pelagos.vehicles.afloat_config import RadiationConfig

Values = NDArray[np.float64]
_ORDER: Final = 4  # states a kernel


@dataclass(frozen=True)
class Kernel:
    """Radiation force in direction `row` after velocities in `column`: the real part of sum weight e^{pole t}.

    Attributes:
        row, column: 0 to 5.
        poles: [1/s], of each pair one; real ones first have no imaginary part.
        weights: complex [N/m] and the like.
    """

    row: int
    column: int
    poles: tuple[complex, ...]
    weights: tuple[complex, ...]


def remember(
    kernels: Sequence[Kernel], memory: Sequence[Array], velocity: Vector, h: Array
) -> tuple[list[Array], list[Array]]:
    """The memory after h [s] at a velocity relative to the water, and the force in that step's middle, as many."""
    new: list[Array] = []
    wrench: list[Array] = [0.0] * len(velocity)
    at = 0
    for kernel in kernels:
        v = velocity[kernel.column]
        for pole, weight in zip(kernel.poles, kernel.weights, strict=True):
            re, im = memory[at], memory[at + 1]
            at += 2
            size = dr.exp(pole.real * h)
            s, c = dr.sincos(pole.imag * h)
            gr, gi = size * c, size * s
            inverse = 1 / pole  # (e^{p h} - 1) / p, exact for a velocity that is constant in the step
            ur, ui = (gr - 1) * inverse.real - gi * inverse.imag, (gr - 1) * inverse.imag + gi * inverse.real
            nr, ni = gr * re - gi * im + ur * v, gr * im + gi * re + ui * v
            new += [nr, ni]
            push = 0.5 * (weight.real * (re + nr) - weight.imag * (im + ni))
            wrench[kernel.row] = wrench[kernel.row] - push
    return new, wrench


def momentum(kernels: Sequence[Kernel], before: Sequence[Array], after: Sequence[Array], count: int = 6) -> list[Array]:
    """Momentum (count) of the waves that were radiated, in the middle of a step: less the integral of their force.

    A kernel's integral is zero (`steady_weights`), so the integral of the force follows from the memory as it is.
    """
    found: list[Array] = [0.0] * count
    at = 0
    for kernel in kernels:
        for pole, weight in zip(kernel.poles, kernel.weights, strict=True):
            share = 0.5 * weight / pole
            re, im = before[at] + after[at], before[at + 1] + after[at + 1]
            at += 2
            found[kernel.row] = found[kernel.row] + (share.real * re - share.imag * im)
    return found


def states(kernels: Sequence[Kernel]) -> int:
    """Number of values in the memory of kernels."""
    return 2 * sum(len(k.poles) for k in kernels)


def radiation_kernels(coefficients: RadiationConfig, density: float) -> tuple[Kernel, ...]:
    """Every kernel that matters, as a sum of exponentials."""
    return fitted_kernels(np.array(coefficients.omega_radps), density * np.array(coefficients.damping))


def fitted_kernels(omega: Values, damping: Values) -> tuple[Kernel, ...]:
    """Kernels of damping `(frequencies, n, n)` at frequencies omega [rad/s]."""
    count = damping.shape[1]
    omega, damping = np.concatenate([[0.0], omega]), np.concatenate([np.zeros((1, count, count)), damping])
    tail = omega[-1] * np.geomspace(1.05, 4, 40)  # beyond the last frequency it falls as a wave maker's, omega^-3
    damping = np.concatenate([damping, damping[-1] * ((omega[-1] / tail) ** 3)[:, None, None]])
    omega = np.concatenate([omega, tail])
    largest = np.abs(damping).max(axis=0)
    found = []
    for row in range(count):
        for column in range(count):
            scale = math.sqrt(largest[row, row] * largest[column, column])
            if scale > 0 and largest[row, column] > 0.01 * scale:
                found.append(_kernel(row, column, omega, damping[:, row, column]))
    return tuple(found)


def _kernel(row: int, column: int, omega: Values, damping: Values) -> Kernel:
    peak = omega[int(np.argmax(np.abs(damping)))]
    step = 0.08 / peak
    t = step * np.arange(800)
    kernel = retardation(t, omega, damping)
    poles = np.log(np.linalg.eigvals(fit_memory(kernel, step, _ORDER).phi).astype(complex)) / step
    poles = np.minimum(poles.real, -0.01 * peak) + 1j * poles.imag
    poles = poles[poles.imag >= -1e-12]
    return Kernel(row, column, tuple(map(complex, poles)), tuple(map(complex, steady_weights(t, kernel, poles))))


def steady_weights(t: Values, kernel: Values, poles: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Weights of exponentials for a kernel at times t [s], by least squares under one condition: no force in the end.

    A body that moves steadily radiates nothing, so the kernel's integral is zero (T. Perez and T. I. Fossen 2008,
    Table 1); one that is not acts as a damping, and where it is negative as an engine.
    """
    waves = np.exp(poles * t[:, None])
    basis = np.concatenate([waves.real, -waves.imag], axis=1)
    end = np.concatenate([(-1 / poles).real, (1 / poles).imag])  # of the real part of weight times -1 / pole
    real = np.abs(poles.imag) < 1e-12
    used = np.concatenate([np.ones(len(poles), bool), ~real])
    basis, end = basis[:, used], end[used]
    normal = np.block([[basis.T @ basis, end[:, None]], [end[None], np.zeros((1, 1))]])
    found = np.linalg.lstsq(normal, np.append(basis.T @ kernel, 0.0), rcond=None)[0][:-1]
    parts = np.zeros(2 * len(poles))
    parts[used] = found
    return np.asarray(parts[: len(poles)] + 1j * parts[len(poles) :])
