"""The answers of the step loop to sensors that ask about other agents while they read."""

from __future__ import annotations

from dataclasses import dataclass

from pelagos.sensors.comms.link.medium import SharedMedium
from pelagos.sensors.navigation.collision import Blows
from pelagos.sensors.sonar.ping.interference import Neighbours


@dataclass(frozen=True)
class Encounters:
    """Sensors are built with these, and the step loop answers through them; a model does not hold them.

    Attributes:
        neighbours: the sonars of a scenario, which may hear one another.
        blows: contacts of hulls in the last second.
        medium: the water between modems.
    """

    neighbours: Neighbours
    blows: Blows
    medium: SharedMedium
