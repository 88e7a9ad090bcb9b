"""Scenarios to fuzz with: an example changed within its schema, one drawn from the schema, one broken anywhere."""

from __future__ import annotations

import copy
import json
import math
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from random import Random
from typing import Any

import yaml
from from_schema import FromSchema, Node, Place

ROOT = Path(__file__).parents[2]
EXAMPLES = [yaml.safe_load(path.read_text()) for path in sorted((ROOT / "examples").glob("*.yaml"))]
SCENARIOS = [data for data in EXAMPLES if isinstance(data.get("agents"), dict)]
SCHEMA = json.loads((ROOT / "schema/scenario.schema.json").read_text())
ODD = [None, True, False, "", "null", "imu", "remus100", "../../x", "module:function", "\x1b[2J", "é\u202e", [], {},
       [[]], {"type": "imu"}, 0, -1, 7, 0.0, 1e300, -1e300, 1e-300, 2**63, -(2**31), math.nan, math.inf]  # fmt: skip


def donors() -> dict[str, list[Any]]:
    """Parts of the examples and of the catalogue by the title of their form: sensors, legs, starts, vehicles, ..."""
    found: dict[str, list[Any]] = defaultdict(list)
    for data in SCENARIOS:
        for place, _, form in FromSchema(SCHEMA, Random(0)).places(data, SCHEMA):
            if form.get("type") == "object" and form.get("properties"):
                found[form["title"]].append(at(data, place))
    for path in sorted((ROOT / "src/pelagos/vehicles/catalogue").glob("*.yaml")):
        vehicle = yaml.safe_load(path.read_text())
        for place, _, form in FromSchema(SCHEMA, Random(0)).places(vehicle, SCHEMA["$defs"]["VehicleConfig"]):
            if form.get("type") == "object" and form.get("properties"):
                found[form["title"]].append(at(vehicle, place))
        found["VehicleConfig"].append(vehicle | {"type": "custom"})
    return found


def at(data: Any, place: Place) -> Any:
    """What stands at a place."""
    for key in place:
        data = data[key]
    return data


def near(draw: Random) -> Any:
    """An example with one to four changes that the schema allows: mostly accepted, or nearly right."""
    data = copy.deepcopy(draw.choice(SCENARIOS)) if draw.random() < 0.5 else plain(draw)
    for _ in range(draw.choice([1, 1, 2, 2, 3, 4])):
        _change(data, draw)
    return data


UP = (
    "mariner", "kvlcc2", "tanker", "container", "supply", "semisub", "frigate", "zeefakkel", "navalvessel", "otter",
    "wamv", "surface_vessel", "quadrotor", "fixed_wing",
)  # fmt: skip
"""At the surface or above."""


def plain(draw: Random) -> Any:
    """A vehicle of the catalogue with some sensors, all by default."""
    agent = SCHEMA["$defs"]["Agent"]["properties"]
    names = next(option["enum"] for option in agent["vehicle"]["anyOf"] if "enum" in option)
    forms = FromSchema(SCHEMA, draw).options(agent["sensors"]["additionalProperties"])
    kinds = [
        form["properties"]["type"]["const"] for form in forms if "const" in form.get("properties", {}).get("type", {})
    ]
    vehicle = draw.choice([name for name in names if name != "custom"])
    afloat = vehicle in UP
    sensors = {kind: {"type": kind} for kind in draw.sample(kinds, draw.randint(1, 4))}
    start = {"position_m": [draw.uniform(-9.0, 9.0), draw.uniform(-9.0, 9.0)]} | ({} if afloat else {"depth_m": 4.0})
    world = draw.choice([{"type": "flat", "depth_m": 30.0}, {"type": "flat", "depth_m": 9.0}, {"type": "harbour"}])
    return {"world": world, "agents": {"auv": {"vehicle": vehicle, "start": start, "sensors": sensors}}}


def _change(data: Any, draw: Random) -> None:
    """One change of one place."""
    maker = FromSchema(SCHEMA, draw)
    found = list(maker.places(data, SCHEMA))
    depth = draw.randint(1, max(len(place) for place, _, _ in found))  # places are many where lists are long
    place, node, form = draw.choice([one for one in found if len(one[0]) >= depth])
    holder, key = at(data, place[:-1]), place[-1]
    value, kind = holder[key], form.get("type")
    if draw.random() < 0.05:
        holder[key] = maker.value(node, 1)
    elif kind == "object" and form.get("properties"):
        _change_mapping(holder, key, form, maker)
    elif kind in ("object", "array") and not form.get("prefixItems") and value:
        _change_many(value, maker)
    elif kind in ("number", "integer"):
        holder[key] = maker.number(form, near=value)
    elif kind == "boolean":
        holder[key] = not value
    else:
        holder[key] = maker.value(node, 1) if "enum" in form or "const" in form or draw.random() < 0.2 else value


