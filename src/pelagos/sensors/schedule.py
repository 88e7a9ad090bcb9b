"""From a rate to a number of ticks: a sensor is due on ticks that are multiples of its period, 0 included."""

from __future__ import annotations

import math

from pelagos.errors import ScenarioError


def period_ticks(rate_hz: float, dt_ns: int, *, where: str = "") -> int:
    """Ticks between two samples.

    Raises:
        ScenarioError: the rate does not divide the tick rate; the message names the nearest rates that do.
    """
    tick_rate = 1e9 / dt_ns
    exact = tick_rate / rate_hz
    period = round(exact)
    whole_ns = 0.5 / dt_ns  # 30 ticks a second are ticks of 33 333 333 ns, not quite 30 a second
    if period >= 1 and math.isclose(exact, period, rel_tol=max(1e-9, whole_ns)):
        return period
    near = {max(math.floor(exact), 1), max(math.ceil(exact), 1)}
    rates = " or ".join(f"{tick_rate / p:.6g}" for p in sorted(near, reverse=True))
    problem = "is faster than" if rate_hz > tick_rate else "does not divide"
    message = f"rate_hz {rate_hz:g} {problem} the tick rate of {tick_rate:g} Hz; nearest: {rates}"
    raise ScenarioError(message, where=where)
