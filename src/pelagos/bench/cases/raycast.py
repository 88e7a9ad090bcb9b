"""The ray caster beside the raw ray-tracing calls that it is made of."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.check import must
from pelagos.bench.timing import seconds
from pelagos.jit import Array
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import NO_BODY, Rays
from pelagos.raycast.scene import Scene
from pelagos.world.terrain import HeightField

NODES: Final = 1001  # 1000 x 1000 cells: 2 M triangles
SPACING_M: Final = 0.5
MEAN_DEPTH_M: Final = 40.0
SONAR_DEPTH_M: Final = 20.0
REACH_M: Final = 400.0
_ROUGHNESS_M: Final = 4.0  # standard deviation of the depth
_DECAY: Final = 1.6  # amplitude falls with this power of the wave number: rough down to the smallest triangle


@cache
def _terrain() -> HeightField:
    """Fractal ground, 500 m x 500 m."""
    rng = np.random.Generator(np.random.PCG64(1))
    k = np.hypot(np.fft.fftfreq(NODES)[:, None], np.fft.rfftfreq(NODES))
    k[0, 0] = np.inf
    spectrum = (rng.standard_normal(k.shape) + 1j * rng.standard_normal(k.shape)) * k**-_DECAY
    z = np.fft.irfft2(spectrum, s=(NODES, NODES))
    half = SPACING_M * (NODES - 1) / 2
    return HeightField(-half, -half, SPACING_M, z / z.std() * _ROUGHNESS_M - MEAN_DEPTH_M)


@cache
def _scene() -> Scene:
    return Scene([_terrain().geometry(material=0, label=1, instance=1)])


@dataclass(frozen=True)
class _Shot:
    origin: Array
    direction: Array
    count: int


def _shot(count: int) -> _Shot:
    """A forward-looking sonar's fan: 130 degrees across, 20 degrees high, tilted down by 20, from 20 m depth."""
    side = math.isqrt(count)
    azimuth = np.deg2rad(np.linspace(-65.0, 65.0, count // side))
    elevation = np.deg2rad(np.linspace(-30.0, -10.0, side))
    a, e = np.meshgrid(azimuth, elevation, indexing="ij")
    direction = np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)]).reshape(3, -1)
    origin = dr.full(jit.Array3f64, 0.0, count)
    origin.z = dr.full(jit.Float64, -SONAR_DEPTH_M, count)
    shot = _Shot(origin, jit.Array3f(np.ascontiguousarray(direction, dtype=np.float32)), count)
    dr.make_opaque(shot.origin, shot.direction)
    return shot


def _caster(scene: Scene) -> Callable[..., Any]:
    def shoot(caster: Caster, origin: Array, direction: Array) -> tuple[Array, Array]:
        n = dr.width(direction)
        reach, own = dr.full(jit.Float, REACH_M, n), dr.full(jit.UInt32, NO_BODY, n)
        hits = caster.cast(Rays(origin, direction, reach, dr.zeros(jit.UInt32, n), own))
        return hits.t, hits.normal

    return scene.compile(shoot)


def _raw(scene: Scene, shot: _Shot) -> Callable[[], Any]:
    """The same rays through Mitsuba alone."""
    origin = jit.mi.Point3f(shot.origin - scene.tables.origin)
    direction = jit.mi.Vector3f(shot.direction)
    dr.make_opaque(origin, direction)
    static = scene.static

    def shoot(o: Array, d: Array) -> tuple[Array, Array]:
        si = static.ray_intersect(jit.mi.Ray3f(o, d, REACH_M, 0.0, []), jit.mi.RayFlags.Minimal, True)
        return si.t, si.n

    frozen = dr.freeze(shoot)
    return lambda: frozen(origin, direction)


def _checked(shot: _Shot, t: NDArray[np.float32], normal: NDArray[np.float32]) -> str:
    """The hits lie on the ground, which is not flat."""
    hit = np.isfinite(t)
    must(float(hit.mean()) > 0.95, f"only {hit.mean():.0%} of the rays hit the terrain")
    points = shot.origin.numpy().T[hit] + shot.direction.numpy().T[hit] * t[hit][:, None]
    error = np.abs(points[:, 2] - _terrain().surface(points[:, 0], points[:, 1]))
    must(float(np.nanmax(error)) < 0.01, "hits do not lie on the terrain")
    must(float(normal[2, hit].std()) > 1e-3, "normals do not vary")
    return f"{hit.mean():.1%} of rays hit, at most {1e3 * np.nanmax(error):.2g} mm off the ground"


def cast_256_ms() -> Measured:
    """A 256-ray cast to NumPy, frozen."""
    scene, shot = _scene(), _shot(256)
    shoot = _caster(scene)

    def ours() -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        t, normal = shoot(shot.origin, shot.direction)
        return t.numpy(), normal.numpy()

    raw = _raw(scene, shot)

    def theirs() -> tuple[Any, Any]:
        t, normal = raw()
        return t.numpy(), normal.numpy()

    detail = _checked(shot, *ours())
    limit = 1e3 * seconds(theirs)
    return Measured(1e3 * seconds(ours), Reference("raw Mitsuba call, same rays, same run", limit), detail)


def cast_mrays() -> Measured:
    """262 144 rays with normals on 2 M triangles."""
    scene, shot = _scene(), _shot(262_144)
    shoot = _caster(scene)

    def ours() -> None:
        dr.eval(shoot(shot.origin, shot.direction))
        dr.sync_thread()

    raw = _raw(scene, shot)

    def theirs() -> None:
        dr.eval(raw())
        dr.sync_thread()

    t, normal = shoot(shot.origin, shot.direction)
    detail = _checked(shot, t.numpy(), normal.numpy())
    limit = shot.count / seconds(theirs, at_least_s=2.0) * 1e-6
    value = shot.count / seconds(ours, at_least_s=2.0) * 1e-6
    return Measured(value, Reference("raw Mitsuba calls, same rays, same run", limit), detail)


CASES: Final = (
    Case(
        name="cast_256_ms",
        title="256 rays with normals on 2 M triangles, one frozen call until the NumPy result",
        measure=cast_256_ms,
        unit="ms",
        goal=0.2,
        better="lower",
        reference=Reference("raw Mitsuba call, same rays, same run"),
    ),
    Case(
        name="cast_mrays",
        title="262 144 rays with hit normals on 2 M triangles",
        measure=cast_mrays,
        unit="M rays/s",
        goal=10.0,
        better="higher",
        reference=Reference("raw Mitsuba calls, same rays, same run"),
    ),
)
