"""Arrays that are computed when somebody looks at them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numpy.typing import NDArray

_Class = TypeVar("_Class")


class _Promise:
    def __init__(self, compute: Callable[[], NDArray[Any]]) -> None:
        self.compute = compute


class _Promised:
    """An attribute that computes what it was promised, once; everything else it hands out as it is."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __get__(self, instance: Any, owner: type) -> Any:
        found = instance.__dict__[self._name]
        if isinstance(found, _Promise):
            found = instance.__dict__[self._name] = found.compute()
        return found

    def __set__(self, instance: Any, value: Any) -> None:
        instance.__dict__[self._name] = value


def promised(compute: Callable[[], NDArray[Any]]) -> NDArray[Any]:
    """Promise of `compute()`, for a field of a class that `keeps_promises`: it is called when somebody looks."""
    return cast("NDArray[Any]", _Promise(compute))


def keeps_promises(*names: str) -> Callable[[type[_Class]], type[_Class]]:
    """Let fields of a dataclass be `promised` arrays."""

    def change(cls: type[_Class]) -> type[_Class]:
        for name in names:
            setattr(cls, name, _Promised(name))
        return cls

    return change
