"""The numbers of a compiled model that depend on parameters, found by comparing models, and set to arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

Place = tuple[str | int, ...]
"""Names of fields, keys and indices from the model down to a number."""


def numbers_of(node: Any, at: Place = ()) -> Iterator[tuple[Place, float]]:
    """Every number of a model, with its place."""
    if isinstance(node, bool) or node is None or isinstance(node, str):
        return
    if isinstance(node, (int, float, np.floating)):
        yield at, float(node)
    elif is_dataclass(node) and not isinstance(node, type):
        for f in fields(node):
            yield from numbers_of(getattr(node, f.name), (*at, f.name))
    elif isinstance(node, BaseModel):  # terms that keep their coefficients as they were configured
        for name in type(node).model_fields:
            yield from numbers_of(getattr(node, name), (*at, name))
    elif isinstance(node, Mapping):
        for key, value in node.items():
            yield from numbers_of(value, (*at, key))
    elif isinstance(node, (list, tuple)):
        for k, value in enumerate(node):
            yield from numbers_of(value, (*at, k))
    elif isinstance(node, np.ndarray) and node.dtype.kind == "f":
        for k, value in enumerate(node.ravel()):
            yield (*at, f"[{k}]"), float(value)


def with_numbers(node: Any, values: Mapping[Place, Any]) -> Any:
    """`node` with other numbers, which may be arrays, at these places."""
    if () in values:
        return values[()]
    below: dict[str | int, dict[Place, Any]] = {}
    for place, value in values.items():
        below.setdefault(place[0], {})[place[1:]] = value
    if is_dataclass(node) and not isinstance(node, type):
        return replace(node, **{str(name): with_numbers(getattr(node, str(name)), v) for name, v in below.items()})
    if isinstance(node, BaseModel):
        return node.model_copy(
            update={str(name): with_numbers(getattr(node, str(name)), v) for name, v in below.items()}
        )
    if isinstance(node, Mapping):
        return {key: with_numbers(value, below[key]) if key in below else value for key, value in node.items()}
    changed = [with_numbers(value, below[k]) if k in below else value for k, value in enumerate(node)]
    return tuple(changed) if isinstance(node, tuple) else changed


def values_at(model: Any, places: Sequence[Place]) -> NDArray[np.float64]:
    """The numbers of a model at these places `(c,)`."""
    found = dict(numbers_of(model))
    return np.array([found[place] for place in places])
