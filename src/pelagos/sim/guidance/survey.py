"""Survey lines over an area of any shape, as far apart as the swath on the seabed there asks for."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import ScenarioError

Height = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]
Points = tuple[tuple[float, float], tuple[float, float]]

STEP_M: Final = 2.0  # the depth is looked at this often along a line
NARROWEST_M: Final = 0.5  # lines are never nearer to each other
MOST_LINES: Final = 2000
FITS: Final = 6  # steps in which a line is moved up where the seabed rises towards it


@dataclass(frozen=True)
class Swath:
    """Distance of lines: a spacing [m], or an opening angle [rad] with an overlap [-]."""

    spacing_m: float | None
    angle_rad: float
    overlap: float

    def half_width(self, altitude: float) -> float:
        """Width that one line covers to one side [m], the overlap taken off."""
        if self.spacing_m is not None:
            return self.spacing_m / 2
        return (1 - self.overlap) * altitude * math.tan(self.angle_rad / 2)


def survey_lines(
    area: NDArray[np.float64],
    swath: Swath,
    *,
    height: Height,
    depth_m: float | None,
    altitude_m: float | None,
    heading_rad: float | None = None,
    where: str = "",
) -> list[Points]:
    """Lines (start, end), in order and each against the last, that cover a polygon `(k, 2)` [m].

    Args:
        area: corners in order.
        swath: what a line covers.
        height: of the ground at x, y [m]; NaN where there is none.
        depth_m, altitude_m: where the sonar goes; both None: at the surface.
        heading_rad: compass heading of the first line; along the longest side where None.
        where: in the scenario, for errors.

    Raises:
        ScenarioError: the area has no extent, there is no seabed to measure from, or a line would run into it.
    """
    sides = np.roll(area, -1, axis=0) - area
    if abs(float(np.sum(area[:, 0] * np.roll(area[:, 1], -1) - area[:, 1] * np.roll(area[:, 0], -1)))) < 1e-6:
        raise ScenarioError("the corners of the area lie on one line", where=where)
    if heading_rad is None:
        longest = sides[int(np.argmax(np.hypot(sides[:, 0], sides[:, 1])))]
        heading_rad = math.atan2(-longest[1], longest[0])
    along = np.array([math.cos(heading_rad), -math.sin(heading_rad)])
    right = np.array([-math.sin(heading_rad), -math.cos(heading_rad)])
    across = area @ right
    low, high = float(across.min()), float(across.max())

    def reach(offset: float) -> float:
        return swath.half_width(_altitude(_cut(area, along, right, offset), height, depth_m, altitude_m, swath, where))

    def beyond(edge: float) -> float:
        """The next line behind what is covered up to `edge`: as far as its own swath reaches back."""
        far = high - edge - 1e-6
        width = min(reach(edge + 1e-6), far)
        for _ in range(FITS):
            width = min(width, reach(edge + width))
        return edge + max(width, 0.0)

    lines: list[Points] = []
    at = min(beyond(low), (low + high) / 2)
    while True:
        for a, b in _cut(area, along, right, at):
            lines.append(_points(a, b) if len(lines) % 2 == 0 else _points(b, a))
        half = reach(at)
        if at + half >= high - 1e-9:
            return lines
        at = min(max(beyond(at + half), at + NARROWEST_M), high - 1e-6)
        if len(lines) > MOST_LINES:
            raise ScenarioError(f"the survey needs more than {MOST_LINES} lines; give a larger spacing", where=where)


def _points(a: NDArray[np.float64], b: NDArray[np.float64]) -> Points:
    return (float(a[0]), float(a[1])), (float(b[0]), float(b[1]))


def _cut(
    area: NDArray[np.float64], along: NDArray[np.float64], right: NDArray[np.float64], offset: float
) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Pieces of the line at `offset` to the right that lie inside the polygon (even-odd rule), in its direction."""
    u, v = area @ along, area @ right - offset
    u2, v2 = np.roll(u, -1), np.roll(v, -1)
    crosses = (v > 0) != (v2 > 0)
    at = np.sort(u[crosses] + (u2[crosses] - u[crosses]) * v[crosses] / (v[crosses] - v2[crosses]))
    return [(a * along + offset * right, b * along + offset * right) for a, b in zip(at[::2], at[1::2], strict=False)]


def _altitude(
    pieces: list[tuple[NDArray[np.float64], NDArray[np.float64]]],
    height: Height,
    depth_m: float | None,
    altitude_m: float | None,
    swath: Swath,
    where: str,
) -> float:
    """The sonar's least altitude along a line [m]."""
    least = math.inf
    for a, b in pieces:
        count = max(2, round(float(np.hypot(*(b - a))) / STEP_M) + 1)
        p = a + np.linspace(0, 1, count)[:, None] * (b - a)
        bottom = height(p[:, 0], p[:, 1])
        bottom = bottom[np.isfinite(bottom)]
        if altitude_m is not None:
            least = min(least, altitude_m)
        elif len(bottom):
            clear = -(depth_m or 0.0) - float(bottom.max())
            if clear <= 0 and depth_m is not None:
                raise ScenarioError(
                    f"at {depth_m:g} m depth a line from x {a[0]:.1f}, y {a[1]:.1f} to x {b[0]:.1f}, y {b[1]:.1f} m "
                    f"runs into the seabed, {-bottom.max():.1f} m deep; give a smaller depth_m, or altitude_m",
                    where=where,
                )
            least = min(least, clear)
    if swath.spacing_m is None and not math.isfinite(least) and pieces:
        raise ScenarioError("there is no seabed below the area to plan a swath over; give spacing_m", where=where)
    return least if math.isfinite(least) and least > 0 else 0.0
