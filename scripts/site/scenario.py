"""Reference of scenario files, one page a component, from the models' own descriptions."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))

import reference

from pelagos.cli.schema import VEHICLE, schema_data
from pelagos.config import registry


@cache
def pages() -> dict[str, tuple[str, str, str]]:
    """By file name: group, title and text of every page but the index."""
    schema = schema_data()
    definitions = schema["$defs"]
    reference.page()  # fills the table of anchors
    found: dict[str, tuple[str, str, str]] = {}
    for kind, group in (("sensor", "Sensors"), ("world", "Worlds")):
        for name, entry in registry.entries(kind, plugins=False).items():  # type: ignore[arg-type]
            model = definitions[entry.config.__name__]
            text = reference.section(1, name, model, title=entry.title, leave_out={"type"})
            found[name.lower()] = (group, name, text + _parts(model, definitions))
    for name, model, title in (
        ("agents", "Agent", "Agents"),
        ("the-ocean", "OceanConfig", "The ocean"),
        ("vehicles", VEHICLE, "Vehicles"),
        ("recording", "Record", "Recording"),
        ("origin", "Origin", "Origin"),
    ):
        text = reference.section(1, title, definitions[model]) + _parts(definitions[model], definitions)
        found[name] = ("The scenario", title, text)
    legs = [
        reference.section(2, definitions[leg]["properties"]["type"]["const"], definitions[leg])
        for leg in reference.LEGS
    ]
    found["mission"] = (
        "The scenario",
        "Missions",
        "# Missions\n\nA list of legs, run one after the other.\n\n" + "\n".join(legs),
    )
    return found


def _parts(model: dict[str, Any], definitions: dict[str, Any]) -> str:
    """Sections of the mappings that stand inside a component, and inside those."""
    own = {entry.config.__name__ for k in ("sensor", "world") for entry in registry.entries(k, plugins=False).values()}  # type: ignore[arg-type]
    own |= {"Agent", "OceanConfig", VEHICLE, "Record", "Origin", *reference.LEGS}
    names: list[str] = []
    waiting = _named(model)
    while waiting:
        name = waiting.pop(0)
        if name not in names and name not in own and name in definitions:
            names.append(name)
            waiting += _named(definitions[name])
    return "".join("\n" + reference.section(2, name, definitions[name]) for name in names)


def _named(value: Any) -> list[str]:
    """Names of the definitions that a part of the schema refers to."""
    if isinstance(value, dict):
        own = [value["$ref"].rpartition("/")[2]] if isinstance(value.get("$ref"), str) else []
        return own + [n for v in value.values() for n in _named(v)]
    if isinstance(value, list):
        return [n for v in value for n in _named(v)]
    return []


def write(folder: Path) -> None:
    """One page a component, and an index."""
    folder.mkdir(parents=True, exist_ok=True)
    made = pages()
    for name, (_, _, text) in made.items():
        (folder / f"{name}.md").write_text(_linked(text, name), encoding="utf-8")
    index = [
        reference.HEAD.replace("This page is made", "These pages are made"),
        _linked(reference.section(2, "The scenario", schema_data()), "index"),
    ]
    for group in ("The scenario", "Sensors", "Worlds"):
        index += [f"```{{toctree}}\n:caption: {group}\n:maxdepth: 1\n"]
        index += [f"{title} <{name}>" for name, (g, title, _) in made.items() if g == group]
        index += ["```\n"]
    (folder / "index.md").write_text("\n".join(index), encoding="utf-8")


def _linked(text: str, here: str) -> str:
    """Links of the reference on one page as links between pages."""
    import re

    titles = {f"#{line[3:].strip().lower()}" for line in text.splitlines() if line.startswith("## ")}

    def link(match: re.Match[str]) -> str:
        anchor = match[1].lower()
        if anchor in pages() and anchor != here:
            return f"]({anchor}.md)"
        if f"#{anchor}" in titles:
            return f"](#{anchor})"
        home = next(
            (n for n, (_, _, t) in pages().items() if f"## {match[1]}\n" in t or f"## {anchor}\n" in t.lower()), None
        )
        return f"]({home}.md#{anchor})" if home else "](index.md)"

    return re.sub(r"\]\(#([A-Za-z0-9_\-]+)\)", link, text)
