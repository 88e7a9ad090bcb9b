"""A chart of a vehicle's way, for people who watch a policy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pelagos.math.so3 import rotate_np


class Track:
    """Track of one vehicle since its episode began, with the direction of its bow."""

    def __init__(self, goal: Sequence[float] | None = None) -> None:
        """`goal`: world NWU (3) [m], where it is the same in every episode."""
        self._places: list[NDArray[np.float64]] = []
        self._bow: NDArray[np.float64] = np.array([1.0, 0.0, 0.0])
        self._goal: NDArray[np.float64] | None = None if goal is None else np.array(goal)

    def clear(self) -> None:
        """A new episode."""
        self._places.clear()

    def note(self, state: Mapping[str, NDArray[np.float64]]) -> None:
        """Keep its present place; `state` as `FleetEnv.state` has it, of one copy or the first of several."""
        self._places.append(state["position"][0].copy())
        self._bow = rotate_np(state["attitude"][:1], np.array([[1.0, 0.0, 0.0]]))[0]
        if "task.goal_x" in state:
            self._goal = np.array([float(state[f"task.goal_{axis}"][0]) for axis in "xyz"])

    def picture(self) -> NDArray[np.uint8]:
        """`(480, 640, 3)` uint8: from above (north up) on the left, from the west on the right."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(figsize=(6.4, 4.8), dpi=100, layout="constrained")
        canvas = FigureCanvasAgg(figure)
        way = np.array(self._places or [np.zeros(3)])
        self._draw(figure.add_subplot(1, 2, 1), way, (1, 0), ("west [m]", "north [m]"), flip=True)
        self._draw(figure.add_subplot(1, 2, 2), way, (0, 2), ("north [m]", "up [m]"), flip=False)
        canvas.draw()
        return np.array(canvas.buffer_rgba())[..., :3].copy()

    def _draw(
        self, axes: Any, way: NDArray[np.float64], of: tuple[int, int], names: tuple[str, str], *, flip: bool
    ) -> None:
        a, b = of
        axes.plot(way[:, a], way[:, b], color="tab:blue")
        axes.plot(way[0, a], way[0, b], "o", color="gray", label="start")
        axes.annotate(
            "", xy=(way[-1, a] + 0.4 * self._bow[a], way[-1, b] + 0.4 * self._bow[b]), xytext=(way[-1, a], way[-1, b]),
            arrowprops={"arrowstyle": "-|>", "color": "tab:red"},
        )  # fmt: skip
        if self._goal is not None:
            axes.plot(self._goal[a], self._goal[b], "x", color="tab:green", label="goal")
        axes.set(xlabel=names[0], ylabel=names[1])
        axes.set_aspect("equal", adjustable="datalim")
        axes.grid(alpha=0.3)
        axes.legend(loc="upper right", fontsize=8)
        if flip:
            axes.invert_xaxis()
