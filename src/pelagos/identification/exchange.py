"""A second solution in which an actuator's lag and the hull's own time constant have changed places.

A lag T before a hull of mass m and damping d answers to a command with 1/d 1/(T s + 1) 1/(m/d s + 1), which is the same
with T and m/d exchanged: a motion says which two time constants there are, and not which of them is the hull's. What
tells is that drag is not linear, that several axes share a lag, or what is known before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import ScenarioError, SimulationError
from pelagos.identification.parameters import Family, Parameter
from pelagos.identification.problem import Problem
from pelagos.identification.search import Found, search

_ITERATIONS: Final = 10  # of the search for the other solution, which is known but for what is not linear
_SURPRISE: Final = 8.0  # loss by the priors from which another solution is not looked for: odds of 1 in 3000
_ALIKE: Final = 2.0  # loss by the record up to which another solution tells it as well: odds of 1 in 7
_APART: Final = 0.2  # logarithm of two lags that are not the same
_STEP: Final = 1e-4  # of a parameter's coordinate
_LEAST: Final = 1e-3  # of the whole mass, that a parameter is


def exchanged(problem: Problem, found: Found, tell: Callable[[str], None]) -> tuple[str, ...]:
    """Other solutions that tell the record as well, in words."""
    family, sigma, first = problem.family, problem.sigma.copy(), _by_the_record(problem, found)
    said = []
    for lag, mass, at in _candidates(problem, found):
        tell("with a lag and the hull exchanged")
        try:
            other = search(problem, found.shots, iterations=_ITERATIONS, at=at)
        except (ScenarioError, SimulationError):  # numbers that no vehicle has are no other solution
            continue
        finally:
            problem.sigma = sigma.copy()
        alike = _by_the_record(problem, other) < first + _ALIKE
        if alike and abs(other.at[lag] - found.at[lag]) > _APART:
            pairs = [
                " and ".join(f"{q.name} {q.value(float(x[k])):.3g}" for k in (lag, mass) if (q := family.parameters[k]))
                for x in (other.at, found.at)
            ]
            said.append(
                f"{pairs[0]} tell this record as well as {pairs[1]}: the actuator's lag and the hull's own time "
                "constant change places, which intervals do not count; give the one that you know better a narrower "
                "spread"
            )
    return tuple(said)


def _candidates(problem: Problem, found: Found) -> Iterator[tuple[int, int, NDArray[np.float64]]]:
    """Parameters of a lag and a mass, and where the search for the other solution begins `(p,)`."""
    parameters, at = problem.family.parameters, found.at
    lags = [
        k for k, p in enumerate(parameters)
        if p.logarithmic and all(s.startswith("actuators.") and s.endswith(".time_constant_s") for s in p.paths)
    ]  # fmt: skip
    masses = [k for k, p in enumerate(parameters) if p.paths[0].split(".")[0] in ("mass", "added_mass")]
    if not lags or not masses:
        return
    whole, times = _mass(problem.family, at), _hull_times(problem, found)
    for mass in masses:
        moved = at.copy()
        moved[mass] += _STEP
        slope = (_mass(problem.family, moved) - whole) / (_STEP * parameters[mass].slope(at[mass]))
        axis = int(np.argmax(np.abs(slope) / whole))
        if abs(slope[axis] * parameters[mass].value(at[mass])) < _LEAST * whole[axis]:
            continue
        for lag in lags:
            of_lag, of_hull = parameters[lag].value(at[lag]), float(times[axis])
            wanted = parameters[mass].value(at[mass]) + whole[axis] * (of_lag / of_hull - 1) / slope[axis]
            if not (0 < of_hull < np.inf and _may_be(parameters[mass], wanted) and _may_be(parameters[lag], of_hull)):
                continue
            there = at.copy()
            there[lag], there[mass] = parameters[lag].coordinate(of_hull), parameters[mass].coordinate(wanted)
            if abs(there[lag] - at[lag]) > _APART and _surprise(problem, there) < _surprise(problem, at) + _SURPRISE:
                yield lag, mass, there


def _may_be(parameter: Parameter, value: float) -> bool:
    """True for a value within a parameter's bounds, and of its prior's sign where that is kept."""
    return parameter.low <= value <= parameter.high and (not parameter.logarithmic or value * parameter.prior > 0)


def _by_the_record(problem: Problem, found: Found) -> float:
    """Loss without that by the priors of parameters."""
    return problem.loss(found.at, found.shots)[0] - _surprise(problem, found.at)


def _surprise(problem: Problem, at: NDArray[np.float64]) -> float:
    """Loss by the priors."""
    return 0.5 * float((problem.precision * (at - problem.prior) ** 2).sum())


def _mass(family: Family, at: NDArray[np.float64]) -> NDArray[np.float64]:
    """Diagonal of the whole mass matrix `(6,)` [kg], [kg m^2]."""
    return np.array([float(row[k]) for k, row in enumerate(family.model_at(at).inertia.whole)])


def _hull_times(problem: Problem, found: Found) -> NDArray[np.float64]:
    """Time in which each velocity of its own falls to 1/e of what it was off `(6,)` [s]; infinite where it does not.

    By the derivatives of the velocities by their first values, a row of the grid later.
    """
    compiled, p = problem.family.compiled(found.at), len(found.at)
    _, slopes = problem.shooter.play(found.shots, compiled, range(6, 12), tangents=True)
    assert slopes is not None
    kept = np.array([slopes[1, 6 + k, :, p + k].mean() for k in range(6)])
    falls = (kept > 0) & (kept < 1)
    return np.where(falls, -problem.shooter.grid_s / np.log(np.where(falls, kept, 0.5)), np.inf)
