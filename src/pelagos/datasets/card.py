"""The data card, and the other files that are common to all shards."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pelagos.datasets.config import SPLITS
from pelagos.datasets.contact_sheet import contact_sheet
from pelagos.datasets.formats import coco, yolo
from pelagos.datasets.plan import Plan, Shard
from pelagos.datasets.shard import RECORDS, put

Records = Sequence[Mapping[str, Any]]


def write_common(
    plan: Plan, folder: Path, records: Records, classes: dict[int, tuple[int, str]], command: str
) -> list[str]:
    """Write merged annotations, descriptions, pictures and the card.

    Returns:
        Their paths below the folder.
    """
    shards = [plan.shard(index) for index in range(plan.shards)]
    splits = [name for name in SPLITS if any(shard.split == name for shard in shards)]
    made: dict[str, bytes | None] = {}
    if "coco" in plan.config.formats:
        for split in splits:
            of_split = (shard for shard in shards if shard.split == split)
            made[f"coco/annotations/instances_{split}.json"] = coco.merged(folder, of_split, classes)
    if "yolo" in plan.config.formats:
        made["yolo/data.yaml"] = yolo.description(splits, classes)
    made["contact_sheet.png"] = contact_sheet(_strips(folder, shards))
    made["histograms.png"] = _histograms(records)
    made["README.md"] = card(plan, records, splits, command).encode()
    for name, data in made.items():
        if data is not None:
            put(folder / name, data)
    return ["plan.json", *(name for name, data in made.items() if data is not None)]


def _strips(folder: Path, shards: Sequence[Shard]) -> list[Path]:
    found = [folder / RECORDS / f"{shard.name}.png" for shard in shards]
    return [path for path in found if path.exists()]


def card(plan: Plan, records: Records, splits: Sequence[str], command: str) -> str:
    """The data card: Markdown with the head that Hugging Face reads."""
    config = plan.config
    total = sum(f["bytes"] for r in records for f in r["files"].values())
    sheet = "![Contact sheet](contact_sheet.png)\n\n" if plan.rig.camera else ""
    without, facing = (sum(r[key] for r in records) for key in ("without_objects", "facing"))
    return f"""---
license: {config.licence.lower()}
pretty_name: {config.name}
---
# {config.name}

{config.description}

Simulated with Pelagos {plan.versions["pelagos"]}: readings of one vehicle at random poses in random worlds.

| | |
|---|---|
| licence | {config.licence} |
| seed | {config.seed} |
| samples | {plan.samples} in {config.worlds} worlds, {plan.shards} shards, {total / 1e6:.1f} MB |
| formats | {", ".join(config.formats)} |
| sensors | {", ".join(plan.rig.sensors)} |
| poses that face an object | {facing} |
| samples without an object | {without} |
| plan | SHA-256 `{plan.digest}` |
| versions | {", ".join(f"{k} {v}" for k, v in plan.versions.items())} |

{sheet}![Histograms](histograms.png)

## Splits

A world lies in one split only.

| split | worlds | samples | objects |
|---|---|---|---|
{_split_rows(records, splits)}

## Objects

| class | pictures of them |
|---|---|
{_object_rows(records)}

## Drawn for every world

| key | values |
|---|---|
{_drawn_rows(records)}

## Made by

```sh
{command or "pelagos dataset CONFIG.yaml FOLDER"}
```

`plan.json` holds the configuration and the scenario as they were resolved. The same plan and versions give the same
bytes on one kind of processor, with any number of workers; `manifest.json` has the SHA-256 of every file.
"""


def _split_rows(records: Records, splits: Sequence[str]) -> str:
    rows = []
    for split in splits:
        own = [r for r in records if r["split"] == split]
        counted = sum(sum(r["objects"].values()) for r in own)
        worlds = len({r["world"] for r in own})
        rows.append(f"| {split} | {worlds} | {sum(r['count'] for r in own)} | {counted} |")
    return "\n".join(rows)


def _object_rows(records: Records) -> str:
    objects: Counter[str] = Counter()
    for record in records:
        objects.update(record["objects"])
    return "\n".join(f"| {name} | {count} |" for name, count in objects.most_common()) or "| none | 0 |"


def _drawn_rows(records: Records) -> str:
    drawn = sorted({key for r in records for key in r["drawn"]})
    return "\n".join(f"| `{key}` | {_values([r['drawn'][key] for r in records])} |" for key in drawn)


def _values(values: Sequence[Any]) -> str:
    numbers = [v for v in values if isinstance(v, int | float) and not isinstance(v, bool)]
    if len(numbers) == len(values):
        return f"{min(numbers):.6g} to {max(numbers):.6g}"
    counts = Counter(map(str, values))
    return ", ".join(f"{value} ({count})" for value, count in sorted(counts.items()))


def _histograms(records: Records) -> bytes:
    """PNG of how many samples have which depth and altitude, and of the sizes of objects."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 2.8), layout="constrained")
    canvas = FigureCanvasAgg(figure)
    axes = figure.subplots(1, 3)
    for axis, key, title in zip(axes, ("depth_m", "altitude_m"), ("depth [m]", "altitude [m]"), strict=False):
        values = np.concatenate([np.asarray(r[key], dtype=np.float64) for r in records])
        axis.hist(values, bins=30, color="#1f6f8b")
        axis.set_xlabel(title)
    axes[0].set_ylabel("samples")
    areas = np.sum([r["areas"] for r in records], axis=0)
    axes[2].bar(np.arange(len(areas)), areas, color="#b5651d")
    ticks = range(1, len(areas), 4)
    axes[2].set_xticks([t - 0.5 for t in ticks], [f"{records[0]['area_edges_px'][t - 1]}" for t in ticks])
    axes[2].set_xlabel("area of an object [px]")
    axes[2].set_ylabel("objects")
    buffer = io.BytesIO()
    figure.set_canvas(canvas)
    figure.savefig(buffer, format="png", dpi=100, metadata={"Software": None})
    return buffer.getvalue()
