"""Whole episodes as a LeRobot data set, version 3.0: tables in Parquet with pictures as PNG, and their statistics.

Format: https://huggingface.co/docs/lerobot/lerobot-dataset-v3. A frame is an observation with the action that was
taken on it; the observation that an episode ends with has no action, and is left out. Pictures are kept without loss
(`dtype: image`), not as films.
"""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.drawing.png import png
from pelagos.envs.fleet import FleetEnv
from pelagos.envs.sensing import SensingEnv
from pelagos.envs.trajectories import Trajectory
from pelagos.errors import CommandError, InputError

VERSION: Final = "v3.0"
FILE_MB: Final = 100  # of data, about
FILES: Final = 1000  # of a folder
_DATA: Final = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_EPISODES: Final = "meta/episodes/chunk-000/file-000.parquet"
_SHARES: Final = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
_OWN: Final = {"timestamp": "float32", "frame_index": "int64", "episode_index": "int64", "index": "int64",
               "task_index": "int64"}  # fmt: skip
_LEVELS: Final = 256  # of a picture's channel

Columns = dict[str, NDArray[Any]]


def save_lerobot(
    episodes: Sequence[Trajectory], env: FleetEnv | SensingEnv, folder: Path, *, task: str, file_mb: float = FILE_MB
) -> Path:
    """A data set in a new folder, at once or not at all; `LeRobotDataset(NAME, root=folder)` reads it.

    Args:
        episodes: of `collect`.
        env: where they are from.
        folder: new.
        task: words that say what is to be done.
        file_mb: size at which a file of data ends, about [MB].

    Returns:
        The folder.

    Raises:
        CommandError: pyarrow is not installed, no episodes, or the folder is there.
        InputError: it cannot be written.
    """
    _arrow()
    if not episodes:
        raise CommandError("a data set of no episodes: collect some first")
    if folder.exists():
        raise CommandError(f"{folder} is there already; give a new folder, or remove it")
    part: Path | None = None
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        part = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
        _write(part, list(_frames(episodes, env.task.rate_hz)), env, task, file_mb)
        part.chmod(0o755)
        part.rename(folder)
    except OSError as error:
        raise InputError(f"{folder} cannot be written: {error.strerror or error}; nothing of it was kept") from None
    finally:
        if part is not None:
            shutil.rmtree(part, ignore_errors=True)
    return folder


def _frames(episodes: Sequence[Trajectory], rate_hz: float) -> Iterator[Columns]:
    """Arrays of each episode by the names of the format, one row a frame."""
    first = 0
    for number, episode in enumerate(episodes):
        length, seen = len(episode), episode.observations
        by_name = seen if isinstance(seen, Mapping) else {"state": seen}
        found = {_feature(name, values): values[:length] for name, values in by_name.items()}
        frame = np.arange(length, dtype=np.int64)
        yield found | {
            "action": episode.actions,
            "next.reward": episode.rewards.astype(np.float32),
            "next.done": episode.terminations | episode.truncations,
            "next.truncated": episode.truncations,
            "timestamp": (frame / rate_hz).astype(np.float32),
            "frame_index": frame,
            "episode_index": np.full(length, number, dtype=np.int64),
            "index": first + frame,
            "task_index": np.zeros(length, dtype=np.int64),
        }
        first += length


def _feature(name: str, values: NDArray[Any]) -> str:
    return f"observation.images.{name}" if _is_picture(values) else f"observation.{name}"


def _is_picture(values: NDArray[Any]) -> bool:
    """True of rows of pictures `(n, height, width, 3)`."""
    return values.ndim == 4 and values.dtype == np.uint8 and values.shape[-1] == 3


