"""What is shown, as numbers for `known.check`: messages of a view, pictures, figures, pages, nested data."""

from __future__ import annotations

import itertools
import json
import re
import time
import zlib
from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np
import pytest
from matplotlib.collections import Collection, QuadMesh
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.quiver import Quiver
from numpy.typing import NDArray

from known import NUMBER
from pelagos.viewer.hub import Hub

_CELL: Final = 8  # pixels along a side of what a picture is reduced to
_SMALL: Final = 64
_TYPES: Final = {"f4": "<f4", "u4": "<u4", "u1": "u1"}
_EMBEDDED: Final = re.compile(r"data:[a-z/]+;base64,[A-Za-z0-9+/=]*")


def digest(text: str) -> str:
    """Checksum of the words of a text, numbers left out."""
    return f"{zlib.crc32(NUMBER.sub('0', text).encode()):08x}"


def flat(value: Any) -> tuple[list[float], list[str]]:
    """Numbers and words of nested data, in order; numbers within texts are numbers."""
    numbers: list[float] = []
    words: list[str] = []
    _walk(value, numbers, words)
    return numbers, words


def parts(name: str, value: Any) -> dict[str, Any]:
    """Numbers of nested data, and a checksum of its words."""
    numbers, words = flat(value)
    return {name: numbers, f"{name}, words": digest("\n".join(words))}


def _walk(value: Any, numbers: list[float], words: list[str]) -> None:
    match value:
        case None:
            words.append("None")
        case str():
            text = _EMBEDDED.sub("", value)
            numbers.extend(float(v.replace(",", "")) for v in NUMBER.findall(text))
            words.append(NUMBER.sub("0", text))
        case Mapping():
            for key, inner in value.items():
                words.append(str(key))
                _walk(inner, numbers, words)
        case np.ndarray():
            numbers.extend(np.ravel(value).astype(np.float64).tolist())
        case bool() | int() | float() | np.generic():
            numbers.append(float(value))
        case Iterable():
            for inner in value:
                _walk(inner, numbers, words)
        case _:
            words.append(type(value).__name__)


