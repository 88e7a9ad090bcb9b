"""The ground as a map: shaded and coloured depths, contours, and what stands on it."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pelagos.drawing.relief import Relief, depth_norm, relief, shaded, tone_of
from pelagos.report import theme

__all__ = ["Relief", "depth_bar", "depth_norm", "draw_ground", "relief"]


def draw_ground(axes: Axes, ground: Relief, norm: Normalize, *, contours: bool = True) -> Any:
    """Shaded, coloured depths, contours, and structures in dark grey."""
    span = max(float(np.nanmax(ground.height) - np.nanmin(ground.height)), 1e-3)
    picture = shaded(ground, tone_of(ground, norm))
    axes.imshow(picture, origin="lower", extent=ground.extent, interpolation="bilinear")
    if contours and span > 0.5:
        levels = _levels(float(np.nanmin(ground.height)), float(np.nanmax(ground.height)))
        drawn = axes.contour(
            ground.east, ground.north, ground.height, levels=levels, colors="#0c2238", linewidths=0.45, alpha=0.45,
            linestyles="solid",
        )  # fmt: skip
        axes.clabel(drawn, fmt=lambda z: f"{-z:g}", fontsize=6.5, inline_spacing=2)
    axes.grid(visible=False)
    axes.set_xlabel("east [m]")
    axes.set_ylabel("north [m]")
    axes.set_aspect("equal")


def depth_bar(drawn: Figure, axes: Any, norm: Normalize, label: str = "depth [m]") -> None:
    """A colour bar that counts downwards."""
    owner = axes[0].figure if isinstance(axes, list) else drawn
    bar = owner.colorbar(ScalarMappable(norm, theme.DEPTHS), ax=axes, shrink=0.85, aspect=28, pad=0.015)
    bar.set_label(label)
    bar.formatter = lambda z, _: f"{-z:g}"
    bar.outline.set_visible(False)
    bar.update_ticks()


def _levels(low: float, high: float) -> NDArray[np.float64]:
    span = high - low
    step = next(s for s in (0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000) if span / s <= 12 or s == 1000)
    return np.arange(np.ceil(low / step) * step, high, step)
