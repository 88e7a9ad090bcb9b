"""Keys that a scenario gives and that change nothing, as long as another key is as it is: most likely mistakes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any


def changed(config: Any, keys: Iterable[str]) -> list[str]:
    """Those keys of a configuration that do not have their default."""
    return [k for k in keys if getattr(config, k) != type(config).model_fields[k].default]


def named(keys: Iterable[str]) -> str:
    """Keys as messages name them."""
    return ", ".join(f"'{k}'" for k in keys)
