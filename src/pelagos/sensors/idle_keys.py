"""Keys that a scenario gives and that change nothing, as long as another key is as it is: most likely mistakes."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel


@dataclass(frozen=True)
class Need:
    """Keys that show only where another key has one of some values.

    Attributes:
        keys: those that need it.
        key: the other.
        values: under which they show; none: under all but its default.
    """

    keys: tuple[str, ...]
    key: str
    values: tuple[Any, ...] = ()

    def met(self, config: BaseModel) -> bool:
        """Whether its keys show in a configuration."""
        value = getattr(config, self.key)
        return value in self.values if self.values else value != type(config).model_fields[self.key].default

    def __str__(self) -> str:
        return f"'{self.key}: {' or '.join(map(str, self.values))}'" if self.values else f"'{self.key}'"


def idle(config: BaseModel, needs: Iterable[Need], *, device: Collection[str] = ()) -> str | None:
    """Message about keys that were changed and change nothing, those of a device apart; None without any."""
    for need in needs:
        if not need.met(config) and (keys := changed(config, (k for k in need.keys if k not in device))):
            return f"{named(keys)} changes nothing without {need}"
    return None


def changed(config: BaseModel, keys: Iterable[str]) -> list[str]:
    """Those keys of a configuration that do not have their default."""
    return [k for k in keys if getattr(config, k) != type(config).model_fields[k].default]


def named(keys: Iterable[str]) -> str:
    """Keys as messages name them."""
    return ", ".join(f"'{k}'" for k in keys)
