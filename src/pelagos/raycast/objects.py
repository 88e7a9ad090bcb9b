"""Objects of faces: one row for each label, instance and material that stand together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pelagos.raycast.geometry import Geometry


class Objects:
    """One row for each (label, instance, material) in use."""

    def __init__(self) -> None:
        self.label: list[int] = []
        self.instance: list[int] = []
        self.material: list[int] = []

    def rows(self, geometry: Geometry) -> NDArray[np.unsignedinteger]:
        """`(f,)` object row of each face."""
        start = len(self.label)
        if isinstance(geometry.material, int):
            materials, inverse = np.array([geometry.material]), np.zeros(len(geometry.faces), dtype=np.uint8)
        else:
            counts = np.bincount(geometry.material)
            materials = np.flatnonzero(counts)
            kind = np.min_scalar_type(len(materials))
            inverse = (np.cumsum(counts > 0) - 1).astype(kind)[geometry.material]
        self.label += [geometry.label] * len(materials)
        self.instance += [geometry.instance] * len(materials)
        self.material += [int(m) for m in materials]
        kind = np.min_scalar_type(len(self.label))  # there are as many rows as triangles: bytes where they suffice
        return np.add(inverse, start, dtype=kind)

    def add(self, label: int, instance: int, materials: Sequence[int]) -> NDArray[np.uint32]:
        """`(len(materials),)` object row of one thing in each of its materials."""
        start = len(self.label)
        self.label += [label] * len(materials)
        self.instance += [instance] * len(materials)
        self.material += list(materials)
        return np.arange(start, len(self.label), dtype=np.uint32)

    def cut(self, count: int) -> None:
        """Forget all but the first `count` rows."""
        for rows in (self.label, self.instance, self.material):
            del rows[count:]
