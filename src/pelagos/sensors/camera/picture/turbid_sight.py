"""Water that is not the same everywhere in a picture: lines of sight through plankton and sediment."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.sight_line import SightLines, sums_along
from pelagos.optics.suspended import with_suspended
from pelagos.optics.water import WaterArrays
from pelagos.sensors.camera.picture.camera_rays import Frame, ViewConfig
from pelagos.sensors.camera.picture.pixel_blocks import around, square_pixels
from pelagos.sensors.camera.picture.pixel_order import Pixels
from pelagos.sensors.camera.picture.radiance import open_sea_rate
from pelagos.sensors.camera.picture.scenery import Scenery, by_ray

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean

SUSPENDED: Final = ("chlorophyll", "turbidity")


def sight_lines(
    scenery: Scenery, frame: Frame[ViewConfig], where: Pixels, rate_at: Callable[[Pixels], Array] | None = None
) -> SightLines | None:
    """Lines of sight around the rays of `where`; None where the water is the same everywhere.

    `rate_at` some pixels diffuse light falls along the lines [1/m]; None: as in the open sea.
    """
    if scenery.murk is None:
        return None
    tiling = frame.tiling
    squares = square_pixels(tiling, frame.images)[0]
    rays = frame.rays(squares, scenery.level)
    spread = by_ray(scenery, squares.image)
    murk = spread.murk
    assert murk is not None
    depth = dr.gather(jit.Float, scenery.depth, squares.image)
    t = dr.gather(jit.Float64, scenery.t, squares.image)
    d = rays.direction

    def water_at(distance: Array) -> WaterArrays:
        place = rays.origin + jit.Array3f64(d) * jit.Float64(distance)
        return suspended_water(murk.ocean, murk.clear, place, t)

    rate = open_sea_rate(spread, d, depth) if rate_at is None else rate_at(squares)
    sums = sums_along(water_at, spread.field, spread.water, d, rate)
    corner, right, down = around(tiling, where)
    return SightLines(sums, jit.UInt32(dr.width(depth)), corner, right, down)


def suspended_tracers(ocean: Ocean) -> tuple[str, ...]:
    """Tracers of the ocean that its light depends on."""
    return tuple(n for n in SUSPENDED if n in ocean.tracers)


def suspended_water(ocean: Ocean, clear: WaterArrays, place: Array, t: Array) -> WaterArrays:
    """The clear water with what the ocean's tracers put in it at places `Array3f64` and times [s]."""
    found = {n: jit.Float(ocean.tracer(n, place, t)) for n in suspended_tracers(ocean)}
    return with_suspended(clear, found.get("chlorophyll"), found.get("turbidity"))
