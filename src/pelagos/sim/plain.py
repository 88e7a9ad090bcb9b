"""Trees of plain values on disk: numbers, texts, lists, dictionaries, dataclasses of this package, and arrays.

A file is an NPZ archive of arrays without pickles, and a skeleton in JSON: reading one runs nobody's code.
"""

from __future__ import annotations

import dataclasses
import json
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import numpy as np

from pelagos.errors import RecordingError
from pelagos.files import give_name

_KIND: Final = "__kind__"
_SKELETON: Final = "skeleton"


def write(path: Path, tree: Any) -> None:
    """Write a tree; the file is complete or not there.

    Raises:
        RecordingError: it cannot be written.
    """
    arrays: list[Any] = []
    skeleton = json.dumps(_plain(tree, arrays))
    parts: dict[str, Any] = {f"a{k}": a for k, a in enumerate(arrays)}
    parts[_SKELETON] = np.frombuffer(skeleton.encode(), dtype=np.uint8)
    unfinished = path.with_name(path.name + ".part")
    try:
        with unfinished.open("wb") as file:
            np.savez_compressed(file, **parts)
        give_name(unfinished, path)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise RecordingError(f"{path} cannot be written: {error}") from None


def read(path: Path) -> Any:
    """The tree in a file.

    Raises:
        RecordingError: it cannot be read, or is no such file.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        return _built(json.loads(arrays[_SKELETON].tobytes()), arrays)
    except OSError as error:
        raise RecordingError(f"{path} cannot be read: {error}") from None
    except Exception as error:  # of a file that is something else, or damaged: whatever zip, NumPy and JSON raise
        raise RecordingError(f"{path} is no checkpoint, or damaged: {error}") from None


def _plain(value: Any, arrays: list[Any]) -> Any:
    if value is None or isinstance(value, str | bool | int | float):
        return value
    if isinstance(value, np.ndarray | np.generic):
        arrays.append(value)
        return {_KIND: "array", "name": f"a{len(arrays) - 1}", "scalar": isinstance(value, np.generic)}
    if dataclasses.is_dataclass(value):
        fields = {f.name: _plain(getattr(value, f.name), arrays) for f in dataclasses.fields(value)}
        kind = type(value)
        return {_KIND: "dataclass", "type": f"{kind.__module__}:{kind.__qualname__}", "fields": fields}
    if isinstance(value, tuple | list):
        return {_KIND: type(value).__name__, "items": [_plain(v, arrays) for v in value]}
    if isinstance(value, dict):
        return {_KIND: "dict", "items": [[_plain(k, arrays), _plain(v, arrays)] for k, v in value.items()]}
    raise TypeError(f"{type(value).__name__} is no plain value")


def _built(value: Any, arrays: dict[str, Any]) -> Any:
    if not isinstance(value, dict):
        return value
    kind = value[_KIND]
    if kind == "array":
        found = arrays[value["name"]]
        return found[()] if value["scalar"] else found
    if kind == "dataclass":
        fields = {k: _built(v, arrays) for k, v in value["fields"].items()}
        return _class(value["type"])(**fields)
    items = [_built(v, arrays) if kind != "dict" else [_built(p, arrays) for p in v] for v in value["items"]]
    return {"dict": dict, "list": list, "tuple": tuple}[kind](items)


def _class(name: str) -> Any:
    module, _, qualified = name.partition(":")
    if module.split(".")[0] != "pelagos":
        raise ValueError(f"{name} is not of this package")
    found: Any = import_module(module)
    for part in qualified.split("."):
        found = getattr(found, part)
    if not (isinstance(found, type) and dataclasses.is_dataclass(found)):
        raise ValueError(f"{name} is no dataclass")
    return found
