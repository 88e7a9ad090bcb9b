"""Parquet: one file a shard, one row a sample; pictures as encoded bytes, arrays as tensors of fixed shape.

By Apache Arrow (extra `datasets`); pictures are structures of `bytes` and `path`, as Hugging Face's `datasets` reads
them.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Final

import numpy as np

from pelagos.datasets.plan import Plan, Shard
from pelagos.datasets.sample import Sample, as_json
from pelagos.errors import InputError

try:
    import pyarrow as pa
    import pyarrow.parquet as pq
except ImportError:
    raise InputError("the format 'parquet' needs Apache Arrow: pip install 'pelagos[datasets]'") from None

ROWS: Final = 64  # of a row group: what is held in memory


class Parquet:
    """`parquet/SPLIT/shard-000000.parquet`."""

    def __init__(self, folder: Path, plan: Plan, shard: Shard, maker: Any) -> None:
        self._path = folder / "parquet" / shard.split / f"{shard.name}.parquet"
        self._path.parent.mkdir(parents=True, exist_ok=True)
        versions = json.dumps(dict(plan.versions), sort_keys=True)
        self._about = {"pelagos.plan": plan.digest, "pelagos.seed": str(plan.config.seed), "pelagos.versions": versions}
        self._writer: Any = None
        self._rows: list[Sample] = []

    def add(self, sample: Sample) -> None:
        """Write a sample."""
        self._rows.append(sample)
        if len(self._rows) == ROWS:
            self._group()

    def close(self) -> None:
        """End the file."""
        if self._rows:
            self._group()
        if self._writer is not None:
            self._writer.close()

    def _group(self) -> None:
        table = _table(self._rows).replace_schema_metadata(self._about)
        if self._writer is None:
            self._writer = pq.ParquetWriter(self._path, table.schema, compression="zstd")
        self._writer.write_table(table)
        self._rows = []


def _table(rows: list[Sample]) -> Any:
    columns: dict[str, Any] = {
        "index": pa.array([r.index for r in rows], pa.int64()),
        "key": pa.array([r.key for r in rows]),
        "world": pa.array([r.world for r in rows], pa.int64()),
        "split": pa.array([r.split for r in rows]),
        "position_m": pa.array([r.pose.position.tolist() for r in rows], pa.list_(pa.float64(), 3)),
        "attitude_wxyz": pa.array([r.pose.attitude.tolist() for r in rows], pa.list_(pa.float64(), 4)),
        "objects": pa.array([_objects(r) for r in rows], _OBJECTS),
        "about": pa.array([as_json(r.about).decode() for r in rows]),
    }
    for sensor, first in rows[0].readings.items():
        if rows[0].file(sensor)[0] == "npy":
            values = np.stack([np.asarray(r.readings[sensor]) for r in rows])
            flat = values[:, None] if values.ndim == 1 else values
            if first.dtype == np.bool_:
                flat = flat.astype(np.uint8)
            columns[sensor] = pa.FixedShapeTensorArray.from_numpy_ndarray(np.ascontiguousarray(flat))
        else:
            files = [(r.key, *r.file(sensor)) for r in rows]
            columns[sensor] = pa.array([{"bytes": data, "path": f"{key}.{end}"} for key, end, data in files], _PICTURE)
    return pa.table(columns)


def _objects(sample: Sample) -> list[dict[str, Any]]:
    return [
        {
            "instance": t.box.instance, "class": t.name, "class_number": t.number, "area_px": t.box.area,
            "bbox_px": [t.box.column, t.box.row, t.box.width, t.box.height],
        }
        for t in sample.things
    ]  # fmt: skip


_PICTURE: Final = pa.struct([("bytes", pa.binary()), ("path", pa.string())])
_OBJECTS: Final = pa.list_(
    pa.struct([
        ("instance", pa.int64()), ("class", pa.string()), ("class_number", pa.int32()), ("area_px", pa.int64()),
        ("bbox_px", pa.list_(pa.int32(), 4)),
    ])
)  # fmt: skip

FORMAT = Parquet
