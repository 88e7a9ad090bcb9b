"""Values that a JSON schema allows, near its limits or near the defaults; for what scenarios' schema uses.

`hypothesis-jsonschema` raises AttributeError with the Hypothesis of today (6.170), and took minutes for this schema.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from hypothesis import strategies as st

MOST_ITEMS = 3
SPREAD = 4.0
"""A number is drawn within this factor of its default, half of the time."""


class FromSchema:
    """Draws values of a schema's definitions."""

    def __init__(self, schema: Mapping[str, Any], draw: st.DrawFn) -> None:
        self.definitions, self.draw = schema["$defs"], draw

    def value(self, node: Mapping[str, Any], depth: int = 0) -> Any:
        """One value that the node allows."""
        if "$ref" in node:
            return self.value(self.definitions[node["$ref"].split("/")[-1]], depth)
        for key in ("anyOf", "oneOf"):
            if key in node:
                return self.value(self.draw(st.sampled_from(node[key])), depth)
        if "const" in node:
            return node["const"]
        if "enum" in node:
            return self.draw(st.sampled_from(node["enum"]))
        return {
            "object": self.mapping, "array": self.items, "number": self.number, "integer": self.number,
            "boolean": lambda *_: self.draw(st.booleans()), "null": lambda *_: None, "string": self.text,
        }[node.get("type", "null")](node, depth)  # fmt: skip

    def mapping(self, node: Mapping[str, Any], depth: int) -> dict[str, Any]:
        """What it requires, its `type`, and up to three keys more, fewer deep inside."""
        known, required = node.get("properties", {}), set(node.get("required", []))
        required |= {"type"} & set(known)
        others = sorted(set(known) - required)
        most = max(3 - depth, 0)
        more = self.draw(st.lists(st.sampled_from(others), max_size=most, unique=True)) if others and most else []
        found = {key: self.value(known[key], depth + 1) for key in sorted(required) + more}
        open_ended = node.get("additionalProperties")
        if not known and isinstance(open_ended, Mapping) and open_ended:
            for _ in range(self.draw(st.integers(node.get("minProperties", 0), 2))):
                found[self.draw(st.sampled_from(["a", "b", "mud", "sand"]))] = self.value(open_ended, depth + 1)
        return found

    def items(self, node: Mapping[str, Any], depth: int) -> list[Any]:
        """An array of few items."""
        if "prefixItems" in node:
            return [self.value(item, depth + 1) for item in node["prefixItems"]]
        least = node.get("minItems", 0)
        count = self.draw(st.integers(least, min(node.get("maxItems", MOST_ITEMS), max(least, MOST_ITEMS))))
        return [self.value(node.get("items", {}), depth + 1) for _ in range(count)]

    def number(self, node: Mapping[str, Any], _depth: int) -> float:
        """Near the default, or anywhere between the limits, the limits among them."""
        least, most = self.limits(node)
        default = node.get("default")
        if node["type"] == "integer":
            near = 8 if default is None else max(int(SPREAD * abs(default)), 8)
            wide = self.draw(st.integers(0, 7)) == 0
            return self.draw(st.integers(math.ceil(least), math.floor(most if wide else min(most, least + near))))
        if self.draw(st.integers(0, 7)) == 0:
            return self.draw(st.sampled_from([least, most]) | st.floats(least, most, allow_subnormal=False))
        middle = abs(default) if isinstance(default, (int, float)) and default else 1.0
        low, high = max(least, -SPREAD * middle), min(most, SPREAD * middle)
        return self.draw(st.floats(low, high, allow_subnormal=False)) if low < high else least

    @staticmethod
    def limits(node: Mapping[str, Any]) -> tuple[float, float]:
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

    def text(self, node: Mapping[str, Any], _depth: int) -> str:
        """A short word: names of vehicles, sensors, props and files among them."""
        words = ["a", "auv", "imu", "dvl", "cube", "sand", "rock", "depth_heading", "remus100", "no_such.npz"]
        if "default" in node and isinstance(node["default"], str):
            words.append(node["default"])
        return self.draw(st.sampled_from([word for word in words if len(word) >= node.get("minLength", 0)]))
