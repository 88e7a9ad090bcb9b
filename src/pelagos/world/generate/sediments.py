"""Distribution of sediments: random patches that follow the ground, fine ones in hollows, coarse ones on rises."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.world.generate.relief import fractal
from pelagos.world.material import material
from pelagos.world.terrain import HeightField

_FINEST: Final = 5.0  # the smallest bays of a patch, as parts of its size
_COARSE: Final = 5.0  # nodes of the fields in the shortest wavelength: fields are smooth, and made on fewer nodes
_FOLLOW: Final = 0.9  # how far fields follow the ground, for a density ratio of 1 above the mean


def sediment_fields(
    ground: HeightField, names: Sequence[str], patch: float, rng: np.random.Generator
) -> NDArray[np.float32]:
    """Fields `(m, nx, ny)`; a sediment lies where its field is the highest.

    Args:
        ground: the heights.
        names: of the sediments.
        patch: size of the patches [m].
        rng: random numbers.
    """
    from scipy.ndimage import uniform_filter  # a quarter of the time that all imports take

    shape = (ground.z.shape[0], ground.z.shape[1])
    fields = np.zeros((len(names), *shape), dtype=np.float32)
    if len(names) == 1:
        return fields
    shortest = max(2 * ground.spacing, patch / _FINEST)
    step = max(1, int(shortest / (_COARSE * ground.spacing)))
    coarse = (-(-(shape[0] - 1) // step) + 2, -(-(shape[1] - 1) // step) + 2)
    for field in fields:
        made = fractal(coarse, step * ground.spacing, rng, slope=3.8, longest=2 * patch, shortest=shortest)
        field[:] = _denser(made.astype(np.float32), shape, step)
    weight = np.array([material(n).density_ratio for n in names])
    weight = np.clip(weight - weight.mean(), -1, 1)
    level = uniform_filter(ground.z.astype(np.float32), max(1, int(shortest / ground.spacing)), mode="nearest")
    level -= level.mean(dtype=np.float64)
    level /= max(float(level.std(dtype=np.float64)), 1e-3)
    rise = np.clip(level, -2, 2, out=level)
    for field, w in zip(fields, weight, strict=True):
        field += np.float32(_FOLLOW * w) * rise
    return fields


def _denser(coarse: NDArray[np.float32], shape: tuple[int, int], step: int) -> NDArray[np.float32]:
    """Bilinear between nodes `step` apart."""
    if step == 1:
        return coarse[: shape[0], : shape[1]]
    out = coarse
    for axis in (0, 1):
        at = np.arange(shape[axis])
        share = ((at % step) / np.float32(step)).astype(np.float32)
        share = share[:, None] if axis == 0 else share[None, :]
        low, high = np.take(out, at // step, axis=axis), np.take(out, at // step + 1, axis=axis)
        high -= low
        high *= share
        high += low
        out = high
    return out
