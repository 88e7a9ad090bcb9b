"""Encoding of one sensor's readings as messages: its topics, and a function from a reading to their bytes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pelagos.messages.template import Buffer, Template
from pelagos.sensors.sensor import Reading


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


Values: TypeAlias = Callable[[NDArray[Any], Mapping[str, NDArray[Any]]], NDArray[np.float64]]


@dataclass(frozen=True)
class Table:
    """A topic whose messages differ in a row of numbers only, so that many are made in one go.

    Attributes:
        topic: where they go.
        template: takes seconds, nanoseconds and then the numbers.
        values: `(data (k, ...), extras (k, ...)) -> (k, m)`, the numbers of k readings.
    """

    topic: Topic
    template: Template
    values: Values


@dataclass(frozen=True)
class Encoding:
    """Messages of one sensor.

    Attributes:
        topics: in the order of what `encode` returns.
        encode: `(reading, copy)` -> one message a topic as CDR bytes, None where the topic has nothing to say.
        frames: frames that its messages use beside the sensor's own.
        tables: the same topics as tables, where they can be; else empty.
    """

    topics: tuple[Topic, ...]
    encode: Callable[[Reading, int], tuple[Buffer | None, ...]]
    frames: tuple[Frame, ...] = ()
    tables: tuple[Table, ...] = ()

    @property
    def templates(self) -> Sequence[Template | None]:
        """Template of each topic whose messages are rows of numbers, None for the others."""
        return [table.template for table in self.tables] or [None] * len(self.topics)


def tabular(*tables: Table, frames: tuple[Frame, ...] = ()) -> Encoding:
    """The encoding of a sensor all of whose topics are tables."""

    def encode(reading: Reading, copy: int) -> tuple[Buffer, ...]:
        row = slice(copy, copy + 1)
        extras = {name: values[row] for name, values in reading.extras.items()}
        data, time = reading.data[row], seconds_nanoseconds(reading.t_ns)
        return tuple(t.template.encode_row([*time, *t.values(data, extras)[0].tolist()]) for t in tables)

    return Encoding(tuple(t.topic for t in tables), encode, frames, tables)


@dataclass(frozen=True)
class Site:
    """Frame and topic to which a sensor's messages belong.

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
