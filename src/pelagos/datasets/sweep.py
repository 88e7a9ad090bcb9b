"""Sweeps: a run of one scenario for every combination of values, and a table of how each ended."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

import numpy as np

from pelagos.config.document import parse_document
from pelagos.config.loader import load_scenario, to_yaml
from pelagos.config.scenario import Scenario
from pelagos.datasets.engine import Engine, Record
from pelagos.datasets.shard import put
from pelagos.errors import InputError, PelagosError, RecordingError, ScenarioError

MOST: Final = 100_000  # combinations
TABLE: Final = "results.csv"


@dataclass(frozen=True)
class Axis:
    """One key and the values that it takes."""

    key: str
    values: tuple[Any, ...]


def axis_of(text: str) -> Axis:
    """An axis as the command line has it: `KEY=1,2,5`, `KEY=[a, b]`, or `KEY=0:1:5`, five values from 0 to 1.

    Raises:
        InputError: not of this form, or without a value.
    """
    key, equals, given = text.partition("=")
    place = f"--vary {text}"
    if not equals or not all(key.strip().split(".")):
        raise InputError(f"{place}: write KEY.PATH=VALUES, such as ocean.turbidity=0.1,1,3")
    parts = [_number(part) for part in given.split(":")]
    numbers = [part for part in parts if part is not None]
    if len(numbers) == len(parts) == 3:
        low, high, count = numbers
        if count != int(count) or count < 2:
            raise InputError(f"{place}: LOWEST:HIGHEST:COUNT takes a whole count from 2 on, not {count:g}")
        return Axis(key.strip(), tuple(float(v) for v in np.linspace(low, high, int(count))))
    if given.strip().startswith("["):
        data = parse_document(given, place, Path.cwd()).data
    else:
        data = [parse_document(part, place, Path.cwd()).data for part in given.split(",")]
    if not isinstance(data, list) or not data or None in data:
        raise InputError(f"{place}: a value is missing; write VALUE,VALUE,... or a list in YAML")
    twice = [
        v for k, v in enumerate(data) if any(v == w and isinstance(v, bool) == isinstance(w, bool) for w in data[:k])
    ]
    if twice:
        raise InputError(f"{place}: {twice[0]!r} is given twice")
    return Axis(key.strip(), tuple(data))


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


@dataclass(frozen=True)
class Sweep:
    """Runs of a scenario, combination by combination.

    Attributes:
        scenario: plain data, checked.
        axes: the last changes fastest.
        folder: of the results.
        seconds: how long each run lasts [s]; None: as the scenario says.
        record: whether each run is recorded.
    """

    scenario: Mapping[str, Any]
    axes: tuple[Axis, ...]
    folder: Path
    seconds: float | None = None
    record: bool = False

    @property
    def count(self) -> int:
        """Combinations."""
        return math.prod(len(axis.values) for axis in self.axes)

    def values(self, index: int) -> dict[str, Any]:
        """The combination of a number from 0 on, by key."""
        found = {}
        for axis in reversed(self.axes):
            index, k = divmod(index, len(axis.values))
            found[axis.key] = axis.values[k]
        return {axis.key: found[axis.key] for axis in self.axes}

    def of(self, index: int) -> Scenario:
        """The scenario of a combination."""
        return load_scenario(self.scenario, overrides=self.values(index), trust=True)

    def path(self, index: int) -> Path:
        """Path of a run's record."""
        return self.folder / "runs" / f"run-{index:05d}.json"

    @property
    def digest(self) -> str:
        """Digest of all that results depend on, as SHA-256."""
        axes = [(axis.key, list(axis.values)) for axis in self.axes]
        text = json.dumps([self.scenario, axes, self.seconds, self.record], sort_keys=True)
        return sha256(text.encode()).hexdigest()

    def open(self) -> Callable[[int], Record]:
        """Worker that does a run."""
        return self._run

    def _run(self, index: int) -> Record:
        from pelagos.sim.simulation import Simulation

        record: Record = {"run": index, "sweep": self.digest, "values": self.values(index)}
        recording = self.folder / "runs" / f"run-{index:05d}.mcap"
        new = recording.with_name(f".{recording.name}.new")
        try:
            self.folder.joinpath("runs").mkdir(parents=True, exist_ok=True)
            try:
                sim = Simulation.load(self.of(index))
                result = sim.run(self.seconds, record=new if self.record else None)
                record |= {"ended": result.ended, "simulated_s": result.simulated_s, **_measures(sim)}
                if self.record:
                    new.replace(recording)
            except PelagosError as error:
                if isinstance(error, RecordingError):
                    raise
                record |= {"ended": "error", "error": str(error)}
            put(self.path(index), (json.dumps(record, indent=1) + "\n").encode())
        except OSError as error:
            raise RecordingError(f"{self.path(index)}: cannot be written: {error.strerror}") from None
        finally:
            new.unlink(missing_ok=True)
        return record


