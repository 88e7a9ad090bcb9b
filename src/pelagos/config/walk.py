"""Follow a path of keys through models and through the data that they check."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import UnionType
from typing import Annotated, Any, Protocol, Union, get_args, get_origin, runtime_checkable

from pydantic import BaseModel

from pelagos.config.component import Component
from pelagos.config.document import Key


def data_path(data: Any, loc: Sequence[str | int], *, missing: bool = False) -> Key:
    """The path of keys in `data` that a validation error's location names: without the tags of unions.

    Args:
        data: what was checked.
        loc: the error's location.
        missing: the last part is a key that `data` lacks.
    """
    path: list[str | int] = []
    for index, part in enumerate(loc):
        if isinstance(data, Mapping):
            if part in data:
                data = data[part]
            elif not (missing and index == len(loc) - 1):
                continue
        elif isinstance(data, list | tuple) and isinstance(part, int):
            data = data[part] if part < len(data) else None
        else:
            continue
        path.append(part)
    return tuple(path)


@runtime_checkable
class Overlay(Protocol):
    """A model of changes to a catalogue's entry."""

    def with_catalogue(self, data: Any) -> Any:
        """Data that the model checks: the changes laid over their entry; other data as they are."""


def value_at(data: Any, path: Key) -> Any:
    """The value at a path; None where there is none."""
    for part in path:
        try:
            data = data[part]
        except (KeyError, IndexError, TypeError):
            return None
    return data


def annotation_at(root: type[BaseModel], data: Any, path: Key) -> Any:
    """Annotation of the value at `path`; None where nothing declares it."""
    return _followed(root, data, path)[0]


def model_at(root: type[BaseModel], data: Any, path: Key) -> type[BaseModel] | None:
    """The model that the mapping at `path` is checked with; None where it is no model."""
    return model_of(*_followed(root, data, path))


def _followed(root: type[BaseModel], data: Any, path: Key) -> tuple[Any, Any]:
    """Annotation and data at `path`; changes to a catalogue's entry are laid over it, see `Overlay`."""
    annotation: Any = root
    for part in path:
        model = model_of(annotation, data)
        data = model.with_catalogue(data) if isinstance(model, Overlay) else data
        annotation = _child(annotation, data, part)
        data = value_at(data, (part,))
    return annotation, data


def model_of(annotation: Any, value: Any) -> type[BaseModel] | None:
    """The model that `value`, a mapping, is checked with under this annotation; None where it is no model."""
    if get_origin(annotation) is Annotated:
        inner, *marks = get_args(annotation)
        for mark in marks:
            if isinstance(mark, Component):
                return mark.model(value)
        return model_of(inner, value)
    if get_origin(annotation) in (Union, UnionType):
        models = [model for choice in get_args(annotation) if (model := model_of(choice, value)) is not None]
        tag = value.get("type") if isinstance(value, Mapping) else None
        tagged = [m for m in models if "type" in m.model_fields and tag in get_args(m.model_fields["type"].annotation)]
        return next(iter(tagged or models), None)
    if get_origin(annotation) in (tuple, list) and isinstance(value, Mapping):  # one stands for a list of one
        return model_of(get_args(annotation)[0], value)
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return None


def fixed_length(annotation: Any) -> int | None:
    """Number of values in a list of this annotation; None where that is not fixed."""
    origin, args = get_origin(annotation), get_args(annotation)
    if origin is tuple and Ellipsis not in args:
        return len(args)
    if origin is Annotated:
        return fixed_length(args[0])
    if origin in (Union, UnionType):
        return next((length for choice in args if (length := fixed_length(choice)) is not None), None)
    return None


def _child(annotation: Any, data: Any, part: str | int) -> Any:
    model = model_of(annotation, data)
    if model is not None:
        field = model.model_fields.get(str(part))
        if field is None:
            return None
        return Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation
    origin, args = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _child(args[0], data, part)
    if origin in (Union, UnionType):
        return next((child for choice in args if (child := _child(choice, data, part)) is not None), None)
    if origin in (dict, Mapping) or (isinstance(origin, type) and issubclass(origin, Mapping)):
        return args[1]
    if origin in (list, tuple) or (isinstance(origin, type) and issubclass(origin, Sequence)):
        fixed = origin is tuple and Ellipsis not in args
        return args[part] if fixed and isinstance(part, int) and part < len(args) else args[0]
    return None
