"""Keys of legs that the steering of a family of vehicles has no use for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

_TURNING = ("hover", "rotor")
"""Families that go up and down on the spot, at a rate of their own."""
_DRIVEN = {
    "ship": "goes as fast as its engine's setting drives it",
    "glider": "goes as fast as its buoyancy and its glide angle drive it",
}
"""Families whose control modes have no set-point of speed."""


@dataclass(frozen=True)
class Unheard:
    """key: of the leg; why: what the vehicle does instead, after its name."""

    key: str
    why: str


def unheard_key(leg: Any, family: str) -> Unheard | None:
    """The first key that a leg gives and that vehicles of a family would not follow; None without any."""
    for key, why in _unheard(leg, family):
        if getattr(leg, key) != type(leg).model_fields[key].default:
            return Unheard(key, why)
    return None


def _unheard(leg: Any, family: str) -> list[tuple[str, str]]:
    if family in _DRIVEN and "speed_mps" in type(leg).model_fields:
        return [("speed_mps", _DRIVEN[family])]
    if leg.type in ("dive", "surface") and family in _TURNING:
        return [("speed_mps", "goes up and down at a rate of its own")]
    if leg.type != "profile" or family == "glider":
        return []
    if family not in _TURNING:
        return [("glide_deg", "pitches as its control mode does")]
    upright = [(key, "goes straight up and down") for key in ("glide_deg", "heading_deg")]
    return upright + ([("speed_mps", "goes straight up and down without a 'point'")] if leg.point is None else [])
