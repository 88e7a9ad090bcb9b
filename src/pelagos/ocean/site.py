"""Site of an ocean: its place on Earth, the extent of the world, and the seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pelagos.math.geodesy import GeoOrigin

_NO_BOUNDS = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@dataclass(frozen=True)
class Site:
    """Place and time that the parts of an ocean are built with.

    Attributes:
        origin: where on Earth.
        bounds: lowest and highest corner of the world `(2, 3)` NWU [m].
        seed: of the run.
        duration_s: how long the run is to last [s]; 0 where nobody knows.
    """

    origin: GeoOrigin
    bounds: tuple[tuple[float, float, float], tuple[float, float, float]] = _NO_BOUNDS
    seed: int = 0
    duration_s: float = 0.0

    def rng(self, *purpose: int) -> np.random.Generator:
        """Random numbers for making the ocean, one stream a purpose."""
        return np.random.Generator(np.random.PCG64(np.random.SeedSequence([self.seed % 2**63, 0x0CEA, *purpose])))

    @property
    def corners(self) -> NDArray[np.float64]:
        """`(2, 3)` lowest and highest corner."""
        return np.array(self.bounds, dtype=np.float64)