def reduced(picture: Any) -> NDArray[np.float64]:
    """Means of a picture over cells of 8 x 8 pixels, of a small one its pixels."""
    p = np.asarray(picture, dtype=np.float64)
    cell = _CELL if min(p.shape[:2]) >= _SMALL else 1
    h, w = (s // cell * cell for s in p.shape[:2])
    cells = p[:h, :w].reshape(h // cell, cell, w // cell, cell, -1).mean(axis=(1, 3))
    return np.asarray(cells.ravel())


class Ear(Hub):
    """A hub that somebody listens to: it keeps what was published."""

    def __init__(self) -> None:
        super().__init__()
        self.messages: list[tuple[str, dict[str, Any], bytes]] = []

    @property
    def count(self) -> int:
        return 1

    def publish(self, key: str, header: Mapping[str, Any], blob: bytes = b"", *, keep: bool = True) -> None:
        said = json.loads(json.dumps({**header, "kept": keep}, allow_nan=False))
        self.messages.append((key, said, blob))
        super().publish(key, header, blob, keep=keep)

    def told(self) -> dict[str, Any]:
        """Numbers of all messages since the last call: arrays by node's family and name, the rest by type."""
        found: dict[str, list[Any]] = {}
        heads: dict[str, list[Any]] = {}
        for key, header, blob in self.messages:
            family = header["type"]
            if family in ("node", "part"):
                family += " " + "/".join(header["name"].split("/")[1:3])
                for part in header.pop("arrays"):
                    values = np.frombuffer(blob, _TYPES[part["type"]], part["count"], part["at"])
                    found.setdefault(f"{family} {part['name']}", []).append(values.astype(np.float64))
            heads.setdefault(header["type"], []).append([key, header])
        self.messages.clear()
        out: dict[str, Any] = {name: np.concatenate(values) for name, values in found.items()}
        for kind, said in heads.items():
            out |= parts(kind, said)
        return out


class Nobody:
    """In place of a server: it listens nowhere."""

    port, url = 8080, "http://127.0.0.1:8080/?token=x"

    def __init__(self) -> None:
        self.hub, self.offered = Ear(), dict[str, bytes]()

    def offer(self, name: str, media_type: str, data: bytes) -> None:
        self.offered[name] = data

    def close(self) -> None:
        pass


def slow_clock(patch: pytest.MonkeyPatch) -> None:
    """Have wall-clock time go on by 4 s whenever somebody looks at it: everything is due."""
    ticking = itertools.count(100.0, 4.0)
    patch.setattr(time, "monotonic", lambda: next(ticking))


def figure(drawn: Figure) -> dict[str, Any]:
    """Numbers of a figure's artists, axes by axes: data of lines, images, collections, patches; texts; set limits."""
    words: list[Any] = [list(drawn.get_size_inches())]
    found: dict[str, Any] = {}
    for number, axes in enumerate(drawn.axes):
        kept: dict[str, list[Any]] = {}
        for line in axes.lines:
            kept.setdefault("lines", []).append(np.asarray(line.get_xydata(), dtype=np.float64))
            words.append([str(line.get_color()), str(line.get_label()), str(line.get_marker())])
        for k, image in enumerate(axes.images):
            kept[f"image {k}"] = [reduced(np.nan_to_num(_filled(image.get_array())))]
            words += [list(image.get_extent()), _limits(image.get_clim())]
        for collection in axes.collections:
            for name, values in _collection(collection).items():
                kept.setdefault(name, []).extend(values)
        for patch in axes.patches:
            kept.setdefault("shapes", []).append(patch.get_path().transformed(patch.get_patch_transform()).vertices)
        found |= {
            f"{number} {n}": np.concatenate([np.ravel(v) for v in values]) for n, values in kept.items() if values
        }
        words.append([axes.get_title(loc=place) for place in ("left", "center", "right")])
        words += [axes.get_xlabel(), axes.get_ylabel(), [[t.get_text(), *_place(t)] for t in axes.texts]]
        for free, limits in ((axes.get_autoscalex_on(), axes.get_xlim()), (axes.get_autoscaley_on(), axes.get_ylim())):
            words.append("free" if free else list(limits))
        words.append([axes.xaxis_inverted(), axes.yaxis_inverted(), axes.get_xscale(), axes.get_yscale()])
    return found | parts("texts", words)


def page(text: str) -> dict[str, Any]:
    """Numbers and words of a page of HTML, section by section."""
    found: dict[str, Any] = {}
    for number, section in enumerate(text[text.index("<body>") :].split("<section>")):
        found |= parts(f"section {number}", section)
    return found


def _filled(values: Any) -> NDArray[np.float64]:
    return np.asarray(np.ma.filled(np.ma.asarray(values, dtype=float), np.nan))


def _limits(pair: tuple[Any, Any]) -> list[Any]:
    return [None if v is None else float(v) for v in pair]


def _place(text: Any) -> list[float]:
    return [float(v) for v in (getattr(text, "xy", None) or text.get_position())]


def _reach(path: Path) -> NDArray[np.float64]:
    """Length of a level's lines, and its moments about both axes: how many corners they have differs by processors."""
    lines = [np.asarray(line) for line in path.to_polygons(closed_only=False)]
    steps = np.concatenate([np.zeros((0, 2)), *(np.diff(line, axis=0) for line in lines)])
    middles = np.concatenate([np.zeros((0, 2)), *((line[1:] + line[:-1]) / 2 for line in lines)])
    return np.linalg.norm(steps, axis=1) @ np.column_stack([np.ones(len(middles)), middles])


def _collection(c: Collection) -> dict[str, list[Any]]:
    if isinstance(c, Quiver):
        return {
            "arrows": [np.stack([np.ravel(c.U), np.ravel(c.V)]), [c.scale or 0.0]],
            "places": [_filled(c.get_offsets())],
        }
    found: dict[str, list[Any]] = {}
    if c.get_array() is not None:
        found["field"] = [_filled(c.get_array())]
        found["range"] = [np.array(_limits(c.get_clim()), dtype=float)]
    if isinstance(c, QuadMesh):
        return found | {"mesh": [c.get_coordinates()]}
    paths = c.get_paths()
    lines = {"contours": [_reach(path) for path in paths]} if isinstance(c, ContourSet) else {}
    return found | {
        **(lines or {"shapes": [path.vertices for path in paths]}),
        "colours": [np.ravel(c.get_facecolor()), np.ravel(c.get_edgecolor())],
    }
