"""Choices of a trial, and which manoeuvre takes which."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Final

from pelagos.errors import InputError


@dataclass(frozen=True)
class Orders:
    """Choices of a trial: helm, heading at which a zig-zag turns [deg], speed before [m/s], longest run [s]."""

    rudder_deg: float | None = None
    angle_deg: float | None = None
    speed_m_s: float | None = None
    seconds: float | None = None


TAKEN: Final[dict[str, frozenset[str]]] = {
    "turning": frozenset({"rudder_deg", "speed_m_s", "seconds"}),
    "zigzag": frozenset({"rudder_deg", "angle_deg", "speed_m_s", "seconds"}),
    "stop": frozenset({"speed_m_s", "seconds"}),
    "spiral": frozenset({"rudder_deg", "speed_m_s", "seconds"}),
    "decay": frozenset({"angle_deg", "seconds"}),
    "bollard": frozenset(),
}
"""Orders that each manoeuvre takes."""


def check(name: str, orders: Orders) -> None:
    """Refuse an order that the manoeuvre would ignore, and one of zero."""
    for key in (f.name for f in fields(orders)):
        value, option = getattr(orders, key), "--" + key.split("_")[0]
        if value is None:
            continue
        if key not in TAKEN[name]:
            allowed = ", ".join("--" + k.split("_")[0] for k in sorted(TAKEN[name])) or "no option"
            raise InputError(f"{option} {value:g}: {name} takes {allowed}")
        if not math.isfinite(value) or value == 0 or (value < 0 and key in ("speed_m_s", "seconds")):
            raise InputError(f"{option} {value:g}: give a number {'other than' if key[0] in 'ra' else 'above'} 0")
