"""WebDataset: one tar a shard; the files of a sample lie beside one another and begin with its key.

Format: https://github.com/webdataset/webdataset, "The WebDataset format" (POSIX ustar; a key ends at the first dot).
"""

from __future__ import annotations

import io
import tarfile
from pathlib import Path
from typing import Any

from pelagos.datasets.plan import Plan, Shard
from pelagos.datasets.sample import Sample, as_json


class WebDataset:
    """`webdataset/SPLIT/shard-000000.tar` with `KEY.SENSOR.EXTENSION` and `KEY.json`."""

    def __init__(self, folder: Path, plan: Plan, shard: Shard, maker: Any) -> None:
        path = folder / "webdataset" / shard.split / f"{shard.name}.tar"
        path.parent.mkdir(parents=True, exist_ok=True)
        self._tar = tarfile.open(path, "w", format=tarfile.USTAR_FORMAT)  # noqa: SIM115

    def add(self, sample: Sample) -> None:
        """Write a sample."""
        for sensor in sample.readings:
            extension, data = sample.file(sensor)
            self._put(f"{sample.key}.{sensor}.{extension}", data)
        self._put(f"{sample.key}.json", as_json(sample.meta))

    def _put(self, name: str, data: bytes) -> None:
        member = tarfile.TarInfo(name)  # time 0, owner 0
        member.size = len(data)
        self._tar.addfile(member, io.BytesIO(data))

    def close(self) -> None:
        """End the archive."""
        self._tar.close()


FORMAT = WebDataset
