"""Time before a shot in which actuators follow their commands, so that their states at its beginning are known."""

from __future__ import annotations

import math
from typing import Final

from pelagos.identification.plan import SHORTEST_PREROLL_S, Plan
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.model import Model

_LEFT: Final = math.log(100)  # time constants after which a hundredth is left of what an actuator was off


def settling_s(model: Model) -> dict[str, float]:
    """Time that each actuator takes to within a hundredth of its command, from any state [s]."""
    found = {}
    for name, actuator in model.actuators.items():
        lag = actuator.lag
        if not isinstance(lag, Lag):
            continue
        stroke = 0.0 if lag.rate_limit is None else (float(lag.high) - float(lag.low)) / float(lag.rate_limit)
        found[name] = _LEFT * float(lag.time_constant) + (stroke if math.isfinite(stroke) else 0.0)
    return found


def preroll_of(plan: Plan, model: Model) -> float:
    """Time before each shot [s]: the plan's, or as long as the slowest actuator takes."""
    if plan.preroll_s is not None:
        return plan.preroll_s
    return max([SHORTEST_PREROLL_S, *settling_s(model).values()])


def doubts_of_preroll(preroll_s: float, model: Model) -> tuple[str, ...]:
    """Actuators that take longer to their commands than they are given."""
    slow = {name: t for name, t in settling_s(model).items() if t > preroll_s}
    if not slow:
        return ()
    return (
        f"{', '.join(slow)}: up to {max(slow.values()):.3g} s from a command to the state, longer than preroll_s "
        f"{preroll_s:g}, so that shots begin with another one: give more, or leave it out",
    )
