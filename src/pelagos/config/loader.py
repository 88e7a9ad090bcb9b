"""From a path, a mapping or a `Scenario` to a checked `Scenario`, and back to a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml
from pydantic import BaseModel, ValidationError

from pelagos.config.document import Document, plain, read_document
from pelagos.config.override import change, with_value
from pelagos.config.problem import as_error, coerced, scenario_error, vanishing
from pelagos.config.scenario import Scenario
from pelagos.errors import ScenarioError


def load_scenario(
    source: str | Path | Mapping[str, Any] | Scenario,
    *,
    overrides: Mapping[str, Any] | None = None,
    changes: Sequence[str] = (),
    trust: bool = False,
) -> Scenario:
    """Read and check a scenario; needs no device.

    Args:
        source: a YAML or JSON file, a mapping, or a scenario.
        overrides: values to change, by dotted path of keys.
        changes: values to change, as the command line gives them: "key.path=value".
        trust: let it name functions of Python to call ("module:function"): such a scenario is a program.

    Raises:
        ScenarioError: something is wrong; says where, what was given and what is allowed.
    """
    if isinstance(source, Scenario):
        if not changes and not overrides:
            return source
        document, trust = Document(source.model_dump(mode="json", exclude_unset=True), dict(source.places)), True
    elif isinstance(source, Mapping):
        document = Document(plain(source), {}, Path.cwd())
    else:
        document = read_document(Path(source))
    for dotted, value in (overrides or {}).items():
        document = with_value(document, dotted, plain(value), place=f"override {dotted}")
    for text in changes:
        document = change(document, text)
    return check(document, trust=trust)


def check(document: Document, *, trust: bool = False) -> Scenario:
    """The scenario that a document describes.

    Raises:
        ScenarioError: it describes none.
    """
    if document.data is None:
        raise ScenarioError(
            "the file is empty; see `pelagos schema` for what goes into a scenario", where=document.where(())
        )
    if not isinstance(document.data, Mapping):
        raise ScenarioError(
            f"a scenario is a mapping of keys, not {type(document.data).__name__}", where=document.where(())
        )
    if too_small := [(document.where(path), text) for path, text in vanishing(document.data)]:
        raise as_error(too_small)
    try:
        scenario = Scenario.model_validate(document.data, context=_context(document, trust))
    except ValidationError as error:
        raise scenario_error(error, document, Scenario) from None
    problems = [(document.where(path), text) for path, text in coerced(document.data, scenario)]
    if problems:
        raise as_error(problems)
    return scenario.placed(document.places)


def _context(document: Document, trust: bool) -> dict[str, Any]:
    """Context of validators: the folder of relative paths, that in which a file's meshes must lie, and trust."""
    of_file = () in document.places
    return {"folder": document.folder, "bounds": document.folder if of_file else None, "trust": trust}


def to_yaml(scenario: Scenario) -> str:
    """The scenario with every default written out, as YAML that loads to an equal scenario."""
    return yaml.dump(_written(scenario), Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=120)


def _written(scenario: Scenario) -> dict[str, Any]:
    """Plain data without the values that are None because nobody gave them."""
    data: dict[str, Any] = _pruned(scenario, scenario.model_dump(mode="json"))
    return data


def _pruned(built: Any, dumped: Any) -> Any:
    if isinstance(built, BaseModel):
        kept = {key: value for key, value in dumped.items() if value is not None or key in built.model_fields_set}
        return {key: _pruned(getattr(built, key, None), value) for key, value in kept.items()}
    if isinstance(built, Mapping):
        return {key: _pruned(built.get(key), value) for key, value in dumped.items()}
    if isinstance(built, list | tuple):
        return [_pruned(item, value) for item, value in zip(built, dumped, strict=True)]
    return dumped


class _Dumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):  # type: ignore[misc]  # libyaml's, five times as fast
    """Lists of plain values on one line, everything else in block style."""


def _list(dumper: yaml.SafeDumper, data: list[Any]) -> yaml.Node:
    flat = all(not isinstance(item, dict | list) or (isinstance(item, list) and len(item) <= 3) for item in data)
    return dumper.represent_sequence("tag:yaml.org,2002:seq", data, flow_style=flat)


_Dumper.add_representer(list, _list)
