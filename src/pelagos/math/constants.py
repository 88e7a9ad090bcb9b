"""Constants that several layers share."""

from __future__ import annotations

from typing import Final

GRAVITY: Final = 9.81  # [m/s^2]
ATMOSPHERE_PA: Final = 101_325.0  # standard atmosphere [Pa], ISO 2533
