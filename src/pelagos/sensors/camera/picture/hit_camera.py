"""Cameras that need no light: values worked out from what the ray of each pixel hits. Depth, labels, instances,
normals and flow are all this, and differ in the values alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.so3 import rotate_back
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Hits, Rays
from pelagos.sensors.camera.picture.camera_rays import Imager, Lens, Trace, ViewConfig, local_directions, view_rays
from pelagos.sensors.camera.picture.pixel_order import Pixels, image_rows, pixels
from pelagos.sensors.camera.picture.sea_crossing import level_over, sea_crossing, uneven_sea
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.sensor import Kinematics, SensorContext

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean


@dataclass(frozen=True)
class Seen:
    """Hits of the pixels of all lanes, for the functions that work out a camera's values.

    Attributes:
        where: the pixels.
        lens: the lens's tables.
        motion: of the vehicles, by image.
        rays: one a pixel, in the world.
        hits: what they meet.
        to_sea: `Float`, way to the sea surface, waves and tide included [m]; very long where the ray does not meet it.
        attitude: `Array4f` by pixel, sensor frame to world.
        level: see `view_rays`.
    """

    where: Pixels
    lens: Lens
    motion: Kinematics
    rays: Rays
    hits: Hits
    to_sea: Array
    attitude: Array
    level: Array | None

    @property
    def at_sea(self) -> Array:
        """`Bool`, the ray meets the sea surface before anything solid."""
        return self.to_sea < dr.minimum(self.hits.t, self.rays.max_range)

    @property
    def solid(self) -> Array:
        """`Bool`, the pixel shows something other than water and sky."""
        return self.hits.valid & ~self.at_sea

    @property
    def direction(self) -> Array:
        """`Array3f`, unit, of the pixel in the sensor frame."""
        return local_directions(self.lens, self.where, self.rays.origin, self.level)

    def to_sensor(self, vector: Array) -> Array:
        """World vectors `Array3f` by pixel in the sensor frame."""
        return rotate_back(self.attitude, vector)

    def of_image(self, vector: Array) -> Array:
        """Vectors by image as `Array3f` by pixel."""
        return dr.gather(jit.Array3f, jit.Array3f(vector), self.where.image)


Values = Callable[[Seen, Any, Trace | None], tuple[Array, ...]]


class HitView:
    """Frames of such a camera.

    Args:
        config: size and lens.
        context: see `SensorContext`.
        values: pure function of what is seen, of `arguments` and of a trace: one array by pixel for each image.
        arguments: arrays that `values` needs, opaque.
        smooth: whether hits carry normals interpolated over smooth surfaces.
    """

    def __init__(
        self, config: ViewConfig, context: SensorContext, values: Values, arguments: Any = (), *, smooth: bool = False
    ) -> None:
        self._config, self._values, self._extra, self._smooth = config, values, arguments, smooth
        self._view = Imager(config, context)
        self._ocean = uneven_sea(context.ocean)
        self._recorded = context.scene.compile(self._kernel)

    def images(self, motion: Kinematics) -> tuple[NDArray[Any], ...]:
        """`(images, height, width)` of each of the values."""
        shape = (-1, self._config.height_px, self._config.width_px)
        return tuple(np.array(v).reshape(shape) for v in self._recorded(*self._arguments(motion)))

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen frame: (name, values, unit)."""
        return self._view.explain(self._kernel, self._arguments(motion))

    def _arguments(self, motion: Kinematics) -> tuple[Any, ...]:
        return *self._view.arguments(motion), self._ocean, self._extra

    def _kernel(
        self,
        caster: Caster,
        lens: Lens,
        motion: Kinematics,
        own: Array,
        ocean: Ocean,
        extra: Any,
        *,
        trace: Trace | None = None,
    ) -> tuple[Array, ...]:
        config, tiling, values, smooth = self._config, self._view.tiling, self._values, self._smooth
        images = dr.width(motion.tick)
        where = pixels(tiling, images)
        position, attitude = sensor_pose(motion, config)
        level = None if lens.dry is None or ocean is None else level_over(ocean, position, motion.t_ns, motion.copy)
        rays = view_rays(lens, where, motion, own, config, level)
        hits = caster.cast(rays, smooth=smooth)
        q = jit.Array4f(*(dr.gather(jit.Float, jit.Float(attitude[i]), where.image) for i in range(4)))
        if trace is not None:
            trace("slant range", hits.t, "m")
        to_sea = sea_crossing(rays, where.image, ocean, position, motion.t_ns, motion.copy).way
        seen = Seen(where, lens, motion, rays, hits, to_sea, q, level)
        return tuple(image_rows(v, tiling, where, images) for v in values(seen, extra, trace))
