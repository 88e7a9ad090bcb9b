"""`pelagos schema`: the JSON schema of scenario files, with every built-in component."""

from __future__ import annotations

import json
from pathlib import Path

from pelagos.cli.console import show_error


def schema_text() -> str:
    """The schema as a JSON document that ends with a line break."""
    from pelagos.config.scenario import Scenario

    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **Scenario.model_json_schema()}
    return json.dumps(schema, indent=2, ensure_ascii=False, sort_keys=True) + "\n"


def compare_schema(path: Path) -> int:
    """0 where the file holds the present schema, 1 where it does not."""
    if path.exists() and path.read_text(encoding="utf-8") == schema_text():
        return 0
    show_error("error", f"{path} is not the schema of this version; renew it with: pelagos schema --write {path}")
    return 1
