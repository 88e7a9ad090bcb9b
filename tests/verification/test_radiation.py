"""Radiation memory against pairs of functions known in closed form, and against the damping that it came from."""

import json
from pathlib import Path

import numpy as np
import pytest

from pelagos import jit
from pelagos.hydro.radiation import fit_memory, radiate, retardation
from pelagos.vehicles.afloat_config import RadiationConfig
from pelagos.vehicles.radiation_kernels import radiation_kernels

# K(t) = k e^{-a t} cos(b t) has the transform B(w) = k a (w^2 + a^2 + b^2) / ((a^2 + (w - b)^2)(a^2 + (w + b)^2)).
# It does not vanish at w = 0 as real damping does; the mathematics is the same.
A, B, K0 = 0.7, 1.9, 350.0
OMEGA = np.concatenate([np.linspace(0, 12, 1201), np.geomspace(12, 4000, 600)[1:]])
DAMPING = K0 * A * (OMEGA**2 + A**2 + B**2) / ((A**2 + (OMEGA - B) ** 2) * (A**2 + (OMEGA + B) ** 2))


def test_kernel_of_a_known_damping() -> None:
    """Beyond 4000 rad/s lie 2/pi k a / 4000 = 4e-2 N/m of K(0); linear pieces of 0.01 rad/s leave 1e-5."""
    t = np.linspace(0, 12, 241)
    assert retardation(t, OMEGA, DAMPING) == pytest.approx(K0 * np.exp(-A * t) * np.cos(B * t), abs=0.1)


def test_order_two_fits_a_kernel_of_order_two() -> None:
    t = 0.02 * np.arange(500)
    memory = fit_memory(K0 * np.exp(-A * t) * np.cos(B * t), 0.02, 2)
    assert memory.misfit < 1e-9
    expected = np.exp((-A + 1j * B) * 0.02)
    assert sorted(np.linalg.eigvals(memory.phi), key=np.imag)[1] == pytest.approx(expected, rel=1e-9)


def test_higher_orders_fit_better_and_are_stable() -> None:
    """A kernel of a floating body's shape: B(w) = w^3 e^{-w^2}, as low and high frequencies of real damping fall."""
    omega = np.linspace(0, 8, 801)
    t = 0.05 * np.arange(800)
    kernel = retardation(t, omega, omega**3 * np.exp(-(omega**2)))
    fits = [fit_memory(kernel, 0.05, order) for order in (2, 4, 6)]
    misfits = [m.misfit for m in fits]
    assert misfits[0] > misfits[1] > misfits[2]
    assert misfits[2] < 0.02
    assert all(np.abs(np.linalg.eigvals(m.phi)).max() < 1 for m in fits)


@pytest.mark.parametrize("omega", [0.5, 1.9, 4.0])
def test_steady_oscillation_is_damped_as_it_should(omega: float) -> None:
    """v = cos(w t): after the transient the force in phase with v is -B(w); the step of 0.01 s costs w h / 2 of
    phase.
    """
    step = 0.01
    t = step * np.arange(800)
    memory = fit_memory(K0 * np.exp(-A * t) * np.cos(B * t), step, 2)
    state, forces = [0.0, 0.0], []
    time = step * (np.arange(3000) + 0.5)
    for v in np.cos(omega * time):
        state, force = radiate(memory, state, float(v))
        forces.append(force)
    late = time > 12
    turns = int((time[-1] - 12) * omega / (2 * np.pi))
    late &= time > time[-1] - turns * 2 * np.pi / omega
    in_phase = 2 * np.mean(np.array(forces)[late] * np.cos(omega * (time[late] + step / 2)))
    exact = K0 * A * (omega**2 + A**2 + B**2) / ((A**2 + (omega - B) ** 2) * (A**2 + (omega + B) ** 2))
    assert -in_phase == pytest.approx(exact, rel=0.03)


def test_device_and_numbers_agree() -> None:
    t = 0.02 * np.arange(500)
    memory = fit_memory(K0 * np.exp(-A * t) * np.cos(B * t), 0.02, 4)
    frozen = jit.freeze(lambda state, v: radiate(memory, state, v))
    state, force = frozen([jit.Float64([0.1, 0.2])] * 4, jit.Float64([1.0, -2.0]))
    for lane, (x, v) in enumerate([(0.1, 1.0), (0.2, -2.0)]):
        new, push = radiate(memory, [x] * 4, v)
        assert [np.array(s)[lane] for s in state] == pytest.approx(new, rel=1e-12)
        assert np.array(force)[lane] == pytest.approx(push, rel=1e-12)


def test_memory_takes_energy_and_gives_none() -> None:
    """A body with memory and a spring, let go: its energy never exceeds what it began with, and dies away."""
    step = 0.01
    t = step * np.arange(800)
    memory = fit_memory(K0 * np.exp(-A * t) * np.cos(B * t), step, 2)
    x, v, state, energy = 1.0, 0.0, [0.0, 0.0], []
    for _ in range(4000):
        state, force = radiate(memory, state, v)
        v += step * (force - 400.0 * x) / 300.0
        x += step * v
        energy.append(0.5 * 300 * v**2 + 0.5 * 400 * x**2)
    assert max(energy) < 200 * 1.02
    assert energy[-1] < 1.0


def test_a_hull_that_moves_steadily_radiates_nothing() -> None:
    """Each kernel's integral is zero, and its transform is the damping that it was made from, within 6 % of the largest
    in the mean; a kernel with an integral left over would brake or drive the hull.
    """
    table = json.loads((Path(__file__).parents[1] / "cross_code/data/capytaine_barge.json").read_text())
    coefficients = RadiationConfig.model_validate(table)
    omega, damping = np.array(coefficients.omega_radps), 1000.0 * np.array(coefficients.damping)
    kernels = radiation_kernels(coefficients, 1000.0)
    assert {(k.row, k.column) for k in kernels} >= {(i, i) for i in range(6)}
    for kernel in kernels:
        poles, weights = np.array(kernel.poles), np.array(kernel.weights)
        made = damping[:, kernel.row, kernel.column]
        assert abs(np.sum(-weights / poles).real) < 1e-9 * np.abs(made).max()
        w = 1j * omega[:, None]
        fit = np.sum(0.5 * (weights / (w - poles) + weights.conj() / (w - poles.conj())), axis=1).real
        assert np.sqrt(np.mean((fit - made) ** 2)) < 0.06 * np.abs(made).max()
