"""Spheres around moving bodies: which of them may stand between two places, without casting a ray."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

_SKIN: Final = 0.1  # [m] by which casts in single precision may err, with much to spare


@dataclass(frozen=True)
class Spheres:
    """Spheres about the origins of bodies that hold all of them.

    Attributes:
        centre: `(b, 3)` NWU [m].
        radius: `(b,)` [m].
        copy: `(b,)` of the fleet in which each is.
    """

    centre: NDArray[np.float64]
    radius: NDArray[np.float64]
    copy: NDArray[np.int64]

    def between(
        self, start: NDArray[np.float64], end: NDArray[np.float64], copy: NDArray[np.int64], *, own: NDArray[np.uint32],
        spared: NDArray[np.float64],
    ) -> NDArray[np.bool_]:  # fmt: skip
        """`(m,)`: one of them reaches into the vertical plane between two places.

        Args:
            start, end: `(m, 3)` NWU [m].
            copy: `(m,)` whose bodies count.
            own: `(m,)` row of a body that does not count.
            spared: `(m,)` nor do bodies that are nearer to the end than this with all that they have [m].
        """
        radius = self.radius + _SKIN
        way = (end - start)[:, None, :2]  # (m, 1, 2)
        out = self.centre[None, :, :2] - start[:, None, :2]  # (m, b, 2)
        share = np.clip((out * way).sum(-1) / np.maximum((way * way).sum(-1), 1e-12), 0.0, 1.0)
        met = np.linalg.norm(out - share[..., None] * way, axis=-1) <= radius
        met &= (self.copy == copy[:, None]) & (np.arange(len(radius)) != own[:, None])
        met &= np.linalg.norm(self.centre - end[:, None], axis=-1) + radius >= spared[:, None]
        return np.asarray(met.any(axis=1))
