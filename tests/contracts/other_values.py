"""Other values for the keys of a configuration, by its JSON schema: numbers moved, switches turned, choices taken."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def others(schema: Mapping[str, Any], defs: Mapping[str, Any], value: Any) -> Iterator[tuple[str, Any]]:
    """Each number, switch and choice in a key's value with another in its place: `(path below the key, whole value)`.

    A path may come several times, nearest first. A name without choices stays as it is.
    """
    schema = fitting(schema, defs, value)
    if isinstance(value, bool):
        yield "", not value
        yield from ((f"={choice}", choice) for choice in choices(schema, defs))
    elif isinstance(value, (int, float)):
        near = (value + 1, value - 1, 2 * value, value // 2, value + 64, 1)
        for moved in dict.fromkeys(_moved(value) if isinstance(value, float) else near):
            yield "", moved
    elif isinstance(value, str):
        for choice in choices(schema, defs):
            if choice != value:
                yield f"={choice}", choice
        yield from _first(schema, defs, of=("number", "integer", "boolean"))
    elif value is None:
        yield from _first(schema, defs)
    elif isinstance(value, (list, tuple)) and value and all(isinstance(v, str) for v in value):
        yield "", value[:-1]
    elif isinstance(value, (list, tuple)):
        yield from _in_rows(schema, defs, value)
    elif isinstance(value, dict):
        inner, each = schema.get("properties", {}), schema.get("additionalProperties") or {}
        for key, v in value.items():
            if key != "type":
                for path, moved in others(inner.get(key, each), defs, v):
                    yield f".{key}{path}", {**value, key: moved}


def choices(schema: Mapping[str, Any], defs: Mapping[str, Any]) -> list[Any]:
    """Strings that a schema allows."""
    every = [_named(s, defs) for s in (schema, *schema.get("anyOf", ()))]
    return [c for s in every for c in s.get("enum", [s["const"]] if "const" in s else ())]


def fitting(schema: Mapping[str, Any], defs: Mapping[str, Any], value: Any) -> Mapping[str, Any]:
    """The part of a schema that describes a table or a row; the schema itself for others."""
    schema = _named(schema, defs)
    if isinstance(value, dict):
        for option in (schema, *schema.get("anyOf", ()), *schema.get("oneOf", ())):
            found = _named(option, defs)
            if "oneOf" in found and found is not schema:
                found = fitting(found, defs, value)
            if _describes(found, value):
                return found
    if isinstance(value, (list, tuple)):
        for option in schema.get("anyOf", ()):
            if _named(option, defs).get("type") == "array":
                return _named(option, defs)
    return schema


def _named(schema: Mapping[str, Any], defs: Mapping[str, Any]) -> Mapping[str, Any]:
    return defs[schema["$ref"].rsplit("/", 1)[1]] if "$ref" in schema else schema


def _describes(schema: Mapping[str, Any], value: Mapping[str, Any]) -> bool:
    inner = schema.get("properties")
    if inner is None:
        return isinstance(schema.get("additionalProperties"), Mapping)
    kind = inner.get("type", {})
    return set(value) <= set(inner) and kind.get("const", value.get("type")) == value.get("type")


def _moved(value: float) -> tuple[float, ...]:
    """A little up, a little down, hardly, far down, far up, next to nothing."""
    if value == 0:
        return 0.05, -0.05, 3.0, 1000.0
    return 1.17 * value, 0.83 * value, 0.98 * value, 0.02 * value, 50.0 * value, 2e-4 * value


def _first(
    schema: Mapping[str, Any], defs: Mapping[str, Any], of: tuple[str, ...] = ("number", "integer", "boolean", "string")
) -> Iterator[tuple[str, Any]]:
    """Values of a key that has none, or none of these types."""
    for option in schema.get("anyOf", ()):
        s = _named(option, defs)
        if s.get("type") not in of:
            continue
        if s["type"] in ("number", "integer"):
            for guess in (0.5, 3.0, 40.0, 900.0, 2e4, 3e5):
                yield "", guess if s["type"] == "number" else int(max(guess, 1))
        elif s["type"] == "boolean":
            yield "=true", True
            yield "=false", False
        else:
            yield from ((f"={choice}", choice) for choice in choices(s, defs))


def _in_rows(schema: Mapping[str, Any], defs: Mapping[str, Any], value: Any) -> Iterator[tuple[str, Any]]:
    fixed, each = schema.get("prefixItems", ()), schema.get("items") or {}
    rises = len(value) > 2 and all(isinstance(v, (int, float)) for v in value) and sorted(value) == list(value)
    for k, v in enumerate(value):
        tried = list(others(fixed[k] if k < len(fixed) else each, defs, v))
        if rises and isinstance(v, float):
            tried.append(("", v + 0.01 * abs(v)))  # a table's axis, which must go on rising
        for path, moved in tried:
            yield f".{k}{path}", [*value[:k], moved, *value[k + 1 :]]
