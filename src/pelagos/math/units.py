"""Units of length and speed beside the metre: one table for scenarios, plans, surveys, instruments and sounds.

Source: BIPM, The International System of Units (9th ed., 2019), Tables 7 and 8; the international yard and pound
agreement of 1959 (foot of 0.3048 m) and the nautical mile of 1929 (1852 m).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

LENGTHS: Final[Mapping[str, float]] = {
    "m": 1.0, "km": 1000.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048, "in": 0.0254, "nmi": 1852.0, "fathom": 1.8288,
}  # fmt: skip
"""Metres in a unit."""
KNOT: Final = LENGTHS["nmi"] / 3600
"""[m/s]"""
SPEEDS: Final[Mapping[str, float]] = {
    "m/s": 1.0, "cm/s": LENGTHS["cm"], "mm/s": LENGTHS["mm"], "km/h": 1 / 3.6, "kn": KNOT,
}  # fmt: skip
"""Metres per second in a unit."""
