"""Device tables of a vehicle's step."""

from __future__ import annotations

from pelagos import jit
from pelagos.vehicles.actuators.t200 import T200Tables
from pelagos.vehicles.hull_pressure import HullTable
from pelagos.vehicles.nearby import Walls


@jit.struct
class Tables:
    """thrusters: measured, of T200; hull: the mesh of what floats; walls: near the vehicles, of this tick. None where
    there is nothing to read.
    """

    thrusters: T200Tables | None
    hull: HullTable | None
    walls: Walls | None = None
