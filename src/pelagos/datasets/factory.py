"""The factory: a data set from a configuration, shard by shard, whole again after whatever ended it."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from pelagos.datasets.card import write_common
from pelagos.datasets.engine import Engine, Record
from pelagos.datasets.formats import writer_of
from pelagos.datasets.maker import Maker, classes_of
from pelagos.datasets.plan import Plan, Shard
from pelagos.datasets.shard import STAGING, digest_of, make_shard, put, read_record, record_path
from pelagos.errors import InputError, RecordingError

PLAN: Final = "plan.json"
STALE_S: Final = 86400.0  # what an attempt left so long ago is swept
_SHOWN: Final = 5


@dataclass(frozen=True)
class Made:
    """Result of a call of the factory.

    Attributes:
        made: shards that it made.
        kept: shards that stood already.
        left: shards that are missing still, which others make.
        samples: of the whole data set.
        digest: SHA-256 of the manifest; empty while shards are missing.
    """

    made: int
    kept: int
    left: int
    samples: int
    digest: str


@dataclass(frozen=True)
class ShardJob:
    """Shards of a plan, as work for an engine."""

    plan: Plan
    folder: Path

    def open(self) -> Callable[[int], Record]:
        """Maker of a shard."""
        maker = Maker(self.plan)
        return lambda index: make_shard(maker, self.plan.shard(index), self.folder)


def make_dataset(
    plan: Plan,
    folder: Path,
    *,
    engine: Engine | None = None,
    only: range | None = None,
    verify: bool = False,
    command: str = "",
    progress: Callable[[int, int], None] | None = None,
) -> Made:
    """Make what is missing of a data set.

    Args:
        plan: see `plan_of`.
        folder: of the data set; new, empty, or that of an earlier call with the same plan.
        engine: where the work is done; in this process where not given.
        only: numbers of shards to make; all where not given.
        verify: compare the content of what stands with its hashes, and make anew what differs.
        command: that makes the data set again, for its card.
        progress: called with samples done and in all.

    Raises:
        InputError: the folder is that of another plan, or a format needs a package that is missing.
        RecordingError: a file cannot be written.
    """
    for name in plan.config.formats:
        writer_of(name)
    _claim(plan, folder)
    numbers = range(plan.shards) if only is None else only
    if len(numbers) and not 0 <= min(numbers) <= max(numbers) < plan.shards:
        raise InputError(f"the data set has shards 0 to {plan.shards - 1}, not {max(numbers)}")
    missing = [i for i in numbers if not _stands(folder, plan.shard(i), verify=verify)]
    done = sum(plan.shard(i).count for i in numbers) - sum(plan.shard(i).count for i in missing)
    total = sum(plan.shard(i).count for i in numbers)
    if progress is not None:
        progress(done, total)
    for record in (engine or Engine()).run(ShardJob(replace(plan), folder), missing):
        done += int(record["count"])
        if progress is not None:
            progress(done, total)
    left = [] if only is None else [i for i in range(plan.shards) if read_record(folder, plan.shard(i)) is None]
    digest = "" if left else _finish(plan, folder, command)
    return Made(len(missing), len(numbers) - len(missing), len(left), plan.samples, digest)


def _stands(folder: Path, shard: Shard, *, verify: bool) -> bool:
    record = read_record(folder, shard)
    if record is not None and verify:
        wrong = [name for name, f in record["files"].items() if digest_of(folder / name) != f["sha256"]]
        if wrong:
            record = None
    if record is None:
        with suppress(OSError):
            record_path(folder, shard).unlink(missing_ok=True)
    return record is not None


def _claim(plan: Plan, folder: Path) -> None:
    """Write the plan into a new folder, or see that it is that of the folder."""
    written = folder / PLAN
    try:
        if written.exists():
            _same(plan, written)
        elif folder.exists() and (not folder.is_dir() or any(p for p in folder.iterdir() if p.name != STAGING)):
            raise InputError(f"{folder}: it holds something else; give a new folder, or one of this data set")
        else:
            folder.mkdir(parents=True, exist_ok=True)
            put(written, plan.text.encode())
        _sweep(folder)
    except OSError as error:
        raise RecordingError(f"{folder}: cannot be written: {error.strerror}") from None


def _same(plan: Plan, written: Path) -> None:
    text = written.read_text(encoding="utf-8")
    if text == plan.text:
        return
    try:
        before = dict(_leaves(json.loads(text)))
    except ValueError:
        raise InputError(f"{written}: not the plan of a data set; give another folder") from None
    now = dict(_leaves(json.loads(plan.text)))
    keys = [key for key in sorted({*before, *now}) if before.get(key) != now.get(key)]
    told = "; ".join(f"{key} was {before.get(key, 'absent')!r}, is {now.get(key, 'absent')!r}" for key in keys[:_SHOWN])
    more = f"; and {len(keys) - _SHOWN} more" if len(keys) > _SHOWN else ""
    raise InputError(f"{written.parent}: it holds a data set of another plan ({told}{more}); give another folder")


def _leaves(data: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    if isinstance(data, dict):
        for key, value in data.items():
            yield from _leaves(value, f"{path}.{key}" if path else key)
    else:
        yield path, data


def _sweep(folder: Path) -> None:
    """Remove what attempts left that were killed long ago."""
    staging = folder / STAGING
    if staging.is_dir():
        for old in staging.iterdir():
            if time.time() - old.stat().st_mtime > STALE_S:
                shutil.rmtree(old, ignore_errors=True)


def _finish(plan: Plan, folder: Path, command: str) -> str:
    """Write what is common to all shards, the card and the manifest."""
    records = []
    for index in range(plan.shards):
        record = read_record(folder, plan.shard(index))
        if record is None:
            raise RecordingError(f"{folder}: {plan.shard(index).name} was removed meanwhile; run it again")
        records.append(record)
    try:
        common = write_common(plan, folder, records, classes_of(plan), command)
        files = {name: f for record in records for name, f in record["files"].items()}
        files |= {n: {"sha256": digest_of(folder / n), "bytes": (folder / n).stat().st_size} for n in common}
        told = {"plan": plan.digest, "samples": plan.samples, "shards": plan.shards, "files": files}
        put(folder / "manifest.json", (json.dumps(told, indent=1, sort_keys=True) + "\n").encode())
        shutil.rmtree(folder / STAGING, ignore_errors=True)
    except OSError as error:
        raise RecordingError(f"{folder}: cannot be written: {error.strerror}; run it again to go on") from None
    return digest_of(folder / "manifest.json")
