"""Values that a JSON schema allows, near its limits or near the defaults; for what scenarios' schema uses.

Drawn from a `random.Random`, so that a number is a case: Hypothesis alone takes as long for it as the check.
`hypothesis-jsonschema` raises AttributeError with the Hypothesis of today (6.170), and took minutes for this schema.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from random import Random
from typing import Any, TypeAlias

Place: TypeAlias = tuple[str | int, ...]
Node: TypeAlias = Mapping[str, Any]

MOST_ITEMS = 3
SPREAD = 4.0
"""A number is drawn within this factor of its default, mostly."""
EXTREME = 0.03
"""Share of numbers that are drawn at or between the limits, wherever they are."""
WORDS = ["a", "auv", "imu", "dvl", "cube", "sand", "rock", "depth_heading", "remus100", "no_such.npz"]
"""Names of vehicles, sensors, props and files."""


class FromSchema:
    """Draws values of a schema's definitions."""

    def __init__(self, schema: Node, draw: Random) -> None:
        self.definitions, self.draw = schema["$defs"], draw

    def options(self, node: Node) -> list[Node]:
        """The forms that a value may have: references followed, alternatives laid out."""
        if "$ref" in node:
            return self.options(self.definitions[node["$ref"].split("/")[-1]])
        for key in ("anyOf", "oneOf"):
            if key in node:
                return [found for option in node[key] for found in self.options(option)]
        return [node]

    def form(self, node: Node, value: Any) -> Node | None:
        """The form among a node's that a value has; None where it has none of them."""
        return next((option for option in self.options(node) if _has_form(option, value)), None)

    def places(self, value: Any, node: Node, place: Place = ()) -> Iterator[tuple[Place, Node, Node]]:
        """Every place of a tree with what the schema says of it: place, node, the form that its value has."""
        form = self.form(node, value)
        if form is None:
            return
        if place:
            yield place, node, form
        if isinstance(value, dict):
            known, others = form.get("properties", {}), form.get("additionalProperties")
            for key, item in value.items():
                if (inner := known.get(key, others)) and isinstance(inner, Mapping):
                    yield from self.places(item, inner, (*place, key))
        elif isinstance(value, list):
            fixed = form.get("prefixItems", [])
            for index, item in enumerate(value):
                yield from self.places(item, fixed[index] if fixed else form.get("items", {}), (*place, index))

    def value(self, node: Node, depth: int = 0) -> Any:
        """One value that the node allows."""
        options = self.options(node)
        if len(options) > 1:
            some = [option for option in options if option.get("type") != "null"]
            options = some if self.draw.random() < 0.8 else options
        form = self.draw.choice(options)
        if "const" in form:
            return form["const"]
        if "enum" in form:
            return self.draw.choice(form["enum"])
        return {
            "object": self.mapping, "array": self.items, "number": self.number, "integer": self.number,
            "boolean": lambda *_: self.draw.random() < 0.5, "null": lambda *_: None, "string": self.text,
        }[form.get("type", "null")](form, depth)  # fmt: skip

    def mapping(self, node: Node, depth: int) -> dict[str, Any]:
        """The required keys, `type`, and up to three keys more, fewer deep inside."""
        known, required = node.get("properties", {}), set(node.get("required", []))
        required |= {"type"} & set(known)
        others = sorted(set(known) - required)
        more = self.draw.sample(others, min(self.draw.randint(0, max(3 - depth, 0)), len(others)))
        found = {key: self.value(known[key], depth + 1) for key in sorted(required) + more}
        open_ended = node.get("additionalProperties")
        if not known and isinstance(open_ended, Mapping) and open_ended:
            for _ in range(self.draw.randint(node.get("minProperties", 0), 2)):
                found[self.draw.choice(["a", "b", "mud", "sand"])] = self.value(open_ended, depth + 1)
        return found

    def items(self, node: Node, depth: int) -> list[Any]:
        """An array of few items."""
        if "prefixItems" in node:
            return [self.value(item, depth + 1) for item in node["prefixItems"]]
        least = node.get("minItems", 0)
        count = self.draw.randint(least, min(node.get("maxItems", MOST_ITEMS), max(least, MOST_ITEMS)))
        return [self.value(node.get("items", {}), depth + 1) for _ in range(count)]

    def number(self, node: Node, _depth: int = 0, near: float | None = None) -> float:
        """Near a value or the default; or anywhere between the limits, the limits among them."""
        least, most = limits(node)
        default = node.get("default") if near is None else near
        if node["type"] == "integer":
            wide = self.draw.random() < EXTREME
            reach = 8 if default is None else max(int(SPREAD * abs(default)), 8)
            return self.draw.randint(math.ceil(least), math.floor(most if wide else min(most, max(least, 0) + reach)))
        if self.draw.random() < EXTREME:
            return self.draw.choice([least, most, self.draw.uniform(least, most), _wide(self.draw, least, most)])
        middle = abs(default) if isinstance(default, (int, float)) and default else 1.0
        low, high = max(least, -SPREAD * middle), min(most, SPREAD * middle)
        if (
            default is not None and default > 0 and self.draw.random() < 0.7
        ):  # most that is positive is never meant else
            low = max(low, 0.0)
        return self.draw.uniform(low, high) if low < high else least

    def text(self, node: Node, _depth: int) -> str:
        """A short word; the default among them."""
        words = [*WORDS, node["default"]] if isinstance(node.get("default"), str) else WORDS
        return self.draw.choice([word for word in words if len(word) >= node.get("minLength", 0)])


def limits(node: Node) -> tuple[float, float]:
    """The least and the greatest number that the node allows."""
    least, most = float(node.get("minimum", -1e9)), float(node.get("maximum", 1e9))
    if "exclusiveMinimum" in node:
        least = max(least, math.nextafter(float(node["exclusiveMinimum"]), math.inf))
    if "exclusiveMaximum" in node:
        most = min(most, math.nextafter(float(node["exclusiveMaximum"]), -math.inf))
    if node["type"] == "integer":
        least += "exclusiveMinimum" in node
        most -= "exclusiveMaximum" in node
    return least, most


def _wide(draw: Random, least: float, most: float) -> float:
    """A number of any size between limits: its logarithm is drawn."""
    size = 10.0 ** draw.uniform(-9.0, 15.0) * draw.choice([1.0, -1.0])
    return min(max(size, least), most)


def _has_form(form: Node, value: Any) -> bool:
    """Whether a value is of a form, as far as its kind and its `type` tell."""
    if "const" in form:
        return bool(value == form["const"])
    if "enum" in form:
        return value in form["enum"]
    kind = form.get("type")
    if isinstance(value, dict):
        of_type = form.get("properties", {}).get("type", {})
        named = "type" not in value or "const" not in of_type or value["type"] == of_type["const"]
        return kind == "object" and named
    if isinstance(value, list):
        return kind == "array" and len(value) == len(form.get("prefixItems", value))
    if isinstance(value, bool) or value is None:
        return kind == ("boolean" if value is not None else "null")
    if isinstance(value, (int, float)):
        return kind == "number" or (kind == "integer" and isinstance(value, int))
    return kind == "string"
