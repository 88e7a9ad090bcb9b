"""Doubts about a fit that was made, and about the commands of a record, in words."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from pelagos.identification.record import Record
from pelagos.identification.steps import DOUBTED
from pelagos.vehicles.model import Model

if TYPE_CHECKING:
    from pelagos.identification.fit import Fit, Score

_DIGITS = 3  # of R2, as printed
_TOLD = 0.01  # share of a force: a smaller loss is not told
_UPRIGHT = (0.0, 0.0, 1.0)  # direction of gravity, FRD


def doubts_of_commands(record: Record, model: Model) -> tuple[str, ...]:
    """Actuators that the record says nothing of, commands that they do not follow, and forces that the surface takes
    in a simulation.
    """
    silent = [name for name in model.actuators if name not in record.commands]
    found = []
    if silent:
        found.append(f"no commands of {', '.join(silent)}: taken for 0 throughout; name their columns under commands")
    for name, given in record.commands.items():
        lag = model.actuators[name].lag
        low, high = float(lag.low), float(lag.high)
        slack = 1e-9 * max(abs(low), abs(high))  # of a factor to SI
        used = np.concatenate([given[a:b] for a, b in record.runs])
        beyond = (used < low - slack) | (used > high + slack)
        if beyond.any():
            found.append(
                f"commands of {name} go from {used.min():.4g} to {used.max():.4g}, beyond its limits {low:.4g} .. "
                f"{high:.4g} in {100 * beyond.mean():.2g} % of the rows, where it stays at them; another unit, "
                "or other limits?"
            )
    return (*found, *_near_the_surface(record, model))


def _near_the_surface(record: Record, model: Model) -> Iterator[str]:
    """Actuators that keep less of their force in a simulation than in a fit, in which all are deep."""
    if model.wetting is None:
        return
    known = record.values("depth")
    depths = record.assumed.get("depth", 0.0) if known is None else np.concatenate([known[a:b] for a, b in record.runs])
    shallowest = float(np.min(depths))
    for name, actuator in model.actuators.items():
        if actuator.site.keeps not in ("propeller", "fin"):
            continue
        left = float(actuator.site.share_at(shallowest, _UPRIGHT))
        if left < 1 - _TOLD:
            yield (
                f"{name} is so near the surface that a run takes up to {100 * (1 - left):.2g} % of its force, and the "
                "fit nothing: place it deeper, or give the diameter or span that it has"
            )


def doubts_of_fit(made: Fit) -> tuple[str, ...]:
    """A search that did not end, and an unseen part that is predicted badly."""
    found = []
    if not made.found.settled:
        found.append(
            f"the search did not settle in {made.plan.iterations} steps: give more iterations or narrower priors"
        )
    shifted = [
        f"{e.parameter.name} by {e.step_shift:+.2g}"
        for e in made.estimates if abs(e.step_shift) > DOUBTED * 0.5 * (e.fisher[1] - e.fisher[0])
    ]  # fmt: skip
    if shifted:
        found.append(
            f"the steps of {1000 * made.record.step_s / made.substeps:.3g} ms shift {', '.join(shifted)}: "
            "give more substeps, or a shorter step_s"
        )
    if made.test is not None:
        found += _unseen(made.test, made.before)
    return tuple(found)


def _unseen(test: Score, before: Score) -> Iterator[str]:
    below = [f"{n} {r2:.{_DIGITS}f}" for n, r2 in test.r2.items() if round(r2, _DIGITS) < 0]
    if below:
        yield f"unseen part: R2 below 0, so that its mean would predict it better: {', '.join(below)}"
    worse = [
        f"{n} {r2:.{_DIGITS}f} (priors {before.r2[n]:.{_DIGITS}f})"
        for n, r2 in test.r2.items() if round(r2, _DIGITS) < round(before.r2[n], _DIGITS)
    ]  # fmt: skip
    if worse:
        yield f"unseen part: R2 is worse than before the fit: {', '.join(worse)}"