def _measures(sim: Any) -> dict[str, Any]:
    """Numbers of a run at its end: place, attitude and speed of each agent, and a hash of all true states."""
    found: dict[str, Any] = {}
    digest = sha256()
    for name, state in sim.state.items():
        for part in (state.position, state.attitude, state.velocity, state.angular_velocity):
            digest.update(np.ascontiguousarray(part).tobytes())
        x, y, z = (float(c) for c in state.position[0])
        speed = float(np.linalg.norm(state.velocity[0]))
        found |= {f"{name}.x_m": x, f"{name}.y_m": y, f"{name}.z_m": z, f"{name}.speed_mps": speed}
    return {**found, "state_sha256": digest.hexdigest()}


def sweep_of(
    scenario: Scenario, axes: Sequence[Axis], folder: Path, *, seconds: float | None = None, record: bool = False
) -> Sweep:
    """A sweep; every combination is checked, without a device.

    Raises:
        InputError: no or too many combinations, a key twice, or a value that the scenario does not take.
    """
    keys = [axis.key for axis in axes]
    if not axes:
        raise InputError("nothing varies: give --vary KEY.PATH=VALUES")
    if len(set(keys)) < len(keys):
        raise InputError(f"--vary {next(k for k in keys if keys.count(k) > 1)} is given twice")
    data = scenario.model_dump(mode="json", exclude_unset=True)
    made = Sweep(data, tuple(axes), folder, seconds, record)
    if made.count > MOST:
        raise InputError(f"{made.count} combinations are more than {MOST}; give fewer values")
    for axis in axes:
        for value in axis.values:
            try:
                load_scenario(data, overrides={axis.key: value}, trust=True)
            except InputError as error:
                raise ScenarioError(str(error).removeprefix("override "), where="--vary") from None
    return made


def run_sweep(
    sweep: Sweep, engine: Engine | None = None, *, progress: Callable[[int, int], None] | None = None
) -> list[Record]:
    """Do the runs that are missing, and write the table.

    Returns:
        Records by combination.

    Raises:
        InputError: the folder holds something else.
        RecordingError: a file cannot be written.
    """
    _claim(sweep)
    missing = [i for i in range(sweep.count) if _record(sweep, i) is None]
    done = sweep.count - len(missing)
    if progress is not None:
        progress(done, sweep.count)
    for _ in (engine or Engine()).run(sweep, missing):
        done += 1
        if progress is not None:
            progress(done, sweep.count)
    records = [record for i in range(sweep.count) if (record := _record(sweep, i)) is not None]
    put(sweep.folder / TABLE, _table(records).encode())
    return records


def _claim(sweep: Sweep) -> None:
    note = sweep.folder / "sweep.json"
    try:
        if note.exists():
            if json.loads(note.read_text())["digest"] != sweep.digest:
                raise InputError(f"{sweep.folder}: it holds another sweep; give another folder")
            return
        if sweep.folder.exists() and (not sweep.folder.is_dir() or any(sweep.folder.iterdir())):
            raise InputError(f"{sweep.folder}: it holds something else; give a new folder, or one of this sweep")
        told = {"digest": sweep.digest, "axes": {axis.key: list(axis.values) for axis in sweep.axes}}
        put(note, (json.dumps(told, indent=1) + "\n").encode())
        put(sweep.folder / "scenario.yaml", to_yaml(load_scenario(sweep.scenario, trust=True)).encode())
    except (OSError, ValueError, KeyError) as error:
        raise RecordingError(f"{sweep.folder}: cannot be used: {error}") from None


def _record(sweep: Sweep, index: int) -> Record | None:
    try:
        found: Record = json.loads(sweep.path(index).read_text())
    except (OSError, ValueError):
        return None
    return found if found.get("sweep") == sweep.digest else None


def _table(records: Sequence[Record]) -> str:
    """CSV: what was varied, and what came out."""
    rows = [{"run": r["run"], **r["values"], **dict(_results(r))} for r in records]
    names = list(dict.fromkeys(name for row in rows for name in row))
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return buffer.getvalue()


def _results(record: Record) -> Iterator[tuple[str, Any]]:
    for name, value in record.items():
        if name not in ("run", "values", "sweep"):
            yield name, value


def rows_of(records: Sequence[Record], axes: Sequence[Axis]) -> tuple[list[str], list[list[str]]]:
    """Head and rows of the table that people read: what was varied, end, and the places of agents."""
    hidden = ("state_sha256", "error")
    names = list(dict.fromkeys(name for r in records for name, _ in _results(r) if name not in hidden))
    rows = []
    for r in records:
        values = [str(r["values"][axis.key]) for axis in axes]
        rows.append([*values, *(f"{v:.4g}" if isinstance(v := r.get(n, ""), float) else str(v) for n in names)])
    short = [axis.key.rpartition(".")[2] for axis in axes]
    keys = [name if short.count(name) == 1 else axis.key for name, axis in zip(short, axes, strict=True)]
    return [*keys, *names], rows
