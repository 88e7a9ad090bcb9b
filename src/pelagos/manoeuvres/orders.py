"""Choices of a trial, and which manoeuvre takes which."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Final

from pelagos.errors import InputError


@dataclass(frozen=True)
class Orders:
    """Choices of a trial: helm, heading at which a zig-zag turns [deg], speed before [m/s], longest run [s], depth of
    the water [m].
    """

    rudder_deg: float | None = None
    angle_deg: float | None = None
    speed_m_s: float | None = None
    seconds: float | None = None
    depth_m: float | None = None


_LARGEST_DEG: Final = 90.0
"""Heel, or heading of a zig-zag: beyond it a ship lies on its side, or sails back."""
TAKEN: Final[dict[str, frozenset[str]]] = {
    "turning": frozenset({"rudder_deg", "speed_m_s", "seconds", "depth_m"}),
    "zigzag": frozenset({"rudder_deg", "angle_deg", "speed_m_s", "seconds", "depth_m"}),
    "stop": frozenset({"speed_m_s", "seconds", "depth_m"}),
    "spiral": frozenset({"rudder_deg", "speed_m_s", "seconds", "depth_m"}),
    "decay": frozenset({"angle_deg", "seconds", "depth_m"}),
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
        signed = key == "rudder_deg" or (key == "angle_deg" and name == "decay")
        if not math.isfinite(value) or value == 0 or (value < 0 and not signed):
            raise InputError(f"{option} {value:g}: give a number {'other than' if signed else 'above'} 0")
        if key == "angle_deg" and abs(value) > _LARGEST_DEG:
            raise InputError(f"{option} {value:g}: give at most {_LARGEST_DEG:g} deg")
