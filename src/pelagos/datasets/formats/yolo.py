"""YOLO: a picture and a text file of boxes for each sample: class, and centre and size over those of the picture.

Format: Ultralytics documentation, "Object Detection Datasets", YOLO format.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pelagos.datasets.plan import Plan, Shard
from pelagos.datasets.sample import Sample


class Yolo:
    """`yolo/images/SPLIT/KEY.png` and `yolo/labels/SPLIT/KEY.txt`."""

    def __init__(self, folder: Path, plan: Plan, shard: Shard, maker: Any) -> None:
        self._pictures, self._labels = (folder / "yolo" / part / shard.split for part in ("images", "labels"))
        self._pictures.mkdir(parents=True, exist_ok=True)
        self._labels.mkdir(parents=True, exist_ok=True)
        self._camera, self._instances = plan.rig.camera, plan.rig.labels["instance"]

    def add(self, sample: Sample) -> None:
        """Write a sample."""
        assert self._camera is not None
        extension, data = sample.file(self._camera)
        (self._pictures / f"{sample.key}.{extension}").write_bytes(data)
        height, width = sample.readings[self._instances].shape
        lines = []
        for thing in sample.things:
            box = thing.box
            x, y = (box.column + box.width / 2) / width, (box.row + box.height / 2) / height
            lines.append(f"{thing.number} {x:.6f} {y:.6f} {box.width / width:.6f} {box.height / height:.6f}\n")
        (self._labels / f"{sample.key}.txt").write_text("".join(lines))

    def close(self) -> None:
        """Every file is whole already."""


def description(splits: list[str], classes: dict[int, tuple[int, str]]) -> bytes:
    """`data.yaml`: where the pictures of each split lie, and the names of the classes."""
    lines = ["path: .", *(f"{split}: images/{split}" for split in splits), "names:"]
    lines += [f"  {number}: {name}" for number, name in sorted(classes.values())]
    return ("\n".join(lines) + "\n").encode()


FORMAT = Yolo
