"""Ground too large for one mesh: a part of it stands in the static scene, and is exchanged as the vehicles go on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Patch:
    """Ground that stands in the scene now. Sizes stay the same for long, so that nothing is recorded anew.

    Attributes:
        origin: `(3,)` world position that vertices are relative to, and the scene's origin from now on [m].
        vertices: `(v, 3)` float32 [m].
        faces: `(f, 3)` uint32; unused ones have no area.
        normals: `(v, 3)` float32, unit.
        face_materials: `(f,)` uint32, rows of `StreamedGround.materials`.
    """

    origin: NDArray[np.float64]
    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    normals: NDArray[np.float32]
    face_materials: NDArray[np.uint32]


class StreamedGround(Protocol):
    """Follows places with patches."""

    @property
    def patch(self) -> Patch:
        """The patch now."""

    @property
    def identity(self) -> tuple[int, int, tuple[int, ...]]:
        """Label, instance id, and the world's material rows that `Patch.face_materials` counts."""

    def follow(self, places: NDArray[np.float64]) -> bool:
        """Bring detail to vehicles at `(k, 2)` [m]; whether the patch is a new one."""

    def peek(self, places: NDArray[np.float64]) -> bool:
        """The same for rays of other origin; the next `follow` is as if this had not been."""

    def memory(self) -> object:
        """Last choice of `follow`, as plain values and arrays; None where it was not asked yet."""

    def recall(self, memory: object) -> None:
        """The next `follow` is as if the last one had settled on that."""

    def forget(self) -> None:
        """A run begins anew."""
