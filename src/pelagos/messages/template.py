"""Messages of fixed size, made by overwriting the numbers that vary in bytes that were serialised once.

A field's place is found by serialising the message twice with different values there, so the layout is always the
serialiser's own.
"""

from __future__ import annotations

import copy
import itertools
import struct
from collections.abc import Sequence
from functools import cached_property
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pelagos.messages.store import Message, serialize

_FORMAT: Final = {"float64": "d", "float32": "f", "int32": "i", "uint32": "I", "uint16": "H", "uint8": "B", "int8": "b"}
Buffer: TypeAlias = bytes | bytearray
STAMP: Final = ("header.stamp.sec:int32", "header.stamp.nanosec:uint32")


class Template:
    """Bytes of one message type in which only named numbers vary.

    Attributes:
        name: message type.
        varying: fields that vary, as given.
        places: byte offset and `struct` format character of each varying number.

    Args:
        name: message type.
        message: the constant part, with anything in the varying fields.
        varying: "path.to.field:type" or "path.to.array[3]:type" in the order in which `encode` takes the values; types
            float64, float32, int32, uint32, uint16, uint8, int8, and bytes for a whole array of numbers, whose size is
            that of the array in `message`. "path.to.array[].flag:bytes" is one byte of every element.
    """

    def __init__(self, name: str, message: Message, varying: Sequence[str]) -> None:
        self.name = name
        self.varying = tuple(varying)
        self._bytes = serialize(name, message)
        own = copy.deepcopy(message)
        places = [_place(name, own, *field.split(":")) for field in varying]
        self.places: list[tuple[int, str]] = places
        self._integers = [i for i, (_, code) in enumerate(places) if code in "iIHBb"]
        self._runs: list[tuple[struct.Struct, int, int, int]] = []
        for group in _contiguous(places):
            first, last = group[0][0], group[-1][0]
            code = struct.Struct("<" + "".join(places[i][1] for i, _ in group))
            self._runs.append((code, group[0][1], first, last + 1))

    @property
    def constant(self) -> bytes:
        """The message as it was given."""
        return self._bytes

    def of(self, constant: bytes) -> Template:
        """The same fields in another message of the same size and layout."""
        other = copy.copy(self)
        other._bytes = constant
        return other

    def encode(self, *values: float | bytes) -> bytearray:
        """The message with `values` in its varying fields."""
        out = bytearray(self._bytes)
        for code, offset, first, end in self._runs:
            code.pack_into(out, offset, *values[first:end])
        return out

    def encode_row(self, values: Sequence[float]) -> bytearray:
        """The same for numbers that may be floats where the message has integers."""
        mixed = list(values)
        for i in self._integers:
            mixed[i] = int(mixed[i])
        return self.encode(*mixed)

    def rows(self, t_ns: NDArray[np.int64], values: NDArray[np.float64]) -> NDArray[np.uint8]:
        """`(k, size)` bytes of k messages, of a template that begins with the stamp.

        Args:
            t_ns: `(k,)` simulation times [ns].
            values: `(k, m)`, what follows the stamp.
        """
        record, columns = self._table
        out = np.empty((len(t_ns), len(self._bytes)), dtype=np.uint8)
        out[:] = np.frombuffer(self._bytes, dtype=np.uint8)
        fields = out.view(record)[:, 0]
        fields["0"], fields["1"] = t_ns // 1_000_000_000, t_ns % 1_000_000_000
        for name, first, end in columns:
            fields[name] = values[:, first:end]
        return out

    def numbers(self, rows: NDArray[np.uint8]) -> NDArray[np.float64]:
        """`(k, all)` values of the varying fields in k messages `(k, size)`."""
        return np.stack([_column(rows, at, _dtype(code)) for at, code in self.places], axis=-1)

    @cached_property
    def _table(self) -> tuple[np.dtype[Any], list[tuple[str, int, int]]]:
        """The message as a NumPy record; by field behind the stamp, its name and columns of `rows`' values.

        Numbers of one type that stand together are one field: a field at a time takes half of the time of a row.
        """
        groups = [(0, 1), (1, 2)]
        for i in range(2, len(self.places)):
            (place, code), (before, code_before) = self.places[i], self.places[i - 1]
            if i > 2 and code == code_before and place == before + np.dtype(_dtype(code)).itemsize:
                groups[-1] = (groups[-1][0], i + 1)
            else:
                groups.append((i, i + 1))
        formats = [(_dtype(self.places[i][1]), (end - i,) if i > 1 else ()) for i, end in groups]
        names, offsets = [str(i) for i, _ in groups], [self.places[i][0] for i, _ in groups]
        layout = {"names": names, "formats": formats, "offsets": offsets, "itemsize": len(self._bytes)}
        return np.dtype(layout), [(str(i), i - 2, end - 2) for i, end in groups[2:]]  # type: ignore[call-overload]


