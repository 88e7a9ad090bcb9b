"""A YAML file as plain data that remembers the line of every key.

Differences from YAML 1.1 as PyYAML reads it: `1e3` is a number, `yes`, `no`, `on` and `off` are text, `12:30` is text,
dates are text, and a key written twice is an error.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, TypeAlias

import yaml

from pelagos.errors import ScenarioError, did_you_mean

Key: TypeAlias = tuple[str | int, ...]
MAX_DEPTH: Final = 50
MAX_VALUES: Final = 500_000  # those that anchors and merge keys repeat included
MAX_BYTES: Final = 32 << 20
_COLLECTIONS: Final = ("tag:yaml.org,2002:map", "tag:yaml.org,2002:seq")
_MAX_DIGITS: Final = 30  # of a number: longer ones are no measurement
_NESTED: Final = re.compile(r"^[-?: ]{200,}", re.MULTILINE)  # "- - - -": lists in lists on one line


@dataclass(frozen=True)
class Document:
    """Data, and where it was written.

    Attributes:
        data: mappings, lists and scalars.
        places: "file:line" of every key, by its path from the top.
        folder: folder that relative paths start from.
    """

    data: Any
    places: dict[Key, str] = field(default_factory=dict)
    folder: Path = Path()

    def where(self, path: Key) -> str:
        """ "file:line: key.path" of a value; of what holds it, where it is not written itself."""
        dotted = ".".join(str(part) for part in path)
        for length in range(len(path), -1, -1):
            if path[:length] in self.places:
                return join_place(self.places[path[:length]], dotted, exact=length == len(path))
        return dotted


def join_place(place: str, dotted: str, *, exact: bool) -> str:
    """ "file:line: key.path"; a change from the command line names its own key already."""
    return place if not dotted or (exact and place.startswith(("--set ", "override "))) else f"{place}: {dotted}"


def read_document(path: Path) -> Document:
    """Read a YAML (or JSON) file.

    Raises:
        ScenarioError: missing, not a file, not text, not YAML, or a key is written twice.
    """
    if not path.exists():
        folder = path.parent if path.parent.is_dir() else Path()
        others = [p.name for p in folder.iterdir() if p.suffix in (".yaml", ".yml", ".json")]
        raise ScenarioError(f"there is no such file{did_you_mean(path.name, others)}", where=str(path))
    if path.is_dir():
        raise ScenarioError("this is a folder; give a scenario file", where=str(path))
    if not path.is_file():
        raise ScenarioError("this is a device or a pipe; give a scenario file", where=str(path))
    if path.stat().st_size > MAX_BYTES:
        raise ScenarioError(f"too large for a scenario: more than {MAX_BYTES >> 20} MiB", where=str(path))
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ScenarioError(f"not a text file in UTF-8 (byte {error.start})", where=str(path)) from None
    except OSError as error:
        raise ScenarioError(f"cannot be read: {error.strerror}", where=str(path)) from error
    return parse_document(text, str(path), path.resolve().parent)


def parse_document(text: str, name: str, folder: Path) -> Document:
    """Parse YAML text; `name` stands for the file in messages.

    Raises:
        ScenarioError: not YAML, or a key is written twice.
    """
    try:
        node = _composed(text)
        reader = _Reader(name)
        document = Document(reader.value(node, ()) if node is not None else None, reader.places, folder)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        what = f"not valid YAML: {error.problem or error.context}"
        begun = error.context_mark
        if error.problem and error.context and begun is not None:
            what += f", {error.context} that begins on line {begun.line + 1}"
        if mark is not None and "\t" in _line(text, mark.line):
            what += " (the line holds a tab; indent with spaces)"
        raise ScenarioError(what, where=f"{name}:{mark.line + 1}" if mark else name) from None
    except yaml.YAMLError as error:
        raise ScenarioError(f"not valid YAML: {error}", where=name) from None
    except RecursionError:
        raise ScenarioError("nested too deeply for a scenario", where=name) from None
    document.places[()] = name
    return document


def _line(text: str, number: int) -> str:
    """A line as YAML counts them, from 0; empty behind the last."""
    lines = re.split("\r\n|[\n\r\x85\u2028\u2029]", text)
    return lines[number] if number < len(lines) else ""


def _composed(text: str) -> yaml.Node | None:
    """The tree of a text. Where it is wrong or deeply nested, PyYAML's own parser has the words and the guard."""
    flow = text.count("[") + text.count("{")
    if _FastLoader is not None and (flow <= MAX_DEPTH or _flow_depth(text) <= MAX_DEPTH) and not _NESTED.search(text):
        try:
            return yaml.compose(text, Loader=_FastLoader)
        except yaml.YAMLError:
            pass
    return yaml.compose(text, Loader=_Loader)


def _flow_depth(text: str) -> int:
    """The deepest nesting of brackets, at least: those in texts and comments count too."""
    depth = deepest = 0
    for bracket in re.findall(r"[][{}]", text):
        depth = max(depth + (1 if bracket in "[{" else -1), 0)
        deepest = max(deepest, depth)
    return deepest


