"""Time before a shot in which actuators follow their commands, so that their states at its beginning are known."""

from __future__ import annotations

import math
from typing import Final

from pelagos.identification.plan import Plan
from pelagos.vehicles.model import Model

SHORTEST_S: Final = 3.0
"""Least preroll where a plan gives none [s]."""
_KEPT: Final = 1e-5
"""Part of what an actuator was off that is left when a shot begins: the recorded motion of a run, without noise, shows
no more."""
_REFITTED: Final = 1e-4
"""Part from which on a fit is made again with the lags that it found."""
_DOUBTED: Final = 1e-3
"""Part from which on a preroll that was given is doubtful: noise hides less."""
_MOST: Final = 0.5
"""Share of the record: where shots wait for the preroll (`unknown`), no fit is made again with a longer one."""


def settling_s(model: Model, left: float = _KEPT) -> dict[str, float]:
    """Time after which only a part `left` is left of what each actuator was off its command, from any state [s]."""
    found = {}
    for name, actuator in model.actuators.items():
        lag = actuator.lag
        rate = getattr(lag, "rate_limit", None)
        stroke = 0.0 if rate is None else (float(lag.high) - float(lag.low)) / float(rate)
        found[name] = -math.log(left) * float(lag.time_constant) + (stroke if math.isfinite(stroke) else 0.0)
    return found


def preroll_of(plan: Plan, model: Model) -> float:
    """Time before each shot [s]: the plan's, or as long as the slowest actuator takes."""
    if plan.preroll_s is not None:
        return plan.preroll_s
    return max([SHORTEST_S, *settling_s(model).values()])


def longer_preroll(plan: Plan, preroll_s: float, model: Model, length_s: float) -> float | None:
    """The preroll with which a fit is to be made again [s], or None.

    Args:
        plan: one that says `preroll_s` keeps it.
        preroll_s: of the fit that was made; model: that it found.
        length_s: of the record.
    """
    needed = preroll_of(plan, model)
    slow = any(t > preroll_s for t in settling_s(model, _REFITTED).values())
    possible = plan.actuators_from != "unknown" or needed <= _MOST * length_s
    return needed if slow and possible and needed > preroll_s else None


def doubts_of_preroll(plan: Plan, preroll_s: float, model: Model) -> tuple[str, ...]:
    """Actuators that take longer to their commands than they are given."""
    slow = {name: t for name, t in settling_s(model, _DOUBTED).items() if t > preroll_s}
    if not slow:
        return ()
    cure = "record for longer, or give actuators_from: rest or commands" if plan.preroll_s is None else "give more"
    return (
        f"{', '.join(slow)}: up to {max(slow.values()):.3g} s from a command to within a thousandth of it, longer than "
        f"the {preroll_s:.3g} s before each shot (preroll_s), so that shots begin in another state: {cure}",
    )
