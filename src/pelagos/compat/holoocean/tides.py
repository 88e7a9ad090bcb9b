"""HoloOcean's controller of the tide: the native tide's amplitude and period."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

from pelagos.compat.holoocean.exceptions import HoloOceanException

TIDE_KEYS: Final = ("level", "offset", "amplitude", "period", "max_rate", "active")
"""Of the scenario's `tide`, HoloOcean 2.4."""


def cycle_of(scenario: Mapping[str, Any], ticks_per_sec: int) -> tuple[float, float, bool]:
    """Amplitude [m] and period [ticks] of a scenario's tide, and whether it goes: `tide_cycle`, or else `tide`."""
    cycle, tide = scenario.get("tide_cycle"), scenario.get("tide")
    if cycle or not tide or not (tide.get("amplitude") and tide.get("period")):
        cycle = cycle or {}
        amplitude, ticks, active = cycle.get("amplitude", 100.0), cycle.get("frequency", 2000), cycle.get("active")
    else:
        amplitude, ticks, active = tide["amplitude"], float(tide["period"]) * ticks_per_sec, tide.get("active", True)
    return float(amplitude), _ticks(ticks) if active else float(ticks), bool(active)


def _ticks(period: Any) -> float:
    """Ticks of a period.

    Raises:
        HoloOceanException: not above zero.
    """
    if not float(period) > 0:
        raise HoloOceanException(f"the period of a tide is above zero ticks, not {period!r}")
    return float(period)


def level_of(scenario: Mapping[str, Any]) -> float:
    """The level that a scenario's `tide` begins with [m]."""
    tide = scenario.get("tide") or {}
    return float(tide.get("level", 0.0)) + float(tide.get("offset", 0.0))


class TideController:
    """A level of A sin(2 pi ticks / frequency) [m] while active.

    HoloOcean's comments say centimetres; what its engine does is metres, and so does this.
    """

    def __init__(
        self,
        client: Any,
        amplitude: float = 100.0,
        frequency: float = 2000,
        tide_type: str = "TideNormal",
        active: Any = 0,
    ) -> None:
        self._env, self.amplitude, self.frequency = client, float(amplitude), float(frequency)
        self.active = bool(active)
        self.set_tide_type(tide_type)

    def _changed(self) -> None:
        cycle = self._env._scenario.setdefault("tide_cycle", {})
        cycle.update(active=self.active, amplitude=self.amplitude, frequency=self.frequency)
        self._env._stale = True

    def set_amplitude(self, amplitude: float) -> None:
        """Half of the range [m]."""
        self.amplitude = float(amplitude)
        self._changed()

    def set_frequency(self, frequency: float) -> None:
        """Ticks of a period."""
        self.frequency = _ticks(frequency)
        self._changed()

    def set_period(self, period: float) -> None:
        """Seconds of a period."""
        self.set_frequency(float(period) * self._env._ticks_per_sec)

    def set_active(self, active: Any) -> None:
        """Whether it goes."""
        if active:
            _ticks(self.frequency)
        self.active = bool(active)
        self._changed()

    def set_tide_type(self, tide_type: str) -> None:
        """ "TideNormal"; HoloOcean's other, "TideFreaky", is random and not offered."""
        if tide_type != "TideNormal":
            raise HoloOceanException(f"there is the tide 'TideNormal' only, not {tide_type!r}")
        self.tide_type = tide_type

    def get_height(self) -> float:
        """The level now [m]."""
        if not self.active:
            return float(self._env.sea_level)
        return self.amplitude * math.sin(2 * math.pi * self._env._num_ticks / self.frequency)

    def follow(self) -> None:
        """After a tick: sensors go by the level that the native tide has."""
        if self.active:
            self._env.sea_level = self.get_height()
