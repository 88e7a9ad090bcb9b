"""Simple columns of plankton, salinity and temperature, with patches: for teaching and for adaptive sampling.

Formulas and usual numbers: HoloOcean documentation, BST sensor (BYU FRoSt Lab, MIT licence). NumPy, at any places.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def step_column(depth: ArrayLike, *, surface: float, deep: float, middle_m: float, thickness_m: float) -> Array:
    """From a value at the surface to one in the deep, as a logistic curve of depth [m] about the middle of a cline."""
    x = (np.asarray(depth, dtype=np.float64) - middle_m) / thickness_m
    return np.asarray(surface + (deep - surface) / (1.0 + np.exp(-x)))


def plankton_column(
    depth: ArrayLike, *, surface: float = 1.2, peak: float = 1.0, peak_m: float = 50.0, width_m: float = 25.0,
    photic_m: float = 200.0, sharpness_m: float = 20.0, deep: float = 0.1,
) -> Array:  # fmt: skip
    """Biomass [kg/m^3] at a depth [m]: a bell about `peak_m` on the surface's value, fading into the deep's below the
    photic zone."""
    d = np.asarray(depth, dtype=np.float64)
    bell = surface + (peak - surface) * np.exp(-((d - peak_m) ** 2) / (2 * width_m**2))
    light = 1.0 / (1.0 + np.exp((d - photic_m) / sharpness_m))
    return np.asarray(bell * light + deep * (1.0 - light))


def patches(position: ArrayLike, clusters: Sequence[Mapping[str, Any]]) -> Array:
    """Sum of strength exp(-distance / falloff) over clusters at `position` `(..., 3)` world NWU [m].

    Each has `position`, `strength` (0) and `falloff` (10 m); one whose falloff is not above zero is left out.
    """
    at = np.asarray(position, dtype=np.float64)
    total = np.zeros(at.shape[:-1])
    for cluster in clusters:
        falloff = float(cluster.get("falloff", 10.0))
        if falloff > 0:
            away = np.linalg.norm(at - np.asarray(cluster["position"], dtype=np.float64), axis=-1)
            total = total + float(cluster.get("strength", 0.0)) * np.exp(-away / falloff)
    return total
