"""Style of a report's figures, and their way into a page."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Final

import matplotlib as mpl
from matplotlib.figure import Figure

from pelagos.drawing.colours import DEPTHS, DIFFERENCE

__all__ = [
    "ALARM", "DEPTHS", "DIFFERENCE", "EMPTY", "GRID", "INK", "MUTED", "NIGHT", "SECOND", "SENSOR", "THIRD", "TRUTH",
    "as_png", "data_uri", "figure", "style", "time_axis",
]  # fmt: skip

INK: Final = "#0c2238"
MUTED: Final = "#6b7c8f"
GRID: Final = "#dfe5ea"
TRUTH: Final = "#0c2238"
SENSOR: Final = "#e07b39"
SECOND: Final = "#2a9d8f"
THIRD: Final = "#7b5ea7"
ALARM: Final = "#c1443c"
EMPTY: Final = "#eef1f4"
NIGHT: Final = "#080d12"

_STYLE: Final[dict[str, Any]] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "text.color": INK,
    "axes.edgecolor": "#b9c4ce",
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.3,
    "figure.facecolor": "white",
    "savefig.facecolor": "auto",
}


@contextmanager
def style(**more: Any) -> Iterator[None]:
    """Draw in the report's style."""
    with mpl.rc_context({**_STYLE, **more}):
        yield


def figure(width_in: float, height_in: float) -> Figure:
    """An empty figure with a layout that keeps labels apart."""
    return Figure(figsize=(width_in, height_in), layout="constrained")


def as_png(drawn: Figure, *, dpi: int = 150) -> bytes:
    """PNG bytes of a figure, without a date in them."""
    out = io.BytesIO()
    drawn.savefig(out, format="png", dpi=dpi, metadata={"Software": None})
    return out.getvalue()


def data_uri(data: bytes, media_type: str = "image/png") -> str:
    """Bytes as the address of an image within a page."""
    return f"data:{media_type};base64,{base64.b64encode(data).decode()}"


def time_axis(duration_s: float) -> tuple[float, str]:
    """Divisor of seconds and the label of the axis."""
    return (60.0, "time [min]") if duration_s > 240 else (1.0, "time [s]")
