"""Gradients through many steps, by pulling cotangents back one step at a time.

One step's program is recorded once and played for every step, forwards and backwards, so that a thousand steps compile
no more than one; memory is one state a step. Source: A. Griewank, A. Walther, "Evaluating Derivatives", 2nd ed.,
SIAM 2008, Chapter 3 (reverse mode).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import drjit as dr

from pelagos import jit
from pelagos.jit import Array

Step = Callable[[list[Array], list[Array], list[Array]], list[Array]]
"""`f(state, parameters, inputs) -> state`, lists of `Float64`."""


def rollout(step: Step, start: Sequence[Array], parameters: Sequence[Array], inputs: Sequence[Sequence[Array]]) -> Any:
    """The states before and after every step: one list of arrays each, `len(inputs) + 1` in all."""
    frozen = jit.freeze(step)
    states = [[jit.Float64(x) for x in start]]
    dr.make_opaque(states[0], list(parameters), list(inputs))
    for given in inputs:
        states.append(frozen(states[-1], list(parameters), list(given)))
        dr.eval(states[-1])
    return states


def pull_back(
    step: Step,
    states: Sequence[Sequence[Array]],
    parameters: Sequence[Array],
    inputs: Sequence[Sequence[Array]],
    cotangents: Sequence[Sequence[Array] | None],
) -> tuple[list[Array], list[Array], list[list[Array]]]:
    """Gradients of a function of the states.

    Args:
        step: as in `rollout`.
        states: from `rollout`.
        parameters, inputs: as in `rollout`.
        cotangents: gradient of the function with respect to each of `states`; None where it does not depend on one.

    Returns:
        Gradients with respect to the first state, to the parameters, and to every step's inputs, lane by lane.
    """
    frozen = jit.freeze(_pull(step))
    zero = [0 * x for x in states[-1]]
    adjoint = [a + z for a, z in zip(cotangents[-1] or zero, zero, strict=True)]
    total = [0 * p + 0 * states[-1][0] for p in parameters]
    by_input: list[list[Array]] = []
    dr.make_opaque(list(cotangents), list(inputs), list(parameters))
    for k in reversed(range(len(inputs))):
        dr.make_opaque(adjoint)
        adjoint, by_parameter, by_step = frozen(list(states[k]), list(parameters), list(inputs[k]), adjoint)
        total = [t + g for t, g in zip(total, by_parameter, strict=True)]
        seen = cotangents[k]
        if seen is not None:
            adjoint = [a + c for a, c in zip(adjoint, seen, strict=True)]
        dr.eval(total, adjoint)
        by_input.append(by_step)
    return adjoint, total, by_input[::-1]


def _pull(step: Step) -> Callable[..., Any]:
    def pull(state: list[Array], parameters: list[Array], inputs: list[Array], adjoint: list[Array]) -> Any:
        lane = dr.zeros(jit.Float64, dr.width(adjoint))
        free = [[jit.Float64(dr.detach(x)) + lane for x in group] for group in (state, parameters, inputs)]
        dr.enable_grad(free)
        after = step(*free)
        for x, a in zip(after, adjoint, strict=True):
            if dr.grad_enabled(x):
                dr.set_grad(x, a)
        dr.enqueue(dr.ADMode.Backward, after)
        dr.traverse(dr.ADMode.Backward)
        return tuple([dr.detach(dr.grad(x)) for x in group] for group in free)

    return pull