def _dtype(code: str) -> str:
    return {"d": "<f8", "f": "<f4", "i": "<i4", "I": "<u4", "H": "<u2", "B": "u1", "b": "i1"}[code]


def _column(rows: NDArray[np.uint8], offset: int, kind: str) -> NDArray[np.float64]:
    width = np.dtype(kind).itemsize
    return np.ascontiguousarray(rows[:, offset : offset + width]).view(kind)[:, 0].astype(np.float64)


def _place(name: str, message: Message, path: str, kind: str) -> tuple[int, str]:
    """Byte offset and struct format of one number or array. The message is another while this looks."""
    holder, leaf = _holder(message, path.replace("[].", "."))
    array = None
    if "[]." in path:
        code = f"{len(holder)}s"
    elif kind == "bytes":
        array = np.asarray(getattr(holder, leaf))
        code = f"{array.nbytes}s"
    else:
        code = _FORMAT[kind]
    before, marks = _get(holder, leaf), []
    for fill in (0x3A, 0x5B):
        if "[]." in path:
            value: Any = [fill] * len(holder)
        elif array is not None:
            value = np.frombuffer(bytes([fill]) * array.nbytes, dtype=array.dtype)
        else:
            (value,) = struct.unpack("<" + code, bytes([fill]) * struct.calcsize(code))
        _set(holder, leaf, value)
        marks.append(np.frombuffer(serialize(name, message), dtype=np.uint8))
    _set(holder, leaf, before)
    differing = np.flatnonzero(marks[0] != marks[1])
    first, size = int(differing[0]), struct.calcsize(code)
    assert len(differing) == size == differing[-1] - first + 1, f"{name}: {path} is not {kind}"
    return first, code


def _get(holder: Any, leaf: str) -> Any:
    """An item, a field, or that field of every element of a list."""
    if leaf.startswith("["):
        return holder[int(leaf[1:-1])]
    return [getattr(one, leaf) for one in holder] if isinstance(holder, list) else getattr(holder, leaf)


def _set(holder: Any, leaf: str, value: Any) -> None:
    if leaf.startswith("["):
        holder[int(leaf[1:-1])] = value
    elif isinstance(holder, list):
        for one, own in zip(holder, value, strict=True):
            setattr(one, leaf, own)
    else:
        setattr(holder, leaf, value)


def _holder(message: Any, path: str) -> tuple[Any, str]:
    """Object that holds the last part of a path, and that part."""
    *parents, leaf = path.replace("[", ".[").split(".")
    for part in parents:
        message = message[int(part[1:-1])] if part.startswith("[") else getattr(message, part)
    return message, leaf


def _contiguous(places: Sequence[tuple[int, str]]) -> list[list[tuple[int, int]]]:
    """Runs of fields that follow one another in both orders: lists of (index, offset)."""
    runs: list[list[tuple[int, int]]] = []
    end = -1
    for index, (offset, code) in enumerate(places):
        if offset != end:
            runs.append([])
        runs[-1].append((index, offset))
        end = offset + struct.calcsize(code)
    return runs


def elements(path: str, count: int, kind: str) -> list[str]:
    """Names of the first `count` elements of an array field."""
    return [f"{path}[{i}]:{kind}" for i in range(count)]


def fields(path: str, names: str, kind: str = "float64") -> list[str]:
    """Names of several fields of one sub-message: `fields("pose.position", "x y z")`."""
    return [f"{path}.{name}:{kind}" for name in names.split()]


def joined(*groups: Sequence[str]) -> list[str]:
    """One list of field names."""
    return list(itertools.chain(*groups))