def _write(folder: Path, rows: list[Columns], env: FleetEnv | SensingEnv, task: str, file_mb: float) -> None:
    pa, pq = _arrow()
    told: list[dict[str, Any]] = []
    waiting: list[Any] = []
    file = size = first = 0

    def end() -> None:
        path = folder / _DATA.format(chunk_index=file // FILES, file_index=file % FILES)
        path.parent.mkdir(parents=True, exist_ok=True)
        pq.write_table(pa.concat_tables(waiting), path, compression="snappy")

    for number, columns in enumerate(rows):
        table = pa.table({name: _column(pa, values) for name, values in columns.items()})
        if waiting and (size + table.nbytes) / 1e6 > file_mb:
            end()
            waiting, size, file = [], 0, file + 1
        waiting.append(table)
        size += table.nbytes
        length = len(columns["index"])
        stats = {f"stats/{name}/{kind}": v for name, s in _statistics([columns]).items() for kind, v in s.items()}
        told.append({
            "episode_index": number, "tasks": [task], "length": length, "data/chunk_index": file // FILES,
            "data/file_index": file % FILES, "dataset_from_index": first, "dataset_to_index": first + length, **stats,
            "meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0,
        })  # fmt: skip
        first += length
    end()
    (folder / _EPISODES).parent.mkdir(parents=True)
    pq.write_table(pa.Table.from_pylist(told), folder / _EPISODES)
    pq.write_table(_tasks(pa, task), folder / "meta/tasks.parquet")
    _put(folder / "meta/stats.json", _statistics(rows))
    _put(folder / "meta/info.json", _info(rows, env, first))


def _column(pa: Any, values: NDArray[Any]) -> Any:
    """A column of the type that the format's readers give such a feature."""
    if _is_picture(values):
        files = [{"bytes": png(picture), "path": None} for picture in values]
        return pa.array(files, pa.struct([("bytes", pa.binary()), ("path", pa.string())]))
    kind = pa.from_numpy_dtype(values.dtype)
    if values.ndim == 1:
        return pa.array(values)
    if values.ndim == 2:
        return pa.FixedSizeListArray.from_arrays(pa.array(values.ravel()), values.shape[1])
    for _ in values.shape[1:]:
        kind = pa.list_(kind)
    return pa.array(values.tolist(), kind)


def _statistics(rows: Sequence[Columns]) -> dict[str, dict[str, Any]]:
    """Extremes, mean, deviation, shares and count of each feature: by last axis, of pictures by channel from 0 to 1."""
    found: dict[str, dict[str, Any]] = {}
    for name in rows[0]:
        parts = [columns[name] for columns in rows]
        found[name] = _of_picture(parts) if _is_picture(parts[0]) else _of_numbers(np.concatenate(parts))
    return found


def _of_numbers(values: NDArray[Any]) -> dict[str, Any]:
    flat = values.reshape(-1, values.shape[-1]) if values.ndim > 1 else values[:, None]
    numbers = flat.astype(np.float64)
    shares = np.quantile(numbers, list(_SHARES.values()), axis=0)
    found = {"min": flat.min(axis=0), "max": flat.max(axis=0), "mean": numbers.mean(axis=0), "std": numbers.std(axis=0)}
    found |= dict(zip(_SHARES, shares, strict=True))
    return {kind: v.tolist() for kind, v in found.items()} | {"count": [len(values)]}


def _of_picture(parts: Sequence[NDArray[np.uint8]]) -> dict[str, Any]:
    counts = np.zeros((3, _LEVELS))
    for pictures in parts:
        counts += [np.bincount(pictures[..., c].ravel(), minlength=_LEVELS) for c in range(3)]
    level, total = np.arange(_LEVELS) / (_LEVELS - 1), counts.sum(axis=1)
    mean = counts @ level / total
    deviation = np.sqrt(np.maximum(counts @ level**2 / total - mean**2, 0))
    there, below = counts > 0, np.cumsum(counts, axis=1)
    found = {
        "min": level[there.argmax(axis=1)],
        "max": level[_LEVELS - 1 - there[:, ::-1].argmax(axis=1)],
        "mean": mean,
        "std": deviation,
    }
    for kind, share in _SHARES.items():
        found[kind] = np.array([level[np.searchsorted(row, share * row[-1])] for row in below])
    told = {kind: v[:, None, None].tolist() for kind, v in found.items()}
    return told | {"count": [sum(len(pictures) for pictures in parts)]}


def _tasks(pa: Any, task: str) -> Any:
    """The table of tasks, whose words are the index of a table of pandas."""
    name = "__index_level_0__"
    about = {
        "index_columns": [name],
        "column_indexes": [{"name": None, "field_name": None, "pandas_type": "unicode", "numpy_type": "object",
                            "metadata": {"encoding": "UTF-8"}}],
        "columns": [
            {"name": "task_index", "field_name": "task_index", "pandas_type": "int64", "numpy_type": "int64",
             "metadata": None},
            {"name": None, "field_name": name, "pandas_type": "unicode", "numpy_type": "object", "metadata": None},
        ],
        "creator": {"library": "pyarrow", "version": pa.__version__},
        "pandas_version": "2.0.0",
    }  # fmt: skip
    table = pa.table({"task_index": pa.array([0], pa.int64()), name: pa.array([task])})
    return table.replace_schema_metadata({"pandas": json.dumps(about)})


def _info(rows: list[Columns], env: FleetEnv | SensingEnv, frames: int) -> dict[str, Any]:
    rate = float(env.task.rate_hz)
    features: dict[str, Any] = {}
    for name, values in rows[0].items():
        if _is_picture(values):
            about: dict[str, Any] = {"dtype": "image", "names": ["height", "width", "channels"]}
        else:
            about = {"dtype": _OWN.get(name, str(values.dtype)), "names": None}
        if name == "observation.state" and isinstance(env, FleetEnv):
            about["names"] = list(env.names)
        features[name] = {**about, "shape": list(values.shape[1:]) or [1]}
    return {
        "codebase_version": VERSION,
        "robot_type": _vehicle(env),
        "total_episodes": len(rows),
        "total_frames": frames,
        "total_tasks": 1,
        "chunks_size": FILES,
        "data_files_size_in_mb": FILE_MB,
        "video_files_size_in_mb": FILE_MB,
        "fps": int(rate) if rate == int(rate) else rate,
        "splits": {"train": f"0:{len(rows)}"},
        "data_path": _DATA,
        "video_path": None,
        "features": features,
    }


def _vehicle(env: FleetEnv | SensingEnv) -> str:
    if isinstance(env, FleetEnv):
        return str(getattr(env.task.vehicle, "name", env.task.vehicle))
    return env.sim.model.agents[env.task.agent].vehicle.name


def _put(path: Path, data: Any) -> None:
    path.write_text(json.dumps(data, indent=4) + "\n", encoding="utf-8")


def _arrow() -> tuple[Any, Any]:
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise CommandError("LeRobot's format needs Apache Arrow: pip install 'pelagos[datasets]'") from None
    return pa, pq
