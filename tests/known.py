"""Numbers as they were when somebody last looked at them, so that no change of one goes unseen.

They are our own: that they are right is proven in `tests/verification` and `tests/cross_code`. Where a change is meant,
`PELAGOS_RENEW=1 python -m pytest tests -k known` writes them anew, and the difference is read before it is committed.

Of an array of any size seven numbers are kept: how many of its values are finite, their mean and standard deviation,
and four sums over them with weights that change from place to place, so that a part that moved is seen too. They may
differ by a share of mean and deviation: other processors round single precision another way. Of a text the words are
kept as they are; numbers in it may differ as much.
"""

from __future__ import annotations

import json
import os
import re
import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

FOLDER: Final = Path(__file__).parent / "numbers"
SINGLE: Final = 1e-3
DOUBLE: Final = 1e-5  # shares, of what is reckoned in single and in double precision
EXACT: Final = 1e-6  # of what a few formulas give, to the digits that are kept
_TURNS: Final = (0.0123, 0.318, 1.27, 2.71)  # rad from one value to the next
NUMBER: Final = re.compile(r"(?<![\w#.])[-+]?\d[\d,]*\.?\d*(?:e[-+]?\d+)?")
_NUMBER: Final = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_LEAST: Final = 1e-3  # a number as small as this still weighs beside large ones


def flat(parts: Iterable[Any]) -> NDArray[np.float64]:
    """All values of some arrays, end to end, the large ones beside the small: arsinh of a thousand times each."""
    rows = [np.ravel(np.asarray(part)).astype(np.float64) for part in parts]
    return np.arcsinh(np.concatenate(rows) / _LEAST)


def check(file: str, case: str, found: Mapping[str, Any], share: float = SINGLE) -> None:
    """Compare what was found with what is known of a case, or write it down where `PELAGOS_RENEW` is set."""
    path = FOLDER / f"{file}.json"
    book = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    now = {name: _summary(values) for name, values in found.items()}
    if os.environ.get("PELAGOS_RENEW"):
        book[case] = now
        lines = ",\n".join(f"{json.dumps(c)}: {{\n{_lines(book[c])}\n}}" for c in sorted(book))
        path.write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")
        return
    assert case in book, f"{case} is not known yet: PELAGOS_RENEW=1 python -m pytest tests -k known"
    assert now.keys() == book[case].keys()
    wrong = {
        name: (book[case][name], values) for name, values in now.items() if not _alike(book[case][name], values, share)
    }
    assert not wrong, f"{case}, known and found: {wrong}"


def on_one_scale(value: Any) -> NDArray[np.float64]:
    """All numbers and texts within anything made of parts, in order: asinh(x / 0.001), so that a magnetic field weighs
    beside a position. A text is the numbers in it and a checksum of the rest, bytes are a checksum.
    """
    return np.arcsinh(np.array(list(_leaves(value)), dtype=np.float64) / _LEAST)


def _leaves(value: Any) -> Iterator[float]:
    if value is None:
        yield np.nan
    elif isinstance(value, str):
        yield from map(float, _NUMBER.findall(value))
        yield _checksum(_NUMBER.sub("", value).encode())
    elif isinstance(value, bytes | bytearray | memoryview):
        yield _checksum(value)
    elif isinstance(value, Mapping):
        for name, part in value.items():
            yield _checksum(str(name).encode())
            yield from _leaves(part)
    elif is_dataclass(value):
        for field in fields(value):
            yield from _leaves(getattr(value, field.name))
    elif isinstance(value, np.ndarray) and value.dtype != object:
        array = np.ravel(value)
        yield from (np.concatenate([array.real, array.imag]) if np.iscomplexobj(array) else array).astype(float)
    elif hasattr(value, "__iter__"):
        for part in value:
            yield from _leaves(part)
    elif isinstance(value, int | float | np.generic):
        yield float(value)
    else:
        yield _checksum(str(value).encode())


def _checksum(raw: Any) -> float:
    """-1 to 1."""
    return zlib.crc32(raw) / 2.0**31 - 1.0


def _lines(case: Mapping[str, Any]) -> str:
    return ",\n".join(
        f"  {json.dumps(name)}: {json.dumps(values, ensure_ascii=False)}" for name, values in case.items()
    )


def _summary(values: Any) -> list[float] | str:
    if isinstance(values, str):
        return values
    array = np.ravel(np.asarray(values))
    flat = (np.concatenate([array.real, array.imag]) if np.iscomplexobj(array) else array).astype(np.float64)
    finite = np.isfinite(flat)
    if not finite.any():
        return [float(finite.sum()), float(flat.size)]
    kept, place = flat[finite], np.flatnonzero(finite)
    sums = [float(np.mean(kept * np.cos(turn * place + 0.7))) for turn in _TURNS]
    return [float(finite.sum()), *(float(f"{v:.7g}") for v in (kept.mean(), kept.std(), *sums))]


def _alike(known: Any, found: Any, share: float) -> bool:
    if isinstance(known, str):
        return isinstance(found, str) and _same_text(known, found, share)
    if len(known) != len(found) or known[0] != found[0]:
        return False
    if len(known) == 2:
        return known == found
    size = abs(known[1]) + known[2]
    return all(abs(a - b) <= share * size + 1e-9 for a, b in zip(known[1:], found[1:], strict=True))


def _same_text(known: str, found: str, share: float) -> bool:
    """Whether words are the same, and numbers but for a share and one of their last digit."""
    if NUMBER.sub("0", known) != NUMBER.sub("0", found):
        return False
    for a, b in zip(NUMBER.findall(known), NUMBER.findall(found), strict=True):
        last = 10.0 ** -len(a.partition("e")[0].partition(".")[2]) if "." in a else 0.0
        one, other = (float(v.replace(",", "")) for v in (a, b))
        if abs(one - other) > share * abs(one) + 1.01 * last:
            return False
    return True
