"""Write docs/scenario.md, the reference of scenario files, from the models' own descriptions."""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path
from typing import Any

from pelagos.cli.schema import VEHICLE, schema_data
from pelagos.config import registry

PAGE = Path(__file__).parents[1] / "docs" / "scenario.md"
HEAD = """\
# Scenario files

A scenario is one YAML (or JSON) file: a world, an ocean, and agents with their missions and sensors. This page is made
from the program's own descriptions by `make docs`; `pelagos schema` prints the same as JSON schema for editors.

* The unit of a value is the ending of its key: `_m` metres, `_s` seconds, `_hz` hertz, `_mps` metres per second,
  `_deg` degrees. A value is the number alone.
* World coordinates: x north, y **west**, z up, from the world's origin at the mean sea surface. Headings are of the
  compass: 0 north, 90 east.
* An unknown key is an error, with file, line and the nearest known key; so is a key that is written twice.
* Limits from 1e8 on, which only keep numbers finite, are left out of the tables; the schema has them.
* A path is looked for from the folder of the scenario file.
* `--set key.path=value` changes a value from the command line: `--set agents.auv0.sensors.imaging.range_max_m=40`;
  items of lists are named by their number from 0.

A small but whole scenario:

```yaml
name: first dive
duration_s: 120
world: {type: flat, depth_m: 20}
agents:
  auv0:
    vehicle: remus100
    start: {position_m: [0, 0], heading_deg: 90}
    mission:
      - {type: dive, depth_m: 5}
      - {type: waypoints, points: [[0, -80]], depth_m: 5}
      - {type: surface}
    sensors:
      imu: {type: imu, rate_hz: 100}
      depth: {type: depth, rate_hz: 10}
```
"""

ANCHORS = {
    VEHICLE: "vehicles", "OceanConfig": "the-ocean", "Agent": "agents", "Record": "recording", "GpsFix": "gps_fix",
}  # fmt: skip
TYPES: dict[str, str] = {}  # what scenarios write for a mapping that has a `type`, by its name in the schema
SPELLED = {
    "Ekf": "EKF", "Mmg": "MMG", "Tma": "TMA", "Jonswap": "JONSWAP", "Ochi hubble": "Ochi-Hubble",
    "Pierson moskowitz": "Pierson-Moskowitz",
}  # fmt: skip
GUARD = 1e8  # limits from here on are of arithmetic
LEGS = [
    "Dive", "Waypoints", "Lawnmower", "Surface", "GpsFix", "Hold", "Goto", "StationKeeping", "Orbit", "Survey",
    "Follow", "Profile", "Drift", "Dock", "Land", "Repeat",
]  # fmt: skip


def page() -> str:
    schema = schema_data()
    definitions = schema["$defs"]
    for name, model in definitions.items():
        if "const" in (named := model.get("properties", {}).get("type", {})):
            TYPES[name] = named["const"]
    for table in ("sensor", "world", "bridge"):
        for name, entry in registry.entries(table, plugins=False).items():  # type: ignore[arg-type]
            ANCHORS[entry.config.__name__] = name
    inner = titles(definitions)
    ANCHORS.update({name: slug(title) for name, title in inner.items()})
    parts = [HEAD, section(2, "The scenario", schema)]
    parts += [section(2, "Origin", definitions["Origin"]), section(2, "Agents", definitions["Agent"])]
    parts += [section(3, "start", definitions["Start"]), "### mission\n\nA list of legs, run one after the other.\n"]
    parts += [section(4, definitions[leg]["properties"]["type"]["const"], definitions[leg]) for leg in LEGS]
    parts.append("## Sensors\n\nEvery sensor also has `rate_hz`, `position_m` and `orientation_deg`.\n")
    for kind, title in (("sensor", ""), ("world", "## Worlds\n"), ("bridge", "## Bridges\n")):
        parts.append(title)
        for name, entry in registry.entries(kind, plugins=False).items():  # type: ignore[arg-type]
            model = definitions[entry.config.__name__]
            parts.append(section(3, name, model, title=entry.title, leave_out={"type"}))
    parts += [section(2, "The ocean", definitions["OceanConfig"]), section(2, "Vehicles", definitions[VEHICLE])]
    parts.append(section(2, "Recording", definitions["Record"]))
    parts.append("## Parts\n\nMappings that stand inside those above.\n")
    parts += [
        section(3, inner[name], definitions[name]) for name in sorted(inner, key=lambda name: inner[name].lower())
    ]
    return "\n".join(part for part in parts if part).rstrip() + "\n"


