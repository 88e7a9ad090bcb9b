"""Changes to a scenario: `agents.auv0.sensors.imaging.range_max_m=40`."""

from __future__ import annotations

from typing import Any

from pelagos.config.document import Document, parse_document, plain
from pelagos.errors import LookupFailed, ScenarioError


def change(document: Document, text: str) -> Document:
    """The document after one change as the command line gives it, "key.path=value" with the value in YAML.

    Raises:
        ScenarioError: not of this form, or the path leads through something that holds no keys.
    """
    path, equals, value = text.partition("=")
    if not equals or not all(path.strip().split(".")):
        raise ScenarioError(
            "give a change as key.path=value, such as agents.auv0.start.heading_deg=90", where=f"--set {text}"
        )
    place = f"--set {path.strip()}={value.strip()}"
    return with_value(document, path.strip(), parse_document(value, place, document.folder).data, place=place)


def with_value(document: Document, dotted: str, value: Any, *, place: str) -> Document:
    """The document with one value set; items of lists are named by their number.

    Args:
        document: is not changed.
        dotted: path of keys, "agents.auv0.start.heading_deg".
        value: what to set.
        place: what messages about this value begin with.

    Raises:
        ScenarioError: the path leads through something that holds no keys.
    """
    data = plain(document.data) if document.data is not None else {}
    holder = data
    *outer, last = dotted.split(".")
    keys: list[str | int] = []
    places = dict(document.places)
    for part in outer:
        key = _key(holder, part, keys, place)
        if isinstance(holder, dict):
            if holder.get(key) is None:
                _refuse_new_name(holder, str(key), keys, place)
                holder[key] = {}
                places[*keys, key] = place
            elif key == "vehicle" and isinstance(holder[key], str):
                holder[key] = {"type": holder[key]}
        holder = holder[key]
        keys.append(key)
    keys.append(_key(holder, last, keys, place))
    holder[keys[-1]] = value
    path = tuple(keys)
    kept = {at: line for at, line in places.items() if at[: len(path)] != path}
    return Document(data, {**kept, path: place}, document.folder)


def _refuse_new_name(holder: dict[Any, Any], name: str, keys: list[str | int], place: str) -> None:
    """A single value makes no new agent or sensor: its name is probably misspelt."""
    for kind, inside in (("agent", len(keys) == 1 and keys[0] == "agents"), ("sensor", keys[2:] == ["sensors"])):
        if inside:
            raise LookupFailed(kind, name, map(str, holder), where=place)


def _key(holder: Any, part: str, keys: list[str | int], place: str) -> str | int:
    if isinstance(holder, dict):
        return part
    where = ".".join(str(key) for key in keys)
    if not isinstance(holder, list):
        raise ScenarioError(f"{where} is a value ({holder!r}) and has no key {part!r}", where=place)
    if part not in [str(index) for index in range(len(holder))]:
        raise ScenarioError(
            f"{where} is a list of {len(holder)}; name an item by its number from 0, not {part!r}", where=place
        )
    return int(part)
