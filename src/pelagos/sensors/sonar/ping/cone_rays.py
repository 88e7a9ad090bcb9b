"""Rays of a round beam."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.acoustics.beam_pattern import line_length, line_np

_GOLDEN: Final = math.pi * (3.0 - math.sqrt(5.0))  # turn from ray to ray: evenly spread about the axis
_REACH: Final = 1.129  # first null of a line over its half-power width


def cone_rays(beamwidth: float, count: int) -> dict[str, NDArray[Any]]:
    """Rays about -z out to the first null, one in each of `count` rings (see `Fan`); `beamwidth` [rad]."""
    edges = np.linspace(0.0, _REACH * beamwidth, count + 1)
    low, high = edges[:-1], edges[1:]
    angle = 0.5 * (low + high)
    turn = _GOLDEN * np.arange(count)
    cell = edges[-1] * math.sqrt(math.pi / count)  # edge of a ray's share of the cone: strips on slopes are as long
    ca, sa, ct, st = np.cos(angle), np.sin(angle), np.cos(turn), np.sin(turn)
    return {
        "direction": np.stack([sa * ct, sa * st, -ca], axis=-1),
        "along": np.stack([ca * ct, ca * st, sa], axis=-1),
        "aside": np.zeros((count, 3)),
        "lower": np.minimum(low - angle, -0.5 * cell),
        "upper": np.maximum(high - angle, 0.5 * cell),
        "across": np.sqrt(2 * np.pi * sa * (high - low)),  # neighbours on the spiral are as far apart any way
        "weight": 2 * np.pi * (np.cos(low) - np.cos(high)) * line_np(sa, line_length(beamwidth)) ** 4,
        "beam": np.zeros(count, dtype=np.uint32),
    }
