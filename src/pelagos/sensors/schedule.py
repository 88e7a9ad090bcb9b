"""Schedule of a sensor: due on ticks that are multiples of its period, 0 included; and its unambiguous range."""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, Any, Final

from pelagos.errors import ScenarioError, ValidityWarning
from pelagos.math.constants import NOMINAL_SOUND_SPEED

if TYPE_CHECKING:
    from pelagos.sensors.sensor import SensorConfig

SLOWEST: Final = 1400.0  # sound speed [m/s] by which a range is surely unambiguous


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


def farthest_heard(rate_hz: float, sound_speed: Any = NOMINAL_SOUND_SPEED) -> Any:
    """Range [m] from which an echo comes before the next ping: c/(2 rate)."""
    return sound_speed * (0.5 / rate_hz)


def slower(rate_hz: float, reach: float) -> float:
    """The fastest whole part of a rate at which echoes from `reach` [m] are unambiguous.

    For parts of a sonar, which ping when the sonar says so.
    """
    pings_in_flight = 2.0 * reach * rate_hz / SLOWEST
    return rate_hz / max(math.ceil(pings_in_flight), 1)


def warn_of_ambiguity(config: SensorConfig, path: str, reach: float, *, device: str | None = None) -> None:
    """Warn where a scenario asks for ranges (`range_max_m`, [m]; `reach` along the beams) beyond the next ping.

    A `device` of the catalogue has its range from its maker, who knows how often it pings there.
    """
    heard = farthest_heard(config.rate_hz, SLOWEST)
    if "range_max_m" in config.model_fields_set and device is None and reach > heard:
        message = (
            f"{path}: echoes from {reach:.4g} m come after the next ping at {config.rate_hz:g} Hz, and are lost; "
            + (f"ranges up to {heard:.4g} m are heard, or all at {SLOWEST / (2 * reach):.3g} Hz")
        )
        warnings.warn(message, ValidityWarning, stacklevel=4)
