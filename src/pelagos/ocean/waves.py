"""Surface waves: one table of components, evaluated wherever somebody asks. Linear (Airy) theory.

Elevation sum a cos(k . x - omega t + phase), and below it the velocity, acceleration and pressure of the same
components, e.g. L. H. Holthuijsen, Waves in Oceanic and Coastal Waters (2007), Chapter 5. Near the surface the motion
is stretched after J. D. Wheeler, J. Pet. Technol. 22:359 (1970), doi 10.2118/2712-PA: what linear theory has at z = 0
stands at the surface. Stretching at all depths would give the water at a place a mean velocity against the waves, which
takes the Stokes drift from whatever goes along; so it fades, and is gone a significant height below the mean surface.
Pictures, buoyancy, forces, sensors and sound all read this table, so they see the same sea.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.constants import GRAVITY
from pelagos.math.turns import cos_turns, sincos_turns
from pelagos.ocean.site import Site
from pelagos.ocean.wave_system import Components, WavesConfig
from pelagos.ocean.whitecaps import NEVER, breaking_limit

_STRIDE: Final = 8  # numbers a component has in the table
_AT_ONCE: Final = 8  # components in one turn of the loop
_SPARE: Final = np.array([0, 0, 0, 0, 0, 1.0, 1, 1])  # a component of no amplitude
_CALM: Final = 1e-6  # [m]; depths are told in heights of the waves
_FOAM: Final = ((0.0, 1.0), (1.5, 0.6), (4.0, 0.35))  # ages of foam [s], and what is left of it; assumed
_ONSET: Final = (0.8, 1.25)  # of the limit: from the first foam to a crest that is all white; assumed


@jit.struct
class WaterMotion:
    """Motion by waves: elevation [m]; velocity [m/s] and acceleration [m/s^2], `Array3f64` NWU; head, dynamic
    pressure over rho g [m].
    """

    elevation: Array
    velocity: Array
    acceleration: Array
    head: Array


@jit.struct
class SurfacePoint:
    """A point of the surface: displacement, `Array3f64` NWU [m]; normal; fold, negative where the crest breaks over."""

    displacement: Array
    normal: Array
    fold: Array


@jit.struct
class Changed:
    """Change of a sea by place, `Float64` each, a Dr.Jit struct.

    Attributes:
        scale: factor on all heights, 0 or more.
        cosine, sine: of the angle that it is turned by about the world's origin, from north to west.
        moment: time [s] that it begins at: at t = 0 it is what it was at `moment`.
    """

    scale: Array
    cosine: Array
    sine: Array
    moment: Array

    def of(self, row: list[Array]) -> list[Array]:
        """A component's row, see `Waves.table`."""
        kx, ky, omega, phase, amplitude, *rest = row
        turned = [self.cosine * kx - self.sine * ky, self.sine * kx + self.cosine * ky]
        return [*turned, omega, phase - omega * self.moment, amplitude * self.scale, *rest]


