"""Constants that several layers share."""

from __future__ import annotations

from typing import Final

GRAVITY: Final = 9.81  # [m/s^2]
STANDARD_GRAVITY: Final = 9.80665  # [m/s^2], by definition: the g of data sheets and protocols
NOMINAL_SOUND_SPEED: Final = 1500.0  # [m/s], of sea water: for lengths that data sheets state and sonars do not measure
ATMOSPHERE_PA: Final = 101_325.0  # standard atmosphere [Pa], ISO 2533
