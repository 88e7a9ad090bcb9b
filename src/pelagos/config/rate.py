"""Rates at which things are sampled: their type, and whether one divides the tick rate."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Field

Rate: TypeAlias = Annotated[float, Field(ge=1e-6)]
"""Samples per second [Hz]; one in twelve days at least."""


def divides(rate_hz: float, tick_rate_hz: float) -> bool:
    """True where a sample falls due every whole number of ticks."""
    ticks = tick_rate_hz / rate_hz
    return ticks > 1 - 1e-9 and abs(ticks - round(ticks)) < 1e-6 * ticks


_MOST_TRIED = 100_000
"""Ticks between two samples up to which the nearest rates that divide are looked for."""


def rate_text(rate_hz: float, tick_rate_hz: float) -> str:
    """The fault of a rate in words, and the nearest rates that are possible."""
    if rate_hz > tick_rate_hz:
        return f"{rate_hz:g} Hz is faster than the tick rate of {tick_rate_hz:g} Hz; at most {tick_rate_hz:g} Hz"
    ticks = tick_rate_hz / rate_hz
    if ticks > _MOST_TRIED:
        return (
            f"{rate_hz:g} Hz does not divide the tick rate of {tick_rate_hz:g} Hz; give {tick_rate_hz:g} / k, k whole"
        )
    above = next((tick_rate_hz / k for k in range(int(ticks), 0, -1) if _short(tick_rate_hz / k)), tick_rate_hz)
    below = next(
        (tick_rate_hz / k for k in range(int(ticks) + 1, int(ticks) * 10 + 10) if _short(tick_rate_hz / k)), None
    )
    near = f"{below:g} or {above:g} Hz" if below else f"{above:g} Hz"
    return f"{rate_hz:g} Hz does not divide the tick rate of {tick_rate_hz:g} Hz; the nearest that do are {near}"


def _short(rate_hz: float) -> bool:
    """True for a rate that three decimals write."""
    return abs(rate_hz * 1000 - round(rate_hz * 1000)) < 1e-9
