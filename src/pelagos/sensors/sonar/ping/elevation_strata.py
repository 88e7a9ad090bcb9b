"""Strata of elevation: how the rays of a fan are shared out over its main lobe and side lobes."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.acoustics.beam_pattern import line_np
from pelagos.acoustics.element_array import ElementLine, line_amplitude

_HIGHEST: Final = math.radians(80.0)
_SIDE_LOBE_RAYS: Final = 0.12  # density of rays in side lobes, on the axis 1.45


def strata(
    length: float,
    side_lobes: int,
    count: int,
    which: NDArray[np.integer],
    offset: NDArray[np.floating],
    transmit: ElementLine | None = None,
) -> tuple[NDArray[np.float64], ...]:
    """Edges [rad] of the strata `which` of `count`, and the integral of their two-way pattern over the elevation.

    `offset`, in (0, 1), moves all edges of a beam by parts of a stratum: edges that were the same in all beams would
    show as rings. The pattern is integrated, not sampled at the ray. `length` is the aperture's [wavelengths]; one way
    the pattern is that of `transmit`, where it is given.
    """
    limit = min(math.asin(min((1.0 + side_lobes) / length, 1.0)), _HIGHEST)
    grid = np.linspace(-limit, limit, 8001)
    step = grid[1] - grid[0]
    pattern = line_np(np.sin(grid), length)
    density = np.where(np.abs(np.sin(grid)) * length < 1.0, 0.45 + pattern**2, _SIDE_LOBE_RAYS)
    sent = pattern**2 if transmit is None else np.abs(line_amplitude(transmit, np.sin(grid))) ** 2
    share, power = (
        np.concatenate([[0.0], np.cumsum(0.5 * (f[1:] + f[:-1]))]) for f in (density, sent * pattern**2 * np.cos(grid))
    )
    low, high = (
        np.interp(np.clip((which + i - 1 + offset) / (count - 1), 0.0, 1.0) * share[-1], share, grid) for i in (0, 1)
    )
    return low, high, (np.interp(high, grid, power) - np.interp(low, grid, power)) * step
