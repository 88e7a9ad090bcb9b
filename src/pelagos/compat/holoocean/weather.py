"""HoloOcean's controller of the weather."""

from __future__ import annotations

from typing import Any

from pelagos.compat.holoocean.exceptions import HoloOceanException


class WeatherController:
    """Weather 0 (sunny), 1 (cloudy) or 2 (rain) of an environment."""

    def __init__(self, client: Any, cur_weather: int | None = None) -> None:
        if cur_weather not in (None, 0, 1, 2):
            raise HoloOceanException(f"a weather is 0 (sunny), 1 (cloudy) or 2 (rain), not {cur_weather!r}")
        self._env, self.cur_weather = client, cur_weather

    def get_weather(self) -> int | None:
        """The present one; None where none was chosen."""
        return self.cur_weather

    def set_weather(self, weather_type: int) -> None:
        """Another one."""
        self._env.change_weather(weather_type)
