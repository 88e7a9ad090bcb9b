"""Eigenrays: the rays that lead from a source to a receiver, with what each brings.

A fan of rays is traced to the receiver's range. Between neighbours with the same bounces the depth at which they
arrive changes steadily, and its slope is known from dynamic ray tracing: where it passes the receiver's depth, Newton's
method inside of the bracket finds the ray to 1e-7 m. The fan is made finer where the number of bounces changes, and
where the depth has an extremum (a caustic).

Source: F. B. Jensen, W. A. Kuperman, M. B. Porter, H. Schmidt, Computational Ocean Acoustics (2nd ed., 2011), Sections
3.3.5.1 (amplitudes), 3.5.1 (eigenrays) and 3.6.2 (caustics), doi 10.1007/978-1-4419-8678-8.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.layered_rays import Launch, march
from pelagos.acoustics.layered_water import Floor, Water
from pelagos.acoustics.section import Section, on_device
from pelagos.jit import Array

RAYS: Final = 1536
"""Of a fan, by default."""
BOUNCES: Final = 24
"""Most bounces of a path, by default."""
_FINE: Final = 0.02  # tangent of the angle below which half of a fan is even, and above which it thins out
_WIDEST: Final = math.tan(math.radians(25.0))  # a fan reaches at least so far: refracted rays need few bounces
_PARTS: Final = 8  # into which an interval of the fan is divided where bounces change
_REFINEMENTS: Final = 2
_CLOSE: Final = 1e-7  # [m] by which an eigenray may miss the receiver
_ROUNDS: Final = 30
_NEAREST: Final = 1e-3  # [m], least horizontal distance
_STEEPEST: Final = 20e3 / _NEAREST  # tangent of the angle: an image 20 km high, from the least distance
_EDGE: Final = 1e-6  # [m], least distance of an end from surface and bottom
_LEAST_LANES: Final = 64


@dataclass(frozen=True)
class Arrivals:
    """Eigenrays, `(k,)` each, ordered by path and delay.

    Attributes:
        path: which of the sections asked for.
        delay: [s].
        amplitude: complex pressure re that at 1 m; the transfer function is the sum of amplitude exp(-i omega delay).
        departure, arrival: angles of the ray at source and receiver, positive down [rad].
        surface, bottom, caustics: numbers of bounces, and of caustics touched.
        length: of the ray [m].
        surface_sine: sine of the grazing angle at the surface [1]; 0 where it has none.
    """

    path: NDArray[np.int64]
    delay: NDArray[np.float64]
    amplitude: NDArray[np.complex128]
    departure: NDArray[np.float64]
    arrival: NDArray[np.float64]
    surface: NDArray[np.int64]
    bottom: NDArray[np.int64]
    caustics: NDArray[np.int64]
    length: NDArray[np.float64]
    surface_sine: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.delay)

    @property
    def loss_db(self) -> NDArray[np.float64]:
        """Transmission loss of each [dB re 1 m]."""
        return np.asarray(-20.0 * np.log10(np.maximum(np.abs(self.amplitude), 1e-300)))

    def of(self, path: int) -> Arrivals:
        """Those of one path."""
        return self.take(self.path == path)

    def take(self, rows: NDArray[Any]) -> Arrivals:
        """Some of them."""
        return Arrivals(*(getattr(self, f.name)[rows] for f in fields(self)))


def eigenrays(
    sections: Sequence[Section], source: NDArray[np.float64], receiver: NDArray[np.float64],
    distance: NDArray[np.float64], *, rays: int = RAYS, bounces: int = BOUNCES,
) -> Arrivals:  # fmt: skip
    """All rays between pairs of places.

    Args:
        sections: one for each pair.
        source, receiver: `(m,)` depths [m].
        distance: `(m,)` horizontal [m].
        rays: of the first fan.
        bounces: most of a path.
    """
    water, floor = on_device(sections)
    reach = np.maximum(distance, _NEAREST)
    deepest = np.array([float(np.max(s.bottom_depth)) for s in sections])
    at_source = np.array([float(s.bottom_at(0.0)) for s in sections])
    at_receiver = np.array([float(s.bottom_at(d)) for s, d in zip(sections, reach, strict=True)])
    hunt = _Hunt(
        water, floor, np.clip(source, _EDGE, at_source - _EDGE), np.clip(receiver, _EDGE, at_receiver - _EDGE),
        reach, bounces,
    )  # fmt: skip
    fan = hunt.trace(*_fan(reach, deepest, rays, bounces))
    for _ in range(_REFINEMENTS):
        fan = _merged(fan, hunt.trace(*_finer(fan, hunt.receiver)))
    return hunt.arrivals(hunt.refine(fan), sections)


@dataclass(frozen=True)
class _Fan:
    """Traced rays, `(k,)` each, by path and angle: see `Ray`."""

    path: NDArray[np.int64]
    angle: NDArray[np.float64]
    z: NDArray[np.float64]
    sine: NDArray[np.float64]
    slowness: NDArray[np.float64]
    time: NDArray[np.float64]
    length: NDArray[np.float64]
    loss: NDArray[np.float64]
    spread: NDArray[np.float64]
    real: NDArray[np.float64]
    imaginary: NDArray[np.float64]
    caustics: NDArray[np.int64]
    surface: NDArray[np.int64]
    bottom: NDArray[np.int64]
    alive: NDArray[np.bool_]

    @property
    def slope(self) -> NDArray[np.float64]:
        """dz/d(angle) at the receiver's range [m/rad]."""
        cosine = np.sqrt(np.maximum(1.0 - self.sine**2, 1e-30))
        return np.where((self.surface + self.bottom) % 2, -1.0, 1.0) * self.spread / cosine

    def take(self, rows: NDArray[Any]) -> _Fan:
        return _Fan(*(getattr(self, f.name)[rows] for f in fields(self)))


