"""Transforms on their way into a recording: those of all agents share the topic /tf."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray


class Frames:
    """Keeps the transforms of a block of ticks until those of every agent are there, and gives them in order of time.

    How a run is cut into blocks so does not show in the order of messages: a resumed run writes that of a whole one.
    """

    def __init__(self) -> None:
        self._kept: list[tuple[NDArray[np.int64], NDArray[np.uint8]]] = []

    def keep(self, t_ns: NDArray[np.int64], rows: NDArray[np.uint8]) -> None:
        """Keep k messages of one size `(k, size)`, at times `(k,)` [ns]."""
        if len(t_ns):
            self._kept.append((t_ns, rows))

    def ordered(self) -> Iterator[tuple[NDArray[np.int64], NDArray[np.uint8]]]:
        """Times [ns] and messages of all that was kept, in pieces of one size; at one time in the order of keeping."""
        kept, self._kept = self._kept, []
        if len(kept) < 2:  # of one agent alone
            yield from kept
            return
        sizes = np.concatenate([np.full(len(rows), rows.shape[1]) for _, rows in kept])
        wide = np.zeros((len(sizes), sizes.max()), dtype=np.uint8)  # names of agents have different lengths
        first = 0
        for _, rows in kept:
            wide[first : first + len(rows), : rows.shape[1]] = rows
            first += len(rows)
        t_ns = np.concatenate([t for t, _ in kept])
        order = np.argsort(t_ns, kind="stable")
        t_ns, sizes, wide = t_ns[order], sizes[order], wide[order]
        cuts = (np.flatnonzero(np.diff(sizes)) + 1).tolist()
        for a, b in zip([0, *cuts], [*cuts, len(sizes)], strict=True):
            yield t_ns[a:b], wide[a:b, : sizes[a]]
