"""`pelagos schema`: the JSON schema of scenario files, with every built-in component."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pelagos.cli.console import show_error
from pelagos.config.limits import bound

VEHICLE = "VehicleConfig"


def schema_text() -> str:
    """The schema as a JSON document that ends with a line break."""
    return json.dumps(schema_data(), indent=2, ensure_ascii=False) + "\n"


def schema_data() -> dict[str, Any]:
    """The schema, in which a vehicle of the catalogue may be changed at any depth."""
    from pelagos.config.scenario import Scenario

    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **Scenario.model_json_schema()}
    definitions = schema["$defs"]
    _hoist(schema, definitions)
    for name in _reachable(definitions, VEHICLE):
        _loosen(definitions[name])
    definitions[VEHICLE]["required"] = ["type"]
    bound(schema)
    return schema | {"$defs": dict(sorted(definitions.items()))}


def _hoist(node: Any, definitions: dict[str, Any]) -> None:
    """Move models that stand where they are used to the definitions, under their names."""
    if isinstance(node, list):
        for child in node:
            _hoist(child, definitions)
    elif isinstance(node, dict):
        for child in list(node.values()):
            _hoist(child, definitions)
        for index, choice in enumerate(node.get("anyOf", [])):
            if "properties" in choice:
                definitions[choice["title"]] = choice
                if "const" in choice["properties"].get("type", {}):
                    choice["required"] = ["type", *(key for key in choice.get("required", []) if key != "type")]
                node["anyOf"][index] = {"$ref": f"#/$defs/{choice['title']}"}


def _reachable(definitions: dict[str, Any], name: str) -> set[str]:
    """Names of the definitions that a definition leads to, itself included."""
    found: set[str] = set()
    ahead = [name]
    while ahead:
        at = ahead.pop()
        if at not in found and at in definitions:
            found.add(at)
            ahead += [ref.rpartition("/")[2] for ref in _references(definitions[at])]
    return found


def _references(node: Any) -> list[str]:
    if isinstance(node, dict):
        own = [node["$ref"]] if isinstance(node.get("$ref"), str) else []
        return own + [ref for child in node.values() for ref in _references(child)]
    return [ref for child in node for ref in _references(child)] if isinstance(node, list) else []


def _loosen(node: Any) -> None:
    """Ask for no key, since the catalogue has it, and for any fitting choice instead of exactly one."""
    if isinstance(node, dict):
        node.pop("required", None)
        node.pop("discriminator", None)
        if "oneOf" in node:
            node["anyOf"] = node.pop("oneOf")
        for child in node.values():
            _loosen(child)
    elif isinstance(node, list):
        for child in node:
            _loosen(child)


def compare_schema(path: Path) -> int:
    """0 where the file holds the present schema, 1 where it does not."""
    if path.exists() and path.read_text(encoding="utf-8") == schema_text():
        return 0
    show_error("error", f"{path} is not the schema of this version; renew it with: pelagos schema --write {path}")
    return 1
