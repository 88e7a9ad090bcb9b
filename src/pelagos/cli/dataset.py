"""`pelagos dataset`."""

from __future__ import annotations

import shlex
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn

from pelagos.cli.console import err, out, shown
from pelagos.cli.live_bar import LiveBar
from pelagos.errors import InputError

LINE_EVERY_S: Final = 10.0


@dataclass(frozen=True)
class DatasetOptions:
    """Options of the command line beside configuration and folder; see `pelagos dataset --help`."""

    workers: int = 1
    ray: str | None = None
    shard: str | None = None
    verify: bool = False
    plan_only: bool = False
    trust: bool = False


def make(config: Path, folder: Path | None, changes: Sequence[str], options: DatasetOptions) -> None:
    """Make a data set, or what is missing of it.

    Raises:
        InputError: the configuration, an option or the folder is wrong.
    """
    from pelagos.datasets.config import load_config
    from pelagos.datasets.engine import checked
    from pelagos.datasets.plan import plan_of

    plan = plan_of(load_config(config, tuple(changes)), trust=options.trust)
    if options.plan_only:
        splits = {name: plan.splits.count(name) for name in dict.fromkeys(plan.splits)}
        told = ", ".join(f"{count} {name}" for name, count in splits.items())
        out.print(f"{plan.samples} samples in {plan.shards} shards of {plan.config.worlds} worlds: {told}")
        return
    if folder is None:
        raise InputError("give a folder for the data set")
    engine = checked(options.workers, options.ray)
    only = None if options.shard is None else _chosen(options.shard, plan.shards)
    from pelagos.datasets.factory import make_dataset

    words = ["pelagos", "dataset", config.name, "FOLDER", *(w for c in changes for w in ("--set", c))]
    started = time.perf_counter()
    with Bar("samples") as bar:
        made = make_dataset(
            plan, folder, engine=engine, only=only, verify=options.verify, command=shlex.join(words), progress=bar
        )
    took = time.perf_counter() - started
    kept = f", {made.kept} stood already" if made.kept else ""
    out.print(f"{made.made} shards made in {took:.1f} s{kept}: {shown(folder)}", markup=False)
    if made.left:
        out.print(
            f"{made.left} of {plan.shards} shards are missing; without --shard, all are made and the card written"
        )
    else:
        out.print(f"{made.samples} samples; manifest SHA-256 {made.digest}")
        out.print(f"data card: {shown(folder / 'README.md')}", markup=False)


def _chosen(text: str, shards: int) -> range:
    """ "3": that shard; "3/16": the fourth, and every sixteenth from there."""
    first, slash, step = text.partition("/")
    try:
        start, stride = int(first), int(step) if slash else shards
    except ValueError:
        raise InputError(f"--shard {text!r}: write I, a number from 0, or I/N") from None
    if stride < 1 or start < 0 or (slash and start >= stride) or (not slash and start >= shards):
        most = f"0 to {stride - 1}" if slash else f"0 to {shards - 1}"
        raise InputError(f"--shard {text}: I is a number from {most}")
    return range(start, shards, stride)


class Bar(LiveBar):
    """Progress with the time that is left: a bar on a terminal, a line now and then elsewhere."""

    def __init__(self, what: str) -> None:
        super().__init__(TextColumn(what), BarColumn(), MofNCompleteColumn(), TextColumn("left"), TimeRemainingColumn())
        self._what = what
        self._next_line = 0.0
        self._before: int | None = None

    def __call__(self, done: int, total: int) -> None:
        """Show that `done` of `total` are done; the first call says what was done before."""
        if self._before is None:
            self._before = done
        if self._bar is not None:
            self._bar.update(self._task, completed=done, total=total)
            return
        wall = time.perf_counter() - self._started
        if wall >= self._next_line and done > self._before:
            self._next_line = wall + LINE_EVERY_S
            rate = (done - self._before) / wall
            err.print(f"{done} of {total} {self._what}, {rate:.2f} a second, {(total - done) / rate:.0f} s left")