def titles(definitions: dict[str, Any]) -> dict[str, str]:
    """Headings of the mappings inside others, by name in the schema: words, and each another than all before."""
    taken = {*ANCHORS.values(), "the-scenario", "scenario-files", "sensors", "worlds", "bridges", "parts", "mission"}
    taken |= {definitions[leg]["properties"]["type"]["const"] for leg in LEGS}
    found = {}
    for name in definitions:
        if name in {*LEGS, *ANCHORS, "Origin", "Start"}:
            continue
        words = re.findall(r"[A-Z][0-9]+|[A-Z][a-z]*", name.removesuffix("Config"))
        title = " ".join([words[0], *(word.lower() for word in words[1:])])
        for word, written in SPELLED.items():
            title = title.replace(word, written)
        found[name] = f"{title} (part)" if slug(title) in taken else title
        taken.add(slug(found[name]))
    return found


def slug(title: str) -> str:
    """The anchor that the site makes of a heading."""
    return re.sub(r"[^a-z0-9_ -]", "", title.lower()).replace(" ", "-")


def section(level: int, name: str, model: dict[str, Any], *, title: str = "", leave_out: set[str] | None = None) -> str:
    """A heading, a description, and a table of keys."""
    lines = [f"{'#' * level} {name}", ""]
    text = title or model.get("description", "")
    if text:
        lines += [text[0].upper() + text[1:].rstrip(".") + ".", ""]
    required = set(model.get("required", []))
    rows = [(key, value) for key, value in model.get("properties", {}).items() if key not in (leave_out or set())]
    if rows:
        lines += ["| key | value | default | meaning |", "|---|---|---|---|"]
    for key, value in rows:
        default = "**required**" if key in required else shown_default(value.get("default"))
        words = " ".join(str(value.get("description", "")).split())
        lines.append(f"| `{key}` | {cell(kind(value))} | {cell(default)} | {cell(words)} |")
    return "\n".join(lines) + "\n"


def kind(value: dict[str, Any]) -> str:
    """What a value may be, in a few words."""
    if "$ref" in value:
        name = value["$ref"].rpartition("/")[2]
        anchor = ANCHORS.get(name, name.lower())
        return f"[{TYPES.get(name, anchor.replace('-', ' '))}](#{anchor})"
    if "const" in value:
        return f"`{value['const']}`"
    if "enum" in value:
        return ", ".join(f"`{choice}`" for choice in value["enum"])
    for key in ("anyOf", "oneOf"):
        if key in value:
            choices = [kind(choice) for choice in value[key] if choice.get("type") != "null"]
            if len(choices) < 5:
                return " or ".join(dict.fromkeys(choices))
            pages = {f"(#{anchor})" for anchor in ANCHORS.values()}
            named = [] if any(choice[choice.find("](") + 1 :] in pages for choice in choices) else choices
            return f"a mapping with `type`{': ' if named else ''}{', '.join(named)}"
    if value.get("type") == "array":
        return array(value)
    if value.get("type") == "object":
        inner = value.get("additionalProperties")
        return f"name: {kind(inner)}" if isinstance(inner, dict) else "mapping"
    words = {"number": "number", "integer": "whole number", "string": "text", "boolean": "true or false"}
    return words.get(str(value.get("type")), "value") + limits(value)


def array(value: dict[str, Any]) -> str:
    if "prefixItems" in value:
        return f"list of {len(value['prefixItems'])}: {kind(value['prefixItems'][0])}"
    return f"list: {kind(value['items'])}" if "items" in value else "list"


def limits(value: dict[str, Any]) -> str:
    signs = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}
    found = [f"{sign} {value[key]:g}" for key, sign in signs.items() if key in value and abs(value[key]) < GUARD]
    return f" {', '.join(found)}" if found else ""


def shown_default(value: Any) -> str:
    if value is None or isinstance(value, dict):
        return ""
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return f"[{', '.join(shown_default(item) for item in value)}]"
    return f"{str(value).lower() if isinstance(value, bool) else value}"


def cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="compare only; exit code 1 if the page is out of date")
    parser.add_argument("page", nargs="?", type=Path, default=PAGE)
    given = parser.parse_args()
    if not given.check:
        given.page.write_text(page(), encoding="utf-8")
        return 0
    if given.page.exists() and given.page.read_text(encoding="utf-8") == page():
        return 0
    print(f"{given.page} is out of date; renew it with: make docs", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
