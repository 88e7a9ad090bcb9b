"""The contact sheet of a data set: small pictures of what its sensors see, boxes drawn in."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.datasets.plan import Plan
from pelagos.datasets.sample import Sample
from pelagos.world.label import label_color

COLUMNS: Final = 2
ROWS: Final = 12
_GAP: Final = 4
_BOX: Final = (255, 220, 0)
_FLOOR_DB: Final = -50.0  # of a sonar's picture below its brightest bin


def strip(plan: Plan, sample: Sample, height: int) -> NDArray[np.uint8] | None:
    """`(height, width, 3)`: the pictures of a sample side by side; None where it has none."""
    shown = [p for name in sample.readings if (p := _picture(plan, sample, name)) is not None]
    if not shown:
        return None
    return np.concatenate([_scaled(p, height) for p in shown], axis=1)


def _picture(plan: Plan, sample: Sample, sensor: str) -> NDArray[np.uint8] | None:
    values = sample.readings[sensor]
    if sensor == plan.rig.labels.get("instance"):
        return None  # the boxes show it
    if sensor == plan.rig.labels.get("semantic"):
        palette = np.array([label_color(n) for n in range(256)], dtype=np.uint8)
        return np.asarray(palette[values])
    if values.ndim == 3 and values.shape[-1] == 3 and values.dtype == np.uint8:
        return _boxed(values, sample) if sensor == plan.rig.camera else values
    if values.ndim != 2 or not np.issubdtype(values.dtype, np.floating):
        return None
    if sensor == plan.rig.labels.get("depth"):
        return _greys(values)
    if values.min() >= 0 and values.max() <= 1:  # a picture already
        return _greys(values.T[::-1])
    level = 10 * np.log10(np.maximum(np.abs(values), 1e-30))  # (beams, bins), drawn with range upwards
    top = level.max()
    return _greys(np.clip((level - top) / -_FLOOR_DB + 1, 0, 1).T[::-1])


def _greys(values: NDArray[Any]) -> NDArray[np.uint8]:
    finite = np.isfinite(values)
    top = float(values[finite].max()) if finite.any() else 1.0
    grey = np.where(finite, values / max(top, 1e-30), 1.0)
    return np.repeat((255 * np.clip(grey, 0, 1)).astype(np.uint8)[..., None], 3, axis=2)


def _boxed(values: NDArray[np.uint8], sample: Sample) -> NDArray[np.uint8]:
    from PIL import Image, ImageDraw

    image = Image.fromarray(values)
    draw = ImageDraw.Draw(image)
    for thing in sample.things:
        b = thing.box
        draw.rectangle((b.column, b.row, b.column + b.width - 1, b.row + b.height - 1), outline=_BOX)
    return np.asarray(image)


def _scaled(values: NDArray[np.uint8], height: int) -> NDArray[np.uint8]:
    from PIL import Image

    width = max(1, round(values.shape[1] * height / values.shape[0]))
    return np.asarray(Image.fromarray(values).resize((min(width, 3 * height), height)))


def contact_sheet(strips: Sequence[Path]) -> bytes | None:
    """PNG of the strips of shards, evenly chosen; None where there are none."""
    from PIL import Image

    most = COLUMNS * ROWS
    chosen = [strips[k * len(strips) // min(most, len(strips))] for k in range(min(most, len(strips)))]
    if not chosen:
        return None
    tiles = [Image.open(path).convert("RGB") for path in chosen]
    width, height = max(t.width for t in tiles) + _GAP, max(t.height for t in tiles) + _GAP
    columns = min(COLUMNS, len(tiles))
    sheet = Image.new("RGB", (columns * width + _GAP, -(-len(tiles) // columns) * height + _GAP), (24, 24, 28))
    for k, tile in enumerate(tiles):
        sheet.paste(tile, (_GAP + k % columns * width, _GAP + k // columns * height))
    buffer = io.BytesIO()
    sheet.save(buffer, "PNG")
    return buffer.getvalue()
