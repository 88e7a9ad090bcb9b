"""One shard on the disk: all its files under a temporary name, then in place, and its record last.

A shard exists when its record does. Whatever ends the process before leaves files of the same bytes that the next
attempt writes over, and no record.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shutil
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

from pelagos.datasets.formats import writer_of
from pelagos.datasets.maker import Maker
from pelagos.datasets.plan import Plan, Shard
from pelagos.datasets.sample import Sample, as_json, encoded
from pelagos.errors import RecordingError
from pelagos.files import give_name

RECORDS: Final = "shards"
STAGING: Final = ".staging"
THUMB_PX: Final = 160
_NO_ROOM: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_AREAS: Final = tuple(2**k for k in range(2, 22))  # edges of the histogram of areas [px]


def record_path(folder: Path, shard: Shard) -> Path:
    """Path of a shard's record."""
    return folder / RECORDS / f"{shard.name}.json"


def read_record(folder: Path, shard: Shard) -> dict[str, Any] | None:
    """A shard's record; None where the shard does not exist, or a file of it is gone or has another size."""
    try:
        found: dict[str, Any] = json.loads(record_path(folder, shard).read_bytes())
        whole = all((folder / name).stat().st_size == f["bytes"] for name, f in found["files"].items())
    except (OSError, ValueError):
        return None
    return found if whole else None


def make_shard(maker: Maker, shard: Shard, folder: Path) -> dict[str, Any]:
    """Make a shard.

    Returns:
        Its record: files with their SHA-256, and statistics.

    Raises:
        RecordingError: the disk is full, or a file cannot be written; nothing is half-written.
        InputError: its world cannot be built.
    """
    staged = folder / STAGING / f"{shard.name}.{os.getpid()}"
    try:
        staged.mkdir(parents=True, exist_ok=True)
        record = _written(maker, shard, staged)
        for name in record["files"]:
            target = folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            give_name(staged / name, target)
        put(record_path(folder, shard), as_json(record) + b"\n")
    except OSError as error:
        raise _no_file(error, shard) from None
    finally:
        shutil.rmtree(staged, ignore_errors=True)
    return record


def put(path: Path, data: bytes) -> None:
    """Write a file under a temporary name, and give it its own when it is whole."""
    path.parent.mkdir(parents=True, exist_ok=True)
    new = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        new.write_bytes(data)
        give_name(new, path)
    except BaseException:
        new.unlink(missing_ok=True)
        raise


def digest_of(path: Path) -> str:
    """SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _no_file(error: OSError, shard: Shard) -> RecordingError:
    place = error.filename or shard.name
    if error.errno in _NO_ROOM:
        why = f"no room for {shard.name} ({error.strerror}); nothing of it was kept. Make room, and run it again"
        return RecordingError(f"{why}: what is whole stays")
    return RecordingError(f"{place}: cannot be written: {error.strerror}")


def _written(maker: Maker, shard: Shard, staged: Path) -> dict[str, Any]:
    maker.prepare(shard)
    writers = [writer_of(name)(staged, maker.plan, shard, maker) for name in maker.plan.config.formats]
    statistics = Statistics()
    try:
        for sample in maker.samples(shard):
            if not statistics.samples:
                _thumbs(maker.plan, shard, sample, staged)
            statistics.add(maker, sample)
            for writer in writers:
                writer.add(sample)
    finally:
        for writer in writers:
            writer.close()
    files = {
        name: {"sha256": digest_of(staged / name), "bytes": (staged / name).stat().st_size} for name in _files(staged)
    }
    told = {"shard": shard.index, "world": shard.world, "split": shard.split, "first": shard.first}
    drawn = maker.plan.values(shard.world)
    return {**told, "count": shard.count, "plan": maker.plan.digest, "drawn": drawn, "files": files, **statistics.told}


def _files(staged: Path) -> Iterator[str]:
    yield from sorted(path.relative_to(staged).as_posix() for path in staged.rglob("*") if path.is_file())


class Statistics:
    """Counts of what samples show, for the data card."""

    def __init__(self) -> None:
        self.samples = self.facing = self.empty = 0
        self._objects: Counter[str] = Counter()
        self._areas = np.zeros(len(_AREAS) + 1, dtype=np.int64)
        self._depths: list[float] = []
        self._altitudes: list[float] = []

    def add(self, maker: Maker, sample: Sample) -> None:
        """Count a sample."""
        self.samples += 1
        self.facing += sample.pose.facing is not None
        self.empty += not sample.things
        self._objects.update(thing.name for thing in sample.things)
        for thing in sample.things:
            self._areas[int(np.searchsorted(_AREAS, thing.box.area, side="right"))] += 1
        x, y, z = sample.pose.position
        self._depths.append(round(-float(z), 3))
        ground = float(np.ravel(maker.simulation.world.height(x, y))[0])
        if np.isfinite(ground):
            self._altitudes.append(round(float(z) - ground, 3))

    @property
    def told(self) -> dict[str, Any]:
        """As JSON data."""
        return {
            "facing": self.facing, "without_objects": self.empty, "objects": dict(sorted(self._objects.items())),
            "area_edges_px": list(_AREAS), "areas": self._areas.tolist(), "depth_m": self._depths,
            "altitude_m": self._altitudes,
        }  # fmt: skip


def _thumbs(plan: Plan, shard: Shard, sample: Sample, staged: Path) -> None:
    """Small pictures of a shard's first sample, side by side, for the contact sheet."""
    from pelagos.datasets.contact_sheet import strip

    values = strip(plan, sample, THUMB_PX)
    if values is not None:
        path = staged / RECORDS / f"{shard.name}.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(encoded(values, "png", "contact sheet")[1])
