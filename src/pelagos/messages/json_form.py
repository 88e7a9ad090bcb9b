"""Messages as JSON, as rosbridge writes them: fields by name, bytes in base64, null for what is not finite.

Source: https://github.com/RobotWebTools/rosbridge_suite, ROSBRIDGE_PROTOCOL.md, version 2.
"""

from __future__ import annotations

import base64
import binascii
import math
from collections.abc import Mapping
from dataclasses import is_dataclass
from typing import Any, Final

import numpy as np

from pelagos.errors import InputError, LookupFailed
from pelagos.messages.store import Message, typestore

_BYTES: Final = ("uint8", "byte", "char")
_NODES: Final = ("base", "name", "array", "sequence")


def to_json(message: Message) -> dict[str, Any]:
    """A message as what `json.dumps` takes."""
    names = typestore().fielddefs[message.__msgtype__][1]  # the class has the type's constants too, which say nothing
    return {name: _plain(getattr(message, name)) for name, _ in names}


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        return to_json(value)
    if isinstance(value, np.ndarray):
        if value.dtype == np.uint8:
            return base64.b64encode(value.tobytes()).decode()
        if value.dtype.kind == "f" and not np.isfinite(value).all():
            return [_plain(v) for v in value.tolist()]
        return value.tolist()
    if isinstance(value, list):
        return [_plain(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def from_json(name: str, data: Any, where: str = "") -> Message:
    """The message of a type ("geometry_msgs/msg/Twist") in JSON; fields that are left out are 0 or empty.

    Args:
        name: of the type.
        data: an object of its fields.
        where: for messages: the field that it stands in.

    Raises:
        InputError: a field that the type does not have, or a value that does not fit.
    """
    if not isinstance(data, Mapping):
        raise InputError(f"{where or name}: an object of fields is wanted, not {type(data).__name__}")
    definitions = dict(typestore().fielddefs[name][1])
    for key in data:
        if key not in definitions:
            raise LookupFailed(f"field of {name}", key, definitions)
    made = {key: _value(f"{where or name}.{key}", node, data.get(key)) for key, node in definitions.items()}
    return typestore().types[name](**made)


def _value(where: str, node: Any, data: Any) -> Any:
    """One field; `data` None where it is left out, and for a number that is not finite."""
    kind, inner = _NODES[int(node[0]) - 1], node[1]
    if kind == "name":
        return from_json(inner, {} if data is None else data, where)
    if kind == "base":
        return _scalar(where, inner[0], data)
    element, count = inner[0], inner[1]
    item = (_NODES[int(element[0]) - 1], element[1])
    if item[0] == "base" and item[1][0] != "string":
        return _numbers(where, item[1][0], count if kind == "array" else None, data)
    if data is None:
        data = []
    if not isinstance(data, list):
        raise InputError(f"{where}: a list is wanted, not {data!r:.60}")
    return [_value(f"{where}[{i}]", element, v) for i, v in enumerate(data)]


def _scalar(where: str, base: str, data: Any) -> Any:
    if base == "string":
        if not isinstance(data, str | None):
            raise InputError(f"{where}: a text is wanted, not {data!r:.60}")
        return data or ""
    if base == "bool":
        if not isinstance(data, bool | int | None):
            raise InputError(f"{where}: true or false is wanted, not {data!r:.60}")
        return bool(data)
    if isinstance(data, bool) or not isinstance(data, int | float | None):
        raise InputError(f"{where}: a number is wanted, not {data!r:.60}")
    if base.startswith("float"):
        return 0.0 if data is None else float(data)
    if base in _BYTES:
        base = "uint8"
    whole, limits = 0 if data is None else int(data), np.iinfo(base)
    if (data is not None and whole != data) or not limits.min <= whole <= limits.max:
        raise InputError(f"{where}: a whole number from {limits.min} to {limits.max} is wanted, not {data!r:.60}")
    return whole


def _numbers(where: str, base: str, count: int | None, data: Any) -> Any:
    kind = np.uint8 if base in _BYTES else np.dtype(base)
    if data is None:
        return np.zeros(count or 0, dtype=kind)
    if isinstance(data, str) and kind == np.uint8:
        try:
            made = np.frombuffer(base64.b64decode(data, validate=True), dtype=np.uint8)
        except binascii.Error:
            raise InputError(f"{where}: bytes in base64 are wanted") from None
    elif isinstance(data, list):
        made = np.array([_scalar(f"{where}[{i}]", base, v) for i, v in enumerate(data)], dtype=kind)
    else:
        raise InputError(f"{where}: a list of numbers is wanted, not {data!r:.60}")
    if count is not None and len(made) != count:
        raise InputError(f"{where}: {count} numbers are wanted, not {len(made)}")
    return made
