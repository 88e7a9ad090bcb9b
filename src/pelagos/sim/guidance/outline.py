"""The way that a mission means to go, as points: for maps and for software outside, before anything has moved."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.config.agent import Start
from pelagos.sim.guidance.guidance import Step
from pelagos.sim.guidance.line import Line
from pelagos.sim.guidance.orbit import Orbit
from pelagos.sim.guidance.task import Level, Task
from pelagos.sim.guidance.vertical import Dive, Land, Profile
from pelagos.sim.guidance.wait import Station

Height = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]
CIRCLE_STEP: Final = math.radians(10.0)  # between two points of an orbit
_SAME_M: Final = 1e-6


def outline(steps: Sequence[Step], start: Sequence[float], height: Height) -> NDArray[np.float64]:
    """`(k, 3)` corners of the planned way in NWU [m], the start first.

    What nobody knows beforehand is left out: following a vehicle or a wall, drifting, and where a heading is held until
    something happens. A `Line` ends at its goal; how a vehicle rounds its corners depends on the vehicle.

    Args:
        steps: of the mission.
        start: where it begins (x, y, z) [m].
        height: `(x, y)` -> z of the seabed [m].
    """
    way = [np.asarray(start, dtype=np.float64)]
    for step in steps:
        for x, y in _corners(step.task, way[-1]):
            goal = np.array([x, y, _level(_deep(step.task), x, y, way[-1][2], height)])
            if np.abs(goal - way[-1]).max() > _SAME_M:
                way.append(goal)
    return np.stack(way)


def start_of(start: Start, height: Height) -> tuple[float, float, float]:
    """(x, y, z) where a scenario puts an agent, NWU [m]; at the mean sea surface where it gives no height."""
    x, y, *z = start.position_m
    depth = start.depth_m if start.depth_m is not None else -(z[0] if z else 0.0)
    return x, y, _level(Level(depth, start.altitude_m), x, y, -depth, height)


def _corners(task: Task, at: NDArray[np.float64]) -> list[tuple[float, float]]:
    """Places (x, y) of one task, for a vehicle that comes from `at`."""
    here = (float(at[0]), float(at[1]))
    if isinstance(task, Line):
        return [task.end] if task.start is None else [task.start, task.end]
    if isinstance(task, Orbit):
        return _circle(task, here)
    if isinstance(task, Station | Land | Profile) and task.point is not None:
        return [task.point]
    return [here] if isinstance(task, Dive | Station) else []


def _circle(task: Orbit, here: tuple[float, float]) -> list[tuple[float, float]]:
    """Clockwise as the compass turns, from where the vehicle comes to the circle."""
    x, y = task.center
    first = math.atan2(-(here[1] - y), here[0] - x)  # bearing from the centre
    count = max(math.ceil(2 * math.pi * task.turns / CIRCLE_STEP), 1)
    bearings = first + task.turn * np.linspace(0.0, 2 * math.pi * task.turns, count + 1)
    return [(x + task.radius_m * math.cos(b), y - task.radius_m * math.sin(b)) for b in bearings.tolist()]


def _deep(task: Task) -> Level:
    return Level(task.upper_m) if isinstance(task, Profile) else task.common.level


def _level(level: Level, x: float, y: float, z: float, height: Height) -> float:
    if level.altitude_m is not None:
        ground = float(height(np.array([x]), np.array([y]))[0])
        return z if math.isnan(ground) else ground + level.altitude_m  # no ground: nobody knows
    return z if level.depth_m is None else -level.depth_m