@jit.struct
class Waves:
    """The components: a Dr.Jit struct.

    Attributes:
        table: `Float64`, by component: kx, ky, omega, phase over 2 pi; amplitude [m]; k [1/m]; 1 / (1 - exp(-2 k h))
        and
            1 / (1 + exp(-2 k h)). Padded with components of no amplitude.
        depth: `Float64` (1), of the water [m]; 1e9 where deep.
        limit: `Float64` (1), downward acceleration over gravity at which the surface breaks.
        height: `Float64` (1), significant [m].
        deep: whether it is.
        breaks: whether it breaks anywhere.
        copies: of a fleet, each with a sea of its own: one after the other in `table`, and in `limit` and `height`.
        lane: `UInt32`, the copy of each place that is asked for, see `at`; None where there is one sea.
        changed: see `Changed`; None: as it is.
    """

    table: Array
    depth: Array
    limit: Array
    height: Array
    deep: bool
    breaks: bool
    copies: int = 1
    lane: Array | None = None
    changed: Changed | None = None

    def with_change(self, changed: Changed) -> Waves:
        """The sea of each place, changed."""
        return self._with(height=self.height * dr.maximum(changed.scale, _CALM), changed=changed)

    def at(self, copy: Array) -> Waves:
        """The sea that each place is in, by the copies `UInt32` of a fleet in which they are."""
        limit, height = (dr.gather(jit.Float64, v, copy) for v in (self.limit, self.height))
        return self._with(limit=limit, height=height, lane=copy)

    def _with(self, **changes: Any) -> Waves:
        return Waves(**{f.name: getattr(self, f.name) for f in fields(Waves)} | changes)  # see `jit.without_constants`

    def elevation(self, x: Array, y: Array, t: Array) -> Array:
        """Height of the surface over the mean [m] at world x, y [m] and time t [s], `Float64`."""

        def add(i: Array, height: Array) -> tuple[Array, Array]:
            for _ in range(_AT_ONCE):
                turns, (a, *_) = self._component(i, x, y, t)
                height = dr.fma(a, cos_turns(turns), height)
                i = i + 1
            return i, height

        return self._loop(add, 0 * (x + y + t))[0]

    def slope(self, x: Array, y: Array, t: Array) -> tuple[Array, Array]:
        """Slopes of the surface along x and y [1]."""

        def add(i: Array, sx: Array, sy: Array) -> tuple[Array, ...]:
            first, second = self._rows(i)
            turns = _turns(first, x, y, t)
            rise = -2 * math.pi * second[0] * sincos_turns(turns)[0]
            return i + 1, sx + first[0] * rise, sy + first[1] * rise

        nothing = 0 * (x + y + t)
        sx, sy = self._loop(add, nothing, nothing)
        return sx, sy

    def foam(self, x: Array, y: Array, t: Array) -> Array:
        """Whiteness of the surface, 0 to 1: most where it breaks, and less where it did in the seconds before."""
        white = 0 * (x + y + t)
        for age, left in _FOAM:
            over = self._falling(x, y, t - age) / self.limit - _ONSET[0]
            white = dr.maximum(white, left * dr.clip(over * (1 / (_ONSET[1] - _ONSET[0])), 0.0, 1.0))
        return white

    def _falling(self, x: Array, y: Array, t: Array) -> Array:
        """Downward acceleration of the surface over gravity."""

        def add(i: Array, sum_: Array) -> tuple[Array, Array]:
            for _ in range(_AT_ONCE):
                first, second = self._rows(i)
                rate = 2 * math.pi * first[2]
                sum_ = dr.fma(second[0] * rate * rate, cos_turns(_turns(first, x, y, t)), sum_)
                i = i + 1
            return i, sum_

        return self._loop(add, 0 * (x + y + t))[0] * (1 / GRAVITY)

    def motion(self, position: Array, t: Array, *, stretch: bool = True) -> WaterMotion:
        """Motion of the water at `position` (`Array3f64` NWU [m]); above the surface that of the surface itself.

        Args:
            position: place.
            t: time [s].
            stretch: after Wheeler near the surface; otherwise linear theory as it is, held at z = 0 above.
        """
        x, y, z = position
        nothing = 0 * (x + y + z + t)
        level = self._stretched(z, self.elevation(x, y, t)) if stretch else dr.minimum(z, 0.0) + nothing

        def add(i: Array, *sums: Array) -> tuple[Array, ...]:
            eta, u, v, w, du, dv, dw, p = sums
            for _ in range(_AT_ONCE // 4):
                first, second = self._rows(i)
                s, c = sincos_turns(_turns(first, x, y, t))
                along, up, head = self._decay(second[1], level, second)
                rate, towards = 2 * math.pi * first[2], 2 * math.pi / second[1]
                nx, ny, rise, fall = towards * first[0], towards * first[1], second[0] * c, second[0] * s
                fast, slow = rate * along * rise, rate * rate * along * fall
                eta, p = eta + rise, p + head * rise
                u, v, w = u + nx * fast, v + ny * fast, w + rate * up * fall
                du, dv, dw = du + nx * slow, dv + ny * slow, dw - rate * rate * up * rise
                i = i + 1
            return i, eta, u, v, w, du, dv, dw, p

        eta, u, v, w, du, dv, dw, p = self._loop(add, *([nothing] * 8))
        return WaterMotion(eta, jit.Array3f64(u, v, w), jit.Array3f64(du, dv, dw), p)

    def head(self, position: Array, t: Array) -> tuple[Array, Array]:
        """(elevation [m], dynamic pressure over rho g [m]) at a place, in one pass, without stretching; for hulls."""
        x, y, z = position
        level = dr.minimum(z, 0.0)

        def add(i: Array, height: Array, pressure: Array) -> tuple[Array, ...]:
            for _ in range(_AT_ONCE // 2):
                first, second = self._rows(i)
                wave = second[0] * cos_turns(_turns(first, x, y, t))
                height, pressure = height + wave, pressure + wave * self._decay(second[1], level, second)[2]
                i = i + 1
            return i, height, pressure

        nothing = 0 * (x + y + z + t)
        height, pressure = self._loop(add, nothing, nothing)
        return height, pressure

    def drift(self, z: Array) -> Array:
        """Mean velocity of water at a height z [m] that goes along with the waves, `Array3f64` NWU [m/s].

        Stokes drift, sum a^2 omega k cosh 2k(z + h) / (2 sinh^2 kh); G. G. Stokes, Trans. Camb. Phil. Soc. 8:441, 1847.
        """
        level = dr.minimum(z, 0.0)

        def add(i: Array, north: Array, west: Array) -> tuple[Array, ...]:
            first, second = self._rows(i)
            a, k = second[0], second[1]
            along, up, _ = self._decay(k, level, second)
            speed = 0.5 * a * a * first[2] * (2 * math.pi) * (along * along + up * up)  # over k: times (kx, ky) below
            return i + 1, north + speed * 2 * math.pi * first[0], west + speed * 2 * math.pi * first[1]

        nothing = 0 * z
        north, west = self._loop(add, nothing, nothing)
        return jit.Array3f64(north, west, nothing)

    def surface_point(self, x: Array, y: Array, t: Array, *, choppiness: float = 1.0) -> SurfacePoint:
        """Displaced place of the water that rests at (x, y), on a surface with sharp crests (F. J. Gerstner, 1802).

        Args:
            x, y: rest [m].
            t: time [s].
            choppiness: factor on the horizontal motion; 0 is linear theory's surface, 1 Gerstner's.
        """

        def add(i: Array, *sums: Array) -> tuple[Array, ...]:
            first, second = self._rows(i)
            s, c = sincos_turns(_turns(first, x, y, t))
            a, k = second[0], second[1]
            kx, ky = 2 * math.pi * first[0], 2 * math.pi * first[1]
            dx, dy, dz, xx, xy, yy, sx, sy = sums
            out, bend = a * s / k, a * c / k
            return (
                i + 1,
                dx - kx * out,
                dy - ky * out,
                dz + a * c,
                xx - kx * kx * bend,
                xy - kx * ky * bend,
                yy - ky * ky * bend,
                sx - kx * a * s,
                sy - ky * a * s,
            )

        nothing = 0 * (x + y + t)
        dx, dy, dz, xx, xy, yy, sx, sy = self._loop(add, *([nothing] * 8))
        xx, xy, yy = 1 + choppiness * xx, choppiness * xy, 1 + choppiness * yy
        normal = jit.Array3f64(sy * xy - sx * yy, sx * xy - sy * xx, xx * yy - xy * xy)
        return SurfacePoint(
            jit.Array3f64(choppiness * dx, choppiness * dy, dz), dr.normalize(normal), xx * yy - xy * xy
        )

    def _component(self, i: Array, x: Array, y: Array, t: Array) -> tuple[Array, Array]:
        first, second = self._rows(i)
        return _turns(first, x, y, t), second

    def _rows(self, i: Array) -> tuple[list[Array], list[Array]]:
        # one by one: four at once are slower where all lanes read the same row
        first = i if self.lane is None else self.lane * self._count + i
        row = [dr.gather(jit.Float64, self.table, _STRIDE * first + k) for k in range(_STRIDE)]
        if self.changed is not None:
            row = self.changed.of(row)
        return row[:4], row[4:]

    def _loop(self, add: object, *start: Array) -> tuple[Array, ...]:
        count = self._count
        state = dr.while_loop((jit.UInt32(0), *start), lambda i, *_: i < count, add, mode="symbolic")
        return tuple(state[1:])

    @property
    def _count(self) -> int:
        """Of the components of a sea."""
        return int(dr.width(self.table)) // (_STRIDE * self.copies)

    def _stretched(self, z: Array, surface: Array) -> Array:
        fade = dr.clip(1 + z / self.height, 0.0, 1.0)
        if self.deep:
            return dr.minimum(z - fade * surface, 0.0)
        depth = self.depth
        full = (z - surface) * depth / dr.maximum(depth + surface, 0.05 * depth)
        return dr.clip(z + fade * (full - z), -depth, 0.0)

    def _decay(self, k: Array, level: Array, second: Array) -> tuple[Array, Array, Array]:
        """cosh(k (z + h)) / sinh(k h), sinh(k (z + h)) / sinh(k h), cosh(k (z + h)) / cosh(k h)."""
        down = dr.exp(k * level)
        if self.deep:
            return down, down, down
        back = dr.exp(-k * (level + 2 * self.depth))
        return (down + back) * second[2], (down - back) * second[2], (down + back) * second[3]


def _turns(first: Array, x: Array, y: Array, t: Array) -> Array:
    return dr.fma(first[0], x, dr.fma(first[1], y, dr.fma(-first[2], t, first[3])))


def make_waves(
    systems: tuple[WavesConfig, ...], site: Site, *, depth: float | None, wind: float | None = None
) -> Waves | None:
    """The components of all wave systems together; None where there are none.

    Args:
        systems: see the configurations.
        site: gives the seed of phases, frequencies and directions.
        depth: of the water [m]; None for deep water.
        wind: speed 10 m up [m/s], for whitecaps; None for the wind that would raise such a sea.
    """
    joined = sea_of(systems, site, depth=depth)
    return waves_of(joined, depth=depth, wind=wind) if len(joined.amplitude) else None


def sea_of(systems: tuple[WavesConfig, ...], site: Site, *, depth: float | None) -> Components:
    """The components of wave systems, one after the other."""
    made = [s.components(site.rng(0, number, *_another(s)), depth) for number, s in enumerate(systems)]
    names = [f.name for f in fields(Components)]
    return Components(*(np.concatenate([getattr(c, name) for c in made] or [np.zeros(0)]) for name in names))


def _another(system: WavesConfig) -> tuple[int, ...]:
    seed = getattr(system, "seed", 0)  # a regular wave has nothing to draw
    return (seed,) if seed else ()


def waves_of(components: Components, *, depth: float | None, wind: float | None = None) -> Waves:
    """A sea of given components, see `make_waves`."""
    return _table_of([components], depth=depth, wind=wind)


def waves_by_copy(seas: Sequence[Components], *, count: int, depth: float | None, wind: float | None) -> Waves:
    """A sea of its own for each copy of a fleet, of `count` components at most; see `make_waves`.

    Whatever the seas are, the arrays' sizes are the same, and so is what is asked of them.
    """
    return replace(_table_of(seas, depth=depth, wind=wind, count=count), breaks=True)


def _table_of(seas: Sequence[Components], *, depth: float | None, wind: float | None, count: int = 0) -> Waves:
    limits = np.array([breaking_limit(c, wind) for c in seas])
    tables = [component_table(c, depth=depth) for c in seas]
    rows = max(count + -count % _AT_ONCE, _AT_ONCE, *(len(table) for table in tables))
    tables = [np.concatenate([table, np.tile(_SPARE, (rows - len(table), 1))]) for table in tables]
    heights = [2.0 * math.sqrt(2.0) * float(np.linalg.norm(c.amplitude)) for c in seas]
    waves = Waves(
        jit.Float64(np.concatenate(tables).ravel()),
        jit.Float64(depth or 1e9),
        jit.Float64(limits),
        jit.Float64(np.maximum(heights, _CALM)),
        depth is None,
        bool(limits.min() < NEVER),
        len(seas),
    )
    jit.align(waves.table, waves.depth, waves.limit, waves.height)
    return waves


def component_table(c: Components, *, depth: float | None) -> NDArray[np.float64]:
    """`(components, 8)`, padded; see `Waves.table`."""
    k = c.wavenumber
    decay = np.exp(-2 * k * depth) if depth is not None else np.zeros_like(k)
    wave = np.stack([k * np.cos(c.angle), k * np.sin(c.angle), c.omega, c.phase], axis=-1) / (2 * math.pi)
    table = np.concatenate([wave, np.stack([c.amplitude, k, 1 / (1 - decay), 1 / (1 + decay)], axis=-1)], axis=-1)
    return np.ascontiguousarray(np.concatenate([table, np.tile(_SPARE, (-len(table) % _AT_ONCE, 1))]))


def patch(table: NDArray[np.float64], x: NDArray[np.float64], y: NDArray[np.float64], t: float) -> NDArray[np.float64]:
    """Elevation `(len(x), len(y))` [m] on a regular patch, on the host, as one product of two matrices.

    cos(a + b) = cos a cos b - sin a sin b with a = kx x - omega t + phase and b = ky y.
    """
    a = 2 * math.pi * (np.outer(x, table[:, 0]) + (table[:, 3] - table[:, 2] * t) % 1.0)
    b = 2 * math.pi * np.outer(y, table[:, 1])
    left = np.concatenate([np.cos(a) * table[:, 4], -np.sin(a) * table[:, 4]], axis=1)
    product: NDArray[np.float64] = left @ np.concatenate([np.cos(b), np.sin(b)], axis=1).T
    return product
