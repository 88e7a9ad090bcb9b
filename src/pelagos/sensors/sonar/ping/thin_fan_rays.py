"""Rays of fans that are thin fore and aft: each beam's share of the fan is divided both ways."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.acoustics.beam_pattern import line_length, spread_over_beam

_STEP: Final = 0.7548776662466927  # additive recurrences of the plastic number: evenly spread in two dimensions
_STEP2: Final = 0.5698402909980532
_NULLS: Final = 2.26  # angle between a line's first nulls over its half-power width


def slice_rays(
    angles: NDArray[np.float64], sectors: NDArray[np.float64], *, rays: int, width: float, ways: int
) -> dict[str, NDArray[Any]]:
    """The ray pattern of beams that lie side by side in a plane (see `Fan`), `rays` for each.

    Vectors have the components (ahead, left, fore): within the plane along its middle, to the left, out of it. Strata
    are of equal angle within the plane, and hold equal shares of the pattern's power fore and aft; they are about twice
    as long in the plane as out of it, which serves level, slanting and rough ground best. Either way their edges are
    moved from beam to beam: edges that were the same in all beams would show as rings.

    Args:
        angles: beam directions `(beams,)` [rad], positive to the left.
        sectors: angle that belongs to each beam [rad].
        rays: strata of a beam.
        width: half-power width of the fan fore and aft [rad], one way.
        ways: 2 where transmitter and receiver have that width, 1 where one of them is wide.
    """
    wanted = math.sqrt(2.0 * _NULLS * width / float(np.mean(sectors)) * rays)  # strata fore and aft
    deep = min((d for d in range(1, rays + 1) if rays % d == 0), key=lambda d: abs(math.log(d / wanted)))
    beam, k = (a.ravel() for a in np.meshgrid(np.arange(len(angles)), np.arange(rays), indexing="ij"))
    row, column = k % deep, k // deep
    step = sectors[beam] * deep / rays
    low = angles[beam] + step * (column - 0.5 * rays / deep)
    angle = low + (0.5 + _STEP * beam + _STEP2 * k) % 1.0 * step
    offset = (0.5 + _STEP * beam) % 1.0
    shares = [np.clip((row + i - 1 + offset) / max(deep - 1, 1), 0.0, 1.0) if deep > 1 else row + i for i in (0, 1)]
    length = line_length(width)
    (aft, fore), thickness = spread_over_beam(length, np.stack(shares), ways=ways)
    tilt = spread_over_beam(length, 0.5 * (shares[0] + shares[1]), ways=ways)[0]
    ca, sa, ct, st = np.cos(angle), np.sin(angle), np.cos(tilt), np.sin(tilt)
    return {
        "direction": np.stack([ct * ca, ct * sa, st], axis=-1),
        "along": np.stack([-sa, ca, 0 * sa], axis=-1),
        "aside": np.zeros((len(beam), 3)),
        "lower": low - angle,
        "upper": low + step - angle,
        "half": 0.5 * (fore - aft),
        "across": fore - aft,
        "weight": step * thickness * (shares[1] - shares[0]),
        "beam": beam,
    }