class _Loader(yaml.SafeLoader):
    """SafeLoader with the scalars of YAML 1.2's core schema, that ends in `RecursionError` where brackets are nested
    deeper than any scenario: it would look far ahead for the end of each."""

    def fetch_flow_collection_start(self, TokenClass: Any) -> None:
        """A bracket that opens."""
        if self.flow_level > 4 * MAX_DEPTH:  # between, the values tell which of them lies too deep
            raise RecursionError
        super().fetch_flow_collection_start(TokenClass)


def _core_schema() -> dict[str, list[tuple[str, re.Pattern[str]]]]:
    rules = [
        ("null", r"~|null|Null|NULL|", "~nN"),
        ("bool", r"true|True|TRUE|false|False|FALSE", "tTfF"),
        ("int", r"[-+]?\d+|0x[0-9a-fA-F]+|0o[0-7]+", "-+0123456789"),
        ("float", r"[-+]?(\.\d+|\d+(\.\d*)?)([eE][-+]?\d+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)", "-+.0123456789"),
        ("merge", r"<<", "<"),
    ]
    table: dict[str, list[tuple[str, re.Pattern[str]]]] = {"": [("tag:yaml.org,2002:null", re.compile(r"^$"))]}
    for kind, pattern, first in rules:
        for letter in first:
            table.setdefault(letter, []).append((f"tag:yaml.org,2002:{kind}", re.compile(rf"^(?:{pattern})$")))
    return table


_Loader.yaml_implicit_resolvers = _core_schema()
_FastLoader: Any = None
if hasattr(yaml, "CSafeLoader"):  # the same by libyaml, ten times as fast
    _FastLoader = type("_FastLoader", (yaml.CSafeLoader,), {"yaml_implicit_resolvers": _core_schema()})


class _Reader:
    """Turns nodes into data and notes the line of each."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.places: dict[Key, str] = {}
        self._read = 0
        self._merging: list[yaml.Node] = []

    def value(self, node: yaml.Node, path: Key) -> Any:
        self.places.setdefault(path, self.place(node))
        self._read += 1
        if len(path) > MAX_DEPTH or self._read > MAX_VALUES:
            raise ScenarioError("nested too deeply, or too large for a scenario", where=self.place(node))
        if not isinstance(node, yaml.ScalarNode) and node.tag not in _COLLECTIONS:
            raise ScenarioError(f"the tag {node.tag!r} is not understood here", where=self.place(node))
        if isinstance(node, yaml.MappingNode):
            return self.mapping(node, path)
        if isinstance(node, yaml.SequenceNode):
            return [self.value(child, (*path, index)) for index, child in enumerate(node.value)]
        return self.scalar(node)

    def mapping(self, node: yaml.MappingNode, path: Key) -> dict[Any, Any]:
        merged: dict[Any, Any] = {}
        own: dict[Any, Any] = {}
        first: dict[Any, str] = {}
        for key_node, child in node.value:
            if key_node.tag == "tag:yaml.org,2002:merge":
                for source in child.value if isinstance(child, yaml.SequenceNode) else [child]:
                    merged = {**self.merge(source, path), **merged}
                continue
            if not isinstance(key_node, yaml.ScalarNode):
                raise ScenarioError("a key must be a single word", where=self.place(key_node))
            key = self.scalar(key_node)
            self._read += 1
            if key in first:
                raise ScenarioError(
                    f"the key {key!r} is written twice; first on {first[key]}", where=self.place(key_node)
                )
            first[key] = f"line {key_node.start_mark.line + 1}"
            self.places[(*path, key)] = self.place(key_node)
            own[key] = self.value(child, (*path, key))
        return {**merged, **own}

    def merge(self, node: yaml.Node, path: Key) -> dict[Any, Any]:
        if not isinstance(node, yaml.MappingNode):
            raise ScenarioError("'<<' takes a mapping, or a list of mappings", where=self.place(node))
        if any(node is other for other in self._merging):
            raise ScenarioError("'<<' merges a mapping into itself", where=self.place(node))
        if len(self._merging) >= MAX_DEPTH:
            raise ScenarioError("'<<' is nested too deeply", where=self.place(node))
        self._merging.append(node)
        try:
            return self.mapping(node, path)
        finally:
            self._merging.pop()

    def scalar(self, node: yaml.Node) -> Any:
        kind = node.tag.rpartition(":")[2]
        text = str(node.value)
        if kind == "null":
            return None
        if kind == "bool":
            return text.lower() == "true"
        if kind in ("int", "float") and len(text) > _MAX_DIGITS:
            raise ScenarioError(f"a number of {len(text)} characters", where=self.place(node))
        if kind == "int":
            return int(text, 0) if text[:2] in ("0x", "0o") else int(text)
        if kind == "float":
            return float(re.sub(r"\.(inf|nan)$", r"\1", text.lower()))
        if kind == "str":
            return text
        raise ScenarioError(f"the tag {node.tag!r} is not understood here", where=self.place(node))

    def place(self, node: yaml.Node) -> str:
        return f"{self.name}:{node.start_mark.line + 1}"


def plain(value: Any) -> Any:
    """A copy of mappings and lists that may be changed; everything else as it is."""
    if isinstance(value, Mapping):
        return {key: plain(child) for key, child in value.items()}
    return [plain(child) for child in value] if isinstance(value, list | tuple) else value
