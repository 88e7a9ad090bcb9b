"""Goal of a task at this moment, lane by lane; a steering turns it into set-points of a control mode."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.aboard import Aboard, Floats


class Path:
    """Shapes of the way: plain numbers, which arrays of lanes hold.

    COURSE: straight on, at `course`; vehicles that can stop stay at `end`. LINE: along the line from `start` to `end`.
    CIRCLE: around `end` at `radius`. POINT: to `end`, and stay there. DRIFT: no way of one's own. OVER: the mission has
    ended at `end`.
    """

    COURSE: Final = 0
    LINE: Final = 1
    CIRCLE: Final = 2
    POINT: Final = 3
    DRIFT: Final = 4
    OVER: Final = 5


@dataclass
class Goal:
    """Arrays of m lanes.

    Attributes:
        path: `Path`.
        start, end: `(m, 2)` world x, y [m].
        radius: of a circle [m], and of waiting near a point for those who cannot stop.
        turn: 1 clockwise, -1 counterclockwise.
        course: of the compass [rad].
        face: compass heading of those who turn on the spot [rad]; not a number: along the way.
        depth: positive down [m].
        upper: upper turning depth of those who glide [m]; not a number: their own.
        glide: pitch of those who glide [rad]; likewise.
        speed: [m/s].
        sink: largest vertical speed of those who hover [m/s]; not a number: their own.
        stops: the vehicle slows down to stop at `end`.
    """

    path: NDArray[np.int64]
    start: Floats
    end: Floats
    radius: Floats
    turn: Floats
    course: Floats
    face: Floats
    depth: Floats
    upper: Floats
    glide: Floats
    speed: Floats
    sink: Floats
    stops: NDArray[np.bool_]

    @classmethod
    def stay(cls, aboard: Aboard) -> Goal:
        """Stay where the vehicle is."""
        m, here = len(aboard), aboard.xy
        radius, face, upper, glide, sink, turn, speed = rows = np.empty((7, m))
        rows[:5], rows[5], rows[6] = np.nan, 1.0, 0.0
        return cls(
            path=np.full(m, Path.POINT), start=here.copy(), end=here.copy(), radius=radius, turn=turn,
            course=aboard.own.heading.copy(), face=face, depth=aboard.depth, upper=upper, glide=glide,
            speed=speed, sink=sink, stops=np.ones(m, dtype=bool),
        )  # fmt: skip

    def put(self, lanes: NDArray[np.intp], other: Goal) -> None:
        """Set some lanes."""
        for item in fields(self):
            getattr(self, item.name)[lanes] = getattr(other, item.name)
