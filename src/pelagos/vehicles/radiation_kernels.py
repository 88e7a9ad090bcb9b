"""Radiation kernels as sums of exponentials, fitted to a panel method's damping."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.hydro.radiation import fit_memory, retardation
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


def radiation_kernels(coefficients: RadiationConfig, density: float) -> tuple[Kernel, ...]:
    """Every kernel that matters, as a sum of exponentials."""
    omega, damping = np.array(coefficients.omega_radps), density * np.array(coefficients.damping)
    omega, damping = np.concatenate([[0.0], omega]), np.concatenate([np.zeros((1, 6, 6)), damping])
    tail = omega[-1] * np.geomspace(1.05, 4, 40)  # beyond the last frequency it falls as a wave maker's, omega^-3
    damping = np.concatenate([damping, damping[-1] * ((omega[-1] / tail) ** 3)[:, None, None]])
    omega = np.concatenate([omega, tail])
    largest = np.abs(damping).max(axis=0)
    found = []
    for row in range(6):
        for column in range(6):
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
