"""Actuators in the mirror, port for starboard: the part on the other side, and the sign of its states and commands."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

HELMS = ("ship_rudder", "mmg_ship", "nomoto_ship", "bis_ship", "rolling_ship")
"""Kinds whose state is a helm: mirrored, it is laid to the other side."""
PLACES = ("position_m", "direction", "hole_m", "vent_m")
ONE_HAND = {
    "propeller": "its torque rolls the hull to one side, and the mirror's propeller would have the other hand",
}
"""Kinds that no number makes a mirror image of, and why."""
ONE_HAND_ROLLS = np.array([False, False, False, True, False, False])
"""What of their wrench (6) does not change its sign: the torque about x."""
SLANTED = {
    "mariner": {"Y0", "Y0u", "Y0uu", "N0", "N0u", "N0uu"},  # a single screw drives the ship to one side
}
"""Derivatives of vehicles that tell port from starboard, as published."""
_VARIABLE = re.compile(r"phi|[uvwpqrd]")


def odd(derivative: str, *, vertical: bool = False) -> bool:
    """Whether a derivative tells port from starboard; `vertical`: its d is of a plane that turns about y."""
    lateral = {"v", "p", "r", "phi"} | (set() if vertical else {"d"})
    count = sum(variable in lateral for variable in _VARIABLE.findall(derivative[1:]))
    return (count + (derivative[0] in "YKN")) % 2 == 1


def slanted(derivatives: dict[str, float], *, vertical: bool = False) -> set[str]:
    """Derivatives that tell port from starboard."""
    return {name for name in derivatives if odd(name, vertical=vertical)}


def lifts(derivatives: dict[str, float]) -> bool:
    """Whether a plane turns about y: a deflection makes heave, not sway."""
    return all(name[0] in "XZM" for name in derivatives if name.count("d") == 1)


def image(part: Any) -> tuple[Any, float]:
    """The part in the mirror, and the sign of its state and command there."""
    data: dict[str, Any] = part.model_dump()
    for key in PLACES:
        if data.get(key) is not None:
            x, y, z = data[key]
            data[key] = (x, -y, z)
    if "torque_m" in data:
        data["torque_m"] = -data["torque_m"]  # the other hand
    sign = -1.0 if part.type in HELMS or part.type == "fin" else 1.0
    if part.type == "fin":
        data["angle_deg"] = 180.0 - data["angle_deg"]  # right-handed about an axis is left-handed in the mirror
    elif part.type == "flap":
        sign = -1.0 if any(data[key] for key in ("C_Y", "C_l", "C_n")) else 1.0
    elif part.type == "plane":
        sign = 1.0 if lifts(data["derivatives"]) else -1.0
    elif part.type == "mmg_ship":
        for key in ("wake_change", "rudder_straightening"):
            *first, starboard, port = data[key]
            data[key] = (*first, port, starboard)
    elif part.type == "bis_ship":
        data["hull"] |= {key: -data["hull"][key] for key in ("YT", "NT")}  # a single screw
    if "derivatives" in data:
        turned = slanted(data["derivatives"], vertical=part.type == "plane" and sign > 0)
        data["derivatives"] = {key: -v if key in turned else v for key, v in data["derivatives"].items()}
    return type(part).model_validate(data), sign
