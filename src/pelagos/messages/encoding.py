"""How one sensor's readings become messages: its topics, and a function from a reading to their bytes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, TypeAlias

from pelagos.sensors.sensor import Reading

Buffer: TypeAlias = bytes | bytearray


@dataclass(frozen=True)
class Topic:
    """A topic below the sensor's own name, and its message type; an empty suffix is the name itself."""

    suffix: str
    type: str


@dataclass(frozen=True)
class Frame:
    """A frame beside the sensor's own, in which a message type wants its vectors.

    Attributes:
        suffix: its id is the sensor's with this behind it.
        attitude: quaternion wxyz, from this frame to the sensor's.
    """

    suffix: str
    attitude: tuple[float, float, float, float]


OPTICAL: Final = Frame("_optical", (0.5, -0.5, 0.5, -0.5))
"""z forward, x right, y down: cameras."""
PROJECTED: Final = Frame("_projected", (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5)))
"""z forward, x up, y right: ProjectedSonarImage."""
DOWNWARD: Final = Frame("_frd", (0.0, 1.0, 0.0, 0.0))
"""x forward, y right, z down: Dvl and the multibeam messages."""


@dataclass(frozen=True)
class Encoding:
    """What one sensor says.

    Attributes:
        topics: in the order of what `encode` returns.
        encode: `(reading, copy)` -> one message a topic as CDR bytes, None where the topic has nothing to say.
        frames: frames that its messages use beside the sensor's own.
    """

    topics: tuple[Topic, ...]
    encode: Callable[[Reading, int], tuple[Buffer | None, ...]]
    frames: tuple[Frame, ...] = ()


@dataclass(frozen=True)
class Site:
    """Where a sensor's messages belong.

    Attributes:
        frame: frame id of the sensor, "auv0/imu".
        latitude_deg, longitude_deg: the world's origin [deg].
    """

    frame: str
    latitude_deg: float
    longitude_deg: float


def seconds_nanoseconds(t_ns: int) -> tuple[int, int]:
    """Simulation time [ns] as a ROS stamp."""
    return divmod(t_ns, 1_000_000_000)
