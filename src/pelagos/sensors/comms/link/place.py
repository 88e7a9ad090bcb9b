"""Places of transponders and pingers: in the water, and above the ground."""

from __future__ import annotations

import numpy as np

from pelagos.errors import ScenarioError
from pelagos.sensors.sensor import SensorContext

_SUNK_M = 1.0  # in the ground that a device on it may be


def check_in_water(context: SensorContext, name: str, position: tuple[float, float, float]) -> None:
    """Check a place NWU [m].

    Raises:
        ScenarioError: it is above the mean sea surface, or below the ground.
    """
    x, y, z = position
    if z > 0.0:
        raise ScenarioError(f"{name!r} is {z:g} m above the water; z of position_m is 0 or less")
    ground = float(np.ravel(context.world.height(x, y))[0])
    if np.isfinite(ground) and z < ground - _SUNK_M:
        raise ScenarioError(f"{name!r} is {ground - z:.4g} m below the ground, which is at z = {ground:.4g} m there")
