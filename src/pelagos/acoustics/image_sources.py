"""Paths between a flat surface and a flat bottom: straight lines to mirrored sources.

Source: F. B. Jensen, W. A. Kuperman, M. B. Porter, H. Schmidt, Computational Ocean Acoustics (2nd ed., 2011),
Section 2.4.4, doi 10.1007/978-1-4419-8678-8.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Path:
    """One way: bounces at surface and bottom, length [m], launch angle to the horizontal [rad], always positive."""

    surface: int
    bottom: int
    length: float
    angle: float


def paths(water_depth: float, source_depth: float, receiver_depth: float, distance: float, *, count: int) -> list[Path]:
    """The `count` shortest paths over a horizontal `distance` [m], shortest first; depths [m], positive down."""
    found = []
    for m in range(-count, count + 1):
        # images at 2 m D + z_s have |m| bounces of each kind, those at 2 m D - z_s one more at surface or bottom
        for sign, surface, bottom in ((1, abs(m), abs(m)), (-1, abs(m - 1) if m > 0 else abs(m) + 1, abs(m))):
            rise = 2 * m * water_depth + sign * source_depth - receiver_depth
            found.append(Path(surface, bottom, math.hypot(distance, rise), math.atan2(abs(rise), distance)))
    return sorted(found, key=lambda p: p.length)[:count]
