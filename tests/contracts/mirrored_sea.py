"""The sea of `test_every_sensor_key` in the mirror, port for starboard."""

from __future__ import annotations

from typing import Any

PLACES = ("position_m", "at_m")
ANGLES = ("heading_deg", "towards_deg", "from_deg", "azimuth_deg")
EVEN = {"type": "remus100", "actuators": {"propeller": {"torque_fraction": 0.0}}}
"""A vehicle without the torque of its screw, which has one hand."""


def mirrored(value: Any, key: str = "") -> Any:
    """The image of a scenario: places across, headings and turns about x and z the other way round."""
    if isinstance(value, dict):
        return {k: mirrored(v, k) for k, v in value.items()}
    if key in PLACES:
        return [value[0], -value[1], *value[2:]]
    if key == "points_m":
        return [mirrored(p, "at_m") for p in value]
    if key == "orientation_deg":
        return [-value[0], value[1], -value[2]]
    if key in ANGLES:
        return -value
    if key == "command":
        return [value[0], -value[1], *value[2:]]  # depth, heading, revolutions
    return [mirrored(v) for v in value] if isinstance(value, list) else value
