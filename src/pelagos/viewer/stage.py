"""The 3-D stage on the server's side: nodes with names, arrays and poses, sent to the browsers' own renderer.

A node's path says what it goes along with: "/agents/auv0/fin" moves with "/agents/auv0".
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from pelagos.viewer.hub import Hub

Kind = Literal["frame", "mesh", "fan", "lines", "points", "label"]
Colour = tuple[int, int, int]
_TYPES = {"<f4": "f4", "<u4": "u4", "|u1": "u1"}


class Node:
    """One thing on the stage; its `pose` goes out with the next `Stage.send_poses`."""

    def __init__(self, stage: Stage, name: str) -> None:
        self._stage, self.name = stage, name
        self.pose: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None

    def place(self, position: Any, attitude: Any) -> None:
        """Put it at a position `(3,)` [m] with an attitude (w, x, y, z), in the frame of its parent."""
        self.pose = np.asarray(position, dtype=np.float64), np.asarray(attitude, dtype=np.float64)
        self._stage.placed[self.name] = self.pose

    def update(self, **arrays: NDArray[Any]) -> None:
        """Replace some of its arrays; their sizes may be others."""
        self._stage.send_arrays(self.name, arrays)

    def show(self, *, visible: bool) -> None:
        """Show or hide it."""
        self._stage.hub.publish(f"seen{self.name}", {"type": "seen", "name": self.name, "visible": visible})

    def remove(self) -> None:
        """Take it off the stage."""
        self._stage.remove(self.name)


class Stage:
    """Makes nodes.

    Attributes:
        hub: where they go.
        placed: poses by name.
    """

    def __init__(self, hub: Hub) -> None:
        self.hub = hub
        self.placed: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}

    def add(
        self, kind: Kind, name: str, *, colour: Colour | None = None, position: Any = None, attitude: Any = None,
        about: Mapping[str, Any] | None = None, **arrays: NDArray[Any],
    ) -> Node:  # fmt: skip
        """A node, in place of one of that name.

        Args:
            kind: "mesh": `vertices` `(v, 3)`, `faces` `(f, 3)`, maybe `colours` `(v, 3)` uint8; "fan": the same, see-
                through; "lines": `points` `(m, 2, 3)`; "points": `points` `(m, 3)`, `colours`; "label"; "frame".
            name: its path.
            colour: sRGB, of what has no `colours`.
            position, attitude: in its parent's frame.
            about: for the renderer, JSON types: `text`, `size`, `opacity`, `smooth`.
            arrays: see `kind`.
        """
        node = Node(self, name)
        self._send(
            f"node{name}", {"type": "node", "name": name, "kind": kind, "colour": colour, **(about or {})}, arrays
        )
        if position is not None or attitude is not None:
            node.place((0, 0, 0) if position is None else position, (1, 0, 0, 0) if attitude is None else attitude)
        return node

    def remove(self, name: str) -> None:
        """Take a node off, and what goes along with it."""
        for key in [k for k in self.placed if k == name or k.startswith(name + "/")]:
            del self.placed[key]
        for prefix in ("node", "part", "seen"):
            self.hub.forget(f"{prefix}{name}", whole=True)
        self.hub.publish(f"node{name}", {"type": "gone", "name": name}, keep=False)

    def send_poses(self, t_s: float) -> None:
        """Send where everything is."""
        poses = {n: [round(float(v), 5) for v in (*p, *q)] for n, (p, q) in self.placed.items()}
        self.hub.publish("poses", {"type": "poses", "t": t_s, "poses": poses})

    def send_arrays(self, name: str, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Replace arrays of a node."""
        self._send(f"part{name}", {"type": "part", "name": name}, arrays)

    def _send(self, key: str, header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> None:
        parts, listed, at = [], [], 0
        for name, values in arrays.items():
            plain = np.ascontiguousarray(values, dtype=_stored(values))
            raw = plain.tobytes()
            listed.append({"name": name, "type": _TYPES[plain.dtype.str], "count": plain.size, "at": at})
            room = -len(raw) % 4
            parts.append(raw + b"\0" * room)
            at += len(raw) + room
        self.hub.publish(key, {**header, "arrays": listed}, b"".join(parts))


def _stored(values: NDArray[Any]) -> str:
    kind = np.asarray(values).dtype
    return "|u1" if kind == np.uint8 else "<f4" if kind.kind == "f" else "<u4"
