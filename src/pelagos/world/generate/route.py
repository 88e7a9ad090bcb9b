"""Lines across the ground: pipelines and cables from one side of the world to another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pelagos.world import shapes
from pelagos.world.generate.pipeline import Pipeline, pipe_mesh, supports
from pelagos.world.generate.scatter import Places
from pelagos.world.site import Site
from pelagos.world.terrain import HeightField


def route(places: Places, ground: HeightField, rng: np.random.Generator, radius: float) -> NDArray[np.float64] | None:
    """A gently winding path `(k, 2)` from edge to edge over free ground, marked as taken; None where none was found."""
    for _ in range(400):
        low = np.array([places.x[0], places.y[0]]) + 2 * radius
        high = np.array([places.x[1], places.y[1]]) - 2 * radius
        ends = rng.uniform(low, high, (2, 2))
        axis = int(rng.integers(2))
        ends[0, axis], ends[1, axis] = low[axis], high[axis]
        length = float(np.linalg.norm(ends[1] - ends[0]))
        s = np.linspace(0, 1, max(8, int(length)))
        across = np.array([-(ends[1] - ends[0])[1], (ends[1] - ends[0])[0]]) / length
        sway = 0.03 * length * np.sin(2 * np.pi * s * rng.uniform(0.6, 1.6) + rng.uniform(0, 6)) * np.sin(np.pi * s)
        path = ends[0] + s[:, None] * (ends[1] - ends[0]) + sway[:, None] * across
        path = np.clip(path, low, high)
        if (ground.height(path[:, 0], path[:, 1]) < -2).all() and all(places.free(x, y, radius) for x, y in path):
            for x, y in path:
                places.take(x, y, radius)
            return np.asarray(path, dtype=np.float64)
    return None


def add_pipeline(
    site: Site,
    path: NDArray[np.float64],
    ground: HeightField,
    diameter: float,
    rng: np.random.Generator,
    *,
    label: str | int = "pipe",
) -> None:
    """A pipe, buried here and proud there, that hangs free over one scour, which is dug out of the ground in place."""
    radius = diameter / 2
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    burial = radius * (0.6 + 0.6 * np.sin(2 * np.pi * along / rng.uniform(50, 120) + rng.uniform(0, 6)))
    first = rng.uniform(0.3, 0.6) * along[-1]
    span = (first, min(first + rng.uniform(12, 22), 0.9 * along[-1]))
    burial[(along > span[0] - 4) & (along < span[1] + 4)] = 0.1 * radius
    pipe = Pipeline(path, radius, burial, span)
    pipe.scour(ground, rng.uniform(0.5, 1.1))
    site.add(pipe_mesh(pipe, ground), "concrete", label=label, name="pipeline", crease_deg=40)
    site.add(supports(pipe, ground, 3), "concrete", label="concrete", name="pipe supports")


def add_cable(
    site: Site, path: NDArray[np.float64], ground: HeightField, diameter: float, *, label: str | int = "cable"
) -> None:
    """A cable that follows the bed, half sunk in."""
    from scipy.ndimage import gaussian_filter1d  # a quarter of the time that all imports take

    z = gaussian_filter1d(ground.height(path[:, 0], path[:, 1]), 1.0, mode="nearest")
    mesh = shapes.tube(np.column_stack([path, z + 0.1 * diameter]), diameter / 2, sides=10)
    site.add(mesh, "black", label=label, name="cable", crease_deg=60)
