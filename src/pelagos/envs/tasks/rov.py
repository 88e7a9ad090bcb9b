"""The ROV of tasks: a BlueROV2 Heavy whose thrusters lag by 0.1 s."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

NAME: Final = "bluerov2_heavy"
LAG_S: Final = 0.1
"""The catalogue's was 0.1 s when these tasks were first learned, and is the measured 13.4 ms now: an episode's dynamics
stay as they are as long as the task's version does."""
_THRUSTERS: Final = tuple(
    f"{row}_{side}" for row in ("front", "rear", "top_front", "top_rear") for side in ("starboard", "port")
)


def rov(variant: str | None = None) -> Mapping[str, Any]:
    """The vehicle of a task, with a published set of mass and drag."""
    chosen = {} if variant is None else {"variant": variant}
    return {"type": NAME, **chosen, "actuators": {name: {"time_constant_s": LAG_S} for name in _THRUSTERS}}
