"""Error of the parameters by the simulation's steps, and as many substeps as keep it below their intervals."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import InputError
from pelagos.identification.coordinates import number
from pelagos.identification.parameters import Family
from pelagos.identification.problem import Problem
from pelagos.identification.run_steps import MOST, SHORTEST_STEP_S
from pelagos.identification.search import Found
from pelagos.identification.shots import Shooter, Shots

SHARE: Final = 0.1
"""Of the half width of a 95 % interval: shifted by so much, it still covers a normal law's middle 94.6 times in 100."""
DOUBTED: Final = 0.25
"""Of the same, from which a fit is doubtful: 92 times in 100."""
_ORDERS: Final = {"runge_kutta": 4}  # of the others: 1


def finite_substeps(shooter: Shooter, family: Family, shots: Shots, given: int | None) -> int:
    """The least number of substeps, by doubling, with which the motion stays finite at the priors; or that given.

    Raises:
        InputError: those given make steps shorter than 1 ms.
    """
    if given is not None:
        if shooter.grid_s / given < SHORTEST_STEP_S:
            raise InputError(
                f"plan: substeps: {given} in {shooter.grid_s:g} s are steps of {1000 * shooter.grid_s / given:.3g} ms, "
                f"and none may be shorter than 1 ms; give at most {max(1, int(shooter.grid_s / SHORTEST_STEP_S))}"
            )
        return given
    compiled = family.compiled_values([p.coordinate(p.prior) for p in family.parameters])
    for substeps in (1, 2, 4, 8):
        shooter.divide(substeps)
        if np.isfinite(shooter.play(shots, compiled, [], tangents=False)[0]).all():
            return substeps
    return MOST


def step_shift(problem: Problem, found: Found, integrator: str) -> NDArray[np.float64]:
    """Shift of the parameters, in the coordinates of the search, that the length of steps causes `(p,)`.

    The exact motion follows from that with half the step by Richardson's extrapolation: e = (y_h - y_h/2) 2^k /
    (2^k - 1) with the order k of the integrator (E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary Differential
    Equations I", 2nd ed., Springer 1993, Section II.4). Parameters and initial states answer to an error e of the
    motion as to one of the measurements, with a step of Gauss and Newton: -H^-1 J^T W e.
    """
    shooter, at, shots = problem.shooter, found.at, found.shots
    substeps = shooter.substeps
    seen, slopes = shooter.play(shots, problem.family.compiled(at), problem.free, tangents=True)
    assert slopes is not None
    shooter.divide(2 * substeps)
    finer, _ = shooter.play(shots, problem.family.compiled_values(at), [], tangents=False)
    shooter.divide(substeps)
    order = _ORDERS.get(integrator, 1)
    return _shift(problem, found, seen, slopes, finer, 2**order / (2**order - 1))


def shift_from(problem: Problem, found: Found, run: Shooter) -> NDArray[np.float64]:
    """Shift of the parameters, likewise, because the steps of the fit are not those of a run that was recorded `(p,)`:
    e is the motion in the fit's steps less that in the run's.
    """
    seen, slopes = problem.shooter.play(found.shots, problem.family.compiled(found.at), problem.free, tangents=True)
    assert slopes is not None
    other, _ = run.play(found.shots, problem.family.compiled_values(found.at), [], tangents=False)
    return _shift(problem, found, seen, slopes, other, 1.0)


def _shift(
    problem: Problem, found: Found, seen: NDArray[np.float64], slopes: NDArray[np.float64], other: NDArray[np.float64],
    share: float,
) -> NDArray[np.float64]:  # fmt: skip
    """-H^-1 J^T W e, where e is a share of the motion that was seen less another."""
    at, chosen = found.at, [number(n) for n in problem.wanted.names]
    error = replace(problem.wanted, wanted=other[:, chosen]).differences(seen) * share
    error = np.where(np.isfinite(problem.wanted.wanted), error, 0.0) / problem.sigma[None, :, None] ** 2
    if not np.isfinite(error).all():
        return np.full(len(at), np.inf)
    p = len(at)
    felt = np.einsum("tcsm,tcs->sm", slopes[:, chosen], error)
    pull = np.concatenate([felt[:, :p].sum(axis=0), felt[:, p:].ravel()])
    return np.asarray(-np.linalg.solve(found.normal.matrix, pull)[:p])
