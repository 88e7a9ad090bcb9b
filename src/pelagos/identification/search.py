"""The search: Levenberg and Marquardt's steps in parameters and initial states together.

Source: J. Nocedal, S. J. Wright, "Numerical Optimization", 2nd ed., Springer 2006, Section 10.3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import SimulationError
from pelagos.identification.problem import HUBER, Normal, Problem, moved
from pelagos.identification.shots import Shots

_ROUNDS: Final = 3  # of new standard deviations
WIDE: Final = 10.0
"""Times Huber's width in the first round from the priors: far from the solution most large differences are no outliers
of the record, but what is to be fitted: a search that counts them linearly ends where it has given some of them up."""
_LARGEST: Final = 1e8  # damping at which no step helps
_SETTLED: Final = 1e-5  # relative change of the loss
_STILL: Final = 0.01  # standard deviations of each parameter that are left to go, whatever initial states still do
_STRIDE: Final = 1.0  # largest change of a logarithm in one step


@dataclass
class Found:
    """End of the search.

    Attributes:
        at: coordinates of the parameters `(p,)`; shots: with their initial states; normal: equations there.
        differences: simulated less recorded `(steps + 1, c, s)`; losses: one a step.
        settled: whether the last step changed nothing that matters: the loss by 1e-5, or parameters by a hundredth of
            their standard deviations.
    """

    at: NDArray[np.float64]
    shots: Shots
    normal: Normal
    differences: NDArray[np.float64]
    losses: list[float]
    settled: bool


def search(
    problem: Problem, shots: Shots, *, iterations: int, tell: Callable[[str], None] = lambda _: None,
    at: NDArray[np.float64] | None = None,
) -> Found:  # fmt: skip
    """Parameters and initial states with the least loss near the priors.

    Args:
        problem: the loss.
        shots: with their first initial states.
        iterations: most steps.
        tell: hears of progress.
        at: where the search begins; None: at the priors.

    Raises:
        SimulationError: the vehicle's motion is not finite at the priors.
    """
    begins = at is None
    at = problem.prior.copy() if at is None else at
    _, off = problem.loss(at, shots)
    if not np.isfinite(off[~np.isnan(problem.wanted.wanted)]).all():
        raise SimulationError(
            "the motion is not finite with the priors: is step_s too long, or a column in another unit?"
        )
    losses: list[float] = []
    settled = False
    for turn in range(_ROUNDS):
        problem.sized(off)
        problem.huber = WIDE * HUBER if turn == 0 and begins else HUBER
        here, off = problem.loss(at, shots)
        damping = 1e-3
        settled = False
        for _ in range(max(1, iterations // (1 if turn == 0 else 2))):
            normal = problem.normal(at, shots)
            step = _improve(problem, normal, at, shots, here, damping)
            if step is None:
                settled = True
                break
            gain = here - step[3]
            at, shots, off, here, damping = step
            losses.append(here)
            tell(f"loss {here:.6g}")
            if gain < _SETTLED * max(here, 1.0) or _still(normal, len(at)):
                settled = True
                break
    return Found(at, shots, problem.normal(at, shots), off, losses, settled)


def _improve(
    problem: Problem, normal: Normal, at: NDArray[np.float64], shots: Shots, here: float, damping: float
) -> tuple[NDArray[np.float64], Shots, NDArray[np.float64], float, float] | None:
    p, f = len(at), len(problem.free)
    diagonal = np.diag(normal.matrix)
    while damping < _LARGEST:
        damped = normal.matrix + np.diag(damping * np.maximum(diagonal, 1e-12))
        step = -np.linalg.solve(damped, normal.gradient)
        logs = np.array([q.logarithmic for q in problem.family.parameters])
        longest = np.abs(step[:p][logs]).max(initial=0.0)
        if longest > _STRIDE:
            step *= _STRIDE / longest
        new = _bounded(problem, at + step[:p])
        trial = moved(shots, problem.free, step[p:].reshape(-1, f)) if f else shots
        loss, off = problem.loss(new, trial)
        if loss < here:
            return new, trial, off, loss, max(damping / 9, 1e-9)
        damping *= 6
    return None


def _still(normal: Normal, count: int) -> bool:
    """True if the undamped step moves none of the first `count` unknowns, the parameters, by what matters."""
    inverse = np.linalg.pinv(normal.matrix, hermitian=True)
    step, spread = (inverse @ normal.gradient)[:count], np.sqrt(np.maximum(np.diag(inverse)[:count], 0.0))
    return bool((np.abs(step) <= _STILL * spread).all())


def _bounded(problem: Problem, at: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.array([q.coordinate(q.value(x)) for q, x in zip(problem.family.parameters, at, strict=True)])
