"""Problems of a scenario, in words: the place, the value given, the values allowed, the nearest match."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Mapping
from typing import Any, Final, get_args

from pydantic import BaseModel, ValidationError

from pelagos.config.document import Document, Key
from pelagos.config.unit import in_unit_of, symbol_of, unit_of
from pelagos.config.walk import annotation_at, data_path, fixed_length, model_at, model_of, value_at
from pelagos.errors import ScenarioError, did_you_mean

_LIMITS: Final = {
    "greater_than": ("greater than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
}
_LEAST: Final = 1e-60
_TOLD: Final = 40  # problems of one error
_SHAPES: Final = (
    "literal_error", "float_type", "int_type", "string_type", "model_type", "model_attributes_type", "dict_type",
)  # fmt: skip
_NUMBERS: Final = ("float_type", "float_parsing", "int_type", "int_parsing", "int_from_float", "finite_number")


def scenario_error(error: ValidationError, document: Document, root: type[BaseModel]) -> ScenarioError:
    """Everything that a validation found, as one error."""
    found: dict[Key, list[str]] = {}
    lines = [line for line in error.errors(include_url=False) if not _follows_from_another(line)]
    paths = [data_path(document.data, line["loc"], missing=line["type"] == "missing") for line in lines]
    for line, path in zip(lines, paths, strict=True):
        if line["type"] in _SHAPES and any(len(p) > len(path) and p[: len(path)] == path for p in paths):
            continue  # another form of a value whose own form has its faults named further in
        if line["type"] == "literal_error" and isinstance(line["input"], Mapping) and paths.count(path) > 1:
            continue  # a mapping was given: its own fault is told, not that it is none of the words
        if line["type"] == "missing" and isinstance(path[-1], int):  # of a list of fixed length
            found[path[:-1]] = [_too_few(path[:-1], document, root)]
            continue
        texts = found.setdefault(path, [])
        if (text := _text(line, path, document, root)) not in texts:
            texts.append(text)
    return as_error([(document.where(path), "; or: ".join(texts)) for path, texts in found.items()])


def as_error(problems: list[tuple[str, str]]) -> ScenarioError:
    """One error for problems, each with its place."""
    where, text = problems[0]
    if len(problems) == 1:
        return ScenarioError(text, where=where)
    lines = "".join(f"\n  {place}: {words}" for place, words in problems[:_TOLD])
    rest = "" if len(problems) <= _TOLD else f"\n  and {len(problems) - _TOLD} more"
    return ScenarioError(f"{len(problems)} things are wrong:{lines}{rest}")


def vanishing(data: Any, path: Key = ()) -> Iterator[tuple[Key, str]]:
    """Places of numbers that are not 0 but no measurement either: what divides by them is infinite."""
    if isinstance(data, Mapping):
        for key, value in data.items():
            yield from vanishing(value, (*path, key))
    elif isinstance(data, list | tuple):
        for index, value in enumerate(data):
            yield from vanishing(value, (*path, index))
    elif isinstance(data, float) and abs(data) < _LEAST and any(struct.pack("d", abs(data))):  # to Dr.Jit 5e-324 == 0
        yield path, f"{data!r} is too small to be meant; at least {_LEAST:g}, or 0"


def coerced(data: Any, built: Any, path: Key = ()) -> Iterator[tuple[Key, str]]:
    """Places where text or true/false was quietly taken for a number, or a number for true/false."""
    if isinstance(built, BaseModel) and isinstance(data, Mapping):
        for key, value in data.items():
            if isinstance(key, str) and key in type(built).model_fields:
                yield from coerced(value, getattr(built, key), (*path, key))
    elif isinstance(built, Mapping) and isinstance(data, Mapping):
        for key, value in data.items():
            if key in built:
                yield from coerced(value, built[key], (*path, key))
    elif isinstance(built, list | tuple) and isinstance(data, list | tuple):
        for index, (value, item) in enumerate(zip(data, built, strict=False)):
            yield from coerced(value, item, (*path, index))
    elif isinstance(built, bool):
        if not isinstance(data, bool):
            yield path, f"expected true or false, not {_shown(data)}"
    elif isinstance(built, int | float) and isinstance(data, str | bool):
        yield path, _number_text(_name(path), data)
    elif isinstance(built, float) and not math.isfinite(built):
        yield path, f"expected a finite number{symbol_of(_name(path))}, not {built}"


def _follows_from_another(line: Mapping[str, Any]) -> bool:
    """A list that counts as too short because its items are wrong."""
    return bool(line["type"] == "too_short" and len(line["input"]) >= line["ctx"]["min_length"])


def _shown(value: Any) -> str:
    """A value as a scenario file has it."""
    if value is None:
        return "nothing"
    return str(value).lower() if isinstance(value, bool) else repr(value)


def _text(line: Mapping[str, Any], path: Key, document: Document, root: type[BaseModel]) -> str:
    kind, given, context = line["type"], line["input"], line.get("ctx", {})
    name = _name(path)
    if kind == "extra_forbidden":
        return _unknown_key(path, document, root)
    if kind == "missing":
        return f"required key {name!r} is missing{symbol_of(name)}"
    if kind in _NUMBERS:
        return _number_text(name, given, whole=kind.startswith("int"))
    if kind in _LIMITS:
        words, key = _LIMITS[kind]
        swapped = "; are latitude and longitude swapped?" if name.startswith("latitude") else ""
        return f"must be {words} {context[key]:g}{symbol_of(name)}, not {_shown(given)}{swapped}"
    if kind == "literal_error":
        return _choice(given, annotation_at(root, document.data, path), str(context["expected"]))
    if kind in ("bool_type", "bool_parsing"):
        return f"expected true or false, not {_shown(given)}"
    if kind in ("string_type",):
        return f"expected text, not {_shown(given)}; write it in quotes if it is meant as text"
    if kind in ("model_type", "model_attributes_type", "dict_type", "mapping_type"):
        return f"expected a mapping of keys{_keys(annotation_at(root, document.data, path))}, not {_shown(given)}"
    if kind in ("tuple_type", "list_type"):
        return f"expected a list{symbol_of(name)}, not {_shown(given)}"
    if kind in ("too_short", "too_long"):
        return _length(context, given, name)
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return _tag(context, given)
    return f"{line['msg'][:1].lower()}{line['msg'][1:]}".removeprefix("value error, ")


def _too_few(path: Key, document: Document, root: type[BaseModel]) -> str:
    given = value_at(document.data, path)
    wanted = fixed_length(annotation_at(root, document.data, path))
    return f"expected {wanted or 'more'} values{symbol_of(_name(path))}, not {len(given)}: {_shown(given)}"


def _unknown_key(path: Key, document: Document, root: type[BaseModel]) -> str:
    model = model_at(root, document.data, path[:-1])
    known = list(model.model_fields) if model else []
    return f"unknown key {_name(path)!r}{did_you_mean(_name(path), known)}; known: {', '.join(known)}"


def _number_text(name: str, given: Any, *, whole: bool = False) -> str:
    kind = "a whole number" if whole else "a number"
    unit = unit_of(name)
    text = f"expected {kind}{f' of {unit}' if unit else ''}, not {_shown(given)}"
    if isinstance(given, float) and not whole:
        return f"expected a finite number{symbol_of(name)}, not {_shown(given)}"
    if isinstance(given, str):
        converted = in_unit_of(name, given)
        if converted is not None:
            return f"{text}; write {converted:g}"
        if _is_number(given):
            return f"{text}; write it without quotes"
        if unit:
            return f"{text}; the unit is in the key's name, write the number alone"
    return text


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _choice(given: Any, annotation: Any, expected: str) -> str:
    known = [str(choice) for choice in _literals(annotation)]
    hint = did_you_mean(given, known) if isinstance(given, str) else ""
    return f"{_shown(given)} is not allowed{hint}; allowed: {', '.join(known) if known else expected}"


def _literals(annotation: Any) -> list[Any]:
    args = get_args(annotation)
    if args and not any(get_args(arg) or isinstance(arg, type) for arg in args):
        return [arg for arg in args if isinstance(arg, str | int | float | bool)]
    return [literal for arg in args for literal in _literals(arg)]


def _keys(annotation: Any) -> str:
    model = model_of(annotation, {})
    return f" ({', '.join(model.model_fields)})" if model else ""


def _length(context: Mapping[str, Any], given: Any, name: str) -> str:
    at_least, at_most = context.get("min_length"), context.get("max_length")
    count = len(given) if hasattr(given, "__len__") else "another number of"
    wanted = f"at least {at_least}" if at_most is None else f"at most {at_most}"
    plural = "" if (at_most or at_least) == 1 else "s"
    return f"expected {wanted} value{plural}{symbol_of(name)}, not {count}: {_shown(given)}"


def _tag(context: Mapping[str, Any], given: Any) -> str:
    expected = str(context.get("expected_tags", "")).replace("'", "").split(", ")
    tag = context.get("tag")
    if tag is None:
        return (
            f"required key 'type' is missing; known: {', '.join(expected)}"
            if expected != [""]
            else "required key 'type' is missing"
        )
    return f"unknown type {tag!r}{did_you_mean(str(tag), expected)}; known: {', '.join(expected)}"


def _name(path: Key) -> str:
    names = [part for part in path if isinstance(part, str)]
    return names[-1] if names else ""
