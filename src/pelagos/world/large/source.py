"""Source of a large ground's heights: asked at nodes of its grid, never held as a whole."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import WorldError
from pelagos.math.geodesy import GeoOrigin
from pelagos.math.interpolate import bilinear
from pelagos.world.bathymetry.projection import from_latlon
from pelagos.world.bathymetry.survey import Grid
from pelagos.world.large.noise import Fractal
from pelagos.world.terrain import HeightField

_FILE_BATCH: Final = 32_768  # nodes read before the file is unmapped again: its pages count as memory while mapped


class Source(Protocol):
    """Heights at places, the same whatever is asked for beside them."""

    def heights(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Heights [m] at world places of equal shape [m]."""


@dataclass(frozen=True)
class FractalSource:
    """Relief about a mean depth, with a slope of the whole.

    Attributes:
        relief: see `Fractal`.
        mean_m: height of the mean level at the origin [m].
        gradient: rise of the mean level along x and y [m/m].
    """

    relief: Fractal
    mean_m: float
    gradient: tuple[float, float] = (0.0, 0.0)

    def heights(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """See `Source`."""
        return self.mean_m + self.gradient[0] * x + self.gradient[1] * y + self.relief.heights(x, y)


@dataclass(frozen=True)
class FieldSource:
    """A grid in memory; NaN outside it."""

    field: HeightField

    def heights(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """See `Source`."""
        return self.field.surface(x, y)


@dataclass(frozen=True)
class SurveySource:
    """A survey's grid, interpolated bilinearly; beyond its edge the value at the edge.

    Attributes:
        grid: heights upwards, without holes.
        origin: of the world.
    """

    grid: Grid
    origin: GeoOrigin

    def heights(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """See `Source`."""
        g = self.grid
        lat, lon = self.origin.to_latlon(x, y)
        u, v = from_latlon(g.crs, lat, lon, near=float(g.v[len(g.v) // 2]))
        i = np.interp(u, g.u, np.arange(len(g.u), dtype=np.float64))
        j = np.interp(v, g.v, np.arange(len(g.v), dtype=np.float64))
        return bilinear(g.z, i, j)


class FileSource:
    """A NumPy file of heights `(nx, ny)`, float32 or float64, read piece by piece; beyond its edge the value there.

    Node (i, j) stands at (x0 + i spacing, y0 + j spacing).

    Raises:
        WorldError: missing, not such a file, or with values that are not finite where they are read.
    """

    def __init__(self, path: Path, *, x0: float, y0: float, spacing: float) -> None:
        self.path, self.x0, self.y0, self.spacing = path, x0, y0, spacing
        self.shape = grid_file_shape(path)

    def heights(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """See `Source`; places are taken to be nodes."""
        i = np.clip(np.rint((np.ravel(x) - self.x0) / self.spacing).astype(np.int64), 0, self.shape[0] - 1)
        j = np.clip(np.rint((np.ravel(y) - self.y0) / self.spacing).astype(np.int64), 0, self.shape[1] - 1)
        out = np.empty(i.size)
        for start in range(0, i.size, _FILE_BATCH):
            part = slice(start, start + _FILE_BATCH)
            out[part] = _open(self.path)[i[part], j[part]]
        if not np.isfinite(out).all():
            bad = int(np.argmin(np.isfinite(out)))
            raise WorldError(f"heights {self.path}: the value at node ({i[bad]}, {j[bad]}) is not finite")
        return out.reshape(np.shape(x))


def grid_file_shape(path: Path) -> tuple[int, int]:
    """Nodes of a NumPy file of heights.

    Raises:
        WorldError: it is not one.
    """
    found = _open(path)
    if found.ndim != 2 or min(found.shape) < 2 or found.dtype not in (np.float32, np.float64):
        raise WorldError(
            f"heights {path}: a large ground needs float32 or float64 heights (nx, ny), not {found.dtype} {found.shape}"
        )
    return int(found.shape[0]), int(found.shape[1])


def _open(path: Path) -> NDArray[np.floating]:
    try:
        found: NDArray[np.floating] = np.load(path, mmap_mode="r", allow_pickle=False)
    except FileNotFoundError:
        raise WorldError(f"heights file {path} does not exist") from None
    except (OSError, ValueError, EOFError) as error:
        raise WorldError(f"heights file {path} cannot be read; it may be damaged or cut short ({error})") from error
    return found
