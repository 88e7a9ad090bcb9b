"""COCO: pictures, and one annotation file a split with boxes and masks.

Format: T.-Y. Lin et al. 2014, doi 10.1007/978-3-319-10602-1_48; masks are uncompressed run lengths, which
`pycocotools` reads. Each shard has a part; `merged` puts the parts together, with numbers that follow from the samples.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from pelagos.datasets.plan import Plan, Shard
from pelagos.datasets.sample import Sample, as_json
from pelagos.sensors.camera.picture.annotations import run_lengths


class Coco:
    """`coco/images/SPLIT/KEY.png` and a part of `coco/annotations/instances_SPLIT.json`."""

    def __init__(self, folder: Path, plan: Plan, shard: Shard, maker: Any) -> None:
        self._pictures = folder / "coco" / "images" / shard.split
        self._pictures.mkdir(parents=True, exist_ok=True)
        self._part = folder / part_of(shard)
        self._part.parent.mkdir(parents=True, exist_ok=True)
        self._camera, self._instances = plan.rig.camera, plan.rig.labels["instance"]
        self._images: list[dict[str, Any]] = []
        self._annotations: list[dict[str, Any]] = []

    def add(self, sample: Sample) -> None:
        """Write a sample."""
        assert self._camera is not None
        extension, data = sample.file(self._camera)
        name = f"{sample.key}.{extension}"
        (self._pictures / name).write_bytes(data)
        instances = sample.readings[self._instances]
        height, width = instances.shape
        self._images.append({"id": sample.index + 1, "file_name": name, "width": width, "height": height})
        for thing in sample.things:
            box = thing.box
            self._annotations.append({
                "image_id": sample.index + 1,
                "category_id": thing.number + 1,
                "bbox": [box.column, box.row, box.width, box.height],
                "area": box.area,
                "iscrowd": 0,
                "instance_id": box.instance,
                "segmentation": {"size": [height, width], "counts": run_lengths(instances == box.instance)},
            })  # fmt: skip

    def close(self) -> None:
        """Write the part."""
        self._part.write_bytes(as_json({"images": self._images, "annotations": self._annotations}) + b"\n")


def part_of(shard: Shard) -> str:
    """The path of a shard's part below the folder of the data set."""
    return f"coco/parts/{shard.name}.json"


def merged(folder: Path, shards: Iterable[Shard], classes: dict[int, tuple[int, str]]) -> bytes:
    """The annotation file of a split, from the parts of its shards; annotations are numbered from 1."""
    images: list[Any] = []
    annotations: list[Any] = []
    for shard in shards:
        part = json.loads((folder / part_of(shard)).read_bytes())
        images += part["images"]
        annotations += [{**a, "id": len(annotations) + k} for k, a in enumerate(part["annotations"], start=1)]
    categories = [{"id": n + 1, "name": name, "supercategory": "marine"} for n, name in sorted(classes.values())]
    return as_json({"images": images, "annotations": annotations, "categories": categories}) + b"\n"


FORMAT = Coco
