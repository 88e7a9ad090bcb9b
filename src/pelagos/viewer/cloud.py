"""Points in space as they are measured: pieces that are sent once, and a last one that is sent now and then."""

from __future__ import annotations

import time
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.drawing.colours import painted
from pelagos.viewer.stage import Stage

_PIECE: Final = 6000
_MOST: Final = 240  # pieces that stay
_EVERY_S: Final = 0.5  # wall-clock time between two pictures of the piece that grows


class Cloud:
    """The points of one sensor, world NWU [m]; by depth where they have no colours of their own.

    Args:
        stage: where its nodes go.
        name: "auv0.multibeam".
    """

    KINDS: Final = ("multibeam", "lidar", "semantic_lidar")

    def __init__(self, stage: Stage, name: str) -> None:
        self._stage, self._at = stage, "/points/" + name.replace(".", "/")
        self._pieces: list[Any] = []
        self._points: list[NDArray[np.float64]] = []
        self._colours: list[NDArray[np.uint8] | None] = []
        self._node: Any = None
        self._number = self._size = 0
        self._fresh = False
        self._shown_at = 0.0
        self._span: tuple[float, float] | None = None
        self._visible = True

    @property
    def visible(self) -> bool:
        """Whether it is shown."""
        return self._visible

    @visible.setter
    def visible(self, value: bool) -> None:
        self._visible = value
        for node in (*self._pieces, *([] if self._node is None else [self._node])):
            node.show(visible=value)

    def add(self, points: NDArray[np.float64], colours: NDArray[np.uint8] | None) -> None:
        """Take points `(m, 3)`, thinned where they are very many."""
        step = max(1, len(points) // 4000)
        self._points.append(points[::step])
        self._colours.append(None if colours is None else colours[::step])
        self._size += len(self._points[-1])
        self._fresh = True
        if self._size >= _PIECE:
            self._send()
            self._pieces.append(self._node)
            self._node, self._points, self._colours, self._size = None, [], [], 0
            if len(self._pieces) > _MOST:
                self._pieces.pop(0).remove()

    def flush(self, *, looked_on: bool = True) -> None:
        """Send what came since, if it is time."""
        now = time.monotonic()
        if self._fresh and looked_on and self._size and now - self._shown_at > _EVERY_S:
            self._shown_at = now
            self._send()

    def clear(self) -> None:
        """Begin anew."""
        for node in (*self._pieces, *([] if self._node is None else [self._node])):
            node.remove()
        self._pieces, self._points, self._colours, self._node, self._size = [], [], [], None, 0
        self._span = None

    def _send(self) -> None:
        points = np.concatenate(self._points).astype(np.float32)
        own = [c for c in self._colours if c is not None]  # a sensor's points all have colours, or none has
        colours = np.concatenate(own) if own else self._paint(points)
        self._fresh = False
        if self._node is None:
            self._number += 1
        self._node = self._stage.add("points", f"{self._at}/{self._number}", points=points, colours=colours)
        if not self._visible:
            self._node.show(visible=False)

    def _paint(self, points: NDArray[np.float32]) -> NDArray[np.uint8]:
        """By depth, over the span of the first points, widened as it must be."""
        if len(points):
            low, high = float(points[:, 2].min()), float(points[:, 2].max())
            if self._span is None:
                middle = 0.5 * (low + high)
                self._span = (min(low, middle - 2.0), max(high, middle + 2.0))
            self._span = (min(low, self._span[0]), max(high, self._span[1]))
        return painted(points[:, 2], *(self._span or (-1.0, 0.0)))
