"""Currents as arrows in the scene: where the water sets, sampled on a level grid."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.drawing.water import sampled
from pelagos.world.world import World

_ACROSS: Final = 12  # arrows along the longer side
_STILL_MPS: Final = 0.005
_WIDEST_M: Final = 100.0  # of the world that gets arrows where it has no bounds


def arrows(ocean: Any, world: World, t_s: float, depth_m: float) -> NDArray[np.float32]:
    """Segments `(m, 2, 3)` NWU [m]: shafts and two barbs each; the fastest is as long as the arrows are apart.

    Called by a thread that may use the device.

    Args:
        ocean: `Simulation.ocean.fields`.
        world: its bounds are covered; where the ground is higher than the level, there are none.
        t_s, depth_m: of the level that is sampled.
    """
    low, high = extent(world)
    step = float((high - low).max()) / _ACROSS
    x, y = (np.arange(a + step / 2, b, step) for a, b in zip(low, high, strict=True))
    places = np.stack([*(v.ravel() for v in np.meshgrid(x, y, indexing="ij")), np.zeros(len(x) * len(y))], axis=-1)
    places[:, 2] = -depth_m
    ground = world.height(places[:, 0], places[:, 1])
    places = places[~(ground >= -depth_m)]
    if ocean is None or not len(places):
        return np.zeros((0, 2, 3), dtype=np.float32)
    flow = sampled(first_current(ocean), places, np.full(len(places), t_s))
    speed = np.linalg.norm(flow[:, :2], axis=1)
    moves = speed > _STILL_MPS
    if not moves.any():
        return np.zeros((0, 2, 3), dtype=np.float32)
    places, flow = places[moves], flow[moves] * (0.9 * step / speed.max())
    flow[:, 2] = 0.0
    tips = places + flow / 2
    lines = [np.stack([places - flow / 2, tips], axis=1)]
    for turn in (math.radians(155), math.radians(-155)):
        c, s = math.cos(turn), math.sin(turn)
        barb = 0.28 * np.stack([c * flow[:, 0] - s * flow[:, 1], s * flow[:, 0] + c * flow[:, 1], flow[:, 2]], axis=-1)
        lines.append(np.stack([tips, tips + barb], axis=1))
    return np.concatenate(lines).astype(np.float32)


def extent(world: World) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners (x, y) of the part of a world that is drawn, NWU [m]: its bounds, or 100 m about the origin."""
    low, high = world.bounds[:, :2]
    if np.isfinite(world.bounds[:, :2]).all() and (high > low).all():
        return low, high
    return np.full(2, -_WIDEST_M), np.full(2, _WIDEST_M)


def first_current(ocean: Any) -> Callable[[Any, Any], Any]:
    """The current of the first copy of a fleet, as a function of place and time."""
    return lambda place, t: ocean.current(place, t, dr.zeros(jit.UInt32, dr.width(place)))
