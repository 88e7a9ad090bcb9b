"""Errors of an ultra-short baseline beyond noise and echoes: its array, its motion sensor, its detector, its mounting.

Thermal and sea noise fall with the level, these do not: they are the floor that data sheets give as an accuracy.
"""

from __future__ import annotations

import numpy as np

from pelagos.acoustics.bearing import angles_of, direction_of, scattered, turned
from pelagos.sensors.comms.link.chance import Chance
from pelagos.sensors.comms.link.modem_port import ModemPort


def reported_bearing(
    port: ModemPort, chance: Chance, c: int, number: int, angles: tuple[float, float]
) -> tuple[float, float]:
    """Azimuth and elevation [rad] that the device tells of a packet, in the sensor frame.

    Args:
        port: with an array.
        chance: of the run.
        c: copy of the fleet.
        number: of the packet.
        angles: azimuth and elevation by the phases [rad].
    """
    if port.bearing_noise_deg == 0.0 and not any(port.alignment_std_deg):
        return angles
    direction = direction_of(*angles)
    if any(port.alignment_std_deg):
        direction = turned(direction, np.radians(port.alignment_std_deg) * chance.normals(port.path, "alignment", c, 3))
    left, up = np.radians(port.bearing_noise_deg) * chance.normals(port.path, f"pointing {number}", c, 2)
    return angles_of(scattered(direction, (float(left), float(up))))


def reported_range(port: ModemPort, chance: Chance, c: int, number: int, distance: float) -> float:
    """Range [m] that the device tells of a response, from the one by its clock [m]; see `reported_bearing`."""
    if port.range_noise_m == 0.0:
        return distance
    (drawn,) = chance.normals(port.path, f"range {number}", c, 1)
    return max(distance + port.range_noise_m * float(drawn), 0.0)
