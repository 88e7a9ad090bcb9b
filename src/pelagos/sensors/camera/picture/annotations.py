"""Labels as computer vision wants them: boxes in the picture and COCO's annotations, from an instance camera. Boxes in
space are `boxes_3d`'s.

COCO data format: T.-Y. Lin et al. 2014, doi 10.1007/978-3-319-10602-1_48; masks are uncompressed run lengths, column
    by column.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pelagos.world.label import label_name


@dataclass(frozen=True)
class Box:
    """One object in one picture.

    Attributes:
        instance: its id.
        label: its semantic label.
        column, row: upper left pixel.
        width, height: [px], at least 1.
        area: pixels that show it.
    """

    instance: int
    label: int
    column: int
    row: int
    width: int
    height: int
    area: int


def boxes(instances: NDArray[np.uint32], labels: NDArray[np.uint8], *, least_area: int = 1) -> list[Box]:
    """Boxes around what is visible of each object, by id.

    Args:
        instances: `(height, width)` of one lane of an instance camera.
        labels: the same pixels' labels.
        least_area: objects of fewer pixels are left out.
    """
    rows, columns = np.nonzero(instances)
    if not len(rows):
        return []
    ids = instances[rows, columns]
    order = np.argsort(ids, kind="stable")  # one pass for all objects; the first pixel of each stays the first
    rows, columns, ids = rows[order], columns[order], ids[order]
    first = np.flatnonzero(np.concatenate([[True], ids[1:] != ids[:-1]]))
    areas = np.diff(np.append(first, len(ids)))
    lows = [np.minimum.reduceat(v, first) for v in (columns, rows)]
    highs = [np.maximum.reduceat(v, first) for v in (columns, rows)]
    label = labels[rows[first], columns[first]]
    return [
        Box(
            int(ids[first[k]]), int(label[k]), int(lows[0][k]), int(lows[1][k]),
            int(highs[0][k] - lows[0][k]) + 1, int(highs[1][k] - lows[1][k]) + 1, int(areas[k]),
        )
        for k in np.flatnonzero(areas >= least_area)
    ]  # fmt: skip


def coco(
    frames: Iterable[tuple[str, NDArray[np.uint32], NDArray[np.uint8]]],
    *,
    user_labels: Mapping[str, int] | None = None,
    masks: bool = True,
    least_area: int = 1,
) -> dict[str, Any]:
    """COCO's "images", "annotations" and "categories", ready for `json.dump`.

    Args:
        frames: (file name, instances, labels) of each picture, the arrays `(height, width)`.
        user_labels: the scenario's own labels, name to number.
        masks: whether annotations carry run lengths.
        least_area: objects of fewer pixels are left out.
    """
    images: list[dict[str, Any]] = []
    annotations: list[dict[str, Any]] = []
    used: set[int] = set()
    for number, (name, instances, labels) in enumerate(frames, start=1):
        height, width = instances.shape
        images.append({"id": number, "file_name": name, "width": width, "height": height})
        for box in boxes(instances, labels, least_area=least_area):
            used.add(box.label)
            entry: dict[str, Any] = {
                "id": len(annotations) + 1,
                "image_id": number,
                "category_id": box.label,
                "bbox": [box.column, box.row, box.width, box.height],
                "area": box.area,
                "iscrowd": 0,
                "instance_id": box.instance,
            }
            if masks:
                entry["segmentation"] = {"size": [height, width], "counts": run_lengths(instances == box.instance)}
            annotations.append(entry)
    known = dict(user_labels or {})
    categories = [{"id": label, "name": label_name(label, known), "supercategory": "marine"} for label in sorted(used)]
    return {"images": images, "annotations": annotations, "categories": categories}


def run_lengths(mask: NDArray[np.bool_]) -> list[int]:
    """Lengths of alternating runs of 0 and 1, column by column, beginning with 0."""
    flat = mask.T.ravel()
    ends = np.flatnonzero(np.diff(flat)) + 1
    runs = np.diff(np.concatenate([[0], ends, [flat.size]]))
    return [int(r) for r in ([0, *runs] if flat[0] else runs)]
