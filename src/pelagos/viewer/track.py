"""A track as it grows: pieces that are sent once, and a last one that is sent again."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.viewer.stage import Stage

_PIECE: Final = 200
_STEP_M: Final = 0.1  # points nearer than this to the last are left out
_MOST: Final = 400  # pieces; every second one of the oldest half goes then


class Track:
    """Lines through places.

    Args:
        stage: where its nodes go.
        name: of its nodes.
        colour: sRGB 0 .. 255.
    """

    def __init__(self, stage: Stage, name: str, colour: tuple[int, int, int]) -> None:
        self._stage, self._name, self._colour = stage, name, colour
        self._pieces: list[Any] = []
        self._points: list[NDArray[np.float64]] = []
        self._node: Any = None
        self._count = 0

    def add(self, place: NDArray[np.float64]) -> None:
        """Go on to a place `(3,)` [m]."""
        if self._points and float(np.abs(place - self._points[-1]).max()) < _STEP_M:
            return
        self._points.append(np.array(place))
        if len(self._points) < 2:
            return
        line = np.asarray(self._points, dtype=np.float32)
        segments = np.stack([line[:-1], line[1:]], axis=1)
        if self._node is None:
            self._count += 1
            self._node = self._stage.add("lines", f"{self._name}/{self._count}", colour=self._colour, points=segments)
        else:
            self._node.update(points=segments)
        if len(self._points) >= _PIECE:
            self._pieces.append(self._node)
            self._points, self._node = self._points[-1:], None
            if len(self._pieces) > _MOST:
                self._pieces.pop(0).remove()

    def clear(self) -> None:
        """Begin anew."""
        for node in [*self._pieces, *([] if self._node is None else [self._node])]:
            node.remove()
        self._pieces, self._points, self._node = [], [], None
