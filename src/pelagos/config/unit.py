"""The unit that a key's last letters state: `range_max_m` is in metres."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Final

from pelagos.math.units import KNOT, LENGTHS, SPEEDS

UNITS: Final = {
    "m": "metres [m]",
    "mps": "metres per second [m/s]",
    "mps2": "metres per second squared [m/s^2]",
    "s": "seconds [s]",
    "ms": "milliseconds [ms]",
    "us": "microseconds [us]",
    "ns": "nanoseconds [ns]",
    "hz": "hertz [Hz]",
    "khz": "kilohertz [kHz]",
    "deg": "degrees [deg]",
    "degps": "degrees per second [deg/s]",
    "dps": "degrees per second [deg/s]",
    "rad": "radians [rad]",
    "radps": "radians per second [rad/s]",
    "kg": "kilograms [kg]",
    "n": "newtons [N]",
    "nm": "newton metres [N m]",
    "pa": "pascals [Pa]",
    "v": "volts [V]",
    "w": "watts [W]",
    "db": "decibels [dB]",
    "c": "degrees Celsius [degC]",
    "degc": "degrees Celsius [degC]",
    "celsius": "degrees Celsius [degC]",
    "psu": "practical salinity [psu]",
    "rpm": "revolutions per minute [rpm]",
    "t": "teslas [T]",
    "nt": "nanoteslas [nT]",
}

# What people write beside a number, as a factor to the unit that a key states.
FACTORS: Final[Mapping[str, Mapping[str, float]]] = {
    "m": LENGTHS,
    "mps": {"m/s": 1.0, "mps": 1.0, "kn": KNOT, "kt": KNOT, "knots": KNOT, "km/h": SPEEDS["km/h"]},
    "s": {"s": 1.0, "sec": 1.0, "min": 60.0, "h": 3600.0, "ms": 0.001},
    "hz": {"hz": 1.0, "khz": 1000.0, "mhz": 1e6},
    "khz": {"khz": 1.0, "hz": 0.001, "mhz": 1000.0},
    "deg": {"deg": 1.0, "°": 1.0, "rad": 57.29577951308232},
    "kg": {"kg": 1.0, "g": 0.001, "lb": 0.45359237},
}


_MISREAD: Final = ("mHz",)
"""Spellings whose small letters are another unit: mHz is not MHz."""


def unit_of(key: str) -> str:
    """The unit in words that a key ends in, with its symbol in brackets; empty where it states none."""
    return UNITS.get(key.rpartition("_")[2], "")


def symbol_of(key: str) -> str:
    """The unit's symbol in brackets with a space before it, `" [m]"`; empty where the key states none."""
    match = re.search(r"\[.*\]", unit_of(key))
    return f" {match[0]}" if match else ""


def in_unit_of(key: str, text: str) -> float | None:
    """The number in `text`, such as "40 ft", in the unit of the key; None where that is not understood."""
    match = re.fullmatch(r"\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*([A-Za-z/°]+)\s*", text)
    factors = FACTORS.get(key.rpartition("_")[2], {})
    if match is None or match[2].lower() not in factors or match[2] in _MISREAD:
        return None
    try:
        value = float(f"{float(match[1]) * factors[match[2].lower()]:.6g}")
    except ValueError:
        return None
    return value if math.isfinite(value) else None
