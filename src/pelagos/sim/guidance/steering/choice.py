"""The steering of a vehicle, by its family and envelope."""

from __future__ import annotations

from typing import Final

import numpy as np

from pelagos.sim.guidance.steering.cruise import Cruise
from pelagos.sim.guidance.steering.hover import Hover
from pelagos.sim.guidance.steering.steering import Crab, Lead, Steering
from pelagos.sim.guidance.steering.surface import Surface
from pelagos.vehicles.envelope import EnvelopeConfig
from pelagos.vehicles.family import Family

LOOKAHEAD_LENGTHS: Final = {"torpedo": 12.0, "glider": 12.0, "surface": 4.0, "ship": 6.0, "airplane": 12.0}
"""Hull lengths that a vehicle aims ahead on its line; of a torpedo AUV about its turning radius."""
SHARE_OF_RADIUS: Final = 0.5  # of the turning circle: nobody aims nearer ahead than that
KEEPING: Final = 1.3  # turning circles' radii: how wide those circle that cannot stop, with a current to make up for
LEAD_S: Final = 1.5  # a reference point runs ahead of its vehicle by at most this time at cruising speed,
LEAD_M: Final = 0.8  # and is allowed this much at any speed
GAIN_S: Final = 2.5  # it takes this long to cruising speed


def steering_of(family: Family, envelope: EnvelopeConfig, length_m: float, n: int) -> Steering:
    """A new steering for n lanes of a vehicle of a length [m]."""
    if family.name in ("hover", "rotor"):
        return Hover(envelope.cruise_mps / GAIN_S, max(LEAD_M, LEAD_S * envelope.cruise_mps))
    lookahead = LOOKAHEAD_LENGTHS[family.name] * length_m
    crab, lead = Crab(np.zeros(n)), Lead(np.zeros(n))
    if family.name == "surface":
        return Surface(lookahead, length_m, envelope.cruise_mps, crab, lead)
    radius = envelope.turn_radius_m or lookahead
    keeping = KEEPING * radius
    if family.name in ("airplane", "ship"):
        lookahead = max(lookahead, SHARE_OF_RADIUS * radius)
    return Cruise(family.name, lookahead, keeping, envelope.cruise_mps, crab, lead)  # type: ignore[arg-type]