def _change_mapping(holder: Any, key: str | int, form: Node, maker: FromSchema) -> None:
    """A key more or less, or another example's part of the same form."""
    draw, value = maker.draw, holder[key]
    absent = sorted(set(form["properties"]) - set(value))
    spare = sorted(set(value) & set(form["properties"]) - set(form.get("required", [])) - {"type"})
    do = draw.random()
    if do < 0.25:
        holder[key] = copy.deepcopy(draw.choice(DONORS.get(form["title"]) or [value]))
    elif do < 0.75 and absent:
        name = draw.choice(absent)
        value[name] = maker.value(form["properties"][name], 1)
    elif spare:
        del value[draw.choice(spare)]


def _change_many(value: Any, maker: FromSchema) -> None:
    """An entry of a list or of named things more, or one less."""
    draw = maker.draw
    keys = list(value) if isinstance(value, dict) else list(range(len(value)))
    which = draw.choice(keys)
    if draw.random() < 0.4:
        del value[which]
    elif isinstance(value, dict):
        value[f"{which}x"] = copy.deepcopy(value[which])
    else:
        value.insert(draw.choice(keys), copy.deepcopy(value[which]))


def allowed(draw: Random) -> Any:
    """What the schema allows: a world, an ocean, and one agent with up to three sensors; half of each left out."""
    value = FromSchema(SCHEMA, draw).value
    top, agent = SCHEMA["properties"], SCHEMA["$defs"]["Agent"]["properties"]
    auv = {"vehicle": "remus100", "start": {"depth_m": 3.0}}
    auv |= {key: value(agent[key], 1) for key in draw.sample(sorted(agent), draw.choice([0, 0, 1, 2]))}
    sensors = agent["sensors"]["additionalProperties"]
    auv["sensors"] = {name: value(sensors, draw.choice([1, 2])) for name in "abc"[: draw.randint(0, 3)]}
    data = {"world": {"type": "flat", "depth_m": 20.0}, "agents": {"auv": auv}}
    more = draw.sample(sorted(set(top) - {"agents", "name"}), draw.choice([0, 0, 1, 2]))
    return data | {key: value(top[key], 1) for key in more}


def broken(draw: Random) -> Any:
    """An example with one to three places replaced by anything, removed, or with a key too many."""
    data = copy.deepcopy(draw.choice(EXAMPLES))
    for _ in range(draw.randint(1, 3)):
        if not (found := places(data)):
            break
        place, kind = draw.choice(found), draw.choice(["set", "set", "del", "add"])
        holder, key = at(data, place[:-1]), place[-1]
        if kind == "del":
            del holder[key]
        elif kind == "add" and isinstance(holder, dict):
            holder[f"{key}x"] = odd(draw)
        else:
            holder[key] = odd(draw)
    return data


def odd(draw: Random, depth: int = 0) -> Any:
    """Any value: a number of any size, a text, something nested, something of the examples."""
    kind = draw.choice(["fixed", "number", "integer", "text", "list", "mapping"][: 6 if depth < 2 else 4])
    if kind == "fixed":
        return copy.deepcopy(draw.choice(ODD))
    if kind == "number":
        return draw.choice([1.0, -1.0]) * 10.0 ** draw.uniform(-30.0, 30.0)
    if kind == "integer":
        return draw.choice([draw.randint(-10, 10), draw.randint(-(2**70), 2**70)])
    if kind == "text":
        return "".join(draw.choice("ab:.-é\n\x00\u2028{[*&'\"0 ") for _ in range(draw.randint(0, 20)))
    items = [odd(draw, depth + 1) for _ in range(draw.randint(0, 4))]
    return items if kind == "list" else {str(odd(draw, 2)): item for item in items}


def places(data: Any, place: Place = ()) -> list[Place]:
    """Every place of a tree of plain values."""
    found = [place] if place else []
    items = data.items() if isinstance(data, Mapping) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        found += places(value, (*place, key))
    return found


DONORS = donors()
