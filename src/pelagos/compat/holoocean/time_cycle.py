"""HoloOcean's controller of the time of day."""

from __future__ import annotations

from typing import Any, Final

from pelagos.compat.holoocean.exceptions import HoloOceanException

_STEP_H: Final = 0.25  # the sun is moved when it has gone so far: light is worked out anew then


class TimeController:
    """Hours that go round once in `frequency` ticks from midnight on, or stand still."""

    def __init__(self, client: Any, frequency: float = 0, hour: float = 12, active: bool = False) -> None:
        self._env, self.hour, self.active = client, hour, bool(active)
        self._shown: float | None = None
        self.set_frequency(frequency)

    def set_frequency(self, frequency: float) -> None:
        """Ticks of a day; with 0 it stands still.

        Raises:
            HoloOceanException: below zero.
        """
        if not frequency >= 0:
            raise HoloOceanException(f"a day has 0 ticks or more, not {frequency!r}")
        self.frequency = frequency

    def set_hour(self, hour: float) -> None:
        """The time of day, from the next tick on."""
        self.hour = hour
        self._env.change_time_of_day(hour)

    def set_active(self, active: bool) -> None:
        """Whether it goes on."""
        self.active = bool(active)

    def get_time_of_day(self) -> float:
        """The hour now."""
        return self.hour

    def tick(self, ticks: int) -> None:
        """After a tick; the sun goes on in steps of a quarter of an hour."""
        if not self.frequency:
            return
        self.hour = 24.0 * (ticks % self.frequency) / self.frequency
        if self._shown is None or abs(self.hour - self._shown) >= _STEP_H:
            self._shown = self.hour
            self._env.change_time_of_day(self.hour)
