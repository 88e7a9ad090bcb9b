"""Change of a lens's rays from pixel to pixel: it makes motion in space motion in the picture, and tells how much of
the scene one pixel covers.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from pelagos import jit
from pelagos.jit import Array
from pelagos.sensors.camera.picture.camera_rays import ViewConfig, pixel_rays
from pelagos.sensors.camera.picture.pixel_order import Tiling

_STEP: Final = 0.01  # [px], for the lens's derivative


@jit.struct
class RayChange:
    """Change of the rays of a lens from pixel to pixel, a Dr.Jit struct of pairs (rightwards, downwards) of `Array3f`,
    sensor frame, lanes in the order of `Tiling`.

    Attributes:
        direction: of their directions [1/px].
        dry: the same where a port is out of the water; None without a port.
        start: of where they start on a port [m/px]; None without a port.
    """

    direction: list[Array]
    dry: list[Array] | None
    start: list[Array] | None


def ray_change(config: ViewConfig) -> RayChange:
    """The tables, by central differences."""
    tiling = Tiling(config.width_px, config.height_px)

    def tables(which: int, **more: Any) -> list[Array]:
        found = []
        for aside in ((_STEP, 0.0), (0.0, _STEP)):
            ahead, behind = (pixel_rays(config, shift=(k * aside[0], k * aside[1]), **more)[which] for k in (1, -1))
            slope = np.nan_to_num((ahead - behind) / (2 * _STEP))
            found.append(jit.Array3f(np.ascontiguousarray(tiling.arrange(slope).T)))
        return found

    ported = config.port is not None
    made = RayChange(
        direction=tables(1),
        dry=tables(1, outside=1.0) if ported else None,
        start=tables(0) if ported else None,
    )
    jit.align(made)
    return made