@dataclass(frozen=True)
class _Hunt:
    """One search: tables, depths of source and receiver, horizontal distance, most bounces."""

    water: Water
    floor: Floor
    source: NDArray[np.float64]
    receiver: NDArray[np.float64]
    reach: NDArray[np.float64]
    bounces: int

    def trace(self, path: NDArray[np.int64], angle: NDArray[np.float64]) -> _Fan:
        """Rays of these paths at these angles; calls of similar size share one kernel."""
        count = len(path)
        width = max(_LEAST_LANES, 1 << (count - 1).bit_length()) if count else _LEAST_LANES
        rows = np.zeros((4, width))
        rows[:, :count] = path, self.source[path], angle, self.reach[path]
        packed = _traced()(self.water, self.floor, jit.Float64(jit.padded(rows)), jit.UInt32(self.bounces))
        z, sine, slowness, time, length, loss, spread, real, imaginary, *counts = packed.numpy().reshape(13, width)[
            :, :count
        ]
        caustics, surface, bottom = (v.astype(np.int64) for v in counts[:3])
        return _Fan(
            path, angle, z, sine, slowness, time, length, loss, spread, real, imaginary, caustics, surface, bottom,
            counts[3] > 0.5,
        )  # fmt: skip

    def refine(self, fan: _Fan) -> _Fan:
        """The eigenrays, from a sorted fan."""
        left, right, there = fan.take(slice(None, -1)), fan.take(slice(1, None)), self.receiver  # type: ignore[arg-type]
        missed = fan.z - there[fan.path]
        f0, f1 = missed[:-1], missed[1:]
        same = (left.path == right.path) & (left.surface == right.surface) & (left.bottom == right.bottom)
        rows = np.flatnonzero(same & left.alive & right.alive & ((f0 <= 0.0) != (f1 <= 0.0)))
        path, low, high, f_low = left.path[rows], left.angle[rows].copy(), right.angle[rows].copy(), f0[rows].copy()
        angle = low + (high - low) * (f_low / (f_low - f1[rows]))
        found = self.trace(path, angle)
        for _ in range(_ROUNDS):
            f = found.z - there[path]
            done = ~found.alive | (np.abs(f) < _CLOSE) | (high - low < 1e-15)
            if done.all():
                break
            lower = (f <= 0.0) == (f_low <= 0.0)
            low, f_low = np.where(lower & ~done, angle, low), np.where(lower & ~done, f, f_low)
            high = np.where(~lower & ~done, angle, high)
            with np.errstate(divide="ignore", invalid="ignore"):
                newton = angle - f / found.slope
            inside = (newton > low) & (newton < high)
            angle = np.where(done, angle, np.where(inside, newton, 0.5 * (low + high)))
            found = self.trace(path, angle)
        close = np.abs(found.z - there[path]) < 1e-3 + 1e-7 * self.reach[path]
        return found.take(found.alive & close)

    def arrivals(self, found: _Fan, sections: Sequence[Section]) -> Arrivals:
        """Arrivals by eigenrays."""
        path = found.path
        here = np.array([s.speed_at(z) for s, z in zip(sections, self.source, strict=True)])[path]
        ends = list(zip(sections, self.receiver, self.reach, strict=True))
        there = np.array([s.speed_at(z, x) for s, z, x in ends])[path]
        wavelength = there / np.array([s.frequency for s in sections])[path]
        spread = np.maximum(np.abs(found.spread), least_spread(wavelength, found.length))
        size = np.sqrt(np.cos(found.angle) * there / (here * self.reach[path] * spread)) * 10.0 ** (-found.loss / 20.0)
        phase = (found.real + 1j * found.imaginary) * 1j**found.caustics
        surface_speed = np.array([s.speed_at(0.0, x) for s, _, x in ends])[path]
        level = np.minimum(found.slowness * surface_speed, 1.0)
        sine = np.where(found.surface > 0, np.sqrt(1.0 - level**2), 0.0)
        made = Arrivals(
            path, found.time, size * phase, found.angle, np.arcsin(np.clip(found.sine, -1, 1)), found.surface,
            found.bottom, found.caustics, found.length, sine,
        )  # fmt: skip
        return made.take(np.lexsort((made.delay, made.path)))


