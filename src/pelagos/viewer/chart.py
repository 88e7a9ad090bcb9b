"""The map's pictures: the whole world, and nearer ones of what a browser comes near to, in the same colours and light.

Rays find what stands on the ground, and those are the device's: `survey` is called by a thread that may use it.
"""

from __future__ import annotations

import io
import math
from collections import deque
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pelagos.drawing.colours import DEPTHS, shades
from pelagos.drawing.relief import Relief, depth_norm, relief, shaded, tone_of
from pelagos.viewer.hub import Hub
from pelagos.world.world import World

_LEAST_M: Final = 1.0  # side of what can be asked for
_MOST: Final = 4  # that wait: as many as browsers may ask at once
_UNKNOWN: Final = (0.09, 0.24, 0.36)  # where a world has no ground


class Chart:
    """Draws the ground from above, north up: the report's own map, without its axes.

    Attributes:
        bounds: lowest and highest x and y NWU `(2, 2)` [m].

    Args:
        world: whose ground.
    """

    def __init__(self, world: World) -> None:
        low, high = world.bounds[:, :2]
        if not (high > low).all():
            low, high = np.array([-100.0, -100.0]), np.array([100.0, 100.0])
        self.bounds: NDArray[np.float64] = np.stack([low, high])
        self._world = world
        self._asked: deque[NDArray[np.float64]] = deque(maxlen=_MOST)
        whole = relief(world, low, high)
        self._tone = tone_of(whole, depth_norm(whole.height)) if np.isfinite(whole.height).any() else None
        self.whole = self._png(whole)

    @property
    def legend(self) -> dict[str, Any]:
        """Depths of the first and the last colour [m], and the colours from low to high; empty without ground."""
        if self._tone is None:
            return {}
        norm = self._tone.norm
        return {"deep": round(-float(norm.vmin), 2), "shallow": round(-float(norm.vmax), 2), "shades": shades(DEPTHS)}

    def ask(self, message: Mapping[str, Any]) -> None:
        """Have a part drawn: `bounds` are lowest x, lowest y, highest x, highest y [m]; any thread may call this."""
        bounds = message.get("bounds")
        if not isinstance(bounds, list) or len(bounds) != 4 or self._tone is None:
            return
        if not all(isinstance(v, int | float) and math.isfinite(v) for v in bounds):
            return
        part = np.clip(np.reshape(bounds, (2, 2)).astype(np.float64), *self.bounds)
        if (part[1] - part[0]).min() >= _LEAST_M:
            self._asked.append(part)

    def survey(self) -> Relief | None:
        """The part that was asked for first; None where nothing was."""
        try:
            low, high = self._asked.popleft()
        except IndexError:
            return None
        return relief(self._world, low, high)

    def publish(self, hub: Hub, ground: Relief) -> None:
        """Send a part to the browsers; any thread may call this."""
        east, north = ground.east, ground.north
        half = 0.5 * float(east[1] - east[0])  # pixels lie about their places
        low, high = (north[0] - half, -east[-1] - half), (north[-1] + half, -east[0] + half)
        bounds = [round(float(v), 4) for v in (*low, *high)]
        key = "chart/" + "/".join(map(str, bounds))
        hub.publish(key, {"type": "chart", "bounds": bounds}, self._png(ground), keep=False)

    def _png(self, ground: Relief) -> bytes:
        picture = np.full((*ground.height.shape, 3), _UNKNOWN) if self._tone is None else shaded(ground, self._tone)
        out = io.BytesIO()
        Image.fromarray((255 * picture[::-1]).astype(np.uint8)).save(out, format="PNG", compress_level=3)
        return out.getvalue()
