"""Steps of the search of a fit: length, bounds and damping, its end, and what the simulation's steps shift."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from test_identification_normal import AT, SHOTS, SIGMA, STEPS, Motion, problem, shots

from pelagos.identification.parameters import Parameter
from pelagos.identification.search import _improve, _still
from pelagos.identification.steps import step_shift

GOAL = np.array([4.0, -7.0, 0.3])
STIFF = np.array([2.0, 5.0, 0.5])


def bowl(*, logarithmic: bool, low: float = -np.inf) -> Any:
    """A loss that is quadratic about GOAL; the second parameter may be a logarithm."""
    family = SimpleNamespace(
        parameters=[
            Parameter("a", ("a",), (1.0,), 1.0, 1.0, low, np.inf, False),
            Parameter("b", ("b",), (1.0,), 1.0, 1.0, 1e-300, np.inf, logarithmic),
            Parameter("c", ("c",), (1.0,), 1.0, 1.0, -np.inf, np.inf, False),
        ]
    )
    loss = lambda at, given: (0.5 * float((STIFF * (at - GOAL) ** 2).sum()), at - GOAL)
    return SimpleNamespace(family=family, free=[], loss=loss)


def normal(at: np.ndarray) -> Any:
    return SimpleNamespace(matrix=np.diag(STIFF), gradient=STIFF * (at - GOAL))


def test_a_step_changes_no_logarithm_by_more_than_one() -> None:
    """All parts of the step are shortened alike; without logarithms it is Gauss and Newton's, damped."""
    at = np.array([1.0, 2.0, -1.0])
    made: Any = _improve(bowl(logarithmic=True), normal(at), at, None, 1e9, 1e-3)
    assert made is not None
    assert made[0] == pytest.approx(at + (GOAL - at) / 9.0)  # of 9 in the logarithm one
    assert made[3] == pytest.approx(bowl(logarithmic=True).loss(made[0], None)[0])
    assert made[4] == pytest.approx(1e-3 / 9)
    positive = bowl(logarithmic=False)
    positive.family.parameters[1] = positive.family.parameters[0]
    found: Any = _improve(positive, normal(at), at, None, 1e9, 1e-3)
    assert found[0] == pytest.approx(at + (GOAL - at) / 1.001)
    assert _improve(positive, normal(at), at, None, 1e9, 1e-10)[4] == 1e-9  # type: ignore[index]


def test_a_step_ends_at_a_bound_and_is_damped_until_it_helps() -> None:
    at = np.array([6.0, 2.0, -1.0])
    bounded = bowl(logarithmic=True, low=5.9)
    made: Any = _improve(bounded, normal(at), at, None, 1e9, 1e-3)
    assert made[0][0] == 5.9
    assert made[0][1] == pytest.approx(1.0)
    line = bowl(logarithmic=False)
    line.family.parameters[1] = line.family.parameters[0]
    here, _ = line.loss(at, None)
    steep = normal(at)
    steep.matrix = np.diag(STIFF) / 40.0  # told much too soft: 40 times too long a step at first
    found: Any = _improve(line, steep, at, None, here, 1e-3)
    damping = next(1e-3 * 6.0**k for k in range(20) if abs(1 - 40.0 / (1 + 1e-3 * 6.0**k)) < 1)
    assert found[0] == pytest.approx(at + (GOAL - at) * 40.0 / (1 + damping))
    assert found[4] == pytest.approx(damping / 9)


@pytest.mark.parametrize(("first", "last", "still"), [(0.0199, 9.0, True), (0.0201, 0.0, False), (-0.0201, 0.0, False)])
def test_a_search_is_still_where_parameters_have_a_hundredth_of_their_spread_to_go(
    first: float, last: float, still: bool
) -> None:
    """Standard deviation 1/sqrt(4), step g/4; whatever initial states, which follow, still do."""
    equations: Any = SimpleNamespace(matrix=np.diag([4.0, 100.0, 1.0]), gradient=np.array([first, -0.09, last]))
    assert _still(equations, 2) == still
    assert not _still(equations, 3) or last == 0.0


class Coarse(Motion):
    """A motion that steps of the simulation shift, by the fewer the more."""

    substeps = 2

    def divide(self, count: int) -> None:
        self.substeps = count

    def seen(self, given: Any, at: np.ndarray) -> np.ndarray:  # type: ignore[override]
        found = Motion.seen(given, at)
        t, c, k = (np.arange(n) for n in (STEPS + 1, 12, SHOTS))
        return found + 0.02 / self.substeps * t[:, None, None] * np.sin(1 + c[:, None] + 2 * k)


@pytest.mark.parametrize(("integrator", "order"), [("conservative", 1), ("runge_kutta", 4)])
def test_a_shift_by_the_steps_is_a_step_towards_the_exact_motion(integrator: str, order: int) -> None:
    """-H^-1 J^T W e, e = (y_h - y_(h/2)) 2^k/(2^k - 1), where something was measured."""
    made, _ = problem()
    made.shooter = shooter = Coarse()  # type: ignore[assignment]
    found: Any = SimpleNamespace(at=AT, shots=shots(), normal=made.normal(AT, shots()))
    seen, slopes = shooter.play(shots(), AT, made.free, tangents=True)
    shooter.divide(4)
    error = (seen - shooter.seen(shots(), AT)) * 2**order / (2**order - 1)
    shooter.divide(2)
    size = len(found.normal.matrix)
    pull, f = np.zeros(size), len(made.free)
    for c, place in enumerate((0, 5, 6)):
        for t in range(STEPS + 1):
            for k in range(SHOTS):
                if np.isfinite(made.wanted.wanted[t, c, k]):
                    row = np.zeros(size)
                    row[:2], row[2 + k * f : 2 + (k + 1) * f] = slopes[t, place, k, :2], slopes[t, place, k, 2:]
                    pull += row * error[t, place, k] / SIGMA[c] ** 2
    expected = -np.linalg.solve(found.normal.matrix, pull)[:2]
    assert np.abs(expected).min() > 1e-5
    assert step_shift(made, found, integrator) == pytest.approx(expected, rel=1e-9)
    assert shooter.substeps == 2
