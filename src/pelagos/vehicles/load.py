"""The catalogue's files, and how changes are laid over them."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

import yaml

from pelagos.errors import LookupFailed


@cache
def catalogue_names() -> tuple[str, ...]:
    """Every vehicle of the catalogue."""
    folder = files("pelagos.vehicles.catalogue")
    return tuple(sorted(f.name.removesuffix(".yaml") for f in folder.iterdir() if f.name.endswith(".yaml")))


def catalogue_data(name: str) -> dict[str, Any]:
    """The data of one vehicle, as a mapping of its own.

    Raises:
        LookupFailed: the catalogue has no such vehicle; the message names the nearest.
    """
    if name not in catalogue_names():
        raise LookupFailed("vehicle", name, catalogue_names())
    data: dict[str, Any] = pickle.loads(_data(name))
    return data


@cache
def _data(name: str) -> bytes:
    text = (files("pelagos.vehicles.catalogue") / f"{name}.yaml").read_text(encoding="utf-8")
    return pickle.dumps(yaml.load(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader)))


def merged(base: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with `changes`, mapping by mapping; a part of another `type` replaces the whole part."""
    result = dict(base)
    for key, value in changes.items():
        old = result.get(key)
        if (
            isinstance(old, Mapping)
            and isinstance(value, Mapping)
            and value.get("type", old.get("type")) == old.get("type")
        ):
            result[key] = merged(old, value)
        else:
            result[key] = value
    return result
