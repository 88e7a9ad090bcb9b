"""Widest range of every number of a scenario, by the unit that its key states; a field's own limits are narrower."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, Final

from pydantic import BaseModel

from pelagos.config.document import Key

Range = tuple[float, float]

# By the key's last word. Beyond them nothing on Earth lies, and float64 still resolves what lies within.
_BY_UNIT: Final[Mapping[str, Range]] = {
    "m": (-1e8, 1e8),  # twice around the Earth
    "mm": (-1e6, 1e6),
    "mps": (-1e4, 1e4),  # beyond the speed of a seismic wave
    "mps2": (-1e6, 1e6),
    "s": (-1e10, 1e10),  # 300 years
    "ms": (-1e13, 1e13),
    "us": (-1e13, 1e13),
    "h": (-3e6, 3e6),
    "hz": (0.0, 1e12),  # radio; light has wavelengths
    "khz": (0.0, 1e9),
    "deg": (-36_000.0, 36_000.0),  # a hundred turns
    "degps": (-1e6, 1e6),
    "rad": (-1e3, 1e3),
    "radps": (-1e5, 1e5),
    "rpm": (-1e6, 1e6),
    "kg": (-1e12, 1e12),
    "pa": (-1e12, 1e12),
    "v": (-1e6, 1e6),
    "w": (-1e12, 1e12),
    "ohm": (-1e9, 1e9),
    "db": (-1e3, 1e3),
    "c": (-273.15, 1e4),
    "k": (0.0, 1e4),
    "t": (-100.0, 100.0),  # the strongest steady magnets have half of it
    "ppm": (-1e6, 1e6),
    "lm": (0.0, 1e9),
    "m2": (-1e14, 1e14),
    "m3": (-1e18, 1e18),  # an ocean
    "px": (-1e6, 1e6),
    "bps": (0.0, 1e12),
}
_BY_NAME: Final[Mapping[str, Range]] = {
    "latitude_deg": (-90.0, 90.0),
    "longitude_deg": (-360.0, 360.0),
    "seed": (0.0, 2.0**63),
    "seeds": (0.0, 2.0**63),
}
_BEFORE: Final = ("n", "kg", "m", "m2", "m3", "s", "rad", "deg", "rpm", "cd", "e", "per", "1")  # units in a product
OTHER: Final[Range] = (-1e15, 1e15)  # a stiffness, a derivative, a count; memory is estimated before it is taken
FREE: Final[Mapping[str, str]] = {
    "parameters": "numbers for a function of the user's own, whose range only that function knows",
}


@cache
def range_of(key: str) -> Range | None:
    """The widest range of a key; None where it is `FREE`."""
    if key in FREE:
        return None
    *before, unit = key.split("_")
    compound = not before or before[-1] in _BEFORE  # kilograms per cubic metre are no volume
    return _BY_NAME.get(key) or (OTHER if compound else _BY_UNIT.get(unit, OTHER))


def beyond(
    built: Any, key: str = "", path: Key = (), seen: set[int] | None = None
) -> Iterator[tuple[Key, float, Range]]:
    """Every number that is not finite, or not within the range of its key, with its path; one model that stands in
    several places is looked at once.
    """
    seen = set() if seen is None else seen
    if isinstance(built, bool | str) or built is None:
        return
    if isinstance(built, int | float):
        within = range_of(key)
        if within is not None and not within[0] <= built <= within[1]:  # NaN is within nothing
            yield path, built, within
    elif isinstance(built, BaseModel):
        if id(built) in seen:
            return
        seen.add(id(built))
        for name, value in built.__dict__.items():
            if value is not None and not isinstance(value, bool | str):
                yield from beyond(value, name, (*path, name), seen)
    elif isinstance(built, Mapping):
        for name, value in built.items():
            inner = key if isinstance(value, int | float | list | tuple) else str(name)
            yield from beyond(value, inner, (*path, name), seen)
    elif isinstance(built, list | tuple):
        for index, value in enumerate(built):
            yield from beyond(value, key, (*path, index), seen)


def outside_text(path: Key, value: float, within: Range) -> str:
    """Complaint about a number."""
    key = next((part for part in reversed(path) if isinstance(part, str)), "it")
    if not math.isfinite(value):
        return f"{key} must be a finite number, not {value}"
    return f"{key} of {value:g} is outside of what is possible: from {within[0]:g} to {within[1]:g}"


def bound(node: Any, key: str = "") -> None:
    """Write the ranges into a JSON schema, where a number has no limit of its own."""
    if isinstance(node, list):
        for child in node:
            bound(child, key)
        return
    if not isinstance(node, dict):
        return
    within = range_of(key)
    if node.get("type") in ("number", "integer") and "const" not in node and "enum" not in node and within:
        whole = node["type"] == "integer"
        low, high = (int(x) if whole else x for x in within)
        if "minimum" not in node and "exclusiveMinimum" not in node:
            node["minimum"] = low
        if "maximum" not in node and "exclusiveMaximum" not in node:
            node["maximum"] = high
    for name, child in node.items():
        if name in ("properties", "$defs"):
            for inner, value in child.items():
                bound(value, inner if name == "properties" else "")
        elif name not in ("default", "examples", "const", "enum", "discriminator", "required"):
            bound(child, key)