def least_spread(wavelength: NDArray[np.float64], length: NDArray[np.float64]) -> NDArray[np.float64]:
    """Least spread q of a ray [m/rad]: at caustics, where geometric rays would be infinitely loud.

    A wave has no finer structure than a wavelength, and a ray that starts at an angle known to a wavelength in the
    radius of its first Fresnel zone spreads over as much.
    """
    return np.asarray(np.minimum(np.sqrt(wavelength * length), length))


@cache
def _traced() -> Any:
    """The frozen kernel."""

    def trace(water: Water, floor: Floor, rows: Array, bounces: Array) -> Array:
        width = dr.width(rows) // 4
        lane = dr.arange(jit.UInt32, width)
        path, depth, angle, reach = (dr.gather(jit.Float64, rows, lane + k * width) for k in range(4))
        r = march(water, floor, Launch(jit.UInt32(path), depth, angle, reach, bounces))
        values = (
            r.z, r.sine, r.slowness, r.time, r.length, r.loss, r.spread, r.real, r.imaginary, r.caustics, r.surface,
            r.bottom, dr.select(r.alive, 1.0, 0.0),
        )  # fmt: skip
        return dr.concat([jit.Float64(v) for v in values])

    return jit.freeze(trace)


def _fan(
    reach: NDArray[np.float64], depth: NDArray[np.float64], rays: int, bounces: int
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Paths and angles: half of them even in the height of the image they aim at, half even near the horizontal."""
    steepest = np.clip((bounces + 2) * depth / reach, _WIDEST, _STEEPEST)[:, None]  # (m, 1)
    place = np.linspace(-1.0, 1.0, rays // 2)
    even = steepest * place
    dense = _FINE * np.sinh(np.arcsinh(steepest / _FINE) * (place + 1.0 / rays))
    angle = np.arctan(np.sort(np.concatenate([even, dense], axis=1), axis=1))
    path = np.repeat(np.arange(len(reach)), angle.shape[1])
    return path, angle.ravel()


def _finer(fan: _Fan, receiver: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """More angles: where bounces change from one ray to the next, and at extrema of the depth near the receiver's."""
    same_path = fan.path[1:] == fan.path[:-1]
    bounces = (fan.surface[1:] == fan.surface[:-1]) & (fan.bottom[1:] == fan.bottom[:-1])
    alive = fan.alive[1:] & fan.alive[:-1]
    edges = np.flatnonzero(same_path & ~(bounces & alive) & (fan.alive[1:] | fan.alive[:-1]))
    part = np.arange(1, _PARTS) / _PARTS
    a, b = fan.angle[edges], fan.angle[edges + 1]
    between = (a[:, None] + (b - a)[:, None] * part).ravel()
    f, slope = fan.z - receiver[fan.path], fan.slope
    sign = np.sign(f[:-1])
    dips = same_path & bounces & alive & (f[:-1] * f[1:] > 0) & (sign * slope[:-1] < 0) & (sign * slope[1:] > 0)
    rows = np.flatnonzero(dips)
    share = slope[rows] / (slope[rows] - slope[rows + 1])
    vertex = fan.angle[rows] + share * (fan.angle[rows + 1] - fan.angle[rows])
    path = np.concatenate([np.repeat(fan.path[edges], _PARTS - 1), fan.path[rows]])
    return path, np.concatenate([between, vertex])


def _merged(a: _Fan, b: _Fan) -> _Fan:
    """Both, by path and angle."""
    made = _Fan(*(np.concatenate([getattr(a, f.name), getattr(b, f.name)]) for f in fields(_Fan)))
    return made.take(np.lexsort((made.angle, made.path)))
