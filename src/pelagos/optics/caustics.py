"""Light focused by waves: where refracted sunlight crowds together below a rippled surface.

Short waves (0.3-4 m) make the pattern at the depths that a camera sees daylight in: a wave of number k and height a
focuses at about 4 / (k^2 a). A square tile of sea, periodic in both directions, carries them; its sunlight is
followed straight down from a grid of surface points to a few depths, and counted there in whole numbers. Energy is
conserved: the mean of every map is 1. The same tile gives the slopes that bend and mirror what is seen through the
surface.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.constants import GRAVITY
from pelagos.optics.interface import refract, sun_below_surface, surface_normal
from pelagos.optics.swell import Swell, swell_slope
from pelagos.optics.water import REFRACTIVE_INDEX

TILE: Final = 8.0  # [m]
PLANES: Final = (0.8, 2.0, 5.0, 12.0)  # depths of the maps [m]
CELLS: Final = 128  # of a map, each way
_HALF_UNIT: Final = 64
_UNIT: Final = _HALF_UNIT**2  # of a photon: 2^20 of them fit a cell
_FAINT: Final = 0.05  # of ripples [1/m]
_SWELL_FAINT: Final = 0.004  # of the ocean's own waves [1/m]

_SURFACE_TENSION: Final = 7.3e-5  # over density [m^3/s^2]
_GOLDEN: Final = math.pi * (3 - math.sqrt(5))


@dataclass(frozen=True)
class Ripple:
    """Short waves of a tile: whole-number wave vectors (per tile), heights [m], phases [rad]; each `(waves,)`.

    `finer` and `longer`: mean square slope of waves shorter than the tile's, and of the ocean's own.
    """

    i: tuple[int, ...]
    j: tuple[int, ...]
    height: tuple[float, ...]
    phase: tuple[float, ...]
    finer: float = 0.0
    longer: float = 0.0

    @property
    def mean_square_slope(self) -> float:
        """Variance of the slope, both directions together."""
        k2 = (2 * math.pi / TILE) ** 2 * (np.square(self.i) + np.square(self.j))
        return float(0.5 * np.sum(k2 * np.square(self.height)))

    def measures(self) -> Array:
        """`Float`: the heights, `finer`, the mean square slope, `longer`: an argument of kernels, as of `waves_at`.

        Numbers of Python would be part of a kernel, which another sea would have compiled anew, for seconds.
        """
        known = [*self.height, self.finer, self.mean_square_slope, self.longer]
        return jit.from_numpy(jit.Float, np.array(known, dtype=np.float32))


def ripple(
    mean_square_slope: float = 0.004, *, waves: int = 28, heading: float = 0.4, finer: float = 0.0, longer: float = 0.0
) -> Ripple:
    """Short waves with equal slope in equal steps of log wavelength, as in a saturated sea (O. M. Phillips 1958).

    Args:
        mean_square_slope: of them, both directions together.
        waves: how many.
        heading: where they mostly run to, from north to west [rad].
        finer, longer: see `Ripple`.
    """
    i, j, height, phase = [], [], [], []
    for n in range(waves):
        length = 4.0 * (0.3 / 4.0) ** ((n + 0.5) / waves)
        spread = (((n * _GOLDEN) % (2 * math.pi)) / math.pi - 1) * 1.4
        k = TILE / length
        a, b = round(k * math.cos(heading + spread)), round(k * math.sin(heading + spread))
        number = 2 * math.pi / TILE * math.hypot(a, b)
        i.append(a)
        j.append(b)
        height.append(math.sqrt(2 * mean_square_slope / waves) / number)
        phase.append((n * n * 2.399963) % (2 * math.pi))
    return Ripple(tuple(i), tuple(j), tuple(height), tuple(phase), finer, longer)


@jit.struct
class Waves:
    """The sea surface around the cameras at the moments of the lanes, a Dr.Jit struct.

    Attributes:
        slope_x, slope_y: `Float`, slopes of the short waves, `(moments, CELLS, CELLS)` flattened, x first.
        focus: `Float`, `(moments, planes, CELLS, CELLS)` flattened: irradiance over its mean.
        swell: the ocean's own waves, None where it is flat.
        moment: `UInt32`, the row of these maps for each lane: lanes at one time share them.
        finer, short, long: `Float` (1), mean square slopes of waves that are not drawn, of the short ones, and of the
            ocean's own.
    """

    slope_x: Array
    slope_y: Array
    focus: Array
    swell: Swell | None
    moment: Array
    finer: Array
    short: Array
    long: Array


def waves_at(
    sea: Ripple, t: Array, towards_sun: Array, moments: int, swell: Swell | None = None, moment: Array | None = None,
    *, measures: Array | None = None,
) -> Waves:  # fmt: skip
    """Slopes and light maps at times `t` `(moments,)` [s] for the sun in direction `towards_sun` (above water).

    `moment` says for each lane which of the times is its own; None: they are those of the lanes. `measures` are those
    of the sea, where this becomes part of a kernel.
    """
    known = (*sea.height, sea.finer, sea.mean_square_slope, sea.longer)
    heights = [jit.Float(v) if measures is None else dr.gather(jit.Float, measures, k) for k, v in enumerate(known)]
    rough = heights[len(sea.height) :]
    slope_x, slope_y = _slopes(sea, heights[: len(sea.height)], t, moments)
    moment = dr.arange(jit.UInt32, moments) if moment is None else moment
    return Waves(slope_x, slope_y, _focus(slope_x, slope_y, towards_sun, moments), swell, moment, *rough)


def map_of(waves: Waves, lane: Array) -> Array:
    """`UInt32`, the row of the maps of lane `lane`."""
    return dr.gather(jit.UInt32, waves.moment, lane)


def sea_level(waves: Waves, lanes: int) -> Array:
    """Height of the sea surface over the cameras, `Float` `(lanes,)` [m]."""
    return dr.zeros(jit.Float, lanes) if waves.swell is None else waves.swell.level


def _slopes(sea: Ripple, heights: Sequence[Array], t: Array, lanes: int) -> tuple[Array, Array]:
    cell = dr.arange(jit.UInt32, lanes * CELLS * CELLS)
    lane = cell // (CELLS * CELLS)
    u = jit.Float(cell // CELLS % CELLS) * (2 * math.pi / CELLS)
    v = jit.Float(cell % CELLS) * (2 * math.pi / CELLS)
    slope_x, slope_y = jit.Float(0), jit.Float(0)
    for i, j, height, phase in zip(sea.i, sea.j, heights, sea.phase, strict=True):
        kx, ky = 2 * math.pi / TILE * i, 2 * math.pi / TILE * j
        k = math.hypot(kx, ky)
        omega = math.sqrt(GRAVITY * k + _SURFACE_TENSION * k**3)
        turn = jit.Float64(t) * (omega / (2 * math.pi))
        angle = jit.Float(turn - dr.floor(turn)) * (2 * math.pi)  # (lanes)
        wave = -height * dr.sin(i * u + j * v + phase - dr.gather(jit.Float, angle, lane))
        slope_x, slope_y = slope_x + kx * wave, slope_y + ky * wave
    return slope_x, slope_y


def _focus(slope_x: Array, slope_y: Array, towards_sun: Array, lanes: int) -> Array:
    """Photons through every cell of the surface, counted where they cross each plane."""
    ray = refract(-towards_sun, surface_normal(jit.Array2f(slope_x, slope_y)), 1 / REFRACTIVE_INDEX)
    flat = sun_below_surface(towards_sun)
    dx, dy = ray.x / -ray.z + flat.x / flat.z, ray.y / -ray.z + flat.y / flat.z
    dr.eval(slope_x, slope_y, dx, dy)
    number = dr.arange(jit.UInt32, lanes * len(PLANES) * CELLS * CELLS)
    row, cell = number // (CELLS * CELLS), number % (CELLS * CELLS)
    photon = row // len(PLANES) * (CELLS * CELLS) + cell
    depth = jit.Float(PLANES[0])
    for k in range(1, len(PLANES)):
        depth = dr.select(row % len(PLANES) == k, PLANES[k], depth)
    depth *= CELLS / TILE
    counts = dr.zeros(jit.UInt32, dr.width(number))
    u = jit.Float(cell // CELLS) + dr.gather(jit.Float, dx, photon) * depth
    v = jit.Float(cell % CELLS) + dr.gather(jit.Float, dy, photon) * depth
    _splat(counts, row * (CELLS * CELLS), u, v)
    return _blurred(counts) * (1 / _UNIT)


def _splat(counts: Array, base: Array, u: Array, v: Array) -> None:
    """Share one photon, `_UNIT` whole numbers, among the four cells around (u, v); whole numbers add in any order."""
    i, j = dr.floor(u), dr.floor(v)
    right, up = jit.UInt32((u - i) * _HALF_UNIT + 0.5), jit.UInt32((v - j) * _HALF_UNIT + 0.5)
    i0, j0 = _wrap(i), _wrap(j)
    i1, j1 = (i0 + 1) & (CELLS - 1), (j0 + 1) & (CELLS - 1)
    for row, a in ((i0, _HALF_UNIT - right), (i1, right)):
        for column, b in ((j0, _HALF_UNIT - up), (j1, up)):
            dr.scatter_add(counts, a * b, base + row * CELLS + column)


def _blurred(counts: Array) -> Array:
    """Counts under a 3 x 3 tent: the sun is half a degree wide, and photons stand on a grid."""
    cell = dr.arange(jit.UInt32, dr.width(counts))
    base = cell // (CELLS * CELLS) * (CELLS * CELLS)
    x, y = cell // CELLS % CELLS, cell % CELLS
    total = jit.Float(0)
    for a in (0, 1, 2):
        for b in (0, 1, 2):
            index = base + (x + a + CELLS - 1) % CELLS * CELLS + (y + b + CELLS - 1) % CELLS
            total += (2 - abs(a - 1)) * (2 - abs(b - 1)) / 16 * jit.Float(dr.gather(jit.UInt32, counts, index))
    return total


def focusing(waves: Waves, x: Array, y: Array, depth: Array, towards_sun_below: Array, lane: Array) -> Array:
    """Irradiance of the sun's beam over its mean at places below the surface, `Float`.

    Args:
        waves: maps of the moment.
        x, y: world position [m], `Float`.
        depth: [m]; above the surface the result is 1.
        towards_sun_below: unit vector in the water.
        lane: `UInt32`, of `waves`.
    """
    back = depth / towards_sun_below.z
    qx, qy = x + back * towards_sun_below.x, y + back * towards_sun_below.y
    if waves.swell is not None:  # a tilted surface sends the light elsewhere: by about (1 - 1 / n) of its slope
        tilt = swell_slope(waves.swell, qx, qy, lane) * (depth * (1 - 1 / REFRACTIVE_INDEX))
        qx, qy = qx - tilt.x, qy - tilt.y
    u, v = qx * (CELLS / TILE), qy * (CELLS / TILE)
    step = dr.log2(dr.maximum(depth, 1e-3) / PLANES[0]) * (1 / math.log2(PLANES[1] / PLANES[0]))
    step = dr.clip(step, 0, len(PLANES) - 1.001)
    plane = jit.UInt32(step)
    fade = step - jit.Float(plane)
    base = map_of(waves, lane) * len(PLANES) + plane
    near, far = _bilinear(waves.focus, u, v, base), _bilinear(waves.focus, u, v, base + 1)
    shallow = dr.clip(depth / PLANES[0], 0, 1)
    return dr.lerp(1, dr.lerp(near, far, fade), shallow)


def slope(waves: Waves, x: Array, y: Array, lane: Array, distance: Array) -> Array:
    """Slope of the sea surface at a place seen from `distance` [m], `Array2f`; it averages out within a far pixel."""
    short = _bilinear2(waves.slope_x, waves.slope_y, x, y, map_of(waves, lane)) * dr.rcp(
        1 + dr.square(_FAINT * distance)
    )
    if waves.swell is None:
        return short
    return short + swell_slope(waves.swell, x, y, lane) * dr.rcp(1 + dr.square(_SWELL_FAINT * distance))


def unseen_slope(waves: Waves, distance: Array) -> Array:
    """Mean square of the slope that `slope` leaves out, both directions together, `Float`."""
    short = dr.square(dr.rcp(1 + dr.square(_FAINT * distance)))
    long = dr.square(dr.rcp(1 + dr.square(_SWELL_FAINT * distance)))
    return waves.finer + waves.short * (1 - short) + waves.long * (1 - long)


def _bilinear2(a: Array, b: Array, x: Array, y: Array, lane: Array) -> Array:
    u, v = x * (CELLS / TILE), y * (CELLS / TILE)
    return jit.Array2f(_bilinear(a, u, v, lane), _bilinear(b, u, v, lane))


def _bilinear(table: Array, u: Array, v: Array, row: Array) -> Array:
    """Periodic interpolation in row `row` of a `(rows, CELLS, CELLS)` table; u, v in cells from the first cell."""
    fu, fv = dr.floor(u), dr.floor(v)
    a, b = u - fu, v - fv
    i0, j0 = _wrap(fu), _wrap(fv)
    i1, j1 = (i0 + 1) & (CELLS - 1), (j0 + 1) & (CELLS - 1)
    base = row * (CELLS * CELLS)
    t00 = dr.gather(jit.Float, table, base + i0 * CELLS + j0)
    t01 = dr.gather(jit.Float, table, base + i0 * CELLS + j1)
    t10 = dr.gather(jit.Float, table, base + i1 * CELLS + j0)
    t11 = dr.gather(jit.Float, table, base + i1 * CELLS + j1)
    return dr.lerp(dr.lerp(t00, t01, b), dr.lerp(t10, t11, b), a)


def _wrap(u: Array) -> Array:
    return jit.UInt32(jit.Int32(dr.floor(u)) & (CELLS - 1))
