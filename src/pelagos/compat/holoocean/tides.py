"""HoloOcean's controller of the tide: the native tide's amplitude and period."""

from __future__ import annotations

import math
from typing import Any

from pelagos.compat.holoocean.exceptions import HoloOceanException


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
        self.tide_type, self.active = tide_type, bool(active)

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
        if not float(frequency) > 0:
            raise HoloOceanException(f"the period of a tide is above zero ticks, not {frequency!r}")
        self.frequency = float(frequency)
        self._changed()

    def set_active(self, active: Any) -> None:
        """Whether it goes."""
        self.active = bool(active)
        self._changed()

    def set_tide_type(self, tide_type: str) -> None:
        """ "TideNormal"; HoloOcean's other, "TideFreaky", is random and not offered."""
        if tide_type != "TideNormal":
            raise HoloOceanException(f"there is the tide 'TideNormal' only, not {tide_type!r}")
        self.tide_type = tide_type

    def get_height(self) -> float:
        """The level now [m]."""
        t = self._env.pelagos.time_ns * 1e-9 * self._env._ticks_per_sec
        return self.amplitude * math.sin(2 * math.pi * t / self.frequency) if self.active else self._env.sea_level

    def follow(self) -> None:
        """After a tick: sensors go by the level that the native tide has."""
        if self.active:
            self._env.sea_level = self.get_height()
